//! Sweeps: rows that are what launches come to, whatever is done next to each
//! other, in parts, or after an interruption; and the chapter's table.

use rusty_tests::*;

/// `sweep … --out FILE`, with its exit code.
#[track_caller]
fn sweep(args: &[&str], out: &Path, code: i32) -> Ended {
    sim_server(&[&["sweep"], args, &["--out", arg(out)]].concat()).expect(code)
}

#[test]
fn a_row_is_what_launch_comes_to() {
    let place = folder();
    let few: [(&str, &[&str]); 2] = [
        ("patrol", &["--set", "robot.slip_std=0.03"]),
        // Scans, walls, steering on the truth.
        ("apartment", &["--ticks", "120", "--set", "lidar.beams=90"]),
    ];
    for (scenario, args) in few {
        let out = place.at(format!("{scenario}.csv"));
        let mut all = vec![scenario];
        all.extend(args);
        sweep(&[&all[..], &["--seeds", "5..8"]].concat(), &out, 0);
        let rows = Table::read(&out);
        all.extend(["--seed", "6"]);
        let report = launch("row", &place.at("run"), &all);
        assert_eq!(rows.column("seed"), ["5", "6", "7"]);
        assert_eq!(rows.column("digest")[1], text(&report, "digest"));
        assert_eq!(rows.column("ticks")[1], report["ticks"].to_string());
        let score = &report["scores"][0];
        assert_eq!(rows.column("estimator")[1], text(score, "name"));
        let columns = "distance_m final_position_error_m final_heading_error_rad \
                       mean_position_error_m ate_rmse_m p95_position_error_m \
                       max_position_error_m rmse_heading_error_rad max_heading_error_rad";
        for column in columns.split_whitespace() {
            let (found, expected) = (rows.numbers(column)[1], number(score, column));
            assert_eq!(found.to_bits(), expected.to_bits(), "{scenario}, {column}");
            assert!(found > 0.0, "{scenario}: {column} is nothing to compare");
        }
    }
}

#[test]
fn what_a_launch_remarks_a_sweep_and_a_budget_do_too() {
    let place = folder();
    let text = "ticks = 50\n[[walker]]\nwaypoints = [[6.0, 4.5]]\n\
                [[kidnapping]]\ntick = 400\nto = { x_m = 9.6, y_m = 3.0, theta_rad = 0.0 }\n";
    let file = write(place.path(), "late.toml", text);
    let remarks = ["a kidnapping at tick 400 will not happen", "walker[0] begins at [6.0, 4.5]"];
    let launched = sim_server(&["launch", &file, "--out", arg(&place.at("run"))]).expect(0);
    let swept = sweep(&[&file, "--seeds", "0..2"], &place.at("t.csv"), 0);
    for ended in [launched, swept] {
        remarks.iter().for_each(|remark| assert!(ended.stderr.contains(remark), "{ended:?}"));
    }
    let outside = "walker=[{ waypoints = [[60.0, 4.5]] }]";
    let people = ["budget", &file, "--set", outside, "--set", "kidnapping=[]"];
    sim_server(&people).expect(2).says("people = 1");
    let late = "event=[{ kind = \"remove-box\", tick = 400, number = 1 }]";
    let args = [&people[..2], &["--seeds", "0..2", "--set", "walker=[]", "--set", late]].concat();
    sim_server(&[&args[..], &["--set", "kidnapping=[]"]].concat())
        .expect(0)
        .says("an event at tick 400 will not happen");
}

#[test]
fn with_clients_the_rows_are_the_same() {
    let place = folder();
    let [inside, clients, runs] = ["a.csv", "b.csv", "runs"].map(|n| place.at(n));
    let args = ["patrol", "--seeds", "3..5", "--set", "robot.slip_std=0.02,0.04", "--ticks", "90"];
    sweep(&args, &inside, 0);
    let with = ["--clients", "--jobs", "2", "--runs", arg(&runs)];
    sweep(&[&args[..], &with].concat(), &clients, 0);
    let (a, b) = (Table::read(&inside), Table::read(&clients));
    assert_eq!(a.rows.len(), 4);
    for name in &a.names {
        assert_eq!(a.column(name), b.column(name), "{name}");
    }
    assert!(runs.join("cell-1-seed-4/run.log").exists());
}

