//! Sweeps whose clients stay for many runs: the rows of separate launches to the bit, and
//! what happens to those who misbehave between two runs.

use rusty_tests::*;

/// Time in which a process ends that no timeout ends.
const LIMIT: Duration = Duration::from_secs(40);

/// A scenario with these estimators and a scorer, in a folder.
fn scenario(place: &Folder, estimators: &[(&str, &[&str])]) -> String {
    let (client, mut all) = (binary("series-client"), String::new());
    for (name, args) in estimators {
        let command = [&[arg(&client)], *args].concat();
        all += &estimator(name, &command, "");
    }
    let scorer = "[[participant]]\nname = \"score\"\nrole = \"scorer\"\ncommand = [\"score\"]\n";
    let head = "ticks = 30\nworld = \"open\"\nscan_every = 0\nscript = { kind = \"patrol\" }\n";
    place.write("scenario.toml", format!("{head}{all}{scorer}"))
}

/// A sweep by one crew.
fn by_one_crew<'a>(scenario: &'a str, seeds: &'a str, out: &'a Path) -> Vec<&'a str> {
    let args = ["sweep", scenario, "--seeds", seeds, "--clients", "--jobs", "1"];
    [&args[..], &["--quiet", "--out", arg(out)]].concat()
}

/// The rows of a crew are those of launches.
#[track_caller]
fn same_as_launches(place: &Folder, scenario: &str, more: &[&str]) -> Table {
    let [stayed, launched, runs] = ["stayed.csv", "launched.csv", "runs"].map(|n| place.at(n));
    let crew = by_one_crew(scenario, "3..5", &stayed);
    sim_server(&[&crew[..], more].concat()).expect(0);
    let launches = ["--runs", arg(&runs), "--jobs", "2"];
    let all = ["sweep", scenario, "--seeds", "3..5", "--clients", "--out", arg(&launched)];
    sim_server(&[&all[..], &launches, more].concat()).expect(0);
    let (a, b) = (Table::read(&stayed), Table::read(&launched));
    for name in a.names.iter().filter(|name| !name.starts_with("compute_")) {
        assert_eq!(a.column(name), b.column(name), "{scenario}: {name}");
    }
    a
}

#[test]
fn every_filter_and_driver_has_the_rows_of_separate_launches() {
    let place = folder();
    // `trajectory` answers in the first tick.
    let file = place.write("one.tum", "0.02 1 0 0 0 0 0 1\n");
    let trajectory = format!("trajectory=trajectory {file}");
    let all: [(&str, &[&str]); 6] = [
        ("filters.toml", &["--ticks", "60", "--add", "gridmap=gridmap --save {out}/map"]),
        ("global.toml", &["--ticks", "60", "--add", "grid-localisation=grid-localisation"]),
        ("hallway.toml", &["--ticks", "60", "--add", &trajectory]),
        ("explore.toml", &["--ticks", "60"]),
        ("landmarks.toml", &["--ticks", "60", "--add", "eif-landmarks=eif-landmarks"]),
        ("wander.toml", &["--ticks", "60"]),
    ];
    let mut seen = Vec::new();
    for (file, more) in all {
        let rows = same_as_launches(&folder(), &filter_scenario(file), more);
        seen.extend(rows.column("estimator").into_iter().map(str::to_owned));
    }
    // With a slot `mcl-global`, which is `mcl` that is not told where it starts.
    for program in rusty_filters::PROGRAMS {
        // Those that fit a model to a log have no row.
        let name = program.name;
        assert!(name.starts_with("fit-") || seen.iter().any(|seen| seen == name), "{name}");
    }
}

#[test]
fn a_program_that_takes_part_in_one_run_is_started_again_for_each() {
    let place = folder();
    let scenario = scenario(&place, &[("stays", &[]), ("once", &["--mode", "once"])]);
    let rows = same_as_launches(&place, &scenario, &[]);
    assert_eq!(rows.column("estimator"), ["stays", "once"].repeat(2));
    let errors = rows.numbers("ate_rmse_m");
    assert!(errors.chunks(2).all(|pair| pair[0] == pair[1] && pair[0] > 0.0), "{errors:?}");
}

#[test]
fn what_a_program_wrote_in_one_run_is_not_there_in_the_next() {
    let place = folder();
    let reads = ["--mode", "reads", "--once", "{out}/notes"];
    let rows =
        same_as_launches(&place, &scenario(&place, &[("stays", &[]), ("reads", &reads)]), &[]);
    let errors = rows.numbers("ate_rmse_m");
    assert!(errors.chunks(2).all(|pair| pair[0] == pair[1]), "{errors:?}");
}

#[test]
fn a_filter_that_carries_state_over_is_named() {
    let place = folder();
    let scenario = scenario(&place, &[("honest", &[]), ("carrier", &["--mode", "carries"])]);
    let out = place.at("a.csv");
    let ended = sim_server(&by_one_crew(&scenario, "3..6", &out)).expect(4);
    ended.says("carrier, seed 3: expected the answers of its first run");
    ended.says("another answer at tick 0");
    assert!(!ended.stderr.contains("honest"), "{ended:?}");
    // A single run has nothing to carry over.
    let one = place.at("b.csv");
    sim_server(&by_one_crew(&scenario, "3", &one)).expect(0);
}

