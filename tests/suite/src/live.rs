//! A run that goes on while a test looks, and what is left of it afterwards.

use std::path::PathBuf;

use rusty_contract::RunName;
use rusty_contract::log::TickRecord;
use serde_json::Value;

use crate::{
    Folder, Log, Process, about, arg, binary, folder, fresh_run, launch, list, nothing_left,
    participants, sim_server, text, until, written,
};

pub const ALL: [&str; 3] = ["dead-reckoning", "score", "logger"];
/// A run that would last for half an hour, for faults that end it.
pub const LONG: [&str; 4] = ["--pace", "1", "--ticks", "100000"];
/// A run of eight seconds, for faults that it survives.
pub const SHORT: [&str; 4] = ["--pace", "1", "--ticks", "400"];
/// Takes away all participants of the usual run.
pub const ALONE: [&str; 6] =
    ["--without", "dead-reckoning", "--without", "score", "--without", "logger"];
pub const GO_ON: [&str; 2] = ["--set", "on_loss=continue"];

/// A run that goes on while the test looks.
pub struct Live {
    pub run: RunName,
    pub out: Folder,
    pub server: Process,
}

impl Live {
    pub fn start(verb: &str, tag: &str, args: &[&[&str]]) -> Self {
        let (run, out) = (fresh_run(tag), folder());
        let mut all = vec![verb, "--json", "--run", run.as_str()];
        all.extend(["--out", arg(out.path())]);
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
        until("the log has ticks", || written(&self.log()) > 0);
    }

    pub fn log(&self) -> PathBuf {
        self.out.at("run.log")
    }

    pub fn pid_of(&self, name: &str) -> u32 {
        let mut pid = None;
        until(name, || {
            pid = participants(&self.run).into_iter().find(|(_, n)| n == name).map(|(p, _)| p);
            pid.is_some()
        });
        pid.unwrap()
    }

    /// Asks the run for something: whether it was done.
    pub fn control(&self, request: &[&str]) -> bool {
        sim_server(&[&["control", self.run.as_str()], request].concat()).code == Some(0)
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
    pub out: Folder,
}

impl After {
    /// The run ended in this way after N ticks.
    #[track_caller]
    pub fn ended(&self, how: &str, ticks: u64) {
        assert_eq!((text(&self.report, "ended"), &self.report["ticks"]), (how, &ticks.into()));
    }

    /// Fails the test unless stderr contains these words.
    #[track_caller]
    pub fn says(&self, words: &str) {
        assert!(self.stderr.contains(words), "{words:?} is not in {}", self.stderr);
    }

    pub fn log(&self) -> PathBuf {
        self.out.at("run.log")
    }

    /// The one loss of the run has this name and kind, and says these words,
    /// in the report and to the person.
    #[track_caller]
    pub fn lost(&self, name: &str, kind: &str, words: &str) {
        self.lost_as(name, kind, &kind.replace('-', " "), words);
    }

    /// The same, where people are told another word than the report has.
    #[track_caller]
    pub fn lost_as(&self, name: &str, kind: &str, word: &str, words: &str) {
        let losses = list(&self.report, "losses");
        assert_eq!(losses.len(), 1, "{}", self.report);
        assert_eq!((text(&losses[0], "name"), text(&losses[0], "kind")), (name, kind));
        assert!(text(&losses[0], "detail").contains(words), "{}", losses[0]);
        self.says(&format!("lost: {name} {word}"));
    }

    /// The log's ticks, and whether it is complete.
    pub fn records(&self) -> (Vec<TickRecord>, bool) {
        let log = Log::read(&self.log());
        let complete = log.is_complete();
        (log.intact(), complete)
    }

    /// `verify` of the log: its exit code is this, and no bit differs.
    #[track_caller]
    pub fn verifies(&self, code: i32) -> Value {
        let verdict = about("verify", &self.log(), &["--json"]).expect(code).json();
        assert_eq!(verdict["bit_exact"], true, "{verdict}");
        verdict
    }

    /// All ticks happened, with the frames of an undisturbed run, and
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

/// A value of `--add`: an estimator of this name that misbehaves.
pub fn probe(name: &str, mode: &str) -> String {
    format!("{name}={} --mode {mode}", binary("probe-client").display())
}

/// A launch with one that misbehaves in place of the usual estimator.
pub fn with_probe(tag: &str, mode: &str, args: &[&[&str]]) -> Live {
    let add = probe("dead-reckoning", mode);
    let probe: &[&str] = &["--without", "dead-reckoning", "--add", &add];
    Live::start("launch", tag, &[&[probe], args].concat())
}
