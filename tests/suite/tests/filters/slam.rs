//! Scan matching and SLAM as processes: with the map hidden, on their own log, and on
//! a replay.

use rusty_contract::Start;
use rusty_contract::score::ScoreReport;
use rusty_filters::slam::{Slam, SlamOptions};
use rusty_filters::{Cell, OccupancyMap};
use rusty_geometry::apartment;
use rusty_tests::*;

/// Nothing of the walls is told; where it starts is, so that frames coincide.
const FILTERS: [&str; 2] = ["scan-match", "slam"];

fn scores(report: &Value) -> ScoreReport {
    let page = fs::read(log_of(report).with_file_name("score.json")).unwrap();
    serde_json::from_slice(&page).unwrap()
}

/// A run of half a minute up and down the Apartment's corridor.
fn patrol(tag: &str, out: &Path, more: &[&str]) -> Value {
    let adds: Vec<String> = FILTERS.iter().map(|name| format!("{name}={name}")).collect();
    let mut args = vec!["apartment", "--set", "lidar.dropout=0.02"];
    adds.iter().for_each(|add| args.extend(["--add", add]));
    args.extend(more);
    launch(tag, out, &args)
}

/// Runs a log through the library, and hands out its answers' poses as they should
/// are in the log, with the filter at the end.
fn through_the_library(log: &Path) -> (Slam, u64) {
    let log = Log::read(log);
    let (header, is_complete) = (log.header.clone(), log.is_complete());
    let slot = header.answering().position(|p| p.name == "slam").unwrap();
    let place = header.roster.iter().position(|p| p.name == "slam").unwrap();
    let start = Start::new(&header, place, &header.roster[place]);
    let mut slam = Slam::new(&start, &SlamOptions::default());
    assert!(is_complete);
    let records = log.records();
    for record in &records {
        slam.advance(record.ticks);
        if let Some(ranges_m) = &record.ranges_m {
            slam.scan(ranges_m);
        }
        let Reply::Estimate(estimate) = record.replies[slot] else { panic!("no estimate") };
        assert_eq!(estimate.pose_in_world, slam.pose().0, "tick {}", record.tick);
    }
    (slam, records.len() as u64)
}

#[test]
fn the_apartment_is_mapped_to_five_centimetres() {
    let place = folder();
    let (out, stem) = (place.at("run"), place.at("map"));
    let add = format!("slam=slam --save-map {}", stem.display());
    let args = [
        "apartment",
        "--set",
        "lidar.dropout=0.02",
        "--add",
        &add,
        "--add",
        "scan-match=scan-match",
    ];
    let report = launch("mapped", &out, &args);
    for score in &scores(&report).scores {
        let limit_m = match score.name.as_str() {
            "slam" => 0.02,
            "scan-match" => 0.04,
            _ => continue,
        };
        assert!(score.ate_rmse_m.unwrap() < limit_m, "{score:?}");
        assert!(score.nees.as_ref().unwrap().mean < 9.0, "{score:?}");
    }
    let world = apartment();
    let (slam, ticks) = through_the_library(&log_of(&report));
    assert_eq!(ticks, 1500);
    assert!(slam.loops() > 5, "{}", slam.loops());
    let points = slam.map().flat_map(|(_, points)| points);
    let (rms_m, most_m) = spread(points.map(|p| world.distance_to_nearest(p)).collect());
    assert!(rms_m < 0.03 && most_m < 0.05, "{rms_m} m, 95 % within {most_m} m");
    // The files: cells of 5 cm, half of which adds to what a cell is off.
    let map = OccupancyMap::load(&stem.with_extension("yaml")).unwrap();
    let occupied = map.cells.iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied);
    let off: Vec<f64> =
        occupied.map(|(cell, _)| world.distance_to_nearest(map.frame.centre(cell))).collect();
    assert!(off.len() > 300, "{}", off.len());
    let (rms_m, most_m) = spread(off);
    assert!(rms_m < 0.05 && most_m < 0.075, "{rms_m} m, 95 % within {most_m} m");
    // The map as a world: its walls are those of the Apartment, as far as seen.
    let traced = rusty_floorplan::read(&stem.with_extension("yaml")).unwrap();
    let ends = traced.walls.iter().map(|wall| world.distance_to_nearest(wall.a.into()));
    let (rms_m, most_m) = spread(ends.collect());
    assert!(rms_m < 0.1 && most_m < 0.15, "{rms_m} m, 95 % within {most_m} m");
    // A map of the first third: up to there it is the same filter.
    let third = place.at("third");
    let args = ["--log", text(&report, "log"), "--until", "10", "--save-map"];
    let args = [&args[..], &[arg(&third)]].concat();
    execute("slam", &args).expect(0).says("500 of 1500 answers equal");
    let part = OccupancyMap::load(&third.with_extension("yaml")).unwrap();
    let occupied = |map: &OccupancyMap| map.cells.iter().filter(|c| **c == Cell::Occupied).count();
    assert!((50..occupied(&map)).contains(&occupied(&part)), "{}", occupied(&part));
}

