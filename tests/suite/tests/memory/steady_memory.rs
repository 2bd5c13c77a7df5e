//! A tick takes no memory: neither in those who watch a run, nor in those who
//! make it.

use rusty_clients::recorder::{Delay, Step};
use rusty_clients::{ClientArgs, ClientError, Recorder};
use rusty_contract::log::LogHeader;
use rusty_contract::{Brief, Estimate, Frame, Participant, Role, RunDigest, Start};
use rusty_logger::Logger;
use rusty_metrics::Yardstick;
use rusty_scorer::scorer::Scorer;
use rusty_tests::fuzz::memory::measured;
use rusty_tests::*;

const COVARIANCE: [f64; 9] = [0.02, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.03];

/// A run that was never made: its header says that it is long.
fn header(ticks: u64) -> LogHeader {
    let out = folder();
    launch("header", out.path(), &["--ticks", "10"]);
    let mut header = Log::read(&out.at("run.log")).header;
    header.config.ticks = ticks;
    header
}

/// A recorder of that run, by its `new`.
fn recorder<W>(
    header: &LogHeader,
    out: &Path,
    new: impl FnOnce(&Start, &Brief, &ClientArgs) -> Result<W, ClientError>,
) -> W {
    let start = Start::new(header, 9, &Participant::new("recorder", Role::Logger));
    let brief = Brief { header: header.clone(), out_dir: None, report: true };
    let args = ClientArgs { out: Some(out.to_owned()), ..ClientArgs::default() };
    new(&start, &brief, &args).unwrap()
}

/// Shows it `ticks`, every fifth with a scan of N beams, and says how many bytes the
/// thread had in use for that, at most.
fn shown<W: Recorder>(recorder: &mut W, beams: usize, ticks: std::ops::Range<u64>) -> usize {
    let (digest, mut frame) = (RunDigest::default(), Frame::boxed());
    let ((), bytes) = measured(|| {
        for tick in ticks {
            frame.begin(tick, (tick + 1) as f64 * 0.02, Default::default(), Default::default());
            if tick % 5 == 4 {
                frame.write_scan(beams);
            }
            let at = |off_m: f64| SE2::new(tick as f64 * 1e-3, off_m, 0.1);
            let estimate = Estimate::new(at(tick as f64 * 1e-6)).with_covariance(COVARIANCE);
            let replies = [Reply::from(estimate.with_innovation(2.5, 1 + (tick % 9) as u32))];
            let delay =
                Some(Delay { reported_ns: 1000 + tick % 777, observed_ns: 3000 + tick % 999 });
            let (truth, delays) = (Some(at(0.0)), &[delay]);
            let step = Step { frame: &frame, truth, replies: &replies, delays, digest };
            recorder.step(&step).unwrap();
        }
    });
    bytes
}

#[test]
fn the_logger_takes_no_memory_for_a_tick() {
    let (header, out) = (header(1 << 40), folder());
    let mut logger = recorder(&header, out.path(), Logger::new);
    // What it writes a record in grows to the size of the first one.
    assert!(shown(&mut logger, 1080, 0..5) > 0, "nothing is counted");
    assert_eq!(shown(&mut logger, 1080, 5..50_000), 0);
}

#[test]
fn the_scorer_takes_no_memory_for_a_tick_and_little_for_a_million() {
    let (header, out) = (header(1 << 40), folder());
    let scorer = |_: &Start, brief: &Brief, args: &ClientArgs| {
        Scorer::with(Yardstick::default(), brief, args)
    };
    let (mut scorer, room) = measured(|| recorder(&header, out.path(), scorer));
    assert!((1 << 20..40 << 20).contains(&room), "{room} bytes of room to begin with");
    assert_eq!(shown(&mut scorer, 180, 0..130_000), 0);
    // Here it goes from sorting what it kept for medians to counting,
    let medians = shown(&mut scorer, 180, 130_000..140_000);
    assert!((1 << 20..25 << 20).contains(&medians), "{medians} bytes");
    assert_eq!(shown(&mut scorer, 180, 140_000..1_000_000), 0);
    // and here for the drift.
    let bins = shown(&mut scorer, 180, 1_000_000..1_100_000);
    assert!((1 << 20..3 << 20).contains(&bins), "{bins} bytes");
    assert_eq!(shown(&mut scorer, 180, 1_100_000..1_200_000), 0);
}

/// Memory of a process that is in use now, bytes, without the pages of its program: the
/// kernel takes those back and gives them again as it likes.
fn resident(pid: u32) -> u64 {
    let bytes = |part: &str| {
        let text = status(pid, part);
        1024 * text.strip_suffix(" kB").unwrap().trim().parse::<u64>().unwrap()
    };
    bytes("RssAnon") + bytes("RssShmem")
}

/// The logger's and the scorer's have a separate bound, above.
#[test]
fn the_server_and_an_estimator_take_no_memory_for_a_tick() {
    let args = ["--ticks", "100000000", "--set", "scan_every=0", "--paused"];
    let live = Live::start("launch", "flat", &[&args, &["--without", "score"]]);
    let step = |ticks: &str| live.control(&["step", ticks, "--timeout", "100"]);
    until("it can be stepped", || step("1"));
    let whole = || [live.server.pid(), live.pid_of("dead-reckoning")].map(resident);
    assert!(step("10000"));
    // Room that a process takes once is no leak: that grows in every window.
    let mut before = whole();
    let windows = (0..3).map(|_| {
        assert!(step("50000"));
        let now = whole();
        let grown = [0, 1].map(|k| now[k] as i64 - before[k] as i64);
        before = now;
        grown
    });
    let windows: Vec<[i64; 2]> = windows.collect();
    // 16 bytes a tick would be seen; the replies of a run alone are more.
    let is_steady = |process: usize| windows.iter().any(|grown| grown[process] < 800_000);
    assert!(is_steady(0) && is_steady(1), "bytes in 50,000 ticks each: {windows:?}");
    assert!(live.control(&["stop"]));
    live.ends_with(3);
}