#[test]
fn ticks_that_a_wall_held_are_counted_inside_and_by_the_scorer() {
    let place = folder();
    let [inside, clients] = ["a.csv", "b.csv"].map(|n| place.at(n));
    // An open loop with much slip: it runs into the corridor's walls.
    let set = ["script.leg_s=12.3", "robot.slip_std=0.1", "scan_every=0"];
    let set = set.map(|set| ["--set", set]).concat();
    let args = [&["apartment", "--seeds", "0..4", "--ticks", "900"], &set[..]].concat();
    sweep(&args, &inside, 0);
    sweep(&[&args[..], &["--clients"]].concat(), &clients, 0);
    let (a, b) = (Table::read(&inside), Table::read(&clients));
    assert_eq!(a.column("blocked_ticks"), b.column("blocked_ticks"));
    assert_eq!(a.column("digest"), b.column("digest"));
    assert!(
        a.numbers("blocked_ticks").iter().sum::<f64>() > 0.0,
        "{:?}",
        a.column("blocked_ticks")
    );
    // A robot that stands is held by no box that is put on it.
    let place = folder();
    let standing = place.at("standing.csv");
    let set = [
        "script={ kind = 'commands', list = [{ v_m_s = 0.0, omega_rad_s = 0.0 }] }",
        "event=[{ kind = 'put-box', tick = 9, number = 1, \
         at = { x_m = 6.0, y_m = 4.5, theta_rad = 0.0 }, size_m = [0.4, 0.4] }]",
    ];
    let set = set.map(|set| ["--set", set]).concat();
    sweep(&[&["apartment", "--seeds", "1", "--ticks", "20"], &set[..]].concat(), &standing, 0);
    assert_eq!(Table::read(&standing).column("blocked_ticks"), ["0"]);
}

#[test]
fn a_lost_client_is_a_row_without_figures_and_an_exit_code() {
    let place = folder();
    let (out, probe) = (place.at("a.csv"), binary("probe-client"));
    let leaves = estimator("leaves", &[arg(&probe), "--mode", "exit"], "");
    let text = format!("ticks = 40\nworld = \"open\"\nscan_every = 0\n{leaves}{RECORDERS}");
    let scenario = place.write("scenario.toml", text);
    let args = [&scenario, "--seeds", "0..2", "--clients"];
    let said = sweep(&args, &out, 3).stderr;
    assert!(said.contains("seed 1: leaves: "), "{said}");
    let rows = Table::read(&out);
    assert_eq!(rows.column("estimator"), ["leaves", "leaves"]);
    assert!(rows.numbers("ticks").iter().all(|t| *t < 40.0), "{:?}", rows.column("ticks"));
}

const GRID: [&str; 7] =
    ["patrol", "--seeds", "0..40", "--set", "robot.slip_std=0.01,0.05", "--set", "dt_s=0.1,0.05"];

#[test]
fn the_number_of_jobs_changes_no_byte() {
    let place = folder();
    for ending in ["csv", "parquet"] {
        let out = |jobs: &str| place.at(format!("{ending}-{jobs}.{ending}"));
        for jobs in ["1", "2", "5"] {
            sweep(&[&GRID[..], &["--jobs", jobs]].concat(), &out(jobs), 0);
        }
        let one = fs::read(out("1")).unwrap();
        assert!(one.len() > 8_000, "{} bytes", one.len());
        assert!(["2", "5"].iter().all(|jobs| fs::read(out(jobs)).unwrap() == one), "{ending}");
    }
    let rows = Table::read(&place.at("csv-1.csv"));
    let seeds: Vec<String> = (0..4).flat_map(|_| 0..40).map(|s: u64| s.to_string()).collect();
    assert_eq!(rows.column("seed"), seeds);
    let cell = |i: usize| [rows.column("robot.slip_std")[40 * i], rows.column("dt_s")[40 * i]];
    let cells = [["0.01", "0.1"], ["0.01", "0.05"], ["0.05", "0.1"], ["0.05", "0.05"]];
    assert_eq!([0, 1, 2, 3].map(cell), cells);
}

/// A sweep that is stopped in the middle: it stands still, with something done
/// and something not.
fn in_the_middle(args: &[&str], out: &Path) -> Process {
    let all = [&["sweep"], args, &["--force", "--out", arg(out)]].concat();
    let part = PathBuf::from(format!("{}.part", out.display()));
    // One that is through before it is looked at is tried again.
    for _ in 0..20 {
        let _ = fs::remove_file(out);
        let process = Process::start("sim-server", &all);
        let length = || fs::metadata(&part).map_or(0, |m| m.len());
        until("something is done", || length() > 100_000 || out.exists());
        process.signal(Signal::STOP);
        if !out.exists() {
            return process;
        }
        process.signal(Signal::CONT);
        process.wait().expect(0);
    }
    panic!("never caught in the middle");
}