#[test]
fn asking_for_the_next_run_in_the_middle_of_one_is_a_loss() {
    let place = folder();
    let scenario = scenario(&place, &[("early", &["--mode", "early"])]);
    let out = place.at("a.csv");
    let ended = sim_server(&by_one_crew(&scenario, "3..5", &out)).expect(3);
    let lost = ended.stderr.replace('\n', " ");
    assert!(Table::read(&out).numbers("ticks").iter().all(|ticks| *ticks < 30.0), "{lost}");
}

/// A sweep in which all wait for one that sleeps between its first two runs.
struct Between {
    place: Folder,
    process: Process,
    run: RunName,
}

impl Between {
    fn start(sleep_ms: &str) -> Self {
        let place = folder();
        let (mark, out) = (place.at("mark"), place.at("a.csv"));
        let sleeps = ["--mode", "dawdles", "--sleep-ms", sleep_ms, "--once", arg(&mark)];
        let scenario = scenario(&place, &[("waits", &[]), ("sleeps", &sleeps)]);
        let process = Process::start("sim-server", &by_one_crew(&scenario, "3..6", &out));
        let run = RunName::new(&format!("sweep-{}-0", process.pid())).unwrap();
        until("the first run has ended", || mark.exists());
        Self { place, process, run }
    }
}

#[test]
fn a_server_that_is_killed_between_runs_leaves_nothing() {
    let Between { place, process, run } = Between::start("1500");
    let waiting = participants(&run);
    assert_eq!(waiting.len(), 3, "{waiting:?}");
    process.signal(Signal::KILL);
    assert_eq!(process.wait_within(LIMIT).code, None);
    until_within(LIMIT, "all have ended", || participants(&run).is_empty());
    nothing_left(&run);
    assert!(!place.at("a.csv").exists());
}

#[test]
fn a_sweep_that_is_stopped_between_runs_keeps_what_is_done() {
    let Between { place, process, run } = Between::start("1500");
    process.signal(Signal::INT);
    process.wait_within(LIMIT).expect(3).says("1 of 3 runs");
    assert!(participants(&run).is_empty());
    nothing_left(&run);
    assert!(place.at("a.csv.part").exists() && !place.at("a.csv").exists());
}

#[test]
fn a_participant_that_dies_between_runs_is_named_and_started_again() {
    let place = folder();
    let (marks, out) = (["a", "b"].map(|name| place.at(name)), place.at("a.csv"));
    let sleeps = ["--mode", "dawdles", "--sleep-ms", "1500", "--once", arg(&marks[0])];
    let dies = ["--mode", "dies-asking", "--once", arg(&marks[1])];
    let scenario = scenario(&place, &[("dies", &dies), ("sleeps", &sleeps)]);
    let ended = sim_server(&by_one_crew(&scenario, "3..6", &out)).expect(3);
    ended.says("seed 3: dies: its process was killed by signal 9");
    let rows = Table::read(&out);
    assert_eq!(rows.numbers("ticks"), [30.0; 6]);
    let errors = rows.numbers("ate_rmse_m");
    assert!(errors.chunks(2).all(|pair| pair[0] == pair[1] && pair[0] > 0.0), "{errors:?}");
}

#[test]
fn a_participant_that_never_asks_for_the_next_run_is_named_and_ended() {
    let place = folder();
    let (mark, out) = (place.at("mark"), place.at("a.csv"));
    let lingers = ["--mode", "lingers", "--once", arg(&mark)];
    let scenario = scenario(&place, &[("stays", &[]), ("lingers", &lingers)]);
    let ended = sim_server(&by_one_crew(&scenario, "3..5", &out)).expect(3);
    ended.says("seed 3: lingers: it did not end by itself");
    assert_eq!(Table::read(&out).numbers("ticks"), [30.0; 4]);
}

#[test]
fn a_participant_that_is_lost_is_started_again_for_the_next_run() {
    let place = folder();
    let probe = binary("probe-client");
    let leaves = estimator("leaves", &[arg(&probe), "--mode", "exit"], "");
    let stays = estimator("stays", &[arg(&binary("series-client"))], "");
    let head = "ticks = 40\nworld = \"open\"\nscan_every = 0\non_loss = \"continue\"\n";
    let scenario = place.write("scenario.toml", format!("{head}{stays}{leaves}{RECORDERS}"));
    let out = place.at("a.csv");
    let ended = sim_server(&by_one_crew(&scenario, "0..3", &out)).expect(3);
    for seed in 0..3 {
        ended.says(&format!("seed {seed}: leaves: "));
    }
    let rows = Table::read(&out);
    assert_eq!(rows.numbers("ticks"), [40.0; 6]);
    assert!(rows.numbers("ate_rmse_m").iter().step_by(2).all(|error| *error > 0.0));
}
