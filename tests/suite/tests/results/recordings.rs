//! Defects of recordings: found by the import, kept in the log, and repeated by
//! every program that shows the log; times are the same on every page.

use std::fmt::Write as _;

use rusty_tests::*;

const SCANS: usize = 12;

/// A corrected recording: readings 0.1 m apart, scans corrected to the side, and
/// their echoes, whose stamps were never set.
fn recording(stamp_s: impl Fn(usize) -> f64) -> String {
    let mut log = "ODOM 0 0 0 0 0 0 0 robot 0\n".to_owned();
    let (mut x_m, mut y_m) = (0.0, 0.0);
    for scan in 0..SCANS {
        for reading in 0..3 {
            x_m += 0.1;
            let s = stamp_s(4 * scan + reading);
            writeln!(log, "ODOM {x_m} {y_m} 0 0 0 0 {s} robot {s}").unwrap();
        }
        y_m += 0.05;
        let s = stamp_s(4 * scan + 3);
        writeln!(log, "FLASER 3 1 2 3 {x_m} {y_m} 0 {x_m} {y_m} 0 {s} robot {s}").unwrap();
        writeln!(log, "ODOM {x_m} {y_m} 0 0 0 0 0 robot 0").unwrap();
    }
    log
}

fn kinds(of: &Value) -> Vec<&str> {
    list(of, "findings").iter().map(|finding| text(finding, "kind")).collect()
}

/// Findings as a page shows them, a line each.
fn lines(page: &str) -> Vec<String> {
    let lines = page.lines().filter_map(|line| line.strip_prefix("finding "));
    lines.map(|line| line.trim().to_owned()).collect()
}

fn stamps_s(tum: &Path) -> Vec<f64> {
    let text = fs::read_to_string(tum).unwrap();
    text.lines().map(|line| line.split(' ').next().unwrap().parse().unwrap()).collect()
}

/// Import, `info`, `replay`, its report and its trajectories say the same of a
/// recording whose stamps stand still.
fn check_flat(input: &Path, expected: &[&str]) {
    let place = folder();
    let (log, out) = (place.at("a.runlog"), place.at("run"));
    let said = lines(&import(input, &log, &[]).expect(0).stdout);
    assert_eq!(said.len(), expected.len(), "{said:?}");
    let report = import(input, &log, &["--json", "--force"]).expect(0).json();
    assert_eq!(kinds(&report), expected);
    let info = about("info", &log, &["--json"]).expect(0).json();
    assert_eq!(info["source"]["findings"], report["findings"]);
    assert_eq!(lines(&about("info", &log, &[]).expect(0).stdout), said);
    assert_eq!(info["first_time_s"], report["first_stamp_s"]);
    assert_eq!(info["last_time_s"], report["last_stamp_s"]);

    let replayed = replay(&log, &out, &[]).expect(0).json();
    let again = sim_server(&["replay", arg(&log), "--force", "--out", arg(&out)]).expect(0);
    assert_eq!(lines(&again.stdout), said);
    assert_eq!(replayed["findings"], report["findings"]);
    let page = fs::read_to_string(text(&replayed, "report")).unwrap();
    assert!(said.iter().all(|finding| page.contains(finding)), "{said:?}");
    let span_s = number(&report, "last_stamp_s");
    assert!(page.contains(&format!("<li>{span_s:.1} s</li>")), "{span_s}");

    let tum = place.at("tum");
    let log = text(&replayed, "log");
    sim_server(&["export", "tum", log, "-o", arg(&tum)]).expect(0).prints("evo_ape tum");
    for file in ["truth.tum", "dead-reckoning.tum"] {
        let stamps_s = stamps_s(&tum.join(file));
        assert!(stamps_s.windows(2).all(|pair| pair[0] < pair[1]), "{file}: {stamps_s:?}");
        assert_eq!(stamps_s.len(), report["scans"].as_u64().unwrap() as usize);
    }
}

#[test]
fn a_recording_whose_stamps_are_all_zero_has_one_time_on_every_page() {
    let place = folder();
    let input = place.at("flat.log");
    fs::write(&input, recording(|_| 0.0)).unwrap();
    check_flat(&input, &["flat-stamps"]);
    let report = import(&input, &place.at("a.runlog"), &["--json"]).expect(0).json();
    // Nothing of the truth is in the wheels.
    assert_eq!(report["anchors"], SCANS as u64);
    assert!(number(&report, "lateral_max_m") < 1e-9, "{report}");
    assert!((number(&report, "distance_m") - 3.6).abs() < 1e-9, "{report}");
}