#[test]
fn an_interrupted_sweep_goes_on_to_the_same_bytes() {
    let place = folder();
    let args = ["patrol", "--seeds", "0..1500", "--jobs", "2"];
    let whole = place.at("whole.parquet");
    sweep(&args, &whole, 0);
    for (name, signal, code) in [("int", Signal::INT, Some(3)), ("kill", Signal::KILL, None)] {
        let out = place.at(format!("{name}.parquet"));
        let part = PathBuf::from(format!("{}.part", out.display()));
        let process = in_the_middle(&args, &out);
        process.signal(signal);
        process.signal(Signal::CONT);
        let ended = process.wait();
        assert_eq!(ended.code, code, "{ended:#?}");
        assert!(!out.exists() && part.exists());
        if signal == Signal::INT {
            ended.says("go on with --resume");
        } else {
            // As if the machine had gone in the middle of a record.
            let length = fs::metadata(&part).unwrap().len();
            fs::File::options().write(true).open(&part).unwrap().set_len(length - 5).unwrap();
        }
        let said = sweep(&args, &out, 2).stderr;
        assert!(said.contains("--resume"), "{said}");
        let other = ["patrol", "--seeds", "0..1500", "--set", "robot.track_m=0.17", "--resume"];
        let said = sweep(&other, &out, 2).stderr;
        assert!(said.contains("robot.track_m: 0.16 and 0.17"), "{said}");
        let again = sweep(&[&args[..3], &["--jobs", "1", "--resume", "--json"]].concat(), &out, 0);
        assert!(again.json()["runs_resumed"].as_u64().unwrap() > 10, "{}", again.stdout);
        assert!(fs::read(&out).unwrap() == fs::read(&whole).unwrap(), "{name}");
        assert!(!part.exists());
    }
}

#[test]
fn a_table_that_is_there_is_not_written_over() {
    let place = folder();
    let args = ["patrol", "--seeds", "0..3"];
    for file in ["c-fan.svg", "c-errors.png", "c.csv.json"] {
        // The drawings and settings of a table are those of another work, too.
        fs::write(place.at(file), "mine").unwrap();
        sweep(&args, &place.at("c.csv"), 2).says(file);
        assert_eq!(fs::read(place.at(file)).unwrap(), b"mine");
        fs::remove_file(place.at(file)).unwrap();
    }
    fs::create_dir(place.at("d.csv")).unwrap();
    for more in [&[][..], &["--force"]] {
        sweep(&[&args[..], more].concat(), &place.at("d.csv"), 2).says("is a folder");
    }
    for name in ["a.csv", "b.parquet"] {
        let out = place.at(name);
        sweep(&args, &out, 0);
        let bytes = fs::read(&out).unwrap();
        let said = sweep(&args, &out, 2).stderr;
        assert!(said.contains("is there already") && said.contains("--force"), "{said}");
        let said = sweep(&[&args[..], &["--resume"]].concat(), &out, 0).stderr;
        assert!(said.contains("complete already"), "{said}");
        let other = ["patrol", "--seeds", "0..4"];
        let said = sweep(&[&other[..], &["--resume"]].concat(), &out, 2).stderr;
        assert!(said.contains("seeds: \"0..3\" and \"0..4\""), "{said}");
        assert!(fs::read(&out).unwrap() == bytes);
        sweep(&[&other[..], &["--force"]].concat(), &out, 0);
        assert!(fs::read(&out).unwrap() != bytes);
    }
}

