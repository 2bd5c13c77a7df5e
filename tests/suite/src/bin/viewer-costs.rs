//! What a viewer with a page costs, and how fast the page is, in a browser without a
//! window: the table of `docs/view.md`. Run it from a release build, with nothing else
//! running.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use clap::Parser;
use rusty_metrics::percentile;
use rusty_tests::browser::Browser;
use rusty_tests::viewed::Viewed;
use rusty_tests::{arg, folder, fresh_run, launch, logged};
use serde_json::Value;

/// Measure what a viewer with a page costs, in a browser without a window
#[derive(Parser)]
struct Args {
    /// How often each figure is measured
    #[arg(long, default_value_t = 5)]
    runs: usize,
}

/// Three estimators, as in the goal for speed.
const THREE: [&str; 4] = ["--add", "ekf=ekf", "--add", "mcl=mcl"];
/// A scan of 1080 beams in every tick.
const WIDE: [&str; 4] = ["--set", "lidar.beams=1080", "--set", "scan_every=1"];

fn main() -> Result<(), Box<dyn Error>> {
    let Args { runs } = Args::parse();
    if cfg!(debug_assertions) {
        println!("This is a debug build: its figures say little.");
    }
    let Some(mut browser) = Browser::start() else { return Ok(()) };
    browser.resize(1280, 900);
    opening(&mut browser, runs);
    for pace in ["10", "20"] {
        frames(&mut browser, runs, pace);
    }
    keys(&mut browser, runs);
    drop(browser);
    ticks_per_s(runs)
}

/// Prints a figure as least, median and most.
fn say(what: &str, unit: &str, mut values: Vec<f64>) {
    let mut at = |fraction| percentile(&mut values, fraction).unwrap_or(f64::NAN);
    let [least, median, most] = [0.0, 0.5, 1.0].map(&mut at);
    println!("{what}: {median:.2} {unit} ({least:.2} to {most:.2})");
}

fn number(browser: &mut Browser, expression: &str) -> f64 {
    browser.value(expression).as_f64().unwrap_or(f64::NAN)
}

fn opening(browser: &mut Browser, runs: usize) {
    let (_out, log) = logged("costs", &["--ticks", "600", "--add", "ekf=ekf"]);
    let (mut addresses, mut pictures) = (Vec::new(), Vec::new());
    for _ in 0..runs {
        let begun = Instant::now();
        let viewed = Viewed::view(&[arg(&log)]);
        addresses.push(begun.elapsed().as_secs_f64() * 1e3);
        browser.visit(&viewed.address);
        browser.until("rustyView.ticks > 0 && rustyView.draws > 0");
        pictures.push(number(browser, "rustyView.firstMs"));
    }
    say("address after the start of view LOG", "ms", addresses);
    say("first picture with a tick after the page was opened", "ms", pictures);
}

fn frames(browser: &mut Browser, runs: usize, pace: &str) {
    let rate: f64 = 50.0 * pace.parse::<f64>().unwrap_or(f64::NAN);
    let (mut missed, mut drawn) = (Vec::new(), Vec::new());
    for _ in 0..runs {
        let (run, out) = (fresh_run("frames"), folder());
        let ticks = format!("{}", rate * 6.0);
        let all: [&[&str]; 3] = [&WIDE, &["--pace", pace, "--ticks", &ticks], &[]];
        let viewed = Viewed::launch(&run, out.path(), &all);
        browser.visit(&viewed.address);
        browser.until(&format!("rustyView.lastTick > {}", rate * 5.0));
        let [came, gaps] = ["ticks", "gaps"].map(|name| number(browser, &field(name)));
        missed.push(100.0 * gaps / (came + gaps));
        drawn.push(number(browser, "rustyView.drawMs / rustyView.draws"));
        browser.visit("about:blank");
        viewed.ends_with(0);
    }
    say(&format!("ticks of 1080 beams missed at {rate} per second"), "%", missed);
    say(&format!("one drawing of the map at {rate} per second"), "ms", drawn);
}

