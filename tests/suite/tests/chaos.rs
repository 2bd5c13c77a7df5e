//! The same run under whatever a machine can do to it: everyone stopped and
//! continued in turn, other work on the cores, slow answers, every way of
//! waiting, several paces, pauses and single steps, kills of those who come
//! back, one to eight estimators. The world keeps its digest, and so does the
//! run with the same roster.
//!
//! `RUSTY_CHAOS=150 cargo test --test chaos` draws more combinations. One that
//! fails says how to repeat it alone.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rustix::process::pidfd_send_signal;
use rusty_tests::*;

/// The run: the Apartment, a scan every fifth tick.
const RUN: [&str; 5] = ["apartment", "--ticks", "300", "--answer-timeout", "100"];
const USUAL: u64 = 30;
const MOST: usize = 8;

/// What is done to a run.
#[derive(Debug)]
struct Chaos {
    estimators: usize,
    wait: &'static str,
    pace: &'static str,
    /// Threads that do nothing but take time.
    busy: usize,
    /// Longest sleep before an answer of every second estimator, µs.
    slow_us: u64,
    scorer: bool,
    /// It begins paused, and goes N ticks before it is let go.
    steps: Option<u64>,
    /// Who is killed then, and comes back.
    killed: Option<&'static str>,
    /// Who is stopped, how long after it was seen, and for how long.
    stops: Vec<(&'static str, Duration, Duration)>,
}

/// How many stops hit a process of a run.
static HITS: AtomicU64 = AtomicU64::new(0);
static DEATHS: AtomicU64 = AtomicU64::new(0);

impl Chaos {
    fn draw(number: u64) -> Self {
        let mut dice = Dice::of("chaos", number);
        let wait = ["balanced", "spin", "block"][(number % 3) as usize];
        // Those who never sleep need the cores for themselves.
        let spins = wait == "spin";
        let all: &[&'static str] = &["sim-server", "dead-reckoning", "e2", "score", "logger"];
        let first = all[(number % 5) as usize];
        let mut stops = Vec::new();
        for _ in 0..1 + dice.below(3) {
            let who = if stops.is_empty() { first } else { *dice.pick(all) };
            let (after, during) = (Duration::from_millis(150), Duration::from_millis(60));
            stops.push((who, dice.time(after), dice.time(during)));
        }
        let steps = (dice.below(2) == 0).then(|| 1 + dice.below(200));
        let may_die = ["dead-reckoning", "logger"];
        let killed = steps.is_some().then(|| *dice.pick(&may_die[..]));
        Self {
            steps,
            killed,
            estimators: if spins {
                1 + (number / 3 % 2) as usize
            } else {
                1 + number as usize % MOST
            },
            wait,
            pace: *dice.pick(&["max", "max", "50", "20"][..]),
            busy: if spins { 0 } else { dice.below(4) as usize },
            slow_us: if spins { 0 } else { *dice.pick(&[0, 0, 300, 2000]) },
            scorer: stops.iter().any(|(who, ..)| *who == "score") || dice.below(4) == 0,
            stops,
        }
    }

    fn args(&self) -> Vec<String> {
        let mut args = ["--pace", self.pace, "--wait", self.wait].map(str::to_owned).to_vec();
        args.extend(roster(self.estimators, self.slow_us));
        if self.steps.is_some() {
            args.extend(["--paused", "--set", "on_loss=restart"].map(str::to_owned));
        }
        if !self.scorer {
            args.extend(["--without", "score"].map(str::to_owned));
        }
        args
    }

    fn run(&self) {
        let args = self.args();
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let live = Live::start("launch", "chaos", &[&RUN, &args]);
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let _over = Raise(&over);
            for _ in 0..self.busy {
                scope.spawn(|| {
                    while !over.load(Ordering::Relaxed) {
                        std::hint::spin_loop();
                    }
                });
            }
            if let Some(steps) = self.steps {
                self.step_by_step(&live, steps);
            }
            for stop in &self.stops {
                self.stop(&live, *stop);
            }
            let after = live.ends_with(0);
            assert_eq!(text(&after.report, "world_digest"), calm(1).0, "{self:?}");
            assert_eq!(text(&after.report, "digest"), calm(self.estimators).1, "{self:?}");
            assert_eq!(after.report["losses"].as_array().map(Vec::len), Some(0));
            let back = after.report["restarts"].as_array().map(Vec::len);
            assert_eq!(back, Some(usize::from(self.killed.is_some())), "{self:?}");
        });
    }

