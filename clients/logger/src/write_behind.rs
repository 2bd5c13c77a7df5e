//! `WriteBehind`: what is written to it is taken at once, and a separate
//! thread hands it on.
//!
//! Two buffers of a fixed size change places: one is filled while the other is
//! written. What is taken goes out when there is enough of it for a large write,
//! or 200 ms after the first byte of it came, whether or not more comes. A caller that
//! fills the buffer before the other one is out waits: nothing is dropped, and
//! nothing but the two buffers is ever in memory. An error is reported to the caller that
//! writes or flushes next; from then on nothing more is taken.

use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Room in each of the two buffers, bytes. At 100,000 ticks a second without
/// scans that is half a second for which a disk may stand still.
pub const ROOM: usize = 4 << 20;

/// Number of bytes that are worth a write at once.
const ENOUGH: usize = 256 << 10;

/// Nothing waits longer than this for more to come.
const FLUSH_AFTER: Duration = Duration::from_millis(200);

/// A writer whose work is done by a separate thread. Dropped, it writes what
/// it has taken; [`flush`](Write::flush) says whether that went well.
pub struct WriteBehind {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    taken_bytes: u64,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    /// For the thread: there is something to do.
    work: Condvar,
    /// For who gives: something was done.
    done: Condvar,
}

#[derive(Default)]
struct State {
    filling: Vec<u8>,
    /// The other buffer is being written.
    writing: bool,
    /// A caller waits until all is out.
    hurry: bool,
    /// Nothing more will come.
    closing: bool,
    error: Option<io::Error>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing that can panic is done under the lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl WriteBehind {
    /// Starts the thread that writes to `out`.
    ///
    /// # Errors
    /// What the system says when it starts no more threads.
    pub fn new(out: impl Write + Send + 'static) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        shared.lock().filling.reserve_exact(ROOM);
        let theirs = Arc::clone(&shared);
        let name = "write-behind".to_owned();
        let thread = std::thread::Builder::new().name(name).spawn(move || theirs.write_to(out));
        let thread = thread.map_err(|e| {
            let remedy = "end other processes of this user, or raise `ulimit -u`";
            io::Error::new(
                e.kind(),
                format!("starting the thread that writes failed: {e}; {remedy}"),
            )
        })?;
        Ok(Self { shared, thread: Some(thread), taken_bytes: 0 })
    }

    /// How many bytes it has taken. After a [`flush`](Write::flush) that went
    /// well all of them have been written.
    #[must_use]
    pub fn taken_bytes(&self) -> u64 {
        self.taken_bytes
    }
}

impl Write for WriteBehind {
    /// Takes as much as there is room for, and waits while there is none.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let full = |s: &mut State| s.error.is_none() && s.filling.len() >= ROOM;
        let done = &self.shared.done;
        let mut state = wait_while(done, self.shared.lock(), full);
        if let Some(e) = &state.error {
            return Err(same(e));
        }
        let before = state.filling.len();
        let n = bytes.len().min(ROOM - before);
        state.filling.extend_from_slice(&bytes[..n]);
        drop(state);
        // Between these two the thread sleeps at most until its time is up.
        if n > 0 && (before == 0 || (before < ENOUGH && before + n >= ENOUGH)) {
            self.shared.work.notify_one();
        }
        self.taken_bytes += n as u64;
        Ok(n)
    }

    /// Waits until all that was taken is written.
    fn flush(&mut self) -> io::Result<()> {
        let mut state = self.shared.lock();
        state.hurry = true;
        self.shared.work.notify_one();
        let open = |s: &mut State| s.error.is_none() && (s.writing || !s.filling.is_empty());
        let mut state = wait_while(&self.shared.done, state, open);
        state.hurry = false;
        state.error.as_ref().map_or(Ok(()), |e| Err(same(e)))
    }
}

impl Drop for WriteBehind {
    fn drop(&mut self) {
        self.shared.lock().closing = true;
        self.shared.work.notify_one();
        // It says nothing that it has not left in the state.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl Shared {
    /// What the thread does.
    fn write_to(&self, mut out: impl Write) {
        let mut full = Vec::with_capacity(ROOM);
        loop {
            let idle = |s: &mut State| s.filling.is_empty() && !s.closing;
            let state = wait_while(&self.work, self.lock(), idle);
            let may_wait = |s: &mut State| s.filling.len() < ENOUGH && !s.hurry && !s.closing;
            let waited = self.work.wait_timeout_while(state, FLUSH_AFTER, may_wait);
            let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
            if state.filling.is_empty() {
                return;
            }
            std::mem::swap(&mut state.filling, &mut full);
            state.writing = true;
            drop(state);
            self.done.notify_one();
            let written = out.write_all(&full).and_then(|()| out.flush());
            full.clear();
            let mut state = self.lock();
            state.writing = false;
            state.error = written.err();
            let failed = state.error.is_some();
            drop(state);
            self.done.notify_one();
            if failed {
                return;
            }
        }
    }
}

fn wait_while<'a>(
    condvar: &Condvar,
    state: MutexGuard<'a, State>,
    condition: impl FnMut(&mut State) -> bool,
) -> MutexGuard<'a, State> {
    condvar.wait_while(state, condition).unwrap_or_else(PoisonError::into_inner)
}

