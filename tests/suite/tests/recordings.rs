//! Defects of recordings: found by the import, kept in the log, and repeated by
//! every program that shows the log; times are the same on every page.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use rusty_tests::{Ended, folder, fresh_run, nothing_left, real_data, sim_server, text};
use serde_json::Value;

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

fn import(input: &Path, output: &Path, more: &[&str]) -> Ended {
    let (input, output) = (input.to_str().unwrap(), output.to_str().unwrap());
    sim_server(&[&["import", "carmen", input, "-o", output], more].concat())
}

/// The findings by their kind.
fn kinds(of: &Value) -> Vec<&str> {
    of["findings"].as_array().unwrap().iter().map(|finding| text(finding, "kind")).collect()
}

/// Findings as a page shows them, a line each.
fn lines(page: &str) -> Vec<String> {
    let lines = page.lines().filter_map(|line| line.strip_prefix("finding "));
    lines.map(|line| line.trim().to_owned()).collect()
}

/// Stamps of a trajectory, s.
fn stamps_s(tum: &Path) -> Vec<f64> {
    let text = fs::read_to_string(tum).unwrap();
    text.lines().map(|line| line.split(' ').next().unwrap().parse().unwrap()).collect()
}

/// Import, `info`, `replay`, its report and its trajectories say the same of a
/// recording whose stamps stand still.
fn check_flat(input: &Path, expected: &[&str]) {
    let place = folder();
    let (log, out) = (place.path().join("a.runlog"), place.path().join("run"));
    let said = lines(&import(input, &log, &[]).expect(0).stdout);
    assert_eq!(said.len(), expected.len(), "{said:?}");
    let report = import(input, &log, &["--json", "--force"]).expect(0).json();
    assert_eq!(kinds(&report), expected);
    let path = log.to_str().unwrap();
    let info = sim_server(&["info", path, "--json"]).expect(0).json();
    assert_eq!(info["source"]["findings"], report["findings"]);
    assert_eq!(lines(&sim_server(&["info", path]).expect(0).stdout), said);
    assert_eq!(info["first_time_s"], report["first_stamp_s"]);
    assert_eq!(info["last_time_s"], report["last_stamp_s"]);

    let run = fresh_run("recordings");
    let args = ["replay", path, "--run", run.as_str(), "--out", out.to_str().unwrap()];
    assert_eq!(lines(&sim_server(&args).expect(0).stdout), said);
    let replayed = sim_server(&[&args[..], &["--json", "--force"]].concat()).expect(0).json();
    nothing_left(&run);
    assert_eq!(replayed["findings"], report["findings"]);
    let page = fs::read_to_string(text(&replayed, "report")).unwrap();
    assert!(said.iter().all(|finding| page.contains(finding)), "{said:?}");
    let span_s = report["last_stamp_s"].as_f64().unwrap();
    assert!(page.contains(&format!("<li>{span_s:.1} s</li>")), "{span_s}");

    let tum = place.path().join("tum");
    let log = text(&replayed, "log");
    let exported = sim_server(&["export", "tum", log, "-o", tum.to_str().unwrap()]).expect(0);
    assert!(exported.stdout.contains("evo_ape tum"), "{exported:?}");
    for file in ["truth.tum", "dead-reckoning.tum"] {
        let stamps_s = stamps_s(&tum.join(file));
        assert!(stamps_s.windows(2).all(|pair| pair[0] < pair[1]), "{file}: {stamps_s:?}");
        assert_eq!(stamps_s.len(), report["scans"].as_u64().unwrap() as usize);
    }
}

#[test]
fn a_recording_whose_stamps_are_all_zero_has_one_time_on_every_page() {
    let place = folder();
    let input = place.path().join("flat.log");
    fs::write(&input, recording(|_| 0.0)).unwrap();
    check_flat(&input, &["flat-stamps"]);
    let report = import(&input, &place.path().join("a.runlog"), &["--json"]).expect(0).json();
    // Nothing of the truth is in the wheels.
    assert_eq!(report["anchors"], SCANS as u64);
    assert!(report["lateral_max_m"].as_f64().unwrap() < 1e-9, "{report}");
    assert!((report["distance_m"].as_f64().unwrap() - 3.6).abs() < 1e-9, "{report}");
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
    let output = results.path().join("a.runlog");
    let flat = sources.path().join("flat.log");
    fs::write(&flat, recording(|_| 0.0)).unwrap();
    let real = ["csail", "edmonton", "orebro"].map(|name| format!("{name}-corrected.log.gz"));
    let inputs = real.iter().filter_map(|file| real_data(file)).chain([flat]);
    for input in inputs {
        for more in [&["--strict"][..], &["--strict", "--json"]] {
            let refused = import(&input, &output, more).expect(1);
            assert_eq!(refused.stdout, "");
            assert!(refused.stderr.contains(input.to_str().unwrap()), "{refused:?}");
            assert_eq!(fs::read_dir(results.path()).unwrap().count(), 0);
        }
    }
    let sound = sources.path().join("sound.log");
    fs::write(&sound, recording(|line| 100.0 + line as f64)).unwrap();
    let report = import(&sound, &output, &["--strict", "--json", "--force"]).expect(0).json();
    assert_eq!(kinds(&report), Vec::<&str>::new());
    for file in ["intel-corrected.log.gz", "freiburg-101-corrected.log.gz"] {
        let Some(input) = real_data(file) else { continue };
        import(&input, &output, &["--strict", "--force"]).expect(0);
    }
}

#[test]
fn edmonton_is_measured_up_to_its_codes() {
    let Some(input) = real_data("edmonton-corrected.log.gz") else { return };
    let place = folder();
    let log = place.path().join("a.runlog");
    let report = import(&input, &log, &["--json"]).expect(0).json();
    assert_eq!(kinds(&report), ["sideways", "range-max-doubted"]);
    let doubted = &report["findings"][1];
    assert_eq!((&doubted["exceeding"], &doubted["ranges"]), (&17_844.into(), &61_200.into()));
    let info = sim_server(&["info", log.to_str().unwrap(), "--json"]).expect(0).json();
    assert_eq!(info["config"]["lidar"]["range_max_m"], 51.09);
    assert_eq!(info["source"]["findings"], report["findings"]);
}

#[test]
fn trajectories_whose_stamps_do_not_increase_say_so_and_name_no_command() {
    let place = folder();
    let (input, log) = (place.path().join("a.log"), place.path().join("a.runlog"));
    let (out, tum) = (place.path().join("run"), place.path().join("tum"));
    // The stamps of the last four lines are those of the four before.
    let last = 4 * SCANS - 4;
    fs::write(&input, recording(|line| 1.0 + (if line < last { line } else { last - 1 }) as f64))
        .unwrap();
    import(&input, &log, &["--strict", "--force"]).expect(0);
    let run = fresh_run("recordings");
    let paths = [&log, &out, &tum].map(|path| path.to_str().unwrap());
    let replay = ["replay", paths[0], "--json", "--run", run.as_str(), "--out", paths[1]];
    let replayed = sim_server(&replay).expect(0).json();
    nothing_left(&run);
    let export = ["export", "tum", text(&replayed, "log"), "-o", paths[2]];
    let said = sim_server(&export).expect(0);
    assert!(!said.stdout.contains("evo_ape"), "{said:?}");
    assert!(said.stderr.contains("1 ticks have the stamp"), "{said:?}");
    let exported = sim_server(&[&export[..], &["--force", "--json"]].concat()).expect(0).json();
    assert_eq!(
        (&exported["stamps_repeated"], &exported["stamps_backwards"]),
        (&1.into(), &0.into())
    );
}
