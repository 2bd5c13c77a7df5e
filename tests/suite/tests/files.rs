//! Files that are damaged, too large, or not files.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use rusty_tests::*;

#[test]
fn a_damaged_table_is_refused_without_a_panic() {
    let place = folder();
    let path = place.path().join("t.parquet");
    let table = path.to_str().unwrap();
    let sweep = ["sweep", "patrol", "--ticks", "20", "--seeds", "0..3", "--quiet", "--out", table];
    sim_server(&sweep).expect(0);
    let file = fs::read(&path).unwrap();
    let end = file.len() - 8;
    let footer = end - u32::from_le_bytes(file[end..end + 4].try_into().unwrap()) as usize;
    let mut refused = 0;
    // Here the footer describes the columns' places.
    for at in (footer + 400..footer + 520).step_by(2) {
        for mask in [0x01, 0x80] {
            let mut changed = file.clone();
            changed[at] ^= mask;
            fs::write(&path, changed).unwrap();
            let compared = sim_server(&["compare", table]);
            assert!(!compared.stderr.contains("panicked"), "byte {at}, {mask:#x}: {compared:#?}");
            assert!(matches!(compared.code, Some(1 | 2)), "byte {at}, {mask:#x}: {compared:#?}");
            assert!(compared.stderr.contains(table), "byte {at}, {mask:#x}: {compared:#?}");
            refused += usize::from(compared.stderr.contains("damaged"));
        }
    }
    assert!(refused > 0, "no change made the reader panic: the test changes other bytes");
}

/// Runs a program with this stdout: exit code and stderr.
fn run_to(stdout: impl Into<Stdio>, program: &str, args: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(binary(program));
    let ended = command.args(args).stdin(Stdio::null()).stdout(stdout).output().unwrap();
    (ended.status.code(), String::from_utf8_lossy(&ended.stderr).into_owned())
}

#[test]
fn results_that_cannot_be_written_are_an_error() {
    let place = folder();
    let log = place.path().join("run.log");
    launch("written", place.path(), &["--ticks", "20"]);
    let log = log.to_str().unwrap();
    let empty = place.path().to_str().unwrap();
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
    let scenario = place.path().join("s.toml");
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
        let (run, out) = (fresh_run("loud"), place.path().join(then.split_at(4).0));
        let args = ["launch", scenario.to_str().unwrap(), "--run", run.as_str(), "--out"];
        let ended = sim_server(&[&args[..], &[out.to_str().unwrap()]].concat()).expect(code);
        (ended, out.join("run.log"))
    };
    let (failed, _) = launched("exit 1", 1);
    let (done, log) = launched("exec \\\"$0\\\" \\\"$@\\\"", 0);
    let info = sim_server(&["info", log.to_str().unwrap()]).expect(0);
    let damaged = place.path().join("\u{1b}[2J.log");
    fs::write(&damaged, "no log").unwrap();
    let client = Process::start("score", &["--log", damaged.to_str().unwrap()]).wait().expect(1);
    for shown in [&failed, &done, &info, &client].map(|e| format!("{}{}", e.stdout, e.stderr)) {
        let hidden = |c: char| c != '\n' && (c.is_control() || c == '\u{202e}');
        assert!(!shown.contains(hidden), "{shown:?}");
    }
    assert!(failed.stderr.contains("\\u001b[31mred"), "{failed:#?}");
    assert!(info.stdout.contains("\\u001b[2K\\u000d\\u202e\\nroster"), "{info:#?}");
    assert_eq!(info.stdout.matches("\nroster").count(), 2, "{info:#?}");
}

/// Makes a named pipe.
fn pipe_at(path: &Path) {
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mkfifoat(rustix::fs::CWD, path, mode).unwrap();
}

#[test]
fn pipes_and_devices_are_refused_as_input() {
    let place = folder();
    launch("input", place.path(), &["patrol", "--ticks", "5"]);
    let log = place.path().join("run.log");
    let [blind, key] = ["blind.log", "key"].map(|n| place.path().join(n));
    let [log, blind, key] = [&log, &blind, &key].map(|p| p.to_str().unwrap());
    sim_server(&["seal", log, "--output", blind, "--key-file", key]).expect(0);
    let pipes = ["p.toml", "p.csv", "p.parquet"].map(|name| {
        let path = place.path().join(name);
        pipe_at(&path);
        path.to_str().unwrap().to_owned()
    });
    let [pipe, csv, parquet] = pipes.each_ref().map(String::as_str);
    let world = format!("world_file={pipe}");
    let unmade = place.path().join("unmade.log").to_str().unwrap().to_owned();
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
        let ended = Process::start(program, args).wait();
        assert!(matches!(ended.code, Some(1 | 2)), "{args:?}: {ended:#?}");
        assert!(ended.stderr.contains(named), "{args:?}: {ended:#?}");
    }
}

#[test]
fn a_pipe_in_the_place_of_the_scores_does_not_hold_the_server() {
    let place = folder();
    let [scenario, out] = ["s.toml", "out"].map(|name| place.path().join(name));
    let (score, scores) = (binary("score"), out.join("score.json"));
    let text = format!(
        "ticks = 5\nworld = \"open\"\nscript = {{ kind = \"figure-eight\" }}\n\
         [[participant]]\nname = \"score\"\nrole = \"scorer\"\ncommand = [\"/bin/sh\", \"-c\", \
         '\"$0\" \"$@\"; rm {scores:?}; mkfifo {scores:?}', {score:?}]\n\
         [[participant]]\nname = \"wheels\"\ncommand = [\"dead-reckoning\"]\n"
    );
    fs::write(&scenario, text).unwrap();
    let (run, out) = (fresh_run("pipe"), out.to_str().unwrap());
    let args = ["launch", scenario.to_str().unwrap(), "--json", "--run", run.as_str()];
    let ended = sim_server(&[&args[..], &["--out", out]].concat());
    assert!(fs::metadata(&scores).is_ok_and(|m| !m.is_file()), "{ended:#?}");
    assert_eq!(ended.json()["scores_file"], serde_json::Value::Null, "{ended:#?}");
}

#[test]
fn pipes_in_the_place_of_outputs_are_refused() {
    let place = folder();
    launch("outputs", place.path(), &["--ticks", "20"]);
    let log = place.path().join("run.log");
    let names = ["score.json", "report.html", "report.svg", "report.png"];
    let cases = names.map(|name| ("score", name)).into_iter().chain([("logger", "run.log")]);
    for (program, name) in cases {
        let out = folder();
        pipe_at(&out.path().join(name));
        let args = ["--log", log.to_str().unwrap(), "--out", out.path().to_str().unwrap()];
        let ended = Process::start(program, &args).wait().expect(1);
        assert!(ended.stderr.contains(name), "{program}: {ended:#?}");
        // The other files are written all the same.
        let others = names.iter().filter(|other| **other != name && program == "score");
        let written =
            |other: &&str| fs::metadata(out.path().join(other)).is_ok_and(|m| m.len() > 0);
        assert!(others.into_iter().all(written), "{program}, {name}: {ended:#?}");
    }
}
