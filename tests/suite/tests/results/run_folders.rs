//! A folder holds one run: no verb mixes two runs or writes over what is there
//! unasked, and `runs` lists and removes what runs left.

use rusty_tests::*;

const TICKS: [&str; 2] = ["--ticks", "20"];

/// Every file below a folder with its bytes.
fn snapshot(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => files.extend(snapshot(&path)),
            false => files.push((path.clone(), fs::read(&path).unwrap())),
        }
    }
    files.sort();
    files
}

/// `runs … --json`.
fn runs(args: &[&str]) -> Value {
    sim_server(&[&["runs"], args, &["--json"]].concat()).expect(0).json()
}

#[test]
fn a_folder_that_holds_a_run_is_refused_by_every_verb_and_replaced_with_force() {
    let place = folder();
    let (lab, other) = (place.at("lab"), place.at("other"));
    launch("lab", &lab, &[&TICKS[..], &["--seed", "42"]].concat());
    launch("other", &other, &TICKS);
    let (before, log) = (snapshot(&lab), other.join("run.log"));
    let new = ["--seed", "3", "--without", "logger"];
    for verb in [
        &["launch", "--ticks", "20", "--seed", "3"][..],
        &["serve"],
        &["replay", arg(&log)],
        &["fork", arg(&log), "--at", "9"],
    ] {
        let ended = run_to("second", &lab, verb).expect(2);
        for words in [arg(&lab), "--force", "--run", "sim-server runs"] {
            ended.says(words);
        }
        assert!(ended.stdout.is_empty() && snapshot(&lab) == before, "{verb:?}");
    }
    // Neither is it gone where the next run cannot begin.
    let mistyped = ["launch", "--ticks", "20", "--force", "--add", "x=no-such-program"];
    run_to("mistyped", &lab, &mistyped).expect(1).says("no-such-program");
    assert!(snapshot(&lab) == before);
    let report = launch("forced", &lab, &[&TICKS[..], &new].concat());
    // Nothing of the first run passes for the second's.
    assert!(!lab.join("run.log").exists());
    let file_of = |file: &str| json_file(&lab.join(file));
    assert_eq!(
        (&file_of("score.json")["seed"], &file_of("run.json")["seed"]),
        (&3.into(), &3.into())
    );
    assert_eq!(file_of("run.json")["end"]["digest"], report["digest"]);
}

#[test]
fn what_somebody_else_wrote_is_not_touched_even_with_force() {
    let place = folder();
    let home = place.at("home");
    fs::create_dir(&home).unwrap();
    fs::write(home.join("thesis.tex"), "years").unwrap();
    for force in [&[][..], &["--force"]] {
        let args = [&["launch"][..], force].concat();
        run_to("home", &home, &args).expect(2).says("\"thesis.tex\"");
        assert_eq!(snapshot(&home).len(), 1);
    }
    // Not in the folder of a run either.
    let lab = place.at("lab");
    let mapper = "--add=mapper=gridmap --save {out}/map";
    launch("lab", &lab, &[&TICKS[..], &[mapper]].concat());
    fs::write(lab.join("notes.txt"), "mine").unwrap();
    let again = ["launch", "--ticks", "20", "--force", "--out", arg(&lab)];
    sim_server(&again).expect(2).says("\"notes.txt\"");
    fs::remove_file(lab.join("notes.txt")).unwrap();
    // The mapper's files are the run's.
    assert!(lab.join("map.pgm").exists());
    sim_server(&again).expect(0);
    assert!(!lab.join("map.pgm").exists());
}

#[test]
fn the_folder_of_a_log_that_is_played_is_never_replaced() {
    let place = folder();
    let lab = place.at("lab");
    launch("lab", &lab, &TICKS);
    let (before, log) = (snapshot(&lab), lab.join("run.log"));
    for verb in [&["replay"][..], &["fork", "--at", "9"]] {
        let args = [verb, &[arg(&log), "--force", "--out", arg(&lab)]].concat();
        sim_server(&args).expect(2).says("write over it");
        assert!(snapshot(&lab) == before);
    }
}

#[test]
fn a_run_that_does_not_start_leaves_its_folder_as_it_was() {
    let (empty, place) = (folder(), folder());
    let new = place.at("new");
    for out in [empty.path(), &new] {
        let args = ["launch", "--out", arg(out), "--add", "x=no-such-program"];
        sim_server(&args).expect(1);
    }
    assert!(snapshot(empty.path()).is_empty() && !new.exists());
    sim_server(&["launch", "--ticks", "20", "--out", arg(&new)]).expect(0);
}

