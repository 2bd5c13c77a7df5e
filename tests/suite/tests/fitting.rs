//! What a log tells of the models that filters believe in: its map, the four
//! parts of its readings, the four α of its wheels; whole programs on whole logs.

use std::fs;
use std::path::Path;

use rusty_contract::log::LogReader;
use rusty_contract::{Brief, Start};
use rusty_filters::OdometryNoise;
use rusty_filters::gridmap::{GridMapOf, Options, Poses};
use rusty_filters::occupancy_grid::InverseModel;
use rusty_tests::*;
use serde_json::Value;

/// A log of the Apartment with dropouts; and its blind half.
fn log(place: &Path, ticks: &str) -> String {
    let args = ["apartment", "--ticks", ticks, "--set", "lidar.dropout=0.02"];
    let _ = launch("fitting", place, &args);
    place.join("run.log").to_str().unwrap().to_owned()
}

fn blind(log: &str, place: &Path) -> String {
    let sealed = place.join("blind.log").to_str().unwrap().to_owned();
    let key = place.join("key").to_str().unwrap().to_owned();
    let _ = sim_server(&["seal", log, "-o", &sealed, "--key-file", &key]).expect(0);
    sealed
}

fn run(program: &str, args: &[&str]) -> Ended {
    Process::start(program, args).wait()
}

/// How many standard errors a number is off.
fn off(found: &Value, truth: f64) -> f64 {
    let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{key} of {found}"));
    (number("value") - truth) / number("std_error")
}

#[test]
fn a_run_tells_what_its_laser_and_its_wheels_are() {
    let place = folder();
    let log = log(place.path(), "3000");
    let beam = run("fit-beam", &["--log", &log, "--json"]).expect(0).json();
    assert_eq!(beam["converged"], true);
    // Nothing stands in front of the walls.
    assert!(beam["z_short"]["value"].as_f64().unwrap() < 1e-4, "{}", beam["z_short"]);
    assert!(beam["z_rand"]["value"].as_f64().unwrap() < 1e-4, "{}", beam["z_rand"]);
    assert!(off(&beam["sigma_hit_m"], 0.02).abs() < 3.0, "{}", beam["sigma_hit_m"]);
    assert!(off(&beam["z_max"], 0.02).abs() < 3.0, "{}", beam["z_max"]);
    let page = run("fit-beam", &["--log", &log, "--verbose"]).expect(0).stdout;
    assert!(page.contains("data sheet") && page.contains("round"), "{page}");

    let motion = run("fit-motion", &["--log", &log, "--json"]).expect(0).json();
    assert_eq!(motion["converged"], true);
    let (s2, track2) = (0.02 * 0.02, 0.16 * 0.16);
    let truth = [s2, s2 / track2, 0.5 * s2, 0.25 * s2 * track2];
    for (alpha, truth) in motion["alphas"].as_array().unwrap().iter().zip(truth) {
        assert!(off(alpha, truth).abs() < 3.5, "{alpha} for {truth}");
    }
    let page = run("fit-motion", &["--log", &log]).expect(0).stdout;
    assert!(page.contains("--alpha2 "), "{page}");
}

#[test]
fn a_log_without_truth_is_refused_with_a_remedy() {
    let place = folder();
    let log = log(place.path(), "50");
    let sealed = blind(&log, place.path());
    for program in ["fit-motion", "fit-beam"] {
        let ended = run(program, &["--log", &sealed]);
        assert_eq!(ended.code, Some(1), "{ended:#?}");
        assert!(ended.stderr.contains("--key-file"), "{ended:#?}");
        let key = place.path().join("key");
        let args = ["--log", &sealed, "--key-file", key.to_str().unwrap(), "--json"];
        let _ = run(program, &args).expect(0).json();
    }
}

#[test]
fn a_log_is_mapped_with_the_poses_that_are_asked_for() {
    let place = folder();
    let log = log(place.path(), "300");
    let stem = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
    for poses in ["truth", "dead-reckoning", "odometry"] {
        let ended = run("gridmap", &["--log", &log, "--poses", poses, "--save", &stem(poses)]);
        let ended = ended.expect(0);
        assert!(ended.stderr.contains("60 scans (0 left out: no pose)"), "{ended:#?}");
    }
    // Its own poses are those of the wheels.
    let map = |name: &str| fs::read(format!("{}.pgm", stem(name))).unwrap();
    assert_eq!(map("odometry"), map("dead-reckoning"));
    assert_ne!(map("truth"), map("odometry"));
    let part =
        run("gridmap", &["--log", &log, "--from", "2", "--until", "4", "--save", &stem("part")]);
    assert!(part.expect(0).stderr.contains("20 scans"));
    let nobody = run("gridmap", &["--log", &log, "--poses", "mcl", "--save", &stem("x")]).expect(1);
    assert!(nobody.stderr.contains("there are odometry, truth, dead-reckoning"), "{nobody:#?}");
    let nothing = run("gridmap", &["--log", &log, "--from", "99", "--save", &stem("x")]).expect(1);
    assert!(nothing.stderr.contains("nothing to map"), "{nothing:#?}");
    let sealed = blind(&log, place.path());
    let args = ["--log", &sealed, "--poses", "truth", "--save", &stem("x")];
    assert!(run("gridmap", &args).expect(1).stderr.contains("--key-file"));
    // Nor does the library map with the truth for one who asks for the wheels.
    let header = LogReader::open(Path::new(&log)).unwrap().header().clone();
    let start = Start::new(&header, 0, &header.roster[0]);
    let (poses, save) = (Poses::Odometry, place.path().join("x"));
    let (model, noise) = (InverseModel::default(), OdometryNoise::default());
    let options = Options { poses, save, from: 0.0, until: None, model, noise };
    let refused = GridMapOf::new(&start, &Brief { header, out_dir: None }, &options).err().unwrap();
    assert!(refused.to_string().contains("--poses odometry"), "{refused}");
}

#[test]
fn a_real_robot_s_log_is_mapped_and_fitted() {
    let Some(recording) = real_data("intel-corrected.log.gz") else { return };
    let place = folder();
    let log = place.path().join("intel.log").to_str().unwrap().to_owned();
    let _ = sim_server(&["import", "carmen", recording.to_str().unwrap(), "-o", &log]).expect(0);
    let stem = place.path().join("intel").to_str().unwrap().to_owned();
    let args = ["--log", &log, "--poses", "truth", "--until", "1326", "--save", &stem];
    let ended = run("gridmap", &args).expect(0);
    assert!(ended.stderr.contains("scans (0 left out: no pose)"), "{ended:#?}");
    let yaml = format!("{stem}.yaml");
    let beam = run("fit-beam", &["--log", &log, "--map", &yaml, "--json"]).expect(0).json();
    // Cells of 5 cm, people, and a map that is not the truth: more than a data sheet.
    let sigma_m = beam["sigma_hit_m"]["value"].as_f64().unwrap();
    assert!((0.01..0.2).contains(&sigma_m), "{sigma_m}");
    let motion = run("fit-motion", &["--log", &log, "--json"]).expect(0).json();
    assert!(motion["windows"].as_u64().unwrap() > 500, "{motion}");
}
