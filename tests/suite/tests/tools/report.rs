//! The report of a run: one page that a browser opens without complaint, that
//! needs no network, no script and no mouse, and that fits a phone and paper.
//!
//! `RUSTY_SHOTS=folder` keeps what the pages looked like there.

use nalgebra::Vector3;
use rusty_contract::Estimate;
use rusty_contract::log::{LogHeader, LogReader};
use rusty_contract::score::{ComputeTimes, Durations};
use rusty_scorer::report::html;
use rusty_scorer::scoring::trace::Whole;
use rusty_scorer::scoring::{TraceKeeper, score as scored};
use rusty_tests::browser::Browser;
use rusty_tests::*;

/// A name that would do something if a page ran it.
const EVIL: &str = "<script>document.title=1</script><img src=x onerror=document.title=1>\"'&";

/// Of those that are drawn the third must not be run.
pub(crate) const NAMES: [&str; 10] = [
    "particle-filter",
    "sure-of-itself",
    EVIL,
    "dead-reckoning",
    "extended-kalman-filter",
    "unscented-kalman-filter-with-a-long-name",
    "scan-matcher",
    "pose-graph-with-loop-closures",
    "grid-localisation",
    "oracle",
];

#[test]
fn a_run_and_its_log_have_a_report_with_seed_and_digest() {
    let out = folder();
    let report = launch("report", out.path(), &["--ticks", "60"]);
    let path = PathBuf::from(text(&report, "report"));
    assert_eq!(path, fs::canonicalize(out.path()).unwrap().join("report.html"));
    let page = fs::read_to_string(path).unwrap();
    let command = "<code>sim-server launch ";
    for part in ["<dt>seed</dt><dd>42</dd>", text(&report, "digest"), "60 ticks", command, " UTC"] {
        assert!(page.contains(part), "{part} is missing");
    }
    let (log, again) = (out.at("run.log"), folder());
    let args = ["--log", arg(&log), "--out", arg(again.path())];
    execute("score", &args).expect(0);
    // The same, but for how long answers took and what filters held possible: no
    // log has either, and the page says so.
    let of_log = fs::read_to_string(again.at("report.html")).unwrap();
    let (before, rest) = of_log.split_once(" What filters held possible is not part").unwrap();
    let (_, after) = rest.split_once("</code>.").unwrap();
    let of_log = format!("{before}{after}");
    let without_times = |page: &str| {
        let (before, rest) = page.split_once("id=\"h-times\"").unwrap();
        let (_, after) = rest.split_once("</section>").unwrap();
        let (rest, _) = after.split_once("Compute time per tick").unwrap();
        format!("{before}{rest}")
    };
    assert!(without_times(&of_log) == without_times(&page), "a log tells another story");
}

#[test]
fn a_log_is_scored_for_some_estimators_only() {
    let (out, some) = (folder(), folder());
    let added = ["--ticks", "40", "--add", "second=dead-reckoning", "--add", "third=ekf"];
    let report = launch("only", out.path(), &added);
    let log = out.at("run.log");
    let args = ["--log", arg(&log), "--out", arg(some.path()), "--force", "--only"];
    execute("score", &[&args[..], &["third,second"]].concat()).expect(0);
    let scores = json_file(&some.at("score.json"));
    let names = |scores: &Value| -> Vec<String> {
        list(scores, "scores").iter().map(|score| text(score, "name").to_owned()).collect()
    };
    assert_eq!(names(&scores), ["second", "third"]);
    assert_eq!(
        list(&scores, "scores"),
        &list(&json!({ "scores": timeless(&report["scores"]) }), "scores")[1..]
    );
    let page = fs::read_to_string(some.at("report.html")).unwrap();
    assert!(page.contains("third") && !page.contains("<span>dead-reckoning</span>"));
    let said = execute("score", &[&args[..], &["nobody"]].concat()).expect(2);
    said.says("nobody").says("dead-reckoning, second, third");
}

