//! A run that goes on while a test looks, and what is left of it afterwards.

#![allow(dead_code, missing_docs)] // not every test needs all of it

use std::fs;
use std::path::PathBuf;

use rusty_contract::RunName;
use rusty_contract::log::{Ending, LogReader, Read, TickRecord};
use rusty_tests::*;
use serde_json::Value;

pub const ALL: [&str; 3] = ["dead-reckoning", "score", "logger"];
/// A run that would last for half an hour, for faults that end it.
pub const LONG: [&str; 4] = ["--pace", "1", "--ticks", "100000"];
/// A run of eight seconds, for faults that it survives.
pub const SHORT: [&str; 4] = ["--pace", "1", "--ticks", "400"];
pub const GO_ON: [&str; 2] = ["--set", "on_loss=continue"];

/// A run that goes on while the test looks.
pub struct Live {
    pub run: RunName,
    pub out: tempfile::TempDir,
    pub server: Process,
}

impl Live {
    pub fn start(verb: &str, tag: &str, args: &[&[&str]]) -> Self {
        let (run, out) = (fresh_run(tag), folder());
        let mut all = vec![verb, "--json", "--run", run.as_str()];
        all.extend(["--out", out.path().to_str().unwrap()]);
        all.extend(args.iter().copied().flatten());
        let server = Process::start("sim-server", &all);
        Self { run, out, server }
    }

    /// A launch that has come to where its log grows: in the middle.
    pub fn under_way(tag: &str, args: &[&[&str]]) -> Self {
        let live = Self::start("launch", tag, args);
        live.until_the_log_has_ticks();
        live
    }

    /// Waits until some ticks have reached the disk.
    #[track_caller]
    pub fn until_the_log_has_ticks(&self) {
        until("the log has ticks", || {
            let Ok(mut reader) = LogReader::open(&self.log()) else { return false };
            matches!(reader.read(), Ok(Read::Tick(_)))
        });
    }

    pub fn log(&self) -> PathBuf {
        self.out.path().join("run.log")
    }

    pub fn pid_of(&self, name: &str) -> u32 {
        let mut pid = None;
        until(name, || {
            pid = participants(&self.run).into_iter().find(|(_, n)| n == name).map(|(p, _)| p);
            pid.is_some()
        });
        pid.unwrap()
    }

    /// Starts a participant by hand.
    pub fn join(&self, program: &str, args: &[&str]) -> Process {
        let mut all = vec!["--run", self.run.as_str()];
        all.extend(args);
        Process::start(program, &all)
    }

    /// Waits for the end; checks the code and that nothing is left.
    #[track_caller]
    pub fn ends_with(self, code: i32) -> After {
        let ended = self.server.wait().expect(code);
        assert_eq!(participants(&self.run), [], "processes of the run live on");
        nothing_left(&self.run);
        After { report: ended.json(), stderr: ended.stderr, out: self.out }
    }
}

/// A run that is over.
pub struct After {
    pub report: Value,
    pub stderr: String,
    pub out: tempfile::TempDir,
}

impl After {
    /// The one loss of the run has this name and kind, and says these words,
    /// in the report and to the person.
    #[track_caller]
    pub fn lost(&self, name: &str, kind: &str, words: &str) {
        self.lost_as(name, kind, &kind.replace('-', " "), words);
    }

    /// The same, where people are told another word than the report has.
    #[track_caller]
    pub fn lost_as(&self, name: &str, kind: &str, word: &str, words: &str) {
        let losses = self.report["losses"].as_array().unwrap();
        assert_eq!(losses.len(), 1, "{}", self.report);
        assert_eq!((text(&losses[0], "name"), text(&losses[0], "kind")), (name, kind));
        assert!(text(&losses[0], "detail").contains(words), "{}", losses[0]);
        let said = format!("lost: {name} {word}");
        assert!(self.stderr.contains(&said), "{said:?} is not in {}", self.stderr);
    }

    /// The log's ticks, and whether it is complete.
    pub fn records(&self) -> (Vec<TickRecord>, bool) {
        let mut reader = LogReader::open(&self.out.path().join("run.log")).unwrap();
        let mut records = Vec::new();
        loop {
            match reader.read().unwrap() {
                Read::Tick(entry) => {
                    assert!(entry.intact);
                    records.push(entry.record);
                }
                Read::End(ending) => return (records, matches!(ending, Ending::Complete(_))),
            }
        }
    }

    /// `verify` of the log: its exit code is this, and no bit differs.
    #[track_caller]
    pub fn verifies(&self, code: i32) -> Value {
        let log = self.out.path().join("run.log");
        let verdict = sim_server(&["verify", "--json", log.to_str().unwrap()]).expect(code).json();
        assert_eq!(verdict["bit_exact"], true, "{verdict}");
        verdict
    }

    /// All ticks happened, with the frames of a run that nobody disturbed, and
    /// the estimator's replies are missing from some tick on.
    #[track_caller]
    pub fn went_on_without_the_estimator(&self) {
        let ticks = self.report["ticks"].as_u64().unwrap();
        assert_eq!(self.report["ended"], "done");
        assert_eq!(self.report["ticks_planned"], ticks);
        let out = folder();
        let calm = launch("calm", out.path(), &["--ticks", &ticks.to_string()]);
        assert_eq!(self.report["world_digest"], calm["world_digest"]);
        let (records, complete) = self.records();
        assert!(complete && records.len() as u64 == ticks);
        let answered = records.iter().take_while(|r| r.replies[0].estimate().is_some()).count();
        assert!(answered > 0 && answered < records.len());
        let lost = &records[answered..];
        assert!(lost.iter().all(|r| r.replies == [rusty_contract::Reply::Missing]));
        assert_eq!(self.verifies(0)["digest"], self.report["digest"]);
    }
}

/// The processes of a run but its server: those that are told `--run NAME`
/// and a name of their own, or are called by their program.
pub fn participants(run: &RunName) -> Vec<(u32, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir("/proc").unwrap().flatten() {
        let Some(pid) = entry.file_name().to_str().and_then(|n| n.parse().ok()) else { continue };
        let line = fs::read(entry.path().join("cmdline")).unwrap_or_default();
        let words: Vec<&str> =
            line.split(|b| *b == 0).filter_map(|w| std::str::from_utf8(w).ok()).collect();
        let server = words.first().is_some_and(|w| w.ends_with("sim-server"));
        if words.contains(&run.as_str()) && !server {
            let name = words.iter().skip_while(|w| **w != "--name").nth(1);
            found.push((pid, name.unwrap_or(&words[0]).to_string()));
        }
    }
    found
}

/// An estimator that misbehaves, as `--add` and in place of the usual one.
pub fn probe(mode: &str) -> [String; 4] {
    let probe = binary("probe-client");
    let add = format!("dead-reckoning={} --mode {mode}", probe.display());
    ["--without", "dead-reckoning", "--add", &add].map(str::to_owned)
}

pub fn with_probe(verb: &str, tag: &str, mode: &str, args: &[&[&str]]) -> Live {
    let probe = probe(mode);
    let probe = probe.each_ref().map(String::as_str);
    let mut all: Vec<&[&str]> = vec![&probe];
    all.extend(args);
    Live::start(verb, tag, &all)
}