/// The error once more; it cannot be cloned.
fn same(error: &io::Error) -> io::Error {
    match error.raw_os_error() {
        Some(code) => io::Error::from_raw_os_error(code),
        None => io::Error::new(error.kind(), error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Receiver, Sender, channel};

    /// Writes only what it is allowed to: one write for each word it gets, of
    /// whose bytes it tells.
    struct Gate(Receiver<io::Result<()>>, Sender<Vec<u8>>);

    impl Write for Gate {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.recv().unwrap_or(Ok(()))?;
            let _ = self.1.send(bytes.to_vec());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn gated() -> (WriteBehind, Sender<io::Result<()>>, Receiver<Vec<u8>>) {
        let ((open, opened), (tell, told)) = (channel(), channel());
        (WriteBehind::new(Gate(opened, tell)).unwrap(), open, told)
    }

    #[test]
    fn taken_is_not_written_and_flushed_is() {
        let (mut behind, open, told) = gated();
        behind.write_all(b"one ").unwrap();
        behind.write_all(b"two").unwrap();
        assert_eq!(behind.taken_bytes(), 7);
        assert!(told.try_recv().is_err(), "the gate is shut");
        (0..2).for_each(|_| open.send(Ok(())).unwrap());
        behind.flush().unwrap();
        assert_eq!(told.try_iter().collect::<Vec<_>>().concat(), b"one two");
        behind.flush().unwrap();
    }

    #[test]
    fn what_is_taken_goes_out_although_nothing_follows() {
        let (mut behind, open, told) = gated();
        behind.write_all(b"alone").unwrap();
        open.send(Ok(())).unwrap();
        assert_eq!(told.recv().unwrap(), b"alone");
    }

    #[test]
    fn who_gives_more_than_there_is_room_for_waits_and_loses_nothing() {
        let (mut behind, open, told) = gated();
        let shared = Arc::clone(&behind.shared);
        let giver = std::thread::spawn(move || {
            let mut all = Vec::new();
            for k in 0..40u8 {
                let piece = vec![k; ROOM / 8 + usize::from(k)];
                behind.write_all(&piece).unwrap();
                all.extend(piece);
            }
            behind.flush().unwrap();
            all
        });
        // One buffer is being written, and the other is full to the brim.
        let full = || matches!(&*shared.lock(), s if s.writing && s.filling.len() == ROOM);
        while !full() {
            assert!(!giver.is_finished(), "five times the room was taken at once");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(shared.lock().filling.capacity(), ROOM);
        drop(open);
        let all = giver.join().unwrap();
        let pieces: Vec<Vec<u8>> = told.iter().collect();
        assert!(pieces.iter().all(|piece| piece.len() <= ROOM));
        assert!(pieces.concat() == all);
    }

    #[test]
    fn an_error_is_told_to_whoever_comes_next_and_to_those_who_wait() {
        let (mut behind, open, _told) = gated();
        behind.write_all(b"lost").unwrap();
        open.send(Err(io::Error::from_raw_os_error(28))).unwrap();
        assert_eq!(behind.flush().unwrap_err().raw_os_error(), Some(28));
        assert_eq!(behind.write(b"more").unwrap_err().raw_os_error(), Some(28));
        assert_eq!(behind.taken_bytes(), 4);

        let (mut behind, open, _told) = gated();
        let giver = std::thread::spawn(move || behind.write_all(&vec![0; 3 * ROOM]));
        open.send(Err(io::Error::other("odd"))).unwrap();
        assert_eq!(giver.join().unwrap().unwrap_err().to_string(), "odd");
    }

    #[test]
    fn dropped_it_writes_what_it_has() {
        let (mut behind, open, told) = gated();
        behind.write_all(b"last lines").unwrap();
        drop(open);
        drop(behind);
        assert_eq!(told.iter().collect::<Vec<_>>().concat(), b"last lines");
    }
}