/// Where the robot of the drawn run is at a tick: a bend through the flat.
fn truth(k: u32) -> SE2 {
    let t = f64::from(k) * 0.01;
    SE2::new(1.0, 4.4, 0.0).boxplus(&Vector3::new(1.1 * t, 0.0, 0.0)).compose(&SE2::new(
        0.0,
        0.25 * (1.7 * t).sin(),
        0.4 * (1.7 * t).cos(),
    ))
}

/// A run of estimators of which two of three know how wrong they are, more or
/// less, and the third does not say.
pub(crate) fn drawn_run(header: &LogHeader, names: &[&str], ticks: u32) -> String {
    drawn_run_of(header, names, ticks, 1.0)
}

/// The same with standard deviations that are this much larger.
fn drawn_run_of(header: &LogHeader, names: &[&str], ticks: u32, unsure: f64) -> String {
    let mut header = header.clone();
    let model = header.roster[0].clone();
    let participant = |name: &&str| {
        let mut participant = model.clone();
        participant.name = (*name).to_owned();
        participant
    };
    header.roster = names.iter().map(participant).collect();
    header.config.ticks = ticks.into();
    let mut keeper = TraceKeeper::new(&header);
    for k in 0..ticks {
        let t = f64::from(k) * 0.01;
        // A wobble, so that errors look like errors.
        let wobble = |a: f64| (a * t).sin() * 0.5 + (2.7 * a * t).sin() * 0.3;
        let estimate = |i: usize| {
            let far = [0.06, 0.11, 0.16][i % 3] * (0.15 + t / 5.0);
            let off = Vector3::new(wobble(2.0 + i as f64), wobble(3.1), 0.4 * wobble(1.3)) * far;
            let std_m = unsure * [0.05, 0.02, 0.0][i % 3] * (0.3 + t / 5.0);
            let (u, v, w) = (std_m * std_m, 0.4 * std_m * std_m, 0.16 * std_m * std_m);
            let p = [u, 0.3 * v, 0.0, 0.3 * v, v, 0.0, 0.0, 0.0, w];
            let pose = Estimate::from(truth(k).boxplus(&off));
            Some(Estimate { covariance: (i % 3 < 2).then_some(p), ..pose })
        };
        let ranges_m: Vec<f64> =
            (0..180).map(|beam| 1.0 + 0.4 * (f64::from(beam) * 0.1 + t).sin()).collect();
        let scan = (k % 5 == 4).then_some(&ranges_m[..]);
        keeper.push(0.02 * f64::from(k + 1), Some(truth(k)), scan, (0..names.len()).map(estimate));
    }
    let whole = Whole { ticks: ticks.into(), ticks_with_truth: ticks.into(), driven_m: 6.0 };
    let mut trace = keeper.finish(whole);
    trace.digest = "0123456789abcdef0123456789abcdef".to_owned();
    let mut scores = scored(&trace);
    for (score, slow) in scores.iter_mut().zip([80.0, 3.0, 1.0].into_iter().cycle()) {
        let times = |s: f64| Durations { p50_s: s, p99_s: 4.0 * s, max_s: 30.0 * s };
        let (reported, observed) = (times(slow * 2e-6), times(slow * 2e-6 + 5e-6));
        score.compute = Some(ComputeTimes { reported, observed });
    }
    let scores = trace.report(scores);
    html(&header, &trace, &scores)
}

/// Keeps a picture, on request.
fn keep(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("RUSTY_SHOTS") {
        fs::write(Path::new(&folder).join(name), bytes).unwrap();
    }
}

/// What is shown of the chosen tick: words, errors, what the map says of itself, cursor.
pub(crate) fn scene(browser: &mut Browser) -> String {
    let scene = "[document.querySelector('#now').textContent,
        [...document.querySelectorAll('#readout td')].map((cell) => cell.textContent).join(' | '),
        document.querySelector('#map').ariaLabel,
        document.querySelector('#position .cursor').getAttribute('transform')].join('; ')";
    browser.value(scene).as_str().unwrap().to_owned()
}

