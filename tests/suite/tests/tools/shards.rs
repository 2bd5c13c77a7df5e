//! Sweeps in shards: the merged table has the bytes of the sweep in one process, whatever
//! is killed; and a part or a machine that is not the right one is refused.

use rusty_study::sweep::Manifest;
use rusty_tests::*;

const GRID: [&str; 7] =
    ["patrol", "--seeds", "0..10", "--ticks", "80", "--ab", "robot.slip_std=0.01,0.05"];

/// A sweep in shards, in a folder.
struct Sharded {
    place: Folder,
    manifest: PathBuf,
    parts: PathBuf,
}

impl Sharded {
    /// Plans the sweep with these options.
    #[track_caller]
    fn plan(args: &[&str]) -> Self {
        let place = folder();
        let (manifest, parts) = (place.at("m.toml"), place.at("parts"));
        sim_server(&[&["sweep", "plan", "-o", arg(&manifest)], args].concat()).expect(0);
        Self { place, manifest, parts }
    }

    /// The words of `sweep run` for this shard.
    fn words<'a>(&'a self, index: &'a str) -> [&'a str; 7] {
        ["sweep", "run", arg(&self.manifest), "--shard", index, "--out", arg(&self.parts)]
    }

    #[track_caller]
    fn run(&self, index: u64, code: i32) -> Ended {
        let index = index.to_string();
        sim_server(&[&self.words(&index)[..], &["--json"]].concat()).expect(code)
    }

    #[track_caller]
    fn merge(&self, out: &str, code: i32) -> Ended {
        let words = ["sweep", "merge", arg(&self.manifest), arg(&self.parts), "--json"];
        sim_server(&[&words[..], &["--out", arg(&self.place.at(out))]].concat()).expect(code)
    }

    fn part(&self, index: u64) -> PathBuf {
        Manifest::read(&self.manifest).unwrap().part(&self.parts, index).unwrap().path
    }

    /// The names in the folder of the parts, hidden ones included.
    fn files(&self) -> Vec<String> {
        let files = fs::read_dir(&self.parts).into_iter().flatten().flatten();
        files.map(|file| file.file_name().into_string().unwrap()).collect()
    }

    /// Fails unless a merge names these shards, with these words, and writes nothing.
    /// Returns the command that makes a shard, from the message.
    #[track_caller]
    fn incomplete(&self, missing: &[u64], words: &str) -> Vec<String> {
        let ended = self.merge("bad.csv", 1);
        ended.says(words);
        assert_eq!(ended.json()["missing"], json!(missing));
        assert!(!self.place.at("bad.csv").exists());
        let command = ended.stderr.split('`').nth(1).unwrap();
        command.split(' ').skip(1).map(str::to_owned).collect()
    }
}

#[test]
fn the_merged_table_and_drawings_have_the_bytes_of_one_sweep() {
    for name in ["t.csv", "t.parquet"] {
        let sharded = Sharded::plan(&[&GRID[..], &["--shards", "3"]].concat());
        let alone = sharded.place.at("alone");
        fs::create_dir(&alone).unwrap();
        let one = sim_server(
            &[&["sweep"], &GRID[..], &["--json", "--out", arg(&alone.join(name))]].concat(),
        );
        // In any order, and with any number of jobs.
        for index in [2, 0] {
            assert_eq!(sharded.run(index, 0).json()["was_complete"], false);
        }
        let jobs = [&sharded.words("1")[..], &["--jobs", "2"]].concat();
        sim_server(&jobs).expect(0).prints(arg(&sharded.part(1)));
        assert_eq!(sharded.files().len(), 3, "a shard drew or left something");
        let merged = sharded.merge(name, 0).json();
        let mut files = fs::read_dir(&alone).unwrap().flatten().collect::<Vec<_>>();
        assert!(files.len() >= 7, "{files:?}");
        files.retain(|file| {
            fs::read(file.path()).unwrap() != fs::read(sharded.place.at(file.file_name())).unwrap()
        });
        assert!(files.is_empty(), "{files:?}");
        assert_eq!(merged["report"], one.expect(0).json()["report"]);
        assert_eq!(merged["missing"], json!([]));
        // Neither replaces anything unasked.
        let bytes = fs::read(sharded.part(1)).unwrap();
        assert_eq!(sharded.run(1, 0).json()["was_complete"], true);
        assert!(fs::read(sharded.part(1)).unwrap() == bytes);
        sharded.merge(name, 2).says("--force");
    }
}