#[test]
fn a_living_run_keeps_its_folder_and_a_killed_one_gives_it_back() {
    let live = Live::under_way("live", &[&LONG]);
    let out = live.out.path().to_owned();
    let (dir, name) = (out.parent().unwrap(), arg(out.file_name().unwrap()));
    for args in [
        &["launch", "--out", arg(&out)][..],
        &["launch", "--out", arg(&out), "--force"],
        &["runs", "remove", "--in", arg(dir), name],
    ] {
        let ended = sim_server(args).expect(2);
        for words in ["in use", live.run.as_str()] {
            ended.says(words);
        }
    }
    let found = |of: Value| named(&json!({ "runs": of }), "runs", name).clone();
    assert_eq!(found(runs(&[arg(dir)]))["living"], true);
    live.server.signal(Signal::KILL);
    live.server.wait();
    until("all have ended", || participants(&live.run).is_empty());
    let dead = found(runs(&[arg(dir)]));
    assert_eq!((&dead["living"], &dead["end"]), (&false.into(), &Value::Null));
    sim_server(&["launch", "--ticks", "20", "--force", "--out", arg(&out)]).expect(0);
}

#[test]
fn runs_are_listed_and_removed_by_name_and_nothing_else_is() {
    let place = folder();
    let dir = place.at("runs");
    let at = |name: &str| dir.join(name);
    let a = launch("a", &at("a"), &[&TICKS[..], &["--seed", "7"]].concat());
    launch("b", &at("b"), &[&TICKS[..], &["--without", "logger"]].concat());
    fs::create_dir(at("mine")).unwrap();
    fs::write(at("mine").join("file"), "").unwrap();
    std::os::unix::fs::symlink(at("a"), at("link")).unwrap();
    let listed = runs(&[arg(&dir)]);
    let names: Vec<&str> = listed.as_array().unwrap().iter().map(|run| text(run, "name")).collect();
    assert_eq!(names, ["a", "b"]);
    let first = &listed[0];
    assert_eq!((&first["scenario"], &first["seed"]), (&"apartment".into(), &7.into()));
    assert_eq!((&first["end"]["digest"], &first["end"]["ticks"]), (&a["digest"], &20.into()));
    let size: usize = snapshot(&at("a")).iter().map(|(_, bytes)| bytes.len()).sum();
    assert_eq!(first["bytes"], size);
    sim_server(&["runs", arg(&dir)]).expect(0).prints(text(&a, "digest"));

    let before = snapshot(&dir);
    let outside = format!("../runs/{}", "a");
    for name in ["mine", "link", "gone", &outside, "..", "."] {
        // One that is refused keeps the others.
        sim_server(&["runs", "remove", "--in", arg(&dir), "b", name]).expect(2);
    }
    assert!(snapshot(&dir) == before);
    sim_server(&["runs", "remove", "--in", arg(&dir), "a", "b", "a"]).expect(0);
    assert!(!at("a").exists() && !at("b").exists() && at("mine/file").exists());
    assert!(runs(&[arg(&dir)]).as_array().unwrap().is_empty());
    assert!(runs(&[arg(&place.at("gone"))]).as_array().unwrap().is_empty());
}

#[test]
fn runs_are_compared_by_estimator() {
    let place = folder();
    let reports = [("a", "42"), ("b", "43"), ("c", "42")].map(|(name, seed)| {
        let more: &[&str] = if name == "c" { &["--add", "mine=dead-reckoning"] } else { &[] };
        launch(name, &place.at(name), &[&TICKS[..], &["--seed", seed], more].concat())
    });
    let dir = ["--in", arg(place.path())];
    let compared = runs(&[&["compare", "a", "b", "c"], &dir[..]].concat());
    for (run, report) in compared.as_array().unwrap().iter().zip(&reports) {
        assert_eq!(run["end"]["digest"], report["digest"]);
        assert_eq!((&run["seed"], &run["scores"]), (&report["seed"], &report["scores"]));
    }
    let table = sim_server(&[&["runs", "compare", "c", "b"], &dir[..]].concat()).expect(0);
    let rows = |estimator: &str| {
        let starts = |line: &&str| line.starts_with(estimator);
        table.stdout.lines().filter(starts).map(|l| l.split_whitespace().nth(1).unwrap()).collect()
    };
    let (both, one): (Vec<&str>, Vec<&str>) = (rows("dead-reckoning"), rows("mine"));
    assert_eq!((both, one), (vec!["c", "b"], vec!["c"]));
    // Scores of another run are not those of this one; one that is missing is named.
    fs::copy(place.at("a/score.json"), place.at("b/score.json")).unwrap();
    let compared = runs(&[&["compare", "a", "b"], &dir[..]].concat());
    assert_eq!(compared[1]["scores"], json!([]));
    let missing = [&["runs", "compare", "a", "nowhere"], &dir[..]].concat();
    sim_server(&missing).expect(2).says("nowhere").says("sim-server runs");
    sim_server(&["runs", "compare", "a"]).expect(2);
}

#[test]
fn the_marker_of_a_blind_log_s_replay_names_no_seed() {
    let place = folder();
    let at = |name: &str| place.at(name);
    launch("open", &at("open"), &[&TICKS[..], &["--seed", "918273"]].concat());
    let (log, blind, key) = (at("open/run.log"), at("blind"), at("key"));
    seal(&log, &blind, &key).expect(0);
    let played = at("played");
    sim_server(&["replay", arg(&blind), "--out", arg(&played)]).expect(0);
    let marker = fs::read_to_string(played.join("run.json")).unwrap();
    assert!(!marker.contains("918273") && marker.contains("\"seed\":null"), "{marker}");
}

