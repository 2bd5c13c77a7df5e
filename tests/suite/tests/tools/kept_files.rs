//! Files that a command reads, which it does not write over, whatever is forced.

use rusty_tests::*;

#[test]
fn a_sweep_writes_over_nothing_that_it_reads() {
    let place = folder();
    let floor = "<svg xmlns='http://www.w3.org/2000/svg' width='800' height='600' \
                 data-metres-per-unit='0.01'><path d='M0 0 H800 V600 H0 Z'/></svg>";
    let start = "ticks = 20\nstart = { x_m = 4.0, y_m = 3.0, theta_rad = 0.0 }\n";
    let commands = "script = { kind = \"commands\", file = \"c.csv\" }\n";
    fs::write(place.at("c-fan.svg"), floor).unwrap();
    fs::write(place.at("c.csv"), "0.1 0.1 5\n").unwrap();
    let world = place.write("w.toml", format!("{start}world_file = \"c-fan.svg\"\n"));
    let driven = place.write("d.toml", format!("{start}{commands}"));
    let part = place.write("c.csv.part", start);
    for (scenario, file) in [(&world, "c-fan.svg"), (&driven, "c.csv"), (&part, "c.csv.part")] {
        let before = fs::read(place.at(file)).unwrap();
        let args = [scenario, "--seeds", "0..2", "--force"];
        let table = place.at("c.csv");
        let args = [&["sweep"], &args[..], &["--out", arg(&table)]].concat();
        sim_server(&args).expect(2).says("read or written");
        assert!(fs::read(place.at(file)).unwrap() == before, "{file}");
    }
    let (manifest, table) = (place.at("m.json"), place.at("c.csv"));
    fs::remove_file(&table).unwrap();
    let plan = ["sweep", "plan", &world, "--seeds", "0..2", "--shards", "1", "-o", arg(&manifest)];
    sim_server(&plan).expect(0);
    let merge = ["sweep", "merge", arg(&manifest), "--out", arg(&table), "--force"];
    sim_server(&merge).expect(2).says("read or written");
    let drawing = place.at("c-fan.svg");
    let umbmark = ["umbmark", &world, "--force", "--svg", arg(&drawing)];
    sim_server(&umbmark).expect(2).says("read or written");
    assert_eq!(fs::read_to_string(&drawing).unwrap(), floor);
}

#[test]
fn a_program_on_a_log_writes_over_no_file_of_its_options() {
    let place = folder();
    launch("kept", &place.at("run"), &["apartment", "--ticks", "60"]);
    let log = place.at("run").join("run.log");
    let [sealed, key] = ["blind.log", "key.csv"].map(|file| place.at(file));
    sim_server(&["seal", arg(&log), "-o", arg(&sealed), "--key-file", arg(&key)]).expect(0);
    let before = fs::read(&key).unwrap();
    let blind = ["--log", arg(&sealed), "--key-file", arg(&key), "--force"];
    let to_key = [&blind[..], &["--out", arg(&key)]].concat();
    execute("dead-reckoning", &to_key).expect(2).says("key file");
    let stem = place.at("key");
    let saved = [&blind[..], &["--poses", "truth", "--save", arg(&stem)]].concat();
    execute("gridmap", &saved).expect(0);
    assert!(fs::read(&key).unwrap() == before);
    let map = place.at("key.yaml");
    let page = fs::read(&map).unwrap();
    let over = ["--log", arg(&log), "--map", arg(&map), "--out", arg(&map), "--force"];
    execute("mcl", &over).expect(2).says("another option");
    assert!(fs::read(&map).unwrap() == page);
}