/// The report of a recording has the walls of the map next to its log, and numbers of
/// ticks where its stamps stand still.
#[test]
fn a_report_on_a_recording_has_the_map_of_gridmap_and_ticks_for_its_stamps() {
    let place = folder();
    let (input, log, map) = (place.at("flat.log"), place.at("run.log"), place.at("map"));
    fs::write(&input, recording(|_| 0.0)).unwrap();
    import(&input, &log, &[]).expect(0);
    let page = |to: &str, more: &[&str]| {
        let out = place.at(to);
        let args = ["--log", arg(&log), "--out", arg(&out)];
        execute("score", &[&args[..], more].concat()).expect(0);
        fs::read_to_string(out.join("report.html")).unwrap()
    };
    let walls = |page: &str| {
        let (_, data) = page.split_once("id=\"data\">").unwrap();
        let data: Value = serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap();
        (list(&data, "walls").len(), data["is_in_ticks"].clone())
    };
    assert_eq!(walls(&page("without", &[])), (0, true.into()));
    execute("gridmap", &["--log", arg(&log), "--poses", "truth", "--save", arg(&map)]).expect(0);
    let with = page("with", &[]);
    let (count, _) = walls(&with);
    assert!(count > 0 && with.contains("<li>world map</li>"), "{count}");
    // What is said of time has no seconds.
    assert!(with.contains("\ntick\n") && !with.contains(" s</output>"), "an axis of ticks");
    assert!(!with.contains("time since the first tick (s)") && !with.contains("time (s)"));
    let hallway = repository().join("shared/geometry/worlds/hallway.json");
    let (found, _) = walls(&page("given", &["--map", arg(&hallway)]));
    assert_eq!(found, list(&json_file(&hallway), "walls").len());
    let out = place.at("bad");
    let args = ["--log", arg(&log), "--out", arg(&out), "--map", arg(&input)];
    execute("score", &args).expect(1).says("flat.log");
}

#[test]
fn orebro_has_findings_on_every_page() {
    let Some(input) = real_data("orebro-corrected.log.gz") else { return };
    check_flat(&input, &["no-odometry", "short-odometry", "flat-stamps", "sideways"]);
}

#[test]
fn csail_has_findings_on_every_page() {
    let Some(input) = real_data("csail-corrected.log.gz") else { return };
    check_flat(&input, &["flat-stamps", "sideways"]);
}

#[test]
fn a_strict_import_refuses_what_has_findings_and_writes_nothing() {
    let (sources, results) = (folder(), folder());
    let output = results.at("a.runlog");
    let flat = sources.at("flat.log");
    fs::write(&flat, recording(|_| 0.0)).unwrap();
    let real = ["csail", "edmonton", "orebro"].map(|name| format!("{name}-corrected.log.gz"));
    let inputs = real.iter().filter_map(|file| real_data(file)).chain([flat]);
    for input in inputs {
        for more in [&["--strict"][..], &["--strict", "--json"]] {
            let refused = import(&input, &output, more).expect(1);
            assert_eq!(refused.stdout, "");
            refused.says(arg(&input));
            assert_eq!(fs::read_dir(results.path()).unwrap().count(), 0);
        }
    }
    let sound = sources.at("sound.log");
    fs::write(&sound, recording(|line| 100.0 + line as f64)).unwrap();
    let report = import(&sound, &output, &["--strict", "--json", "--force"]).expect(0).json();
    assert_eq!(kinds(&report), Vec::<&str>::new());
    for file in ["intel-corrected.log.gz", "freiburg-101-corrected.log.gz"] {
        let Some(input) = real_data(file) else { continue };
        import(&input, &output, &["--strict", "--force"]).expect(0);
    }
}

#[test]
fn trajectories_whose_stamps_do_not_increase_say_so_and_name_no_command() {
    let place = folder();
    let (input, log) = (place.at("a.log"), place.at("a.runlog"));
    let (out, tum) = (place.at("run"), place.at("tum"));
    // The stamps of the last four lines are those of the four before.
    let last = 4 * SCANS - 4;
    fs::write(&input, recording(|line| 1.0 + (if line < last { line } else { last - 1 }) as f64))
        .unwrap();
    import(&input, &log, &["--strict", "--force"]).expect(0);
    let replayed = replay(&log, &out, &[]).expect(0).json();
    let export = ["export", "tum", text(&replayed, "log"), "-o", arg(&tum)];
    let said = sim_server(&export).expect(0);
    assert!(!said.stdout.contains("evo_ape"), "{said:?}");
    said.says("1 ticks have the stamp");
    let exported = sim_server(&[&export[..], &["--force", "--json"]].concat()).expect(0).json();
    assert_eq!(
        (&exported["stamps_repeated"], &exported["stamps_backwards"]),
        (&1.into(), &0.into())
    );
}
