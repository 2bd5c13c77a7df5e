//! Making runs side by side.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use super::error::SweepError;
use super::journal::encoded;
use super::record::Record;

/// Between two looks at how far the workers are.
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);
/// How long a worker may keep what it has done to itself: telling of each run
/// would wake the other side as often.
const BETWEEN_BATCHES: Duration = Duration::from_millis(10);

/// One worker: makes runs, one after the other.
pub trait Maker {
    /// Makes the run with this number; `None` if it was asked to stop.
    ///
    /// # Errors
    /// [`SweepError`] if no further run can be made either.
    fn make(&mut self, run: u64) -> Result<Option<Record>, SweepError>;

    /// There are no more runs to make.
    ///
    /// # Errors
    /// [`SweepError`] if something failed after the last one.
    fn finish(&mut self) -> Result<(), SweepError> {
        Ok(())
    }
}

/// A listener that is told what is done.
pub trait Listener {
    /// A run is done; `bytes` are the record as it is in a journal.
    ///
    /// # Errors
    /// [`SweepError`] if it cannot be kept.
    fn done(&mut self, record: Record, bytes: &[u8]) -> Result<(), SweepError>;

    /// Nothing more has come for now.
    ///
    /// # Errors
    /// [`SweepError`] if what has come cannot be kept.
    fn pause(&mut self) -> Result<(), SweepError>;
}

type Batch = Vec<(Record, Vec<u8>)>;

/// Makes the runs `todo`, `jobs` at a time, each by a separate worker, until
/// all are done or `stop` is raised. The listener learns of each in the order in
/// which they end.
///
/// # Errors
/// The first [`SweepError`] of a worker or the listener; it raises `stop`.
pub fn work<M: Maker>(
    todo: &[u64],
    jobs: usize,
    stop: &AtomicBool,
    maker: impl Fn() -> M + Sync,
    listener: &mut impl Listener,
) -> Result<(), SweepError> {
    let next = AtomicUsize::new(0);
    let failure = Mutex::new(None);
    let fail = |error: SweepError| {
        stop.store(true, Ordering::Relaxed);
        if let Ok(mut first) = failure.lock() {
            first.get_or_insert(error);
        }
    };
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel::<Batch>();
        for _ in 0..jobs.clamp(1, todo.len().max(1)) {
            let sender = sender.clone();
            let work = || make_some(maker(), todo, &next, stop, sender).unwrap_or_else(&fail);
            let started = std::thread::Builder::new().spawn_scoped(scope, work);
            if let Err(error) = started {
                fail(SweepError::Thread(error));
                break;
            }
        }
        drop(sender);
        loop {
            let received = match receiver.recv_timeout(BETWEEN_LOOKS) {
                Ok(batch) => batch.into_iter().try_for_each(|(r, bytes)| listener.done(r, &bytes)),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            received.and_then(|()| listener.pause()).unwrap_or_else(&fail);
        }
    });
    let failure = failure.into_inner().unwrap_or_default();
    failure.map_or(Ok(()), Err)
}

/// One worker's part.
fn make_some(
    mut maker: impl Maker,
    todo: &[u64],
    next: &AtomicUsize,
    stop: &AtomicBool,
    sender: Sender<Batch>,
) -> Result<(), SweepError> {
    let (mut batch, mut sent) = (Batch::new(), Instant::now());
    let mut failed = None;
    while !stop.load(Ordering::Relaxed) {
        let Some(&run) = todo.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
        match maker.make(run) {
            Ok(Some(record)) => {
                let bytes = encoded(&record);
                batch.push((record, bytes));
            }
            Ok(None) => break,
            Err(error) => {
                failed = Some(error);
                break;
            }
        }
        if sent.elapsed() >= BETWEEN_BATCHES {
            // The other side listens until every worker has ended.
            let _ = sender.send(std::mem::take(&mut batch));
            sent = Instant::now();
        }
    }
    let _ = sender.send(batch);
    failed.map_or_else(|| maker.finish(), Err)
}