#[test]
fn live_log_and_replay_are_one_and_a_wrong_wheel_is_learned() {
    let place = folder();
    let out = place.at("run");
    // Open loop, such wheels would drive into a wall.
    let set =
        ["--set", "script.kind=truth-steered-patrol", "--set", "robot.radius_bias_right=0.01"];
    let report = patrol("biased", &out, &set);
    let log = log_of(&report);
    let score = |name: &str| scores(&report).scores.into_iter().find(|s| s.name == name).unwrap();
    let lost_m = score("dead-reckoning").ate_rmse_m.unwrap();
    assert!(lost_m > 0.5, "{lost_m}");
    for (name, limit_m) in [("scan-match", 0.05), ("slam", 0.03)] {
        let ate_m = score(name).ate_rmse_m.unwrap();
        assert!(ate_m < limit_m, "{name}: {ate_m} m");
    }
    // By themselves on the log, and all of them again by the server.
    for name in FILTERS {
        execute(name, &["--log", arg(&log)]).expect(0).says("1500 of 1500 answers equal");
    }
    sim_server(&["verify", "--clients", arg(&log)]).expect(0).prints("1500 answers of slam");
    let replayed = replay(&log, &place.at("second"), &[]).expect(0).json();
    assert_eq!(replayed["digest"], report["digest"]);
}

#[test]
fn key_poses_of_the_final_graph_are_a_trajectory_for_score() {
    let place = folder();
    let (out, file) = (place.at("run"), place.at("final.tum"));
    let log = log_of(&patrol("poses", &out, &[]));
    let saves = ["--log", arg(&log), "--save-poses", arg(&file)];
    execute("slam", &saves).expect(0).says("1500 of 1500 answers equal");
    let (slam, _) = through_the_library(&log);
    let number = |word: &str| word.parse::<f64>().unwrap();
    let text = fs::read_to_string(&file).unwrap();
    let lines: Vec<Vec<f64>> =
        text.lines().map(|line| line.split(' ').map(number).collect()).collect();
    assert!(lines.len() > 10 && lines.windows(2).all(|pair| pair[0][0] < pair[1][0]), "{text}");
    let xy: Vec<[f64; 2]> = lines.iter().map(|line| [line[1], line[2]]).collect();
    let expected: Vec<[f64; 2]> = slam.graph().poses().iter().map(|p| [p.x(), p.y()]).collect();
    assert_eq!(xy, expected);
    // Without a key scan there is nothing to save.
    let none = place.at("none.tum");
    let early = ["--log", arg(&log), "--name", "x", "--until", "0", "--save-poses", arg(&none)];
    execute("slam", &early).expect(1).says("--save-poses");
    assert!(!none.exists());
    // A file that is there stays.
    execute("slam", &saves).expect(2).says("final.tum").says("--force");
    assert_eq!(fs::read_to_string(&file).unwrap(), text);
    let add = format!("final=trajectory {}", file.display());
    let report = replay(&log, &place.at("scored"), &["--add", &add]).expect(0).json();
    let all = scores(&report).scores;
    let of_keys = all.iter().find(|score| score.name == "final").unwrap();
    assert_eq!(of_keys.scored_ticks, lines.len() as u64);
    assert!(of_keys.ate_rmse_m.unwrap() < 0.02, "{:?}", of_keys.ate_rmse_m);
}
