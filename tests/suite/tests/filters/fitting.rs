//! What a log tells of the models that filters believe in: its map, the four
//! parts of its readings, the four α of its wheels; whole programs on whole logs.

use rusty_contract::log::LogReader;
use rusty_contract::{Brief, Start};
use rusty_filters::gridmap::{GridMapOf, Options, Poses};
use rusty_filters::moment::Moment;
use rusty_filters::occupancy_grid::InverseModel;
use rusty_filters::{OccupancyMap, OdometryNoise};
use rusty_geometry::World;
use rusty_tests::*;

/// A log of the Apartment with dropouts, which are all that returns nothing.
fn log(place: &Path, ticks: &str) -> String {
    let opaque = "lidar.glass_visible_rad=1.5707963267948966";
    let set = ["--set", "lidar.dropout=0.02", "--set", opaque];
    let args = [&["apartment", "--ticks", ticks], &set[..]].concat();
    let _ = launch("fitting", place, &args);
    arg(&place.join("run.log")).to_owned()
}

fn blind(log: &str, place: &Path) -> String {
    let sealed = place.join("blind.log");
    let _ = seal(Path::new(log), &sealed, &place.join("key")).expect(0);
    arg(&sealed).to_owned()
}

/// How many standard errors a number is off.
fn off(found: &Value, truth: f64) -> f64 {
    (number(found, "value") - truth) / number(found, "std_error")
}

#[test]
fn a_run_tells_what_its_laser_and_its_wheels_are() {
    let place = folder();
    let log = log(place.path(), "3000");
    let beam = execute("fit-beam", &["--log", &log, "--json"]).expect(0).json();
    assert_eq!(beam["converged"], true);
    // Nothing is in front of the walls.
    assert!(number(&beam, "z_short/value") < 1e-4, "{}", beam["z_short"]);
    assert!(number(&beam, "z_rand/value") < 1e-4, "{}", beam["z_rand"]);
    assert!(off(&beam["sigma_hit_m"], 0.02).abs() < 3.0, "{}", beam["sigma_hit_m"]);
    assert!(off(&beam["z_max"], 0.02).abs() < 3.0, "{}", beam["z_max"]);
    let page = execute("fit-beam", &["--log", &log, "--verbose"]).expect(0).stdout;
    assert!(page.contains("data sheet") && page.contains("round"), "{page}");

    let motion = execute("fit-motion", &["--log", &log, "--json"]).expect(0).json();
    assert_eq!(motion["converged"], true);
    // Slip of 2 % of a tick's way d is σ²d per metre, on average over the ticks.
    let (records, track_m) = (records(Path::new(&log)), 0.16);
    let per_m = |way_m: &dyn Fn(&TickRecord) -> f64| {
        let ways: Vec<f64> = records.iter().map(way_m).filter(|way| *way > 0.0).collect();
        0.02 * 0.02 * ways.iter().sum::<f64>() / ways.len() as f64
    };
    let straight = per_m(&|r| 0.02 * r.command.v_m_s);
    let spot = per_m(&|r| 0.02 * 0.5 * track_m * r.command.omega_rad_s.abs());
    let truth = [
        spot / track_m,
        2.0 * straight / (track_m * track_m),
        0.5 * straight,
        0.25 * spot * track_m,
    ];
    for (alpha, truth) in list(&motion, "alphas").iter().zip(truth) {
        assert!(off(alpha, truth).abs() < 3.5, "{alpha} for {truth}");
    }
    execute("fit-motion", &["--log", &log]).expect(0).prints("--alpha2 ");
}

#[test]
fn a_log_without_truth_is_refused_with_a_remedy() {
    let place = folder();
    let log = log(place.path(), "50");
    let sealed = blind(&log, place.path());
    for program in ["fit-motion", "fit-beam"] {
        let ended = execute(program, &["--log", &sealed]);
        assert_eq!(ended.code, Some(1), "{ended:#?}");
        ended.says("--key-file");
        let key = place.at("key");
        let args = ["--log", &sealed, "--key-file", arg(&key), "--json"];
        let _ = execute(program, &args).expect(0).json();
    }
}

