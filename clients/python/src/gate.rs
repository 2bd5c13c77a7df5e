//! `Gate`: whatever belongs to one session is touched by one thread at a time.
//!
//! A session and the frames it hands out share reference counts that are not
//! made for threads. Python objects live on any thread: an array over a frame
//! may go on one thread while another one waits for the next tick. So all of
//! them are behind one lock. A frame that is let go while another thread has the
//! lock is put on a pile, and the thread that gives the lock back clears the pile away.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError, Weak};

use rusty_clients::{HeldFrame, Session};
use rusty_contract::Frame;

/// A session or a frame of it, touched by one thread at a time.
pub struct Lone<T>(T);

impl<T> Lone<T> {
    /// Wraps a session, or a frame that it has handed out.
    ///
    /// # Safety
    /// The session and all its frames are made, used, cloned and dropped only by the
    /// thread that has the lock of their one [`Gate`], or, while joining, by the only
    /// thread that has the session.
    pub unsafe fn new(value: T) -> Self {
        Self(value)
    }

    /// Borrows it.
    pub fn get(&self) -> &T {
        &self.0
    }

    /// Borrows it for a change.
    pub fn get_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

// SAFETY: by the promise of `Lone::new` no two threads touch a shared reference
// count at a time, and each sees what the one before it did.
unsafe impl Send for Lone<Session> {}
// SAFETY: as above.
unsafe impl Send for Lone<HeldFrame> {}
// SAFETY: a shared reference to a frame gives nothing but its bytes, which do
// not change and stay where they are for as long as the frame is held.
unsafe impl Sync for Lone<HeldFrame> {}

/// A session that takes part, and the tick that waits for its answer.
pub struct Part {
    pub session: Lone<Session>,
    /// The tick that may be answered.
    pub open: Option<Arc<Loan>>,
}

/// One session's lock. See the module.
pub struct Gate {
    part: Mutex<Option<Part>>,
    /// Frames that were let go while another thread had the lock.
    returned: Mutex<Vec<Lone<HeldFrame>>>,
    /// How many arrays lie over frames.
    views: AtomicUsize,
    /// The frames that arrays lie over, or did.
    viewed: Mutex<Vec<Weak<Loan>>>,
    /// Raised by a wish to stop: the session then sends a leave message.
    pub stop: Arc<AtomicBool>,
    /// Raised before the session leaves: a thread that waits in it gives way.
    leaving: AtomicBool,
    /// The process that joined. A fork of it has no part in the run.
    pid: u32,
}

/// The gates of this process whose sessions may still take part.
static GATES: Mutex<Vec<Weak<Gate>>> = Mutex::new(Vec::new());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gate {
    pub fn new(session: Lone<Session>, stop: Arc<AtomicBool>) -> Arc<Self> {
        let gate = Arc::new(Self {
            part: Mutex::new(Some(Part { session, open: None })),
            returned: Mutex::default(),
            views: AtomicUsize::new(0),
            viewed: Mutex::default(),
            stop,
            leaving: AtomicBool::new(false),
            pid: std::process::id(),
        });
        let mut gates = lock(&GATES);
        gates.retain(|gate| gate.strong_count() > 0);
        gates.push(Arc::downgrade(&gate));
        gate
    }

    /// Whether this is a fork of the process that joined.
    pub fn is_foreign(&self) -> bool {
        self.pid != std::process::id()
    }

    /// The lock, if no thread has it: a thread that waits for a tick has it.
    pub fn turn(&self) -> Option<Turn<'_>> {
        let guard = match self.part.try_lock() {
            Ok(guard) => guard,
            Err(TryLockError::Poisoned(e)) => e.into_inner(),
            Err(TryLockError::WouldBlock) => return None,
        };
        Some(Turn { gate: self, guard: Some(guard) })
    }

    /// Leaves the run: with a leave message if it is over or a stop was wished for,
    /// as a failure otherwise. Waits for the lock, so hold nothing meanwhile.
    pub fn leave(&self) {
        if self.is_foreign() {
            // The parent takes part. Here, nothing of it may be touched.
            if let Ok(mut part) = self.part.try_lock() {
                std::mem::forget(part.take());
            }
            return;
        }
        self.leaving.store(true, Ordering::Relaxed);
        let mut turn = Turn { gate: self, guard: Some(lock(&self.part)) };
        turn.end();
    }

    /// Whether a thread has begun to leave the run.
    pub fn is_leaving(&self) -> bool {
        self.leaving.load(Ordering::Relaxed)
    }