/// The map as pixels.
pub(crate) fn map(browser: &mut Browser) -> Value {
    browser.value("document.querySelector('#map').toDataURL()")
}

/// The errors in a scene: of each estimator that of position in m, that of
/// heading in degrees, and the NEES, in words.
fn errors(scene: &str) -> Vec<&str> {
    scene.split("; ").nth(1).unwrap().split(" | ").collect()
}

fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| !(c.is_ascii_digit() || ".-e".contains(c)));
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn a_browser_shows_it_on_screen_phone_and_paper_and_the_slider_moves_the_scan() {
    let Some(mut browser) = Browser::start() else { return };
    let out = folder();
    launch("browser", out.path(), &["--ticks", "20"]);
    let reader = LogReader::open(&out.at("run.log")).unwrap();
    let file = out.at("drawn.html");
    fs::write(&file, drawn_run(reader.header(), &NAMES[..3], 500)).unwrap();

    browser.resize(1280, 900);
    browser.media("light", "screen");
    browser.open(&file, "#tick=499");
    let at_first = scene(&mut browser);
    assert!(at_first.contains("tick 499 ") && at_first.contains("Scan of tick 499."), "{at_first}");
    assert_eq!(browser.value("document.title"), "apartment · seed 42", "a name was run");
    assert_eq!(browser.value("document.images.length"), 0, "a name became a part of the page");
    keep("light.png", &browser.picture());
    the_slider_moves(&mut browser, &at_first);
    who_is_not_wanted_is_hidden(&mut browser);
    who_comes_back_finds_what_is_drawn(&mut browser, &file);

    browser.open(&file, "#tick=250");
    assert!(scene(&mut browser).contains("tick 250 "), "a link to a tick");
    keep("tick-250.png", &browser.picture());
    browser.media("dark", "screen");
    keep("dark.png", &browser.picture());
    let ground = |browser: &mut Browser| {
        let colours = "[getComputedStyle(document.querySelector('section')).backgroundColor,
            getComputedStyle(document.querySelector('#position text')).fill].join('; ')";
        let brightness = numbers(&browser.value(colours).as_str().unwrap().replace("rgb", ""));
        (brightness[0], brightness[3])
    };
    let (card, ink) = ground(&mut browser);
    assert!(card < 50.0 && ink > 200.0, "dark: {card}, {ink}");
    on_a_phone(&mut browser);
    let sure = out.at("sure.html");
    fs::write(&sure, drawn_run_of(reader.header(), &NAMES[..3], 500, 1e-3)).unwrap();
    numbers_fit_on_a_phone(&mut browser, &sure);
    browser.open(&file, "");
    // On paper it is always light, and what cannot be moved is not there.
    browser.media("dark", "print");
    let (card, ink) = ground(&mut browser);
    assert!(ink < 60.0, "print: {card}, {ink}");
    let control = "getComputedStyle(document.querySelector('#control')).display";
    assert_eq!(browser.value(control), "none");
    keep_paper(&mut browser, "paper.pdf");
    let many = out.at("many.html");
    fs::write(&many, drawn_run(reader.header(), &NAMES, 200)).unwrap();
    nothing_is_cut_off_on_paper(&mut browser, &many);
    assert_eq!(browser.complaints(), [""; 0]);
    without_script(&mut browser, &file, &at_first);
}

