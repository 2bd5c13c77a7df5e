//! `mcl` as a process: lost at the start, carried away, live and from a log.

use rusty_filters::OccupancyMap;
use rusty_geometry::apartment;
use rusty_tests::*;

/// What the scorer says of `mcl`.
fn convergence(report: &Value) -> Value {
    score_of(report, "mcl")["convergence"].clone()
}

#[test]
fn it_finds_itself_and_its_answers_come_again_from_log_and_replay() {
    let place = folder();
    let report =
        launch("global", place.path(), &[&filter_scenario("global.toml"), "--ticks", "400"]);
    let found = convergence(&report);
    assert!(number(&found, "after_s") < 3.0, "{found}");
    assert!(number(&found, "position_rmse_m") < 0.01, "{found}");
    assert!(number(&found, "heading_rmse_rad") < 0.01, "{found}");
    // Live, alone on the log, and in a replay: bit for bit the same answers.
    let log = log_of(&report);
    about("verify", &log, &["--clients"]).expect(0).prints("400 answers of mcl");
    let again = replay(&log, &place.at("again"), &[]).expect(0).json();
    assert_eq!(again["digest"], report["digest"]);
}

#[test]
fn it_finds_itself_again_after_it_was_carried_away() {
    let place = folder();
    let args = [&filter_scenario("kidnapped.toml"), "--ticks", "800"];
    let found = convergence(&launch("kidnapped", place.path(), &args));
    let recovered = number(&found, "recoveries/0/after_s");
    assert!(recovered < 4.0, "{found}");
    assert!(number(&found, "position_rmse_m") < 0.01, "{found}");
}

#[test]
fn a_map_of_cells_and_the_beam_model_serve_as_processes() {
    let place = folder();
    let stem = place.at("cells");
    OccupancyMap::of_world(&apartment(), 0.2, 0.05).save(&stem).unwrap();
    let on_cells = format!("--add=on-cells=mcl --global --map {}.yaml", stem.display());
    let with_rays = "--add=with-rays=mcl --model beam --particles 500 --particles-min 300";
    let out = place.at("run");
    let args = [&filter_scenario("global.toml"), "--ticks", "300", &on_cells, with_rays];
    let report = launch("maps", &out, &args);
    for (name, most_m) in [("on-cells", 0.06), ("with-rays", 0.02)] {
        let said = score_of(&report, name);
        assert!(number(said, "final_position_error_m") < most_m, "{name}: {said}");
        assert_eq!(said["nees"]["unusable"], 0, "{name}: {said}");
    }
}

/// How far off the answers of `csv` are at the true poses of a log from `from_s` on, m;
/// `None` where there is no answer.
fn offs_m(log: &Path, csv: &str, from_s: f64) -> Vec<Option<f64>> {
    let (header, records) = load(log);
    let dt_s = header.config.dt_s;
    let mut answers = csv.lines().skip(1);
    let (mut offs_m, mut began_s) = (Vec::new(), None);
    for record in records {
        let line: Vec<&str> = answers.next().unwrap().split(',').collect();
        let time_s = record.time_s(dt_s);
        let since_s = time_s - *began_s.get_or_insert(time_s);
        let Some(truth) = record.pose_in_world().filter(|_| since_s >= from_s) else {
            continue;
        };
        let number = |k: usize| line[k].parse::<f64>();
        let answer = number(2).ok().map(|x_m| SE2::new(x_m, number(3).unwrap(), 0.0));
        offs_m.push(answer.map(|a| (a.translation() - truth.translation()).norm()));
    }
    offs_m
}

#[test]
fn a_real_robot_is_found_and_followed_on_the_grid_of_its_own_first_half() {
    let Some(recording) = real_data("intel-corrected.log.gz") else { return };
    let place = folder();
    let log = place.at("intel.log");
    let path = arg(&log);
    let _ = import(&recording, &log, &[]).expect(0);
    let stem = arg(&place.at("intel")).to_owned();
    let args = ["--log", path, "--poses", "truth", "--until", "1326", "--save", &stem];
    let _ = execute("gridmap", &args).expect(0);
    let yaml = format!("{stem}.yaml");
    // What fit-beam and fit-motion find in this log.
    let believed = "--sigma-m 0.0464 --z-short 0.0085 --z-max 0.0276 --z-rand 0.0485 \
                    --alpha1 1.875e-3 --alpha2 5.537e-3 --alpha3 2.418e-3 --alpha4 1.174e-3";
    // It finds itself among 350 m² of rooms that look alike as well.
    for begin in [&["--at", "5.33,-21.85,-0.83"][..], &["--global"]] {
        let mut args = vec!["--log", path, "--map", &yaml, "--from", "1326"];
        args.extend(begin);
        args.extend(believed.split_whitespace());
        let answers = execute("mcl", &args).expect(0).stdout;
        let offs_m = offs_m(&log, &answers, 1326.0);
        // A third of these places are in rooms that the first half did not see: there it
        // says nothing, or is lost, and where it knows the walls again it finds itself.
        let near = offs_m.iter().flatten().filter(|off| **off < 0.5).count();
        let answered = offs_m.iter().flatten().count();
        let all = offs_m.len();
        assert!(near > 250 && near * 10 > answered * 8, "{begin:?}: {near} of {answered} of {all}");
    }
}