    /// Goes some ticks, loses a participant there, and is let go.
    fn step_by_step(&self, live: &Live, steps: u64) {
        until("the run takes steps", || live.control(&["step", &steps.to_string()]));
        if let Some(who) = self.killed {
            send_signal(live.pid_of(who), Signal::KILL);
            DEATHS.fetch_add(1, Ordering::Relaxed);
        }
        assert!(live.control(&["step"]) && live.control(&["resume"]), "{self:?}");
    }

    /// Stops a process once and lets it go on, if it is there and still runs.
    fn stop(&self, live: &Live, (who, after, during): (&str, Duration, Duration)) {
        let server = live.server.pid();
        let ended = || has_ended(server);
        let log = live.log();
        let mut pid = (who == "sim-server").then_some(server);
        while !ended() && (pid.is_none() || !log.exists()) {
            let mut all = participants(&live.run).into_iter();
            pid = pid.or_else(|| all.find(|(_, n)| n == who).map(|(pid, _)| pid));
            if self.estimators == 1 && who == "e2" {
                return;
            }
        }
        let Some((pid, pidfd)) = pid.and_then(|pid| Some((pid, hold(pid)?))) else { return };
        std::thread::sleep(after);
        if pidfd_send_signal(&pidfd, Signal::STOP).is_err() {
            return;
        }
        std::thread::sleep(during);
        if is_stopped(pid) {
            HITS.fetch_add(1, Ordering::Relaxed);
        }
        let _ = pidfd_send_signal(&pidfd, Signal::CONT);
    }
}

/// Arguments for N estimators: dead reckoning, and others after it of
/// which every second one may be slow.
fn roster(estimators: usize, slow_us: u64) -> Vec<String> {
    let slow = format!("slow --sleep-us {slow_us}");
    let one = |k: usize| {
        let (name, is_slow) = (format!("e{k}"), k.is_multiple_of(2) && slow_us > 0);
        let add = if is_slow { probe(&name, &slow) } else { format!("{name}=dead-reckoning") };
        ["--add".to_owned(), add]
    };
    (2..=estimators).flat_map(one).collect()
}

/// World digest and run digest of an undisturbed run with N estimators.
fn calm(estimators: usize) -> &'static (String, String) {
    static CALM: [OnceLock<(String, String)>; MOST] = [const { OnceLock::new() }; MOST];
    CALM[estimators - 1].get_or_init(|| digests(folder().path(), estimators, &[]))
}

fn digests(out: &Path, estimators: usize, more: &[&str]) -> (String, String) {
    let roster = roster(estimators, 0);
    let mut args: Vec<&str> = RUN.to_vec();
    args.extend(["--without", "score", "--without", "logger"]);
    args.extend(roster.iter().map(String::as_str).chain(more.iter().copied()));
    let report = launch("calm", out, &args);
    (text(&report, "world_digest").to_owned(), text(&report, "digest").to_owned())
}

#[test]
fn whatever_happens_on_the_machine_changes_no_bit() {
    binaries();
    let range = cases("RUSTY_CHAOS", USUAL);
    let next = AtomicU64::new(range.start);
    let turns = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if !range.contains(&number) {
                return;
            }
            let chaos = Chaos::draw(number);
            let again = format!("RUSTY_CHAOS_CASE={number}");
            let _repeat = Repeat(format!("{chaos:?} fails; again: {again}"));
            chaos.run();
        }
    };
    std::thread::scope(|scope| [(); 2].map(|()| scope.spawn(turns)).map(|t| t.join().unwrap()));
    let hits = HITS.load(Ordering::Relaxed);
    let deaths = DEATHS.load(Ordering::Relaxed);
    println!("{range:?}: one digest; {hits} stops hit a process, {deaths} died and came back");
    assert!(range.end - range.start < 10 || hits > 0);
}

#[test]
fn another_seed_is_another_run() {
    let (world, run) = digests(folder().path(), 1, &["--seed", "43"]);
    assert_ne!(world, calm(1).0);
    assert_ne!(run, calm(1).1);
    // A further estimator is another run in the same world.
    assert_eq!(calm(2).0, calm(1).0);
    assert_ne!(calm(2).1, calm(1).1);
}
