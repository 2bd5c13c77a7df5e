//! Files that are damaged, too large, or not files.

use std::process::Stdio;

use rusty_tests::*;

/// Runs a program with this stdout: exit code and stderr.
fn run_to(stdout: impl Into<Stdio>, program: &str, args: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(binary(program));
    let ended = command.args(args).stdin(Stdio::null()).stdout(stdout).output().unwrap();
    (ended.status.code(), String::from_utf8_lossy(&ended.stderr).into_owned())
}

#[test]
fn results_that_cannot_be_written_are_an_error() {
    let place = folder();
    let log = place.at("run.log");
    launch("written", place.path(), &["--ticks", "20"]);
    let log = arg(&log);
    let empty = arg(place.path());
    let commands: [(&str, &[&str]); 12] = [
        ("sim-server", &["info", "--json", log]),
        ("sim-server", &["info", log]),
        ("sim-server", &["verify", "--json", log]),
        ("sim-server", &["diff", "--json", log, log]),
        ("sim-server", &["worlds", "--json"]),
        ("sim-server", &["runs", "--json"]),
        ("score", &["--log", log]),
        ("logger", &["measure", "--json", "--ticks", "10", "--rounds", "1", empty]),
        ("fit-motion", &["--json", "--log", log]),
        ("fit-beam", &["--json", "--log", log]),
        ("dead-reckoning", &["--log", log]),
        ("ekf", &["--log", log]),
    ];
    for (program, args) in commands {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let (code, stderr) = run_to(full, program, args);
        assert_eq!(code, Some(1), "{program} {args:?}: {stderr}");
        assert!(stderr.contains("stdout"), "{program} {args:?}: {stderr}");
        // A reader that has gone is no failure.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let (code, stderr) = run_to(writer, program, args);
        assert_eq!(code, Some(0), "{program} {args:?}: {stderr}");
    }
}

#[test]
fn control_characters_of_a_log_do_not_reach_the_terminal() {
    let place = folder();
    let scenario = place.at("s.toml");
    let launched = |then: &str, code| {
        let program = binary("dead-reckoning");
        let text = format!(
            "ticks = 5\nworld = \"open\"\nscript = {{ kind = \"figure-eight\" }}\n\
             [[participant]]\nname = \"loud\"\ncommand = [\"/bin/sh\", \"-c\", \
             \"printf '\\\\033[31mred\\\\n' >&2; {then} # \\u001b[2K\\r\\u202e\\nroster\", \
             {program:?}]\n\
             [[participant]]\nname = \"logger\"\nrole = \"logger\"\ncommand = [\"logger\"]\n"
        );
        fs::write(&scenario, text).unwrap();
        let (run, out) = (fresh_run("loud"), place.at(then.split_at(4).0));
        let args = ["launch", arg(&scenario), "--run", run.as_str(), "--out"];
        let ended = sim_server(&[&args[..], &[arg(&out)]].concat()).expect(code);
        (ended, out.join("run.log"))
    };
    let (failed, _) = launched("exit 1", 1);
    let (done, log) = launched("exec \\\"$0\\\" \\\"$@\\\"", 0);
    let info = sim_server(&["info", arg(&log)]).expect(0);
    let damaged = place.at("\u{1b}[2J.log");
    fs::write(&damaged, "no log").unwrap();
    let client = execute("score", &["--log", arg(&damaged)]).expect(1);
    for shown in [&failed, &done, &info, &client].map(|e| format!("{}{}", e.stdout, e.stderr)) {
        let hidden = |c: char| c != '\n' && (c.is_control() || c == '\u{202e}');
        assert!(!shown.contains(hidden), "{shown:?}");
    }
    failed.says("\\u001b[31mred");
    info.prints("\\u001b[2K\\u000d\\u202e\\nroster");
    assert_eq!(info.stdout.matches("\nroster").count(), 2, "{info:#?}");
}