    /// A frame that is not needed any more.
    fn take_back(&self, frame: Lone<HeldFrame>) {
        if self.is_foreign() {
            std::mem::forget(frame);
            return;
        }
        lock(&self.returned).push(frame);
        self.sweep();
    }

    /// Lets go of the frames on the pile, unless a thread has the lock, which
    /// then does when giving it back.
    fn sweep(&self) {
        while !lock(&self.returned).is_empty() {
            let Some(mut turn) = self.turn() else { return };
            turn.reclaim();
            drop(turn.guard.take());
        }
    }

    /// How many arrays lie over frames.
    pub fn views(&self) -> usize {
        self.views.load(Ordering::Relaxed)
    }

    /// Keeps the frames under arrays until this process ends: see [`pin_all`].
    fn pin(&self) {
        if self.is_foreign() {
            return;
        }
        for loan in lock(&self.viewed).drain(..).filter_map(|loan| loan.upgrade()) {
            if !loan.pinned.swap(true, Ordering::Relaxed) {
                std::mem::forget(loan);
            }
        }
    }
}

/// This process is about to be forked. The fork has the arrays as well, over the
/// same memory, and nothing reports when it needs them no more. So whatever lies
/// under one is never given back, and goes on counting as viewed.
pub fn pin_all() {
    let gates: Vec<_> = lock(&GATES).iter().filter_map(Weak::upgrade).collect();
    gates.iter().for_each(|gate| gate.pin());
}

/// From now on a session that ends sends a leave message, and waiting ends.
pub fn stop_all() {
    for gate in lock(&GATES).iter().filter_map(Weak::upgrade) {
        gate.stop.store(true, Ordering::Relaxed);
    }
}

/// Leaves every run that this process still takes part in.
pub fn leave_all() {
    let gates = std::mem::take(&mut *lock(&GATES));
    for gate in gates.iter().filter_map(Weak::upgrade) {
        gate.leave();
    }
}

/// The lock of a gate, held.
pub struct Turn<'g> {
    gate: &'g Gate,
    guard: Option<MutexGuard<'g, Option<Part>>>,
}

impl Turn<'_> {
    /// The session, if it still takes part.
    pub fn part(&mut self) -> Option<&mut Part> {
        self.guard.as_mut()?.as_mut()
    }

    /// Lets go of the frames on the pile.
    pub fn reclaim(&mut self) {
        let frames = std::mem::take(&mut *lock(&self.gate.returned));
        drop(frames);
    }

    /// Ends the session's part, as [`Gate::leave`] says.
    pub fn end(&mut self) {
        let part = self.guard.as_mut().and_then(|guard| guard.take());
        drop(part);
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        drop(self.guard.take());
        self.gate.sweep();
    }
}

/// A frame that a session handed out. It goes back when the last who holds it
/// lets go.
pub struct Loan {
    frame: Option<Lone<HeldFrame>>,
    gate: Arc<Gate>,
    /// Whether it is kept for a fork.
    pinned: AtomicBool,
}

impl Loan {
    pub fn new(frame: Lone<HeldFrame>, gate: &Arc<Gate>) -> Arc<Self> {
        let (gate, pinned) = (Arc::clone(gate), AtomicBool::new(false));
        Arc::new(Self { frame: Some(frame), gate, pinned })
    }

    /// The frame as the session knows it.
    pub fn held(&self) -> Option<&HeldFrame> {
        self.frame.as_ref().map(Lone::get)
    }

    /// The scan, where it lies: one range in metres for each beam.
    pub fn ranges_m(&self) -> Option<&[f64]> {
        let frame: &Frame = self.held()?;
        frame.ranges_m()
    }

    /// Counts one more array over a frame.
    pub fn viewed(self: Arc<Self>) -> View {
        self.gate.views.fetch_add(1, Ordering::Relaxed);
        let mut viewed = lock(&self.gate.viewed);
        viewed.retain(|loan| loan.strong_count() > 0);
        viewed.push(Arc::downgrade(&self));
        drop(viewed);
        View(self)
    }
}

impl Drop for Loan {
    fn drop(&mut self) {
        if let Some(frame) = self.frame.take() {
            self.gate.take_back(frame);
        }
    }
}

/// A frame under an array.
pub struct View(pub Arc<Loan>);

impl Drop for View {
    fn drop(&mut self) {
        if !self.0.pinned.load(Ordering::Relaxed) {
            self.0.gate.views.fetch_sub(1, Ordering::Relaxed);
        }
    }
}
