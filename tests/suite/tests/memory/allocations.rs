//! A steady tick allocates nothing of ours, and leaves nothing behind: not in
//! the server, not in an estimator's session, not in a recorder's.
//!
//! The transport makes a small handle for every message that is sent, and frees
//! it with the sending. That is all there is: one for each frame, tally and
//! answer, and after any number of ticks no byte more is held than before.
//!
//! Server, estimator and recorder are threads here, each with separate ports,
//! so that one allocator sees them all and tells them apart. They wait without
//! sleeping: going to sleep may allocate, and is no part of a steady tick.

use std::cell::{Cell, RefCell};
use std::sync::mpsc::Sender;
use std::sync::mpsc::channel;
use std::thread;

use rusty_clients::prelude::*;
use rusty_clients::recorder::{Ending, Recorder, Step};
use rusty_clients::{ClientArgs, run_recorder};
use rusty_contract::{Exit, Participant, Role};
use rusty_engine::run::RunBuilder;
use rusty_engine::source::Simulated;
use rusty_link::WaitPolicy;
use rusty_tests::fuzz::memory::{Allocated, allocated};
use rusty_tests::*;

/// Ticks in which everything may find its size.
const WARM_UP: u64 = 300;
/// The transport's handle is no longer than this.
const HANDLE_BYTES: usize = 128;
const STEADY: u64 = 1_500;

/// How often a thread allocated in the steady ticks, how many more bytes it holds,
/// and the longest allocation, bytes.
type Tallied = (i64, i64, usize);

/// What one thread allocated before and after the steady ticks.
#[derive(Default)]
struct Count {
    before: Option<Allocated>,
    after: Option<Allocated>,
}

impl Count {
    fn at(&mut self, tick: u64) {
        match tick {
            WARM_UP => self.before = Some(allocated()),
            t if t == WARM_UP + STEADY => self.after = Some(allocated()),
            _ => {}
        }
    }

    #[track_caller]
    fn steady(&self) -> Tallied {
        let (before, after) = (self.before.unwrap(), self.after.unwrap());
        let (times, held) = (after.times - before.times, after.held - before.held);
        (times, held, after.longest)
    }
}

/// A recorder that looks at every tick and keeps nothing.
struct Watcher(Count);

thread_local! {
    static WATCHED: Cell<Option<Sender<Tallied>>> = const { Cell::new(None) };
}

impl Recorder for Watcher {
    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        self.0.at(step.frame.tick());
        Ok(())
    }
    fn finish(self, _: Ending) -> Result<Exit, ClientError> {
        WATCHED.take().unwrap().send(self.0.steady()).unwrap();
        Ok(Exit::Done)
    }
}

fn args(run: &RunName, name: &str) -> ClientArgs {
    ClientArgs {
        run: Some(run.clone()),
        name: Some(name.to_owned()),
        wait: WaitPolicy::Spin,
        join_timeout: 60.0,
        ..ClientArgs::default()
    }
}

fn estimate(run: &RunName) -> Tallied {
    let mut session = Session::join(&args(run, "estimator")).unwrap();
    let drive = session.start().robot.drive;
    let (mut pose, mut last, mut count) =
        (SE2::identity(), EncoderCounts::default(), Count::default());
    while let Some(tick) = session.next().unwrap() {
        count.at(tick.index());
        pose = pose.boxplus(&odometry_delta(last, tick.encoders(), &drive));
        last = tick.encoders();
        tick.answer(pose).unwrap();
    }
    count.steady()
}

fn header(scan_every: u64) -> LogHeader {
    let mut config = config_of("apartment", &[&format!("scan_every={scan_every}")]);
    config.ticks = WARM_UP + STEADY + 1;
    let by_hand = |name, role| {
        let mut participant = Participant::new(name, role);
        participant.command.clear();
        participant
    };
    header_of(config, vec![by_hand("estimator", Role::Estimator), by_hand("watcher", Role::Scorer)])
}

/// Steady ticks of a run: what server, estimator and recorder allocated.
fn count_a_run(tag: &str, scan_every: u64) -> [Tallied; 3] {
    let (run, out) = (fresh_run(tag), folder());
    let count = RefCell::new(Count::default());
    let before = |tick| count.borrow_mut().at(tick);
    let mut source = Simulated::new(header(scan_every)).unwrap().before_each_tick(before);
    let options = RunBuilder {
        join_timeout_s: 60.0,
        answer_timeout_s: 60.0,
        by_hand: true,
        ..RunBuilder::new(run.clone(), WaitPolicy::Spin)
    };
    let server = options.build(&mut source, out.path()).unwrap();
    let (said, watched) = channel();
    let (one, other) = (run.clone(), run);
    let estimator = thread::spawn(move || estimate(&one));
    let watcher = thread::spawn(move || {
        WATCHED.set(Some(said));
        run_recorder(&args(&other, "watcher"), |_, _| Ok(Watcher(Count::default())))
    });
    let outcome = server.drive().unwrap();
    assert_eq!(outcome.ticks, WARM_UP + STEADY + 1, "{outcome:?}");
    assert_eq!(watcher.join().unwrap(), Exit::Done);
    drop(source);
    [count.into_inner().steady(), estimator.join().unwrap(), watched.recv().unwrap()]
}

#[test]
fn a_steady_tick_allocates_nothing_but_the_transport_s_handles() {
    for (tag, scan_every) in [("alloc-blind", 0), ("alloc-scan", 5)] {
        let found = count_a_run(tag, scan_every);
        // Frame and tally; an answer; an acknowledgement. The recorder looks at
        // a tick after it has acknowledged the next one, except for the last.
        let sent = [2 * STEADY, STEADY, STEADY - 1].map(|n| n as i64);
        assert_eq!(found.map(|f| f.0), sent, "a scan every {scan_every}: {found:?}");
        assert_eq!(found.map(|f| f.1), [0; 3], "a scan every {scan_every}: {found:?}");
        assert!(found.iter().all(|f| f.2 <= HANDLE_BYTES), "{found:?}");
    }
}

#[test]
fn the_counter_counts() {
    let before = allocated();
    let kept = std::hint::black_box(vec![0u8; 100]);
    drop(std::hint::black_box(Box::new([0u8; 300])));
    let after = allocated();
    assert_eq!((after.times - before.times, after.held - before.held), (2, 100));
    assert_eq!(after.longest, 300);
    drop(kept);
}