#[test]
fn with_clients_the_merged_table_is_that_of_one_sweep_but_for_compute_times() {
    let args = ["patrol", "--seeds", "0..3", "--ticks", "60", "--clients"];
    let args = [&args[..], &["--add", "second=dead-reckoning"]].concat();
    let sharded = Sharded::plan(&[&args[..], &["--shards", "2"]].concat());
    let alone = sharded.place.at("alone.csv");
    sim_server(&[&["sweep"], &args[..], &["--out", arg(&alone)]].concat()).expect(0);
    (0..2).for_each(|index| drop(sharded.run(index, 0)));
    sharded.merge("t.csv", 0);
    let tables = [&alone, &sharded.place.at("t.csv")].map(|path| Table::read(path));
    let [alone, merged] = tables.each_ref().map(|table| {
        let names = table.names.iter().filter(|name| !name.starts_with("compute_"));
        names.map(|name| (name, table.column(name))).collect::<Vec<_>>()
    });
    assert_eq!(alone, merged);
    assert_eq!((tables[1].rows.len(), tables[1].column("seed")[5]), (6, "2"));
}

#[test]
fn a_shard_that_is_killed_leaves_no_part_and_the_next_one_makes_it() {
    for (signal, code) in [(Signal::KILL, None), (Signal::INT, Some(3))] {
        let args = ["patrol", "--seeds", "0..40", "--ticks", "20000", "--set", "scan_every=0"];
        let sharded = Sharded::plan(&[&args[..], &["--shards", "2"]].concat());
        let process = Process::start("sim-server", &sharded.words("1"));
        until("runs are under way", || sharded.parts.exists());
        process.signal(signal);
        assert_eq!(process.wait().code, code);
        assert_eq!(sharded.files(), [""; 0]);
        let again = sharded.run(1, 0).json();
        assert_eq!((&again["was_complete"], &again["runs"]), (&json!(false), &json!(20)));
        assert_eq!(sharded.files().len(), 1);
    }
}

