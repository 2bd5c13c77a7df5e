//! The machine's floor, for the bench: processes that hand a number to each
//! other through shared memory, a cache line each, and nothing else.
//!
//! They wait as everyone in a run does: look, give the core away while the
//! awake time lasts, then sleep (here on the line itself, by a futex) for a
//! bounded slice.

use std::fs::OpenOptions;
use std::path::PathBuf;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use rustix::event::Timespec;
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use rustix::thread::futex;
use rusty_contract::{MAX_PARTICIPANTS, RunName};

use crate::wait::{LOOKS_BETWEEN_CHECKS, Waiter, monotonic_ns};
use crate::{Domain, LinkError, Peer, WaitPolicy};

/// What a client's line holds once it is there, and the server's at the end.
const MARK: u32 = u32::MAX;
/// Longest sleep between two looks.
const SLICE: Duration = Duration::from_millis(2);

/// A number on a separate cache line; two, because processors fetch pairs.
#[repr(C, align(128))]
struct Line(AtomicU32);

/// The server's line, then one for each client.
type Lines = [Line; 1 + MAX_PARTICIPANTS];

/// The lines, mapped. The file that holds them belongs to the run's domain and
/// is swept with it.
struct Mapped(NonNull<Lines>);

impl Mapped {
    fn path(domain: &Domain) -> PathBuf {
        domain.memory().join("floor")
    }

    fn open(domain: &Domain, create: bool) -> Result<Self, LinkError> {
        let transport = LinkError::transport::<std::io::Error>;
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create_new(create);
        let file = options.open(Self::path(domain)).map_err(transport("open the floor"))?;
        if create {
            file.set_len(size_of::<Lines>() as u64).map_err(transport("size the floor"))?;
        }
        let access = ProtFlags::READ | ProtFlags::WRITE;
        // SAFETY: a new mapping at an address that the kernel chooses; no
        // memory of this process is replaced.
        let at = unsafe {
            let null = std::ptr::null_mut();
            mmap(null, size_of::<Lines>(), access, MapFlags::SHARED, &file, 0)
        };
        let at = at.map_err(LinkError::transport("map the floor"))?;
        let at = NonNull::new(at.cast()).ok_or("null");
        at.map(Self).map_err(LinkError::transport("map the floor"))
    }

    fn lines(&self) -> &Lines {
        // SAFETY: the mapping is as large as `Lines`, page-aligned and lives as
        // long as `self`; every bit pattern is a `Lines`, and all access of all
        // processes is atomic.
        unsafe { self.0.as_ref() }
    }
}

impl Drop for Mapped {
    fn drop(&mut self) {
        // SAFETY: this is the mapping that `open` made, and nothing borrows from
        // a value that is being dropped.
        let _ = unsafe { munmap(self.0.as_ptr().cast(), size_of::<Lines>()) };
    }
}

/// Waits until `line` is other than `than`, or `is_over`: then `None`.
fn wait_while(
    line: &Line,
    than: impl Fn(u32) -> bool,
    policy: WaitPolicy,
    mut is_over: impl FnMut() -> bool,
) -> Option<u32> {
    let waiter = Waiter::new(policy, monotonic_ns());
    let mut looks = 0u32;
    loop {
        let value = line.0.load(Ordering::Acquire);
        if !than(value) {
            return Some(value);
        }
        let awake = waiter.yielded();
        looks = looks.wrapping_add(1);
        if awake && !looks.is_multiple_of(LOOKS_BETWEEN_CHECKS) {
            continue;
        }
        if is_over() {
            return None;
        }
        if !awake {
            let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(SLICE.subsec_nanos()) };
            // Woken, interrupted, timed out or changed meanwhile: look again.
            let _ = futex::wait(&line.0, futex::Flags::empty(), value, Some(&timeout));
        }
    }
}

/// Hands a number over, and wakes who may sleep on the line: always where
/// no process stays awake. Otherwise a sleeper looks by itself after a slice.
fn hand(line: &Line, value: u32, policy: WaitPolicy) {
    line.0.store(value, Ordering::Release);
    if policy.awake_ns() == 0 {
        let _ = futex::wake(&line.0, futex::Flags::empty(), i32::MAX as u32);
    }
}

/// The side that counts.
pub struct FloorServer {
    memory: Mapped,
    policy: WaitPolicy,
    clients: usize,
}

impl FloorServer {
    /// Makes the lines in `domain`. More clients than a run can have
    /// participants are cut off.
    ///
    /// # Errors
    /// [`LinkError::Transport`] says what the operating system refused.
    pub fn create(domain: &Domain, policy: WaitPolicy, clients: usize) -> Result<Self, LinkError> {
        let memory = Mapped::open(domain, true)?;
        Ok(Self { memory, policy, clients: clients.min(MAX_PARTICIPANTS) })
    }

    /// Waits for all clients to be there; false once `is_over` says so.
    pub fn gather(&self, mut is_over: impl FnMut() -> bool) -> bool {
        self.echoed(MARK, &mut is_over)
    }

    /// Hands `number` over and waits until every client has handed it back;
    /// false once `is_over` says so.
    pub fn round(&self, number: u32, mut is_over: impl FnMut() -> bool) -> bool {
        hand(&self.memory.lines()[0], number, self.policy);
        self.echoed(number, &mut is_over)
    }

    /// Tells the clients to end.
    pub fn end(&self) {
        hand(&self.memory.lines()[0], MARK, self.policy);
    }

    fn echoed(&self, number: u32, is_over: &mut impl FnMut() -> bool) -> bool {
        let lines = &self.memory.lines()[1..=self.clients];
        let echoed = |line| wait_while(line, |v| v != number, self.policy, &mut *is_over).is_some();
        lines.iter().all(echoed)
    }
}

/// Hands back what comes, on line `client` (from 0), until the end or until
/// the server has ended.
///
/// # Errors
/// [`LinkError`] if there is no such run or no such line.
pub fn serve_floor(run: &RunName, client: usize, policy: WaitPolicy) -> Result<(), LinkError> {
    let domain = Domain::find(run)?;
    let server = Peer::new(domain.server_pid());
    let memory = Mapped::open(&domain, false)?;
    let lines = memory.lines();
    let own = lines.get(1 + client).ok_or(client).map_err(LinkError::transport("find a line"))?;
    let mut last = lines[0].0.load(Ordering::Acquire);
    hand(own, MARK, policy);
    while let Some(number) =
        wait_while(&lines[0], |v| v == last, policy, || server.is_dead()).filter(|n| *n != MARK)
    {
        last = number;
        hand(own, number, policy);
    }
    Ok(())
}
