//! Ticks per second of a run at full speed, in the company of a viewer and a browser.

use std::collections::BTreeMap;
use std::path::Path;

use rusty_tests::browser::Browser;
use rusty_tests::viewed::Viewed;
use rusty_tests::{Value, folder, fresh_run, launch, sim_server, until};

use crate::figures::{print, wait};

/// Three estimators, as in the goal for speed.
const RUN: [&str; 8] =
    ["--ticks", "10000", "--pace", "max", "--add", "ekf=ekf", "--add", "mcl=mcl"];

/// A page without a viewer that draws something of the size of the map N times a second:
/// the price of the browser alone.
const ANIMATION: &str = "data:text/html,<canvas id=c width=720 height=640></canvas><script>\
    const x = document.getElementById('c').getContext('2d'); let n = 0;\
    setInterval(() => { n += 1; x.clearRect(0, 0, 720, 640);\
    for (let k = 0; k < 400; k += 1) x.fillRect((k * 37 + n) % 720, (k * 91) % 640, 3, 3); }, ";

/// What is there next to the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Company {
    Alone,
    Viewer,
    Page,
    EmptyPage,
    FourPictures,
    TenPictures,
}

const ALL: [Company; 6] = [
    Company::Alone,
    Company::Viewer,
    Company::Page,
    Company::EmptyPage,
    Company::FourPictures,
    Company::TenPictures,
];

impl Company {
    fn text(self) -> &'static str {
        match self {
            Self::Alone => "nothing",
            Self::Viewer => "a viewer without a page",
            Self::Page => "a viewer with an open page",
            Self::EmptyPage => "no viewer, and a browser with an empty page",
            Self::FourPictures => "no viewer, and a page with 4 pictures per second",
            Self::TenPictures => "no viewer, and a page with 10 pictures per second",
        }
    }
}

/// What a run was measured to be.
struct Figures {
    ticks_per_s: f64,
    /// Time on a core, per second of the run.
    browser: f64,
    viewer: f64,
    pictures_per_s: f64,
}

pub fn measure(runs: usize) {
    let mut all: BTreeMap<Company, Vec<(f64, Figures)>> = BTreeMap::new();
    for _ in 0..runs {
        // The machine may become slower meanwhile: each is compared with the runs alone
        // before and after it.
        let mut before = run(Company::Alone);
        for company in ALL.into_iter().filter(|company| *company != Company::Alone) {
            let found = run(company);
            let after = run(Company::Alone);
            let calm = (before.ticks_per_s + after.ticks_per_s) / 2.0;
            all.entry(company).or_default().push((found.ticks_per_s / calm, found));
            let earlier = std::mem::replace(&mut before, after);
            all.entry(Company::Alone).or_default().push((1.0, earlier));
        }
    }
    println!("A run at full speed with three estimators, a scorer and a logger; next to it:");
    for (company, found) in &all {
        let figure = |of: fn(&Figures) -> f64| -> Vec<f64> {
            found.iter().map(|(_, figures)| of(figures)).collect()
        };
        println!("  {}:", company.text());
        print("    ticks", "per s", &mut figure(|f| f.ticks_per_s));
        if *company == Company::Alone {
            continue;
        }
        let mut ratios: Vec<f64> = found.iter().map(|(ratio, _)| *ratio).collect();
        print("    ticks per second over those with nothing", "", &mut ratios);
        print("    cores used by the viewer", "", &mut figure(|f| f.viewer));
        print("    cores used by the browser", "", &mut figure(|f| f.browser));
        print("    pictures of the map", "per s", &mut figure(|f| f.pictures_per_s));
    }
}

fn run(company: Company) -> Figures {
    let out = folder();
    match company {
        Company::Alone => alone(out.path(), None),
        Company::Viewer => watched(out.path(), None),
        Company::Page => watched(out.path(), Some(crate::browser())),
        Company::EmptyPage => alone(out.path(), Some(crate::browser())),
        Company::FourPictures | Company::TenPictures => {
            let mut browser = crate::browser();
            let pause_ms = if company == Company::FourPictures { 250 } else { 100 };
            browser.visit(&format!("{ANIMATION}{pause_ms});</script>"));
            alone(out.path(), Some(browser))
        }
    }
}

fn alone(out: &Path, browser: Option<Browser>) -> Figures {
    let seconds = || browser.as_ref().map_or(0.0, |browser| seconds_of(browser.pid()));
    let before = seconds();
    let report = launch("costs", out, &RUN);
    Figures::of(&report, [seconds() - before, 0.0], 0.0)
}

fn watched(out: &Path, mut browser: Option<Browser>) -> Figures {
    let run = fresh_run("costs");
    let viewed = Viewed::launch(&run, out, &[&RUN, &["--paused"]]);
    let viewer = children_of(viewed.child.id());
    let viewer = viewer.into_iter().find(|(_, name)| name == "view").expect("a viewer").0;
    if let Some(browser) = &mut browser {
        browser.visit(&viewed.address);
        wait(browser, "rustyView.draws > 0 && rustyView.drawnTick < 0");
    }
    let seconds = || [browser.as_ref().map_or(0.0, |b| seconds_of(b.pid())), seconds_of(viewer)];
    let before = seconds();
    sim_server(&["control", run.as_str(), "resume"]).expect(0);
    let mut report = Value::Null;
    until("the report", || {
        std::thread::sleep(std::time::Duration::from_millis(20));
        report = serde_json::from_str(&viewed.printed()).unwrap_or_default();
        !report.is_null()
    });
    let after = seconds();
    let draws = browser.as_mut().map_or(0.0, |b| crate::number(b, "rustyView.draws"));
    drop((browser, viewed));
    Figures::of(&report, [0, 1].map(|k| after[k] - before[k]), draws)
}

impl Figures {
    fn of(report: &Value, [browser, viewer]: [f64; 2], draws: f64) -> Self {
        let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("{key}: {report}"));
        let elapsed_s = number("elapsed_s");
        Self {
            ticks_per_s: number("ticks_per_s"),
            browser: browser / elapsed_s,
            viewer: viewer / elapsed_s,
            pictures_per_s: draws / elapsed_s,
        }
    }
}

/// Fields of a process after its name: those of proc(5) from the third on.
fn stat(pid: u32) -> Option<(String, Vec<String>)> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let (head, tail) = text.rsplit_once(')')?;
    let name = head.split_once('(')?.1.to_owned();
    Some((name, tail.split_whitespace().map(str::to_owned).collect()))
}

fn children_of(parent: u32) -> Vec<(u32, String)> {
    let of = |(pid, _): (u32, Vec<String>)| {
        let (name, fields) = stat(pid)?;
        (fields.get(1)?.parse() == Ok(parent)).then_some((pid, name))
    };
    rusty_tests::processes().into_iter().filter_map(of).collect()
}

/// Time on a core of a process, of those below it, and of those below it that have ended, s.
fn seconds_of(pid: u32) -> f64 {
    let fields = stat(pid).map(|(_, fields)| fields).unwrap_or_default();
    // utime, stime, cutime, cstime.
    let own = fields.iter().skip(11).take(4).filter_map(|field| field.parse::<f64>().ok());
    let own = own.sum::<f64>() / rustix::param::clock_ticks_per_second() as f64;
    own + children_of(pid).into_iter().map(|(child, _)| seconds_of(child)).sum::<f64>()
}