#[test]
fn a_finished_sweep_tells_its_losses_again_and_has_its_programs() {
    let place = folder();
    let (program, server) = (place.at("mine.sh"), binary("sim-server"));
    let write = |filter: &str| {
        fs::write(&program, format!("exec {} {filter} \"$@\"\n", server.display())).unwrap();
    };
    write("dead-reckoning");
    let few = ["patrol", "--seeds", "0..2", "--ticks", "30", "--clients", "--jobs", "1"];
    let again = |args: &[&str], out: &Path, code: i32| {
        sweep(&[&few[..], args, &["--resume", "--json"]].concat(), out, code)
    };
    let (mine, out) = (format!("mine=sh {}", program.display()), place.at("a.csv"));
    sweep(&[&few[..], &["--add", &mine]].concat(), &out, 0);
    assert_eq!(again(&["--add", &mine], &out, 0).json()["lost"], Value::Array(vec![]));
    write("wander");
    again(&["--add", &mine], &out, 2).says("programs").says("mine.sh");
    write("dead-reckoning");
    let whole = fs::read_to_string(&out).unwrap();
    fs::write(&out, &whole[..whole.trim_end().rfind('\n').unwrap() + 1]).unwrap();
    again(&["--add", &mine], &out, 2).says("has 3 of 4 rows");

    let lost = place.at("b.csv");
    let bad = ["--add", "bad=false"];
    let first = sweep(&[&few[..], &bad, &["--json"]].concat(), &lost, 3).json();
    assert_eq!(list(&first, "lost").len(), 2);
    let told = again(&bad, &lost, 3);
    assert_eq!(told.says("seed 1: bad").json()["lost"], first["lost"]);
}

#[test]
fn what_cannot_be_drawn_is_drawn_later() {
    let place = folder();
    let (out, wall) = (place.at("a.csv"), place.at("a-growth.png"));
    let args = ["patrol", "--seeds", "0..3"];
    fs::create_dir(&wall).unwrap();
    sweep(&args, &out, 1).says("a-growth.png");
    fs::remove_dir(&wall).unwrap();
    sweep(&args, &out, 2).says("--resume");
    let ended = sweep(&[&args[..], &["--resume", "--json"]].concat(), &out, 0).json();
    assert_eq!((list(&ended, "pictures").len(), &ended["ticks"]), (6, &0.into()));
    assert!(wall.is_file() && !place.at("a.csv.part").exists());
}

#[test]
fn a_sweep_that_cannot_begin_takes_nothing_away_and_leaves_nothing() {
    let place = folder();
    let out = place.at("a.csv");
    let with = |add: &'static str| ["patrol", "--seeds", "0..2", "--clients", "--add", add];
    let missing = with("x=no-such-program");
    sweep(&missing, &out, 1).says("no-such-program");
    assert!(fs::read_dir(place.path()).unwrap().next().is_none());
    sweep(&["patrol", "--seeds", "0..2"], &out, 0);
    let bytes = fs::read(&out).unwrap();
    sweep(&[&missing[..], &["--force"]].concat(), &out, 1).says("no-such-program");
    assert!(fs::read(&out).unwrap() == bytes);
    // What fails before the first run has ended leaves no journal.
    let runs = ["patrol", "--seeds", "0..2", "--clients", "--runs", arg(&out)];
    sweep(&runs, &place.at("b.csv"), 1);
    assert!(!place.at("b.csv.part").exists());
}

#[test]
fn a_sweep_at_work_is_not_replaced() {
    let place = folder();
    let out = place.at("a.csv");
    let args = ["patrol", "--seeds", "0..1500", "--jobs", "2"];
    let process = in_the_middle(&args, &out);
    for more in [&[][..], &["--resume"], &["--force"]] {
        sweep(&[&args[..], more].concat(), &out, 2).says("another sweep");
    }
    process.signal(Signal::CONT);
    process.wait().expect(0);
    assert_eq!(Table::read(&out).rows.len(), 1500);
}

#[test]
fn what_cannot_be_swept_is_named_with_its_remedy() {
    let place = folder();
    let out = place.at("a.csv");
    let cases: [(&[&str], &str); 10] = [
        (&["driver", "--seeds", "0..2"], "give --clients"),
        (&["patrol", "--seeds", "3..3"], "0..500"),
        (&["patrol", "--seeds", "0..2", "--set", "seed=1,2"], "give --seeds"),
        (&["patrol", "--seeds", "0..2", "--set", "robot.slip_std=0.1,-1"], "robot.slip_std = -1"),
        (&["patrol", "--seeds", "0..2", "--set", "robot.slip_std=0.1,,1"], "is empty"),
        (&["patrol", "--seeds", "0..2", "--ab", "robot.slip_std=1,2,3"], "has 3 values"),
        (&["patrol", "--seeds", "0..2", "--ab", "a.b=1,2", "--set", "a.b=1"], "given twice"),
        (&["patrol", "--seeds", "0..9000000000"], "fewer seeds"),
        (&["patrol", "--seeds", "0..2", "--set", "ticks=1,2", "--ticks", "9"], "by --ticks"),
        (&["patrol", "--seeds", "0..2", "--set", "a.b=1", "--set", "a={}"], "one by one"),
    ];
    for (args, words) in cases {
        let said = sweep(args, &out, 2).stderr;
        assert!(said.contains(words), "{args:?}: {said}");
        assert!(fs::read_dir(place.path()).unwrap().next().is_none(), "{args:?} left something");
    }
    let said = sweep(&["patrol", "--seeds", "0..2"], &place.at("a.xlsx"), 2).stderr;
    assert!(said.contains("FILE.parquet or FILE.csv"), "{said}");
}

