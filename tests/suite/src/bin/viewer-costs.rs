//! What a viewer with a page costs, and how fast the page is, in a browser without a
//! window: the table of `docs/view.md`. Run it from a release build, with nothing else
//! running.

#[path = "viewer-costs/figures.rs"]
mod figures;
#[path = "viewer-costs/keys.rs"]
mod keys;
#[path = "viewer-costs/speed.rs"]
mod speed;

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use figures::{number, print, wait};
use rusty_contract::Exit;
use rusty_tests::browser::Browser;
use rusty_tests::viewed::Viewed;
use rusty_tests::{arg, folder, fresh_run, logged, sim_server};

/// Measure what a viewer with a page costs, in a browser without a window
///
/// A row that cannot be measured is reported with the reason, the other rows follow, and
/// the exit code is 1. No wait lasts longer than two minutes.
#[derive(Parser)]
struct Args {
    /// How often each figure is measured
    #[arg(long, default_value_t = 5)]
    runs: usize,

    /// Measure only these rows
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Row>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Row {
    /// Start of `view LOG`, and the first picture
    Opening,
    /// Ticks of 1080 beams that a page misses at 500 per second
    Pace10,
    /// The same at 1000 per second
    Pace20,
    /// Key to command and to picture, at 50 ticks per second
    Keys,
    /// Ticks per second at full speed, with and without a page
    Speed,
}

/// A scan of 1080 beams in every tick.
const WIDE: [&str; 4] = ["--set", "lidar.beams=1080", "--set", "scan_every=1"];
/// Time for which a page of a run with a pace is measured.
const WINDOW: Duration = Duration::from_secs(5);

fn main() -> Exit {
    let Args { runs, only } = Args::parse();
    if cfg!(debug_assertions) {
        println!("This is a debug build: its figures say little.");
    }
    // The reason is printed with its row.
    set_hook(Box::new(|_| {}));
    let rows = Row::value_variants().iter().filter(|row| only.is_empty() || only.contains(row));
    let measured: Vec<bool> = rows.map(|&row| measure(row, runs)).collect();
    if measured.contains(&false) { Exit::Failed } else { Exit::Done }
}

/// Measures a row; returns whether that was possible.
fn measure(row: Row, runs: usize) -> bool {
    let measured = catch_unwind(AssertUnwindSafe(|| match row {
        Row::Opening => opening(runs),
        Row::Pace10 => pace(runs, "10"),
        Row::Pace20 => pace(runs, "20"),
        Row::Keys => keys::measure(runs),
        Row::Speed => speed::measure(runs),
    }));
    if let Err(reason) = &measured {
        let text = reason.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| reason.downcast_ref().copied()).unwrap_or("no reason given");
        println!("{row:?}: not measured: {text}");
    }
    measured.is_ok()
}

/// A browser with a page of the size of a desktop, which is not observed more than needed.
fn browser() -> Browser {
    let mut browser = Browser::start().expect("a browser");
    browser.report_nothing();
    browser.resize(1280, 900);
    browser
}

fn opening(runs: usize) {
    let (_out, log) = logged("costs", &["--ticks", "600", "--add", "ekf=ekf"]);
    let (mut addresses, mut pictures) = (Vec::new(), Vec::new());
    let mut browser = browser();
    for _ in 0..runs {
        let begun = Instant::now();
        let viewed = Viewed::view(&[arg(&log)]);
        addresses.push(begun.elapsed().as_secs_f64() * 1e3);
        browser.visit(&viewed.address);
        // The first drawing may be one without a tick.
        wait(&mut browser, "rustyView.firstMs > 0");
        pictures.push(number(&mut browser, "rustyView.firstMs"));
    }
    print("address after the start of view LOG", "ms", &mut addresses);
    print("first picture with a tick after the page was opened", "ms", &mut pictures);
}

/// Ticks that a page misses, and the time of a drawing. The run does not end by itself, so
/// that the page does not turn to its log while it is measured.
fn pace(runs: usize, pace: &str) {
    let (mut rates, mut missed, mut drawn) = (Vec::new(), Vec::new(), Vec::new());
    let mut browser = browser();
    for _ in 0..runs {
        let (run, out) = (fresh_run("pace"), folder());
        let args: [&[&str]; 2] = [&WIDE, &["--pace", pace, "--ticks", "1000000"]];
        let viewed = Viewed::launch(&run, out.path(), &args);
        browser.visit(&viewed.address);
        wait(&mut browser, "rustyView.ticks > 100");
        let mut now = || {
            let counts = browser.value("[rustyView.ticks, rustyView.gaps, performance.now()]");
            [0, 1, 2].map(|k| counts[k].as_f64().expect("a number"))
        };
        let before = now();
        std::thread::sleep(WINDOW);
        let after = now();
        let [ticks, gaps, ms] = [0, 1, 2].map(|k| after[k] - before[k]);
        rates.push((ticks + gaps) / ms * 1e3);
        missed.push(100.0 * gaps / (ticks + gaps));
        drawn.push(number(&mut browser, "rustyView.drawMs / rustyView.draws"));
        sim_server(&["control", run.as_str(), "stop"]).expect(0);
        browser.visit("about:blank");
        viewed.ends_with(3);
    }
    println!("Ticks of 1080 beams at pace {pace}:");
    print("  ticks of the run", "per s", &mut rates);
    print("  ticks that the page missed", "%", &mut missed);
    print("  one drawing of the map", "ms", &mut drawn);
}