/// Keys, links and clicks show other ticks, and the last one looks as it was
/// drawn.
fn the_slider_moves(browser: &mut Browser, at_first: &str) {
    browser.value("document.querySelector('#tick').focus()");
    browser.press("ArrowLeft", 37);
    let before = scene(browser);
    assert!(before.contains("tick 498 "), "{before}");
    // One tick earlier the scan is that of tick 494.
    assert!(before.contains("Scan of tick 494."), "{before}");
    browser.press("ArrowLeft", 37);
    assert!(scene(browser).contains("Scan of tick 494."), "the same scan, a tick earlier");
    assert_eq!(browser.value("location.hash"), "#tick=497");
    assert_ne!(errors(&before), errors(at_first), "the errors did not move");
    let drawn = map(browser);
    browser.press("End", 35);
    assert_eq!(scene(browser), at_first);
    assert_ne!(map(browser), drawn, "the map did not move");
    let at = truth(499);
    let place = format!("Robot at {:.2}, {:.2} m.", at.x(), at.y());
    assert!(at_first.contains(&place), "{place} {at_first}");
    browser.press("Home", 36);
    assert!(scene(browser).contains("tick 0 "));
    let spoken = "document.querySelector('#tick').getAttribute('aria-valuetext')";
    assert_eq!(browser.value(spoken), "tick 0 · 0.02 s");
    a_chart_chooses_its_time(browser);
}

/// By click and by dragging, to wherever the button is let go.
fn a_chart_chooses_its_time(browser: &mut Browser) {
    let corner = "(() => { const chart = document.querySelector('#position');
        chart.scrollIntoView({ block: 'center' });
        const box = chart.getBoundingClientRect();
        return [box.left, box.top, box.width].join('; '); })()";
    let corner = numbers(browser.value(corner).as_str().unwrap());
    let frame = |share: f64| {
        [corner[0] + corner[2] * (62.0 + share * (458.0 - 62.0)) / 480.0, corner[1] + 60.0]
    };
    let near = |browser: &mut Browser, tick: f64| {
        let at = numbers(&scene(browser))[0];
        assert!((at - tick).abs() <= 2.0, "at {at} and not at {tick}");
        assert_eq!(browser.value("location.hash"), format!("#tick={at}"));
    };
    browser.mouse("mousePressed", frame(0.5));
    near(browser, 249.5);
    browser.mouse("mouseMoved", frame(0.25));
    browser.mouse("mouseReleased", frame(0.25));
    near(browser, 125.0);
    browser.mouse("mousePressed", frame(0.5));
    // Beyond the end of the chart is the end of the run.
    browser.mouse("mouseMoved", frame(1.05));
    browser.mouse("mouseReleased", frame(1.05));
    near(browser, 499.0);
    browser.mouse("mouseMoved", frame(0.5));
    near(browser, 499.0);
}

/// What the slider and the boxes say is what is drawn, also for who comes back.
fn who_comes_back_finds_what_is_drawn(browser: &mut Browser, file: &Path) {
    browser.open(file, "");
    let moved = "(() => { const [slider, box] = ['#tick', '.toggle'].map((what) => document.querySelector(what));
        slider.value = 100; slider.dispatchEvent(new Event('input'));
        box.checked = false; box.dispatchEvent(new Event('change')); })()";
    browser.value(moved);
    assert!(scene(browser).contains("tick 100 "));
    browser.leave_and_come_back();
    let slider = browser.value("document.querySelector('#tick').value");
    let at = numbers(&scene(browser))[0];
    assert_eq!(slider, at.to_string(), "the slider's tick, and the one drawn");
    let agree = "document.querySelector('.toggle').checked
        === (document.querySelector('.e0').style.display !== 'none')";
    assert_eq!(browser.value(agree), true, "a box says something else than the map");
}

/// The boxes before the names can be reached and set by keys.
fn who_is_not_wanted_is_hidden(browser: &mut Browser) {
    let shown = "[...document.querySelectorAll('.e0')].filter((part) => part.style.display !== 'none').length";
    assert!(browser.value(shown).as_u64().unwrap() > 5);
    browser.value("document.querySelector('#fit').focus()");
    browser.press("Tab", 9);
    assert_eq!(browser.value("document.activeElement.className"), "toggle");
    browser.press(" ", 32);
    assert_eq!(browser.value(shown), 0);
    browser.press(" ", 32);
    assert!(browser.value(shown).as_u64().unwrap() > 5);
}

