//! What filters hold possible, for looking at: whether a process observes changes
//! no bit of a run, an observer that stands still or dies costs it nothing and
//! leaves nothing, and the report shows what came.

use std::io::{BufRead as _, BufReader};
use std::process::Stdio;

use rusty_tests::browser::Browser;
use rusty_tests::*;

const CLOUD: [&str; 2] = ["--add", "cloud=05_belief"];
const TICKS: [&str; 2] = ["--ticks", "100"];

/// The data that a report's script has.
fn data(page: &str) -> Value {
    let (_, data) = page.split_once("id=\"data\">").unwrap();
    serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
}

fn page(folder: &Path) -> String {
    fs::read_to_string(folder.join("report.html")).unwrap()
}

/// Ticks of the beliefs that a report has of its first filter.
fn ticks(page: &str) -> Vec<u64> {
    let ticks = &data(page)["beliefs"][0]["ticks"];
    ticks.as_array().unwrap().iter().map(|tick| tick.as_u64().unwrap()).collect()
}

fn cloud(tag: &str, out: &Path, more: &[&str]) -> Value {
    launch(tag, out, &[&CLOUD[..], &TICKS, more].concat())
}

#[test]
fn the_report_shows_what_a_filter_held_possible_and_the_run_is_the_same_without() {
    let (seen, again, blind) = (folder(), folder(), folder());
    let report = cloud("seen", seen.path(), &[]);
    let text = page(seen.path());
    // A scan at every fifth tick; the last belief may come too late.
    assert_eq!(ticks(&text), (0..20).map(|k| 5 * k).collect::<Vec<_>>());
    for part in ["particles of cloud", "as received", "cloud: particles 500, tick 95"] {
        assert!(text.contains(part), "{part} is missing");
    }
    assert!(fs::read_to_string(seen.at("report.svg")).unwrap().contains("Arrowheads"));
    // The same run has the same beliefs.
    cloud("again", again.path(), &[]);
    assert_eq!(data(&page(again.path()))["beliefs"], data(&text)["beliefs"]);
    let alone = cloud("alone", blind.path(), &["--without", "score"]);
    assert_eq!(alone["digest"], report["digest"]);
    assert_eq!(alone["world_digest"], report["world_digest"]);
    // No filter shows any: the page has nothing of it.
    let plain = folder();
    launch("plain", plain.path(), &TICKS);
    let text = page(plain.path());
    assert!(!text.contains("Arrowheads") && data(&text)["beliefs"] == json!([]));
}

#[test]
fn on_a_log_they_are_written_to_a_file_and_scored_with_it() {
    let (out, scored) = (folder(), folder());
    cloud("logged", out.path(), &[]);
    let log = out.at("run.log");
    let path = |file: &str| arg(&out.at(file)).to_owned();
    let log = arg(&log);
    let write = |file: &str, more: &[&str]| {
        let (file, csv) = (path(file), path("answers.csv"));
        let args = ["--log", log, "--name", "cloud", "--out", &csv, "--force", "--beliefs", &file];
        execute("05_belief", &[&args[..], more].concat()).expect(0);
        fs::read(file).unwrap()
    };
    let first = write("a.beliefs", &[]);
    assert!(first == write("b.beliefs", &[]), "the same filter on the same log, other bytes");
    let score = |beliefs: &[&str]| {
        let to = arg(scored.path());
        execute("score", &[&["--log", log, "--force", "--out", to][..], beliefs].concat())
    };
    score(&[]).expect(0);
    let without = json_file(&scored.at("score.json"));
    score(&["--beliefs", &path("a.beliefs")]).expect(0);
    assert_eq!(without, json_file(&scored.at("score.json")), "beliefs are no part of a score");
    let live = data(&page(out.path()))["beliefs"].clone();
    assert_eq!(data(&page(scored.path()))["beliefs"], live, "live, and from a file");

    // What is none of this log's is refused by name.
    write("other.beliefs", &["--particles", "3"]);
    score(&["--beliefs", &path("other.beliefs")]).expect(0);
    let (_other, foreign) = logged("other", &[&CLOUD[..], &TICKS, &["--seed", "43"]].concat());
    let file = path("foreign.beliefs");
    let csv = path("answers.csv");
    let args = ["--log", arg(&foreign), "--out", &csv, "--force", "--beliefs", &file];
    execute("05_belief", &args).expect(0);
    score(&["--beliefs", &file]).expect(1).says("after another frame");
    score(&["--beliefs", log]).expect(1).says("no file of beliefs");
    // A filter with one pose has none to write, and one in a run writes no file.
    let args = ["--log", log, "--out", &csv, "--force", "--beliefs", &file];
    execute("dead-reckoning", &args).expect(2).says("shows no belief");
    execute("05_belief", &["--run", "x", "--beliefs", &file]).expect(2);
}

