//! Logs for other programs: what is written is what the log says, and is scored
//! as the scorer scores it; nothing is written over; nothing is left half done.

use std::fs;
use std::path::{Path, PathBuf};

use rusty_contract::Estimate;
use rusty_contract::log::{LogReader, Read, TickRecord};
use rusty_geometry::{SE2, trig};
use rusty_tests::{Ended, binary, folder, launch, sim_server};

/// Who answers late, who is sure of itself, and who says nothing.
fn scenario(folder: &Path) -> PathBuf {
    let (path, probe) = (folder.join("scenario.toml"), binary("probe-client"));
    let text = format!(
        "ticks = 60\nscan_every = 10\nlidar.beams = 30\n\
         [[participant]]\nname = \"prompt\"\ncommand = [\"dead-reckoning\"]\n\
         [[participant]]\nname = \"late\"\ncommand = [\"dead-reckoning\"]\n\
         compute = {{ answer_s = 0.06 }}\n\
         [[participant]]\nname = \"sure\"\ncommand = [{probe:?}, \"--mode\", \"covariance\"]\n\
         [[participant]]\nname = \"silent\"\ncommand = [{probe:?}, \"--mode\", \"abstain\", \"--at\", \"0\"]\n\
         [[participant]]\nname = \"score\"\nrole = \"scorer\"\ncommand = [\"score\"]\n\
         [[participant]]\nname = \"logger\"\nrole = \"logger\"\ncommand = [\"logger\"]\n"
    );
    fs::write(&path, text).unwrap();
    path
}

/// A run of it: the log, the scores, and what is in the log.
fn run(place: &Path) -> (PathBuf, serde_json::Value, Vec<TickRecord>) {
    let out = place.join("run");
    let report = launch("export", &out, &[scenario(place).to_str().unwrap()]);
    let log = out.join("run.log");
    let mut reader = LogReader::open(&log).unwrap();
    let mut ticks = Vec::new();
    while let Read::Tick(entry) = reader.read().unwrap() {
        ticks.push(entry.record);
    }
    assert_eq!(ticks.len(), 60);
    (log, report["scores"].clone(), ticks)
}

#[track_caller]
fn export(what: &str, log: &Path, args: &[&str], code: i32) -> Ended {
    let mut all = vec!["export", what, log.to_str().unwrap()];
    all.extend(args);
    sim_server(&all).expect(code)
}

/// Time and pose of every line.
fn poses(path: &Path) -> Vec<(f64, SE2)> {
    let line = |line: &str| {
        let n: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        assert_eq!((n.len(), &n[3..6]), (8, &[0.0; 3][..]), "{line}");
        assert!((trig::hypot(n[6], n[7]) - 1.0).abs() < 1e-15, "{line}");
        (n[0], SE2::new(n[1], n[2], 2.0 * trig::atan2(n[6], n[7])))
    };
    fs::read_to_string(path).unwrap().lines().map(line).collect()
}

/// To the bit but for the heading, which goes through a quaternion.
#[track_caller]
fn same(a: &SE2, b: &SE2) {
    assert_eq!((a.x().to_bits(), a.y().to_bits()), (b.x().to_bits(), b.y().to_bits()));
    assert!((a.theta() - b.theta()).abs() < 1e-14, "{a:?} {b:?}");
}

