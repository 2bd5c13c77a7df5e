//! The clients in the binary: by links, by a verb, and in a run without links.

use std::os::unix::fs::symlink;

use rusty_tests::*;

/// The clients, as the binary lists them.
fn clients() -> Vec<String> {
    let listed = sim_server(&["programs", "--json"]).expect(0).json();
    let name = |client: &Value| text(client, "name").to_owned();
    let names: Vec<String> = listed.as_array().unwrap().iter().map(name).collect();
    assert!(names.len() > 15, "{names:?}");
    names
}

#[test]
fn each_client_is_a_link_and_a_verb_with_its_own_name() {
    for name in clients() {
        let link = fs::read_link(binaries().join(&name)).unwrap();
        assert_eq!(link, Path::new("sim-server"), "{name}");
        let version = format!("{name} {}\n", env!("CARGO_PKG_VERSION"));
        assert_eq!(execute(&name, &["--version"]).expect(0).stdout, version);
        assert_eq!(sim_server(&[&name, "--version"]).expect(0).stdout, version);
        let usage = format!("Usage: {name} ");
        execute(&name, &["--no-such-option"]).expect(2).says(&usage);
        sim_server(&[&name, "--no-such-option"]).expect(2).says(&usage);
    }
}

#[test]
fn a_run_needs_no_links_and_its_processes_have_the_names_of_clients() {
    let place = folder();
    // The binary in a folder without links, and on the path a program that is no client.
    let path = place.at("sim-server");
    fs::copy(binary("sim-server"), &path).unwrap();
    let other = place.write("dead-reckoning", "#!/bin/sh\nexit 1\n");
    fs::set_permissions(other, fs::metadata(&path).unwrap().permissions()).unwrap();
    let (run, out) = (fresh_run("alone"), folder());
    let mut server = Command::new(path);
    server.env("PATH", place.path()).args(["launch", "--json", "--run", run.as_str()]);
    server.args(["--out", arg(out.path()), "--add", "confined=ekf", "--sandbox", "if-possible"]);
    let live = Live { server: Process::spawn(server.args(LONG)), run, out };
    live.until_the_log_has_ticks();
    for (name, client) in
        [("dead-reckoning", "dead-reckoning"), ("confined", "ekf"), ("logger", "logger")]
    {
        assert_eq!(status(live.pid_of(name), "Name"), client);
    }
    live.server.signal(Signal::INT);
    assert_eq!(live.ends_with(3).report["losses"], json!([]));
}

#[test]
fn links_are_made_in_a_folder_and_other_files_are_not_replaced_unasked() {
    let place = folder();
    let make = |dir: &Path, more: &[&str]| {
        sim_server(&[&["programs", "--json", "--link", arg(dir)], more].concat())
    };
    let bin = place.at("new/bin");
    let made = make(&bin, &[]).expect(0).json();
    assert_eq!(list(&made, "links").len(), clients().len());
    let version = Process::spawn(Command::new(bin.join("mcl")).arg("--version")).wait();
    version.expect(0).prints("mcl ");
    // Links to such a binary are made again, also those to another one.
    fs::remove_file(bin.join("ekf")).unwrap();
    symlink("elsewhere/sim-server", bin.join("ekf")).unwrap();
    make(&bin, &[]).expect(0);
    assert_eq!(fs::read_link(bin.join("ekf")).unwrap(), fs::read_link(bin.join("mcl")).unwrap());

    let other = place.at("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("view"), "an editor").unwrap();
    make(&other, &[]).expect(2).says("--force").says(arg(&other.join("view")));
    assert_eq!(fs::read_dir(&other).unwrap().count(), 1);
    assert_eq!(fs::read_to_string(other.join("view")).unwrap(), "an editor");
    make(&other, &["--force"]).expect(0);
    assert!(other.join("view").is_symlink());
    assert_eq!(fs::read_dir(&other).unwrap().count(), clients().len());
}

#[test]
fn a_program_in_a_folder_with_a_space_is_added() {
    let place = folder();
    let bin = place.at("my programs");
    sim_server(&["programs", "--link", arg(&bin)]).expect(0);
    let add = format!("mine='{}'", bin.join("ekf").display());
    let report = launch("quoted", &place.at("my run"), &["--ticks", "60", "--add", &add]);
    assert!(number(score_of(&report, "mine"), "ate_rmse_m") < 0.05);
    sim_server(&["launch", "--ticks", "60", "--add", "mine='ekf"]).expect(2).says("--add");
}