#[test]
fn what_a_run_showed_is_kept_next_to_its_log_and_drawn_again() {
    let (out, place) = (folder(), folder());
    cloud("kept", out.path(), &[]);
    let live = data(&page(out.path()))["beliefs"].clone();
    let kept = fs::read(out.at("cloud.beliefs")).unwrap();
    let score = |log: &Path, to: &str| {
        let to = place.at(to);
        let args = ["--log", arg(&log), "--out", arg(&to)];
        let ended = execute("score", &args).expect(0);
        (page(&to), ended.stderr)
    };
    let log = out.at("run.log");
    let (again, said) = score(&log, "again");
    assert_eq!(data(&again)["beliefs"], live, "{said}");
    // The same run keeps the same bytes.
    let same = folder();
    cloud("same", same.path(), &[]);
    assert!(fs::read(same.at("cloud.beliefs")).unwrap() == kept);
    // Of another run, damaged, or not there: scored without, and that is said.
    let other = folder();
    cloud("other", other.path(), &["--seed", "43"]);
    let mut damaged = kept.clone();
    let last = damaged.len() - 40;
    damaged[last] ^= 1;
    for (to, beliefs) in [("foreign", Some(kept)), ("damaged", Some(damaged)), ("alone", None)] {
        let file = other.at("cloud.beliefs");
        fs::remove_file(&file).unwrap_or_default();
        let is_there = beliefs.is_some();
        beliefs.iter().for_each(|bytes| fs::write(&file, bytes).unwrap());
        let (text, said) = score(&other.at("run.log"), to);
        assert_eq!(data(&text)["beliefs"], json!([]), "{to}");
        assert!(text.contains("not part of a log: give"), "{to}");
        assert_eq!(said.contains("left out"), is_there, "{to}: {said}");
    }
}

/// A value of `--add`: a filter that shows odd beliefs.
fn odd_belief(odd: &str) -> String {
    format!("odd={} --odd {odd}", binary("odd-belief").display())
}

#[test]
fn odd_beliefs_are_cut_or_left_out_and_the_run_is_well() {
    for (odd, whole) in [("nan", Some(3)), ("many", Some(100_000)), ("empty", None), ("none", None)]
    {
        let out = folder();
        let add = odd_belief(odd);
        let report = launch("odd", out.path(), &["--add", &add, "--ticks", "40"]);
        assert_eq!(report["participants"][1]["answers"], 40, "{odd}");
        let data = data(&page(out.path()));
        assert_eq!(data["beliefs"][0]["whole"][0].as_u64(), whole, "{odd}");
        assert!(page(out.path()).len() < 1 << 20, "{odd}");
    }
    // A panic is reported once, and harms no other process.
    let out = folder();
    let add = odd_belief("panic");
    let report = launch("odd", out.path(), &["--add", &add, "--ticks", "40"]);
    assert_eq!(report["participants"][1]["answers"], 40);
    let said = fs::read_to_string(out.at("odd.txt")).unwrap();
    assert_eq!(said.matches("it is not asked again").count(), 1, "{said}");
}

/// A viewer that was stopped or killed, and one that looks to the end.
#[test]
fn whoever_looks_on_changes_nothing_and_leaves_nothing() {
    let calm = folder();
    let ticks = ["--ticks", "400", "--without", "score"];
    let report = launch("calm", calm.path(), &[&CLOUD[..], &ticks].concat());
    let live = Live::under_way("viewers", &[&CLOUD, &ticks, &["--pace", "1"]]);
    let look = |more: &[&str]| live.join("belief", more);
    let (still, killed) = (look(&["--json"]), look(&["--json"]));
    let awake = look(&["--json", "--name", "cloud"]);
    let three = look(&["--lines", "3"]).wait().expect(0);
    assert_eq!(three.stdout.lines().count(), 4, "{}", three.stdout);
    assert!(three.stdout.contains("particles") && three.stdout.contains("cloud"));
    still.signal(Signal::STOP);
    killed.signal(Signal::KILL);
    let run = live.run.clone();
    // Viewers are no participants: the run's end does not wait for them.
    let Live { server, out: _out, .. } = live;
    assert_eq!(server.wait().expect(0).json()["digest"], report["digest"]);
    let lines = awake.wait().expect(0).stdout;
    let lines: Vec<Value> = lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert!(lines.len() > 3, "{} lines", lines.len());
    for line in &lines {
        assert_eq!((text(line, "kind"), text(line, "name")), ("particles", "cloud"));
        assert!(number(line, "effective") > 499.0, "{line}");
    }
    assert!(lines[lines.len() - 1]["spread_m"].as_f64() > lines[0]["spread_m"].as_f64());
    still.signal(Signal::CONT);
    still.wait().expect(0);
    killed.wait();
    assert_eq!(participants(&run), []);
    nothing_left(&run);
}