#[test]
fn an_interrupted_sweep_with_clients_leaves_nothing_but_its_journal() {
    let place = folder();
    let (out, runs) = (place.at("a.csv"), place.at("runs"));
    let many = ["sweep", "patrol", "--seeds", "0..2", "--ticks", "10000000", "--clients"];
    let files = ["--runs", arg(&runs), "--out", arg(&out)];
    let process = Process::start("sim-server", &[&many[..], &["--jobs", "2"], &files].concat());
    let pid = process.pid();
    let log = |seed: u64| runs.join(format!("cell-0-seed-{seed}/run.log"));
    until("both runs are under way", || {
        (0..2).all(|seed| fs::metadata(log(seed)).is_ok_and(|m| m.len() > 0))
    });
    process.signal(Signal::INT);
    process.wait().expect(3).says("0 of 2 runs");
    assert!(!out.exists());
    for run in 0..2 {
        nothing_left(&RunName::new(&format!("sweep-{pid}-{run}")).unwrap());
    }
}

/// Mean and 95th percentile, linear between ranks.
fn mean_and_p95(values: &[f64]) -> [f64; 2] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = 0.95 * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    [mean, below + (rank - rank.floor()) * (above - below)]
}

#[test]
fn the_chapter_s_table_is_one_command() {
    let place = folder();
    let out = place.at("a.csv");
    // From where the table's bits were pinned, see `shared/sim/tests/odometry.rs`.
    let start = "start={ x_m = 6.0, y_m = 4.5, theta_rad = 0.0 }";
    let said = sweep(&["patrol", "--seeds", "0..500", "--set", start], &out, 0).stdout;
    let rows = Table::read(&out);
    let [mean_m, p95_m] = mean_and_p95(&rows.numbers("final_position_error_m"));
    let heading_deg: Vec<f64> =
        rows.numbers("final_heading_error_rad").iter().map(|rad| rad.to_degrees()).collect();
    let [heading_deg, _] = mean_and_p95(&heading_deg);
    assert!((mean_m - 0.472).abs() < 0.016, "{mean_m}");
    assert!((p95_m - 1.152).abs() < 0.048, "{p95_m}");
    assert!((heading_deg - 7.25).abs() < 0.25, "{heading_deg}");
    let pinned = [0x3fdd_455e_2326_5b0a, 0x3ff2_ae91_d122_e07d, 0x401c_cbc0_c4b6_a851];
    assert_eq!([mean_m, p95_m, heading_deg].map(f64::to_bits), pinned);
    assert!(rows.column("blocked_ticks").iter().all(|b| *b == "0"));
    // What is printed are these.
    for words in [format!("{mean_m:.3}"), format!("{p95_m:.3}"), format!("{heading_deg:.2}")] {
        assert!(said.contains(&words), "{words} is not in {said}");
    }
    for picture in ["a-fan.svg", "a-fan.png", "a-growth.svg", "a-growth.png"] {
        assert!(fs::metadata(place.at(picture)).unwrap().len() > 1000, "{picture}");
        assert!(said.contains(picture), "{said}");
    }
}

#[test]
fn two_values_are_compared_on_the_same_seeds() {
    let place = folder();
    let out = place.at("a.csv");
    let args = ["patrol", "--seeds", "0..30", "--ab", "robot.slip_std=0.02,0.03", "--json"];
    let found = sweep(&args, &out, 0).json();
    let rows = Table::read(&out).numbers("final_position_error_m");
    let paired = &found["report"]["paired"][0];
    assert_eq!(paired["cells"], json!([0, 1]), "{paired}");
    let differences: Vec<f64> = (0..30).map(|i| rows[30 + i] - rows[i]).collect();
    let [mean_m, _] = mean_and_p95(&differences);
    assert!((number(paired, "difference") - mean_m).abs() < 1e-12, "{paired}");
}
