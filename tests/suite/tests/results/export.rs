//! Logs for other programs: what is written is what the log says, and is scored
//! as the scorer scores it; nothing is written over; nothing is left half done.

use std::collections::BTreeMap;

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::{Field, Row};
use rusty_contract::Estimate;
use rusty_geometry::trig;
use rusty_tests::*;

/// Who answers late, who is sure of itself, and who says nothing.
fn scenario(folder: &Path) -> String {
    let (probe, reckons) = (binary("probe-client"), ["dead-reckoning"]);
    let roster = [
        estimator("prompt", &reckons, ""),
        estimator("late", &reckons, "compute = { answer_s = 0.06 }"),
        estimator("sure", &[arg(&probe), "--mode", "covariance"], ""),
        estimator("silent", &[arg(&probe), "--mode", "abstain", "--at", "0"], ""),
    ];
    let run = "ticks = 60
scan_every = 10
lidar.beams = 30
";
    write(folder, "scenario.toml", [run, &roster.concat(), RECORDERS].concat())
}

/// A run of it: the log, the scores, and what is in the log.
fn run(place: &Path) -> (PathBuf, Value, Vec<TickRecord>) {
    let out = place.join("run");
    let report = launch("export", &out, &[&scenario(place)]);
    let log = out.join("run.log");
    let ticks = records(&log);
    assert_eq!(ticks.len(), 60);
    (log, report["scores"].clone(), ticks)
}

#[track_caller]
fn export(what: &str, log: &Path, args: &[&str], code: i32) -> Ended {
    sim_server(&[&["export", what, arg(log)], args].concat()).expect(code)
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
    assert_eq!(document["without"], json!(["silent"]));
    said.says("silent answered no pose");
    // Next to the log, unless another place is given.
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
    assert!(said.contains(arg(&path)), "{said}");
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

/// The numbers of a list, nothing for a cell that is null.
fn numbers(field: &Field) -> Option<Vec<f64>> {
    let Field::ListInternal(list) = field else { return None };
    let number = |field: &Field| match field {
        Field::Double(number) => *number,
        other => panic!("{other:?}"),
    };
    Some(list.elements().iter().map(number).collect())
}

#[test]
fn a_parquet_table_has_the_table_and_the_scans() {
    let place = folder();
    let log = place.at("run/run.log");
    launch("parquet", &place.at("run"), &[&sensed_scenario(place.path(), "sensed.toml", "")]);
    let ticks = records(&log);
    export("csv", &log, &[], 0);
    export("parquet", &log, &[], 0).prints("run.parquet");
    export("parquet", &log, &[], 2).says("--force");
    let mut csv = csv::Reader::from_path(log.with_extension("csv")).unwrap();
    let heads = csv.headers().unwrap().clone();
    let file = fs::File::open(log.with_extension("parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let rows: Vec<Row> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.len(), ticks.len());
    let (mut compared, mut scans, mut seen) = (0, 0, 0);
    for ((row, line), tick) in rows.iter().zip(csv.records().map(Result::unwrap)).zip(&ticks) {
        let cells: BTreeMap<&String, &Field> = row.get_column_iter().collect();
        for (name, text) in heads.iter().zip(&line) {
            let Some(cell) = cells.get(&name.to_owned()) else { continue };
            let as_text = match cell {
                Field::Null => String::new(),
                Field::Double(number) => format!("{number:?}"),
                Field::Long(number) => number.to_string(),
                _ => continue,
            };
            assert_eq!(as_text, text, "{name}, tick {}", tick.tick);
            compared += 1;
        }
        let list = |name: &str| numbers(cells[&name.to_owned()]);
        assert_eq!(list("ranges_m"), tick.ranges_m);
        scans += usize::from(tick.ranges_m.is_some());
        let readings = tick.readings.get();
        assert_eq!(list("sonar_m").as_deref(), readings.sonar_ranges_m());
        let landmarks = readings.landmarks();
        let ranges_m = landmarks.map(|all| all.iter().map(|l| l.range_m).collect::<Vec<f64>>());
        seen += ranges_m.iter().flatten().count();
        assert_eq!(list("landmarks.range_m"), ranges_m);
    }
    assert!(compared > 10 * ticks.len() && scans > 0 && scans < ticks.len() && seen > 0);
}

#[test]
fn nothing_is_written_over_and_nothing_left_half_done() {
    let place = folder();
    let (log, ..) = run(place.path());
    let tum = place.at("tum");
    let to = ["-o", arg(&tum)];
    export("tum", &log, &to, 0);
    let before = files(&tum);
    fs::write(tum.join("prompt.tum"), "mine").unwrap();
    let said = export("tum", &log, &to, 2).stderr;
    assert!(said.contains("is there already") && said.contains("--force"), "{said}");
    assert_eq!(fs::read_to_string(tum.join("prompt.tum")).unwrap(), "mine");
    export("tum", &log, &[&to[..], &["--force"]].concat(), 0);
    assert_eq!(poses(&tum.join("prompt.tum")).len(), 60);
    assert_eq!(files(&tum), before);
    // The log that is read is not written over, with --force neither.
    let bytes = fs::read(&log).unwrap();
    export("csv", &log, &["-o", arg(&log), "--force"], 2).says("read or written");
    let filter = ["--log", arg(&log), "--out", arg(&log), "--force"];
    Process::start("dead-reckoning", &filter).wait().expect(2).says("is the log being read");
    assert!(fs::read(&log).unwrap() == bytes);
    // What follows a trailer belongs to another file, or to none.
    let longer = place.at("longer.log");
    fs::write(&longer, [&bytes[..], b"x"].concat()).unwrap();
    sim_server(&["verify", arg(&longer)]).expect(3).says("after its trailer");
    // What is no log leaves not even a folder.
    let other = place.at("other");
    let said = export("tum", &place.at("scenario.toml"), &["-o", arg(&other)], 1);
    said.says("scenario.toml");
    assert!(!other.exists());

    // A log that was cut is exported as far as it goes.
    let cut = place.at("cut.log");
    let bytes = fs::read(&log).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let said = export("tum", &cut, &["-o", arg(&other)], 3);
    said.says("cut after");
    let (part, whole) = (poses(&other.join("truth.tum")), poses(&tum.join("truth.tum")));
    assert!(part.len() > 5 && part.len() < 60 && part[..] == whole[..part.len()]);
    let table = place.at("cut.csv");
    let said = export("csv", &cut, &["-o", arg(&table), "--json"], 3).json();
    assert_eq!(said["ticks"], part.len());
    assert!(said["cut"].as_str().unwrap().contains("byte"), "{said}");
}

#[test]
fn a_log_without_a_truth_has_its_estimates_alone() {
    let place = folder();
    let (log, ..) = run(place.path());
    let [blind, key, tum] = ["blind.log", "key", "tum"].map(|n| place.at(n));
    let to = arg(&tum);
    seal(&log, &blind, &key).expect(0);
    // Over what another log left: its truth is not this one's.
    export("tum", &log, &["-o", to], 0);
    let said = export("tum", &blind, &["-o", to, "--force"], 0);
    said.says("no tick has a known true pose");
    assert_eq!(files(&tum), ["late.tum", "prompt.tum", "sure.tum"]);
    assert_eq!(poses(&tum.join("prompt.tum")).len(), 60);
}