/// There is room for six who look on at a time, the scorer among them.
#[test]
fn viewers_that_were_killed_leave_their_places_to_others() {
    let live = Live::under_way("places", &[&CLOUD, &LONG]);
    for signal in [Signal::KILL, Signal::HUP, Signal::KILL, Signal::HUP, Signal::KILL] {
        let mut look = Command::new(binary("belief"));
        look.args(["--run", live.run.as_str()]).stdout(Stdio::piped());
        let mut looking = look.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(looking.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert!(line.contains("tick"), "{line:?}");
        send_signal(looking.id(), signal);
        looking.wait().unwrap();
    }
    live.join("belief", &["--lines", "2"]).wait().expect(0);
    live.server.signal(Signal::INT);
    live.ends_with(3);
}

#[test]
fn a_filter_that_is_killed_while_it_shows_leaves_nothing() {
    let live = Live::under_way("killed", &[&CLOUD, &LONG]);
    let awake = live.join("belief", &["--lines", "2"]);
    awake.wait().expect(0);
    send_signal(live.pid_of("cloud"), Signal::KILL);
    live.ends_with(1).lost("cloud", "dead", "its process was killed by signal 9");
    // So does a server that is killed while a process observes.
    let live = Live::under_way("server", &[&CLOUD, &LONG]);
    let awake = live.join("belief", &[]);
    live.join("belief", &["--lines", "1"]).wait().expect(0);
    live.server.signal(Signal::KILL);
    live.server.wait();
    awake.wait().expect(0);
    until("all have ended", || participants(&live.run).is_empty());
    Domain::sweep_dead().unwrap();
    nothing_left(&live.run);
}

/// A confined filter makes its segment as any other.
#[test]
fn a_filter_in_a_sandbox_shows_what_it_holds_possible() {
    let (place, out) = (folder(), folder());
    let cloud = estimator("cloud", &[arg(&binary("05_belief"))], "sandbox = true");
    let scenario = format!("name = \"cell\"\nticks = 40\n{cloud}{RECORDERS}");
    let file = place.write("s.toml", scenario);
    let ended = run_to("cell", out.path(), &["launch", &file]);
    if ended.code == Some(2) && ended.stderr.contains("cannot be had") {
        skipped(ended.stderr.trim());
        return;
    }
    let ended = ended.expect(0);
    assert_eq!(ticks(&page(out.path())), [0, 5, 10, 15, 20, 25, 30, 35], "{ended:#?}");
}

/// What is said of the beliefs that are shown, and the map in pixels.
fn shown(browser: &mut Browser) -> (String, Value) {
    let words = browser.value("document.querySelector('#beliefs').textContent");
    let map = browser.value("document.querySelector('#map').toDataURL()");
    (words.as_str().unwrap().to_owned(), map)
}

#[test]
fn in_a_browser_the_slider_moves_them() {
    let Some(mut browser) = Browser::start() else { return };
    let out = folder();
    cloud("browser", out.path(), &[]);
    browser.open(&out.at("report.html"), "#tick=99");
    let (last, _) = shown(&mut browser);
    assert_eq!(last, "cloud: particles 500, tick 95");
    browser.open(&out.at("report.html"), "#tick=52");
    // As many arrowheads as there are poses are drawn, and none of what is hidden.
    let count = "(() => { let count = 0; const { moveTo } = CanvasRenderingContext2D.prototype;
        CanvasRenderingContext2D.prototype.moveTo = function (...at) {
            if (this.globalAlpha === 0.4) count += 1; moveTo.apply(this, at); };
        dispatchEvent(new Event('resize'));
        CanvasRenderingContext2D.prototype.moveTo = moveTo; return count; })()";
    let (earlier, map) = shown(&mut browser);
    assert_eq!(earlier, "cloud: particles 500, tick 50");
    let marks = data(&page(out.path()))["beliefs"][0]["marks"].clone();
    assert!(browser.value(count) == marks && marks.as_u64().unwrap() > 300, "{marks}");
    let hide = "(() => { const box = document.querySelectorAll('.toggle')[1];
        box.checked = false; box.dispatchEvent(new Event('change')); })()";
    browser.value(hide);
    assert_eq!(browser.value(count), 0);
    assert_ne!(shown(&mut browser).1, map);
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn who_looks_on_at_no_run_is_told_so() {
    let run = fresh_run("nobody");
    execute("belief", &["--run", run.as_str()]).expect(1).says("no run");
    nothing_left(&run);
}