fn estimate(tick: &TickRecord, who: usize) -> Estimate {
    *tick.replies[who].estimate().unwrap()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_trajectory_is_what_is_scored() {
    let place = folder();
    let (log, scores, ticks) = run(place.path());
    let said = export("tum", &log, &["--json"], 0);
    let document = said.json();
    assert_eq!(document["ticks_with_truth"], 60);
    assert_eq!(document["without"], serde_json::json!(["silent"]));
    assert!(said.stderr.contains("silent answered no pose"), "{}", said.stderr);
    // Beside the log, unless it is said where.
    let tum = log.with_file_name("tum");
    assert_eq!(files(&tum), ["late.tum", "prompt.tum", "sure.tum", "truth.tum"]);
    let (truth, prompt) = (poses(&tum.join("truth.tum")), poses(&tum.join("prompt.tum")));
    for (k, tick) in ticks.iter().enumerate() {
        assert_eq!(truth[k].0, (k + 1) as f64 * 0.02);
        same(&truth[k].1, &tick.pose_in_world().unwrap());
        assert_eq!(prompt[k].0.to_bits(), truth[k].0.to_bits());
        same(&prompt[k].1, &estimate(tick, 0).pose_in_world);
    }
    // An answer that takes three ticks is in effect three ticks later.
    let late = poses(&tum.join("late.tum"));
    assert_eq!((late.len(), late[0].0), (57, truth[3].0));
    for (line, tick) in late.iter().zip(&ticks) {
        same(&line.1, &estimate(tick, 1).pose_in_world);
    }
    for score in scores.as_array().unwrap().iter().filter(|s| s["name"] != "silent") {
        let lines = poses(&tum.join(format!("{}.tum", score["name"].as_str().unwrap())));
        assert_eq!(score["scored_ticks"], lines.len());
        let (time_s, last) = lines[lines.len() - 1];
        let (_, at) = truth.iter().find(|(t, _)| *t == time_s).unwrap();
        let off_m = trig::hypot(last.x() - at.x(), last.y() - at.y());
        assert_eq!(score["final_position_error_m"], off_m, "{score}");
    }
}

#[test]
fn a_table_has_every_tick() {
    let place = folder();
    let (log, _, ticks) = run(place.path());
    let said = export("csv", &log, &[], 0).stdout;
    let path = log.with_extension("csv");
    assert!(said.contains(path.to_str().unwrap()), "{said}");
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 60);
    for (row, tick) in rows.iter().zip(&ticks) {
        let text = |name: &str| row.get(names.iter().position(|n| n == name).unwrap()).unwrap();
        let number = |name: &str| text(name).parse::<f64>().unwrap().to_bits();
        assert_eq!(text("tick"), tick.tick.to_string());
        assert_eq!(text("left_ticks"), tick.ticks.left.to_string());
        assert_eq!(number("omega_rad_s"), tick.command.omega_rad_s.to_bits());
        assert_eq!(number("truth.theta_rad"), tick.truth.unwrap()[2].to_bits());
        let sure = estimate(tick, 2);
        assert_eq!(number("sure.theta_rad"), sure.pose_in_world.theta().to_bits());
        assert_eq!(number("sure.var_theta_rad2"), sure.covariance.unwrap()[8].to_bits());
        assert_eq!(text("sure.var_y_m2"), "0.02");
        assert_eq!((text("prompt.var_x_m2"), text("silent.x_m")), ("", ""));
        assert_eq!(text("late.x_m").is_empty(), tick.tick < 3);
    }
}

#[test]
fn nothing_is_written_over_and_nothing_left_half_done() {
    let place = folder();
    let (log, ..) = run(place.path());
    let tum = place.path().join("tum");
    let to = ["-o", tum.to_str().unwrap()];
    export("tum", &log, &to, 0);
    let before = files(&tum);
    fs::write(tum.join("prompt.tum"), "mine").unwrap();
    let said = export("tum", &log, &to, 2).stderr;
    assert!(said.contains("is there already") && said.contains("--force"), "{said}");
    assert_eq!(fs::read_to_string(tum.join("prompt.tum")).unwrap(), "mine");
    export("tum", &log, &[&to[..], &["--force"]].concat(), 0);
    assert_eq!(poses(&tum.join("prompt.tum")).len(), 60);
    assert_eq!(files(&tum), before);
    // What is no log leaves not even a folder.
    let other = place.path().join("other");
    let said =
        export("tum", &place.path().join("scenario.toml"), &["-o", other.to_str().unwrap()], 1);
    assert!(said.stderr.contains("scenario.toml"), "{}", said.stderr);
    assert!(!other.exists());

    // A log that was cut is exported as far as it goes.
    let cut = place.path().join("cut.log");
    let bytes = fs::read(&log).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let said = export("tum", &cut, &["-o", other.to_str().unwrap()], 3);
    assert!(said.stderr.contains("cut after"), "{}", said.stderr);
    let (part, whole) = (poses(&other.join("truth.tum")), poses(&tum.join("truth.tum")));
    assert!(part.len() > 5 && part.len() < 60 && part[..] == whole[..part.len()]);
    let table = place.path().join("cut.csv");
    let said = export("csv", &cut, &["-o", table.to_str().unwrap(), "--json"], 3).json();
    assert_eq!(said["ticks"], part.len());
    assert!(said["cut"].as_str().unwrap().contains("byte"), "{said}");
}

#[test]
fn a_log_without_a_truth_has_its_estimates_alone() {
    let place = folder();
    let (log, ..) = run(place.path());
    let [blind, key, tum] = ["blind.log", "key", "tum"].map(|n| place.path().join(n));
    let [log, sealed, key, to] = [&log, &blind, &key, &tum].map(|p| p.to_str().unwrap());
    sim_server(&["seal", log, "-o", sealed, "--key-file", key]).expect(0);
    // Over what another log left: its truth is not this one's.
    export("tum", Path::new(log), &["-o", to], 0);
    let said = export("tum", &blind, &["-o", to, "--force"], 0);
    assert!(said.stderr.contains("no tick has a known true pose"), "{}", said.stderr);
    assert_eq!(files(&tum), ["late.tum", "prompt.tum", "sure.tum"]);
    assert_eq!(poses(&tum.join("prompt.tum")).len(), 60);
}