/// The page is no wider than a phone, and what is written can be read.
fn on_a_phone(browser: &mut Browser) {
    browser.media("light", "screen");
    for width in [360, 1280] {
        browser.resize(width, 740);
        let wide = browser.value("document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(wide <= u64::from(width), "{wide} of {width} pixels");
        let least = "Math.min(...[...document.querySelectorAll('svg text')].map((text) => {
            const svg = text.ownerSVGElement;
            if (svg.clientWidth === 0) return Infinity;
            return parseFloat(getComputedStyle(text).fontSize) * svg.clientWidth / svg.viewBox.baseVal.width; }))";
        let least = browser.value(least).as_f64().unwrap();
        assert!(least > 8.5, "letters of {least} pixels at {width}");
        keep(&format!("wide-{width}.png"), &browser.picture());
    }
}

/// No number is cut where letters are large and NEES is far above its band.
fn numbers_fit_on_a_phone(browser: &mut Browser, file: &Path) {
    browser.media("light", "screen");
    browser.resize(390, 740);
    browser.open(file, "");
    let outside = "[...document.querySelectorAll('svg:not(.swatch) text')].filter((text) =>
        text.getBoundingClientRect().left < text.ownerSVGElement.getBoundingClientRect().left)
        .map((text) => text.textContent).join('; ')";
    assert_eq!(browser.value(outside), "");
    keep("phone-nees.png", &browser.picture());
}

/// Nothing is wider than what A4 has between its margins.
fn nothing_is_cut_off_on_paper(browser: &mut Browser, file: &Path) {
    let room = (210.0 - 2.0 * 14.0) / 25.4 * 96.0;
    browser.resize(room as u32, 1016);
    browser.open(file, "");
    assert_eq!(browser.value("document.querySelectorAll('.scores thead th').length"), 10);
    let furthest = "Math.max(document.documentElement.scrollWidth,
        ...[...document.querySelectorAll('body :not(svg, svg *)')].map((part) => part.scrollWidth),
        ...[...document.querySelectorAll('.scores *, .readout *')]
            .map((part) => part.getBoundingClientRect().right))";
    let furthest = browser.value(furthest).as_f64().unwrap();
    assert!(furthest <= room, "{furthest} of {room} pixels");
    keep_paper(browser, "many.pdf");
}

fn keep_paper(browser: &mut Browser, name: &str) {
    let paper = browser.paper();
    assert!(paper.starts_with(b"%PDF") && paper.len() > 20_000);
    keep(name, &paper);
}

/// Without a script the page is complete and shows the whole run and its end.
fn without_script(browser: &mut Browser, file: &Path, at_first: &str) {
    browser.ask("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
    browser.media("light", "screen");
    browser.open(file, "#tick=3");
    let written = scene(browser);
    assert!(written.starts_with("tick 499 "), "{written}");
    // What the player makes of the last tick is what was written, but for the last digit,
    // which results from single precision.
    assert_eq!(errors(&written).len(), 9);
    assert_eq!((errors(&written)[8], errors(at_first)[8]), ("–", "–"), "no covariance");
    for (k, (written, moved)) in errors(&written).iter().zip(errors(at_first)).enumerate().take(8) {
        let [written, moved] = [*written, moved].map(|words| words.parse::<f64>().unwrap());
        let last_digit = if k % 3 == 0 { 1e-3 } else { 1e-2 };
        assert!(written != 0.0, "an error of nothing shows nothing");
        assert!((written - moved).abs() < 1.01 * last_digit, "{k}: {written}, then {moved}");
    }
    for (part, display) in [("#map", "none"), ("#whole", "block"), ("#control", "none")] {
        let found = format!("getComputedStyle(document.querySelector('{part}')).display");
        assert_eq!(browser.value(&found), display, "{part}");
    }
}