fn pipe_at(path: &Path) {
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mkfifoat(rustix::fs::CWD, path, mode).unwrap();
}

#[test]
fn pipes_and_devices_are_refused_as_input() {
    let (place, log) = logged("input", &["patrol", "--ticks", "5"]);
    let [blind, key] = ["blind.log", "key"].map(|n| place.at(n));
    seal(&log, &blind, &key).expect(0);
    let [log, blind] = [&log, &blind].map(|path| arg(path));
    let pipes = ["p.toml", "p.csv", "p.parquet"].map(|name| {
        let path = place.at(name);
        pipe_at(&path);
        arg(&path).to_owned()
    });
    let [pipe, csv, parquet] = pipes.each_ref().map(String::as_str);
    let world = format!("world_file={pipe}");
    let unmade = arg(&place.at("unmade.log")).to_owned();
    let cases: [(&str, &[&str], &str); 11] = [
        ("sim-server", &["info", pipe], pipe),
        ("sim-server", &["verify", pipe], pipe),
        ("sim-server", &["diff", log, pipe], pipe),
        ("sim-server", &["replay", pipe], pipe),
        ("sim-server", &["launch", pipe], pipe),
        ("sim-server", &["launch", "--set", &world], pipe),
        ("sim-server", &["worlds", pipe], pipe),
        ("sim-server", &["import", "carmen", pipe, "--output", &unmade], pipe),
        ("sim-server", &["compare", csv], csv),
        ("sim-server", &["compare", parquet], parquet),
        ("score", &["--log", blind, "--key-file", "/dev/zero"], "/dev/zero"),
    ];
    for (program, args, named) in cases {
        let ended = execute(program, args);
        assert!(matches!(ended.code, Some(1 | 2)), "{args:?}: {ended:#?}");
        assert!(ended.stderr.contains(named), "{args:?}: {ended:#?}");
    }
}

#[test]
fn a_pipe_in_the_place_of_the_scores_does_not_hold_the_server() {
    let place = folder();
    let [scenario, out] = ["s.toml", "out"].map(|name| place.at(name));
    let (score, scores) = (binary("score"), out.join("score.json"));
    let text = format!(
        "ticks = 5\nworld = \"open\"\nscript = {{ kind = \"figure-eight\" }}\n\
         [[participant]]\nname = \"score\"\nrole = \"scorer\"\ncommand = [\"/bin/sh\", \"-c\", \
         '\"$0\" \"$@\"; rm {scores:?}; mkfifo {scores:?}', {score:?}]\n\
         [[participant]]\nname = \"wheels\"\ncommand = [\"dead-reckoning\"]\n"
    );
    fs::write(&scenario, text).unwrap();
    let ended = rusty_tests::run_to("pipe", &out, &["launch", arg(&scenario)]);
    assert!(fs::metadata(&scores).is_ok_and(|m| !m.is_file()), "{ended:#?}");
    assert_eq!(ended.json()["scores_file"], Value::Null, "{ended:#?}");
}

#[test]
fn pipes_in_the_place_of_outputs_are_refused() {
    let (_place, log) = logged("outputs", &["--ticks", "20"]);
    let names = ["score.json", "report.html", "report.svg", "report.png"];
    let cases = names.map(|name| ("score", name)).into_iter().chain([("logger", "run.log")]);
    for (program, name) in cases {
        let out = folder();
        pipe_at(&out.at(name));
        let args = ["--log", arg(&log), "--out", arg(out.path())];
        let ended = execute(program, &args).expect(1);
        assert!(ended.stderr.contains(name), "{program}: {ended:#?}");
        // The other files are written all the same.
        let others = names.iter().filter(|other| **other != name && program == "score");
        let written = |other: &&str| fs::metadata(out.at(other)).is_ok_and(|m| m.len() > 0);
        assert!(others.into_iter().all(written), "{program}, {name}: {ended:#?}");
    }
}