#[test]
fn a_part_that_is_missing_cut_or_doubled_is_named_with_the_command_that_makes_it() {
    let sharded = Sharded::plan(&[&GRID[..], &["--shards", "6"]].concat());
    sharded.incomplete(&[0, 1, 2, 3, 4, 5], "for I in 0-5");
    (0..6).for_each(|index| drop(sharded.run(index, 0)));
    sharded.merge("good.csv", 0);
    let good = fs::read(sharded.place.at("good.csv")).unwrap();
    type Damage<'a> = &'a dyn Fn(&Path);
    let damages: [(Damage<'_>, &str); 4] = [
        (&|part| fs::remove_file(part).unwrap(), "is missing"),
        (&|part| drop(fs::copy(sharded.part(3), part)), "\"3/6\" and \"2/6\""),
        (
            &|part| {
                let length = fs::metadata(part).unwrap().len();
                fs::File::options().write(true).open(part).unwrap().set_len(length - 9).unwrap();
            },
            "is damaged after 3 of 4 runs",
        ),
        (
            &|part| {
                let bytes = fs::read(part).unwrap();
                let records = bytes.iter().position(|b| *b == b'\n').unwrap() + 1;
                fs::write(part, [&bytes[..], &bytes[records..]].concat()).unwrap();
            },
            "is damaged after 4 of 4 runs",
        ),
    ];
    for (table, (damage, words)) in ["t.csv", "u.csv", "v.csv", "w.csv"].iter().zip(damages) {
        damage(&sharded.part(2));
        let command = sharded.incomplete(&[2], words);
        let command = command.iter().map(|word| if word == "I" { "2" } else { word });
        sim_server(&command.collect::<Vec<_>>()).expect(0);
        sharded.merge(table, 0);
        assert!(fs::read(sharded.place.at(table)).unwrap() == good, "{words}");
    }
}

#[test]
fn a_machine_with_other_bits_or_settings_makes_no_part() {
    let place = folder();
    let scenario = place.at("mine.toml");
    let write = |slip: f64| {
        let text = format!("ticks = 20\nworld = \"open\"\nscan_every = 0\nrobot.slip_std = {slip}");
        fs::write(&scenario, text).unwrap();
    };
    write(0.02);
    let sharded = Sharded::plan(&[arg(&scenario), "--seeds", "0..4", "--shards", "2"]);
    let text = fs::read_to_string(&sharded.manifest).unwrap();
    sharded.run(0, 0);

    // Another scenario than the one that was planned.
    write(0.03);
    sharded.run(1, 2).says("robot.slip_std: 0.02 and 0.03").says("sweep plan");
    sharded.merge("t.csv", 2).says("robot.slip_std: 0.02 and 0.03");
    write(0.02);

    // A manifest that was changed by hand.
    fs::write(&sharded.manifest, text.replace("0..4", "0..5")).unwrap();
    sharded.run(1, 2).says("was changed").says("sweep plan");
    sharded.merge("t.csv", 2).says("was changed");

    // Golden runs with other digests, as a machine with other bits has them.
    fs::write(&sharded.manifest, &text).unwrap();
    let mut other = Manifest::read(&sharded.manifest).unwrap();
    let name = other.goldens.keys().nth(3).unwrap().clone();
    let digest = other.goldens.insert(name.clone(), "0".repeat(32)).unwrap();
    other.sealed().write(&sharded.manifest).unwrap();
    sharded.run(1, 4).says(&name).says(&digest).says("sim-server doctor");
    // The part of the other manifest is not used.
    sharded.incomplete(&[0, 1], "is missing");
    assert_eq!(sharded.files().len(), 1);
}

#[test]
fn a_plan_is_the_same_again_or_measures_the_runs() {
    let [a, b] = [0, 1].map(|_| Sharded::plan(&[&GRID[..], &["--shards", "3"]].concat()));
    assert_eq!(fs::read(a.manifest).unwrap(), fs::read(&b.manifest).unwrap());
    let again = ["sweep", "plan", "patrol", "--seeds", "0..3", "-o", arg(&b.manifest)];
    sim_server(&again).expect(2).says("--force");
    let planned = sim_server(&[&again[..], &["--force", "--json"]].concat()).expect(0).json();
    assert!(number(&planned, "run_s") > 0.0);
    assert_eq!((&planned["runs"], &planned["shards"]), (&json!(3), &json!(1)));
    let parts = b.manifest.with_extension("parts");
    let own = ["sweep", "plan", "patrol", "--seeds", "0..3", "--shards", "1", "-o", arg(&parts)];
    sim_server(&own).expect(2).says("folder of its parts");
    let few = [&again[..], &["--force", "--shards", "4"]].concat();
    sim_server(&few).expect(2).says("--shards").says("1 to 3");
    let none = ["sweep", "run", arg(&b.manifest), "--shard", "1"];
    sim_server(&none).expect(2).says("--shard").says("0 to 0");
    // Options of the whole sweep do not go with a step, and seeds are needed without one.
    sim_server(&["sweep", "--jobs", "2", "merge", arg(&b.manifest)]).expect(2);
    sim_server(&["sweep", "patrol"]).expect(2).says("--seeds");
}