fn field(name: &str) -> String {
    format!("rustyView.{name}")
}

/// A second socket of the page says when the first tick of another command comes.
const LISTEN: &str = "
globalThis.keys = { pressed: 0, times: [], ahead: 0 };
addEventListener('keydown', (e) => { if (!e.repeat) keys.pressed = performance.now(); }, true);
addEventListener('keyup', () => { keys.pressed = performance.now(); }, true);
const other = new WebSocket(`ws://${location.host}/socket`);
other.binaryType = 'arraybuffer';
other.onopen = () => other.send(JSON.stringify(Object.fromEntries(new URLSearchParams(location.hash.slice(1)))));
other.onmessage = ({ data }) => {
  if (typeof data === 'string') return;
  const words = new Float64Array(data), whole = new Uint32Array(data);
  for (let at = 0; at < words.length; at += Math.max(1, whole[2 * at + 1])) {
    if (whole[2 * at] !== 1 || words[at + 6] === keys.ahead) continue;
    keys.ahead = words[at + 6];
    if (keys.pressed) keys.times.push(performance.now() - keys.pressed);
  }
};
";

fn keys(browser: &mut Browser, runs: usize) {
    let scenario = rusty_tests::repository().join("clients/viewer/scenarios/drive.toml");
    let (run, out) = (fresh_run("keys"), folder());
    // Ticks of 5 ms.
    let args = [arg(&scenario), "--ticks", "1000000", "--set", "dt_s=0.005"];
    let viewed = Viewed::launch(&run, out.path(), &[&args]);
    browser.visit(&viewed.address);
    browser.until("!document.getElementById('drive').hidden && rustyView.ticks > 0");
    browser.value("document.getElementById('drive').click()");
    browser.value(LISTEN);
    for pressed in 1..=5 * runs {
        for (kind, count) in [("keyDown", 2 * pressed - 1), ("keyUp", 2 * pressed)] {
            browser.key(kind, "ArrowUp", 38, "");
            browser.until(&format!("keys.times.length >= {count}"));
        }
    }
    let times = browser.value("keys.times");
    let times = times.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    say("key to the first tick with its command on the page", "ms", times);
    rusty_tests::sim_server(&["control", run.as_str(), "stop"]);
    browser.visit("about:blank");
}

fn rate_of(report: &Value) -> Result<f64, Box<dyn Error>> {
    report["ticks_per_s"].as_f64().ok_or_else(|| format!("no ticks per second: {report}").into())
}

fn ticks_per_s(runs: usize) -> Result<(), Box<dyn Error>> {
    let ticks = ["--ticks", "60000"];
    let out = folder();
    let alone = |name: &str| launch(name, Path::new(&out.at(name)), &[&ticks[..], &THREE].concat());
    let (mut bare, mut paged) = (Vec::new(), Vec::new());
    for k in 0..runs {
        let calm = rate_of(&alone(&format!("calm-{k}")))?;
        for has_page in [false, true] {
            let (run, folder) = (fresh_run("costs"), folder());
            let Some(mut browser) = Browser::start() else { return Ok(()) };
            let viewed = Viewed::launch(&run, folder.path(), &[&ticks, &THREE, &["--paused"]]);
            if has_page {
                browser.visit(&viewed.address);
                browser.until("rustyView.draws > 0");
            }
            rusty_tests::sim_server(&["control", run.as_str(), "resume"]).expect(0);
            rusty_tests::until("the report", || folder.at("run.log").exists());
            let (text, errors) = viewed.ends_with(0);
            let report: Value =
                serde_json::from_str(&text).map_err(|e| format!("{e}: {errors}"))?;
            let ratio = rate_of(&report)? / calm;
            if has_page { paged.push(ratio) } else { bare.push(ratio) }
        }
    }
    say("ticks per second with a viewer over those without", "", bare);
    say("the same with an open page", "", paged);
    Ok(())
}
