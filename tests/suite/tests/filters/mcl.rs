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
    // One that would begin after the end says why it answered nothing.
    let late = ["--log", arg(&log), "--name", "late", "--from", "99"];
    execute("mcl", &late).expect(0).says("--from 99 s");
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
    let args = [&filter_scenario("global.toml"), "--ticks", "600", &on_cells, with_rays];
    let report = launch("maps", &out, &args);
    for (name, most_m) in [("on-cells", 0.06), ("with-rays", 0.02)] {
        let said = score_of(&report, name);
        assert!(number(said, "final_position_error_m") < most_m, "{name}: {said}");
        assert_eq!(said["nees"]["unusable"], 0, "{name}: {said}");
    }
}

/// Many beams pass panes and end on walls behind them.
#[test]
fn it_finds_itself_behind_glass() {
    let place = folder();
    let lost = "--add=lost=mcl --global";
    let report = launch("glass", place.path(), &["glass-lobby", "--ticks", "600", lost]);
    let said = score_of(&report, "lost");
    assert!(number(said, "scored_ticks") > 500.0, "{said}");
    assert!(number(said, "final_position_error_m") < 0.02, "{said}");
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

/// How far off `mcl` is in a recording, once for each list of arguments: from this time on, on
/// the grid of what was before; or in all of it, on the grid of all.
fn followed(file: &str, from_s: Option<f64>, runs: &[String]) -> Option<Vec<Vec<Option<f64>>>> {
    let recording = real_data(&format!("{file}-corrected.log.gz"))?;
    let place = folder();
    let log = place.at("run.log");
    let path = arg(&log);
    let _ = import(&recording, &log, &[]).expect(0);
    let stem = arg(&place.at("grid")).to_owned();
    let [until, from] = ["--until", "--from"].map(|option| from_s.map(|s| format!("{option}={s}")));
    let mut args = vec!["--log", path, "--poses", "truth", "--save", &stem];
    args.extend(until.as_deref());
    let _ = execute("gridmap", &args).expect(0);
    let yaml = format!("{stem}.yaml");
    let run = |own: &String| {
        let mut args = vec!["--log", path, "--map", &yaml];
        args.extend(from.as_deref());
        args.extend(own.split_whitespace());
        offs_m(&log, &execute("mcl", &args).expect(0).stdout, from_s.unwrap_or(0.0))
    };
    Some(runs.iter().map(run).collect())
}

/// Number of answers, of those within 0.5 m, and of those more than 1 m off.
fn counts(offs_m: &[Option<f64>]) -> [usize; 3] {
    let of = |is: fn(f64) -> bool| offs_m.iter().flatten().filter(|off_m| is(**off_m)).count();
    [of(|_| true), of(|off_m| off_m < 0.5), of(|off_m| off_m > 1.0)]
}

/// Compares a row of docs/filters.md with the medians and ranges of the counts over 8 seeds;
/// of other numbers of seeds only that the page has the row.
fn hold(names: &[&str], counts: &[[usize; 3]]) {
    let spread =
        |kind: usize| crate::figures::spread(counts.iter().map(|run| run[kind] as f64).collect());
    let kinds: &[usize] = if counts.len() == 8 { &[0, 1, 2] } else { &[] };
    crate::figures::hold_row(names, &kinds.iter().map(|kind| spread(*kind)).collect::<Vec<_>>());
}

/// With `RUSTY_SEEDS=8` the medians and ranges are those of docs/filters.md.
#[test]
fn a_real_robot_is_found_and_followed_on_the_grid_of_its_own_first_half() {
    // What fit-beam and fit-motion find in this log.
    let believed = "--sigma-m 0.0464 --z-short 0.0085 --z-max 0.0276 --z-rand 0.0485 \
                    --alpha1 1.875e-3 --alpha2 5.537e-3 --alpha3 2.418e-3 --alpha4 1.174e-3";
    // It finds itself among 350 m² of rooms that look alike as well.
    let begins = [("`--at`", "--at 5.33,-21.85,-0.83"), ("`--global`", "--global")];
    let seeds = crate::drivers::seeds(1);
    let runs = begins.iter().flat_map(|(_, begin)| {
        (1..=seeds).map(move |seed| format!("{begin} {believed} --seed {seed}"))
    });
    let Some(all) = followed("intel", Some(1326.0), &runs.collect::<Vec<_>>()) else { return };
    for ((name, _), runs) in begins.iter().zip(all.chunks(seeds as usize)) {
        // A third of these places are in rooms that the first half did not see: there it
        // says nothing, or is lost, and where it knows the walls again it finds itself.
        let counts = runs.iter().map(|offs_m| {
            let ([answers, near, wrong], scans) = (counts(offs_m), offs_m.len());
            println!("{name}: {answers} answers of {scans} scans, {near} near, {wrong} wrong");
            assert!(near > 330 && wrong == 0, "{near} and {wrong} of {answers}");
            assert!(near * 10 > answers * 9, "{near} of {answers}");
            [answers, near, wrong]
        });
        hold(&[name], &counts.collect::<Vec<_>>());
    }
}

/// With `RUSTY_SEEDS=8` the medians and ranges are those of docs/filters.md; without it, two
/// rows are run with the first seed.
#[test]
fn on_grids_of_recordings_it_is_nowhere_else() {
    // The number of answers with the first seed, and of those within 0.5 m.
    let rows = [
        ("freiburg-101", "Freiburg", Some(462.0), [82, 82]),
        ("csail", "CSAIL", Some(120.0), [86, 86]),
        ("edmonton", "Edmonton", Some(370.0), [22, 22]),
        ("freiburg-101", "Freiburg", None, [285, 285]),
        ("csail", "CSAIL", None, [401, 401]),
        ("edmonton", "Edmonton", None, [336, 336]),
    ];
    let seeds = crate::drivers::seeds(1);
    let count = if seeds == 1 { 2 } else { rows.len() };
    for (file, name, from_s, first) in &rows[..count] {
        let runs: Vec<String> = (1..=seeds).map(|seed| format!("--global --seed {seed}")).collect();
        let Some(all) = followed(file, *from_s, &runs) else { return };
        let row = format!("{name}, {} scans", all[0].len());
        let counts: Vec<[usize; 3]> = all.iter().map(|offs_m| counts(offs_m)).collect();
        println!("{row}: {counts:?}");
        assert_eq!(counts[0], [first[0], first[1], 0], "{row}");
        assert!(counts.iter().all(|[_, _, wrong]| *wrong == 0), "{row}: {counts:?}");
        let grid = if from_s.is_some() { "first half" } else { "all" };
        hold(&[&row, grid], &counts);
    }
}