#[test]
fn a_log_is_mapped_with_the_poses_that_are_asked_for() {
    let place = folder();
    let log = log(place.path(), "300");
    let stem = |name: &str| arg(&place.at(name)).to_owned();
    for poses in ["truth", "dead-reckoning", "odometry"] {
        let ended = execute("gridmap", &["--log", &log, "--poses", poses, "--save", &stem(poses)]);
        ended.expect(0).says("60 scans (0 left out: no pose)");
    }
    // Its own poses are those of the wheels.
    let map = |name: &str| fs::read(format!("{}.pgm", stem(name))).unwrap();
    assert_eq!(map("odometry"), map("dead-reckoning"));
    assert_ne!(map("truth"), map("odometry"));
    let part = execute(
        "gridmap",
        &["--log", &log, "--from", "2", "--until", "4", "--save", &stem("part")],
    );
    assert!(part.expect(0).stderr.contains("20 scans"));
    execute("gridmap", &["--log", &log, "--poses", "mcl", "--save", &stem("x")])
        .expect(2)
        .says("there are odometry, truth, dead-reckoning");
    execute("gridmap", &["--log", &log, "--from", "99", "--save", &stem("x")])
        .expect(1)
        .says("nothing to map");
    let sealed = blind(&log, place.path());
    let args = ["--log", &sealed, "--poses", "truth", "--save", &stem("x")];
    assert!(execute("gridmap", &args).expect(1).stderr.contains("--key-file"));
    // Nor does the library map with the truth for one who asks for the wheels.
    let header = LogReader::open(Path::new(&log)).unwrap().header().clone();
    let start = Start::new(&header, 0, &header.roster[0]);
    let (poses, save) = (Poses::Odometry, place.at("x"));
    let (model, noise) = (InverseModel::default(), OdometryNoise::default());
    let options = Options { poses, save, from: Moment::Ticks(0), until: None, model, noise };
    let refused = GridMapOf::new(&start, &Brief { header, out_dir: None, report: true }, &options)
        .err()
        .unwrap();
    assert!(refused.to_string().contains("--poses odometry"), "{refused}");
}

#[test]
fn readings_that_the_map_does_not_explain_ask_for_another_map() {
    let place = folder();
    let log = log(place.path(), "300");
    let asks = |world: &World| {
        let stem = place.at("cells");
        OccupancyMap::of_world(world, 0.2, 0.05).save(&stem).unwrap();
        let map = format!("{}.yaml", stem.display());
        execute("fit-beam", &["--log", &log, "--map", &map]).expect(0).stderr.contains("right map")
    };
    assert!(!asks(&rusty_geometry::apartment()));
    assert!(asks(&rusty_geometry::lobby()));
}

#[test]
fn a_real_robot_s_log_is_mapped_and_fitted() {
    let Some(recording) = real_data("intel-corrected.log.gz") else { return };
    let place = folder();
    let log = arg(&place.at("intel.log")).to_owned();
    let _ = import(&recording, Path::new(&log), &[]).expect(0);
    let stem = arg(&place.at("intel")).to_owned();
    let args = ["--log", &log, "--poses", "truth", "--until", "1326", "--save", &stem];
    execute("gridmap", &args).expect(0).says("scans (0 left out: no pose)");
    let yaml = format!("{stem}.yaml");
    let beam = execute("fit-beam", &["--log", &log, "--map", &yaml, "--json"]).expect(0).json();
    // Cells of 5 cm, people, and a map that is not the truth: more than a data sheet.
    let sigma_m = number(&beam, "sigma_hit_m/value");
    assert!((0.01..0.2).contains(&sigma_m), "{sigma_m}");
    let motion = execute("fit-motion", &["--log", &log, "--json"]).expect(0).json();
    assert!(motion["windows"].as_u64().unwrap() > 500, "{motion}");
}