#[test]
fn a_score_of_a_log_writes_nothing_unasked_and_over_nothing_unforced() {
    let place = folder();
    let lab = place.at("lab");
    launch("lab", &lab, &TICKS);
    let (before, log) = (snapshot(&lab), lab.join("run.log"));
    execute("score", &["--log", arg(&log)]).expect(0).prints("dead-reckoning");
    assert!(snapshot(&lab) == before);
    for client in ["score", "logger"] {
        let to = place.at(client);
        let again = |more: &[&str]| {
            let args = ["--log", arg(&log), "--out", arg(&to)];
            execute(client, &[&args[..], more].concat())
        };
        again(&[]).expect(0);
        let written = snapshot(&to);
        again(&[]).expect(2).says("--force");
        assert!(snapshot(&to) == written);
        again(&["--force"]).expect(0);
    }
    // Nor does a filter: its answers and its map.
    let [csv, map] = ["answers.csv", "map"].map(|name| place.at(name));
    for (program, option, path, file) in
        [("dead-reckoning", "--out", &csv, "answers.csv"), ("gridmap", "--save", &map, "map.pgm")]
    {
        let file = place.at(file);
        fs::write(&file, "mine").unwrap();
        let args = ["--log", arg(&log), option, arg(path)];
        execute(program, &args).expect(2);
        assert_eq!(fs::read(&file).unwrap(), b"mine");
        execute(program, &[&args[..], &["--force"]].concat()).expect(0);
        assert_ne!(fs::read(&file).unwrap(), b"mine");
    }
}

#[test]
fn an_import_and_a_drawing_replace_nothing_unforced() {
    let place = folder();
    let at = |name: &str| place.at(name);
    let odom = |t: f64| format!("ODOM {t} 0 0 0.1 0 0 {t} host {t}\n");
    fs::write(at("in.log"), (1..9).map(|k| odom(0.1 * f64::from(k))).collect::<String>()).unwrap();
    let (input, log, svg) = (at("in.log"), at("out.log"), at("w.svg"));
    for args in [
        &["import", "carmen", arg(&input), "-o", arg(&log)][..],
        &["worlds", "hallway", "--svg", arg(&svg)],
        &["umbmark", "--runs", "2", "--svg", arg(&svg)],
    ] {
        let file = if args[0] == "import" { &log } else { &svg };
        fs::write(file, "mine").unwrap();
        sim_server(args).expect(2).says("--force");
        assert_eq!(fs::read(file).unwrap(), b"mine");
        sim_server(&[args, &["--force"]].concat()).expect(0);
        assert_ne!(fs::read(file).unwrap(), b"mine");
    }
}

#[test]
fn a_scenario_that_is_read_is_not_written_over_even_with_force() {
    let place = folder();
    for (name, verb) in [
        ("s.toml", &["sweep", "plan", "--seeds", "0..2", "--shards", "1", "--force", "-o"][..]),
        ("s.csv", &["sweep", "--seeds", "0..2", "--force", "--out"]),
        ("s.svg", &["umbmark", "--runs", "2", "--force", "--svg"]),
    ] {
        let file = place.at(name);
        fs::write(&file, "ticks = 20\n").unwrap();
        let ended = sim_server(&[verb, &[arg(&file), arg(&file)]].concat()).expect(2);
        ended.says("read or written");
        assert_eq!(fs::read_to_string(&file).unwrap(), "ticks = 20\n");
    }
}

#[test]
fn what_a_scenario_plans_in_vain_is_named_and_happens_to_nobody() {
    let place = folder();
    let file = place.at("vain.toml");
    let planned = "[[event]]\nkind = \"put-box\"\ntick = 2\nnumber = 4\n\
                   at = { x_m = 8.0, y_m = 2.0, theta_rad = 0.0 }\nsize_m = [0.2, 0.2]\n\
                   [[event]]\nkind = \"remove-box\"\ntick = 5\nnumber = 3\n\
                   [[event]]\nkind = \"remove-box\"\ntick = 30\nnumber = 4\n\
                   [[walker]]\nwaypoints = [[1.5, 2.5], [75.0, 2.5]]\n\
                   [[patch]]\ncorners = [[-9.0, 0.0], [-8.0, 0.0], [-8.0, 9.0]]\nslip_std = 0.3\n";
    fs::write(&file, planned).unwrap();
    let ended =
        run_to("vain", &place.at("vain"), &["launch", arg(&file), "--ticks", "20"]).expect(0);
    let ended = ended.says("no box 3").says("event at tick 30");
    ended.says("walker[0].waypoints[1] = [75.0, 2.5]").says("patch[0] lies");
    for sound in ["no box 4", "waypoints[0]", "box 4 at"] {
        assert!(!ended.stderr.contains(sound), "{}", ended.stderr);
    }
}
