//! `Client`: the process under test.

use std::fs::File;
use std::io::Read as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::ExitStatus;

use rustix::process::{Pid, Signal, getpgid, kill_process};
use rusty_contract::{RunName, TruthKey};

use super::Kit;
use super::setting::CLIENT_SLOT;
use rusty_engine::run::{ChildProcess, Groups, RunError, Spawn};

/// The most of its words that are kept, bytes.
const WORDS: u64 = 1 << 16;

/// The process under test, in a separate process group, which is killed when
/// this goes.
pub(super) struct Client {
    child: Option<ChildProcess>,
    status: Option<ExitStatus>,
}

impl Client {
    /// A client that another process started and looks after.
    pub(super) fn elsewhere() -> Self {
        Self { child: None, status: None }
    }

    /// Starts the client as `launch` starts a participant.
    pub(super) fn start(
        kit: &Kit,
        run: &RunName,
        key: &TruthKey,
        folder: &Path,
    ) -> Result<Self, RunError> {
        let spawn = Spawn { run, wait: kit.wait, key, out_dir: folder, groups: &Groups::default() };
        let child = ChildProcess::start(CLIENT_SLOT, &kit.participant(), false, &spawn)?;
        Ok(Self { child: Some(child), status: None })
    }

    /// The process that was started; also its group. 0 if it is elsewhere.
    pub(super) fn pid(&self) -> u32 {
        self.child.as_ref().map_or(0, ChildProcess::pid)
    }

    /// Whether `pid` is the process that was started, or one that it started.
    pub(super) fn is_of_group(&self, pid: u32) -> bool {
        let group = |pid| getpgid(Some(pid)).ok();
        let member = i32::try_from(pid).ok().and_then(Pid::from_raw).and_then(group);
        let here = self.pid();
        here != 0 && (pid == here || member.is_some_and(|g| g.as_raw_pid() as u32 == here))
    }

    /// Whether it has ended. What it started itself ends with it.
    pub(super) fn has_ended(&mut self) -> bool {
        if let Some(child) = self.child.as_mut().filter(|_| self.status.is_none()) {
            self.status = child.status();
            if self.status.is_some() {
                child.end();
            }
        }
        self.status.is_some()
    }

    /// Its exit code, once it has ended by itself.
    pub(super) fn code(&self) -> Option<i32> {
        self.status.and_then(|s| s.code())
    }

    /// Whether it has ended by a signal or a panic, not by its own decision.
    pub(super) fn crashed(&self) -> bool {
        let words = self.words();
        self.status.is_some_and(|s| s.signal().is_some())
            || words.contains("panicked at")
            || words.contains("Traceback (most recent call last)")
    }

    /// How it ended: code or signal, and its last lines.
    pub(super) fn end(&self) -> String {
        let how = match self.status.map(|s| (s.code(), s.signal())) {
            Some((Some(code), _)) => format!("exit code {code}"),
            Some((_, Some(signal))) => format!("killed by signal {signal}"),
            _ => "it still runs".to_owned(),
        };
        format!("{how}; its last lines: {}", self.last_lines())
    }

    /// Its last line on stdout or stderr, or what it panicked with; `none` if it
    /// said nothing.
    pub(super) fn last_lines(&self) -> String {
        let words = self.words();
        let mut lines = words.lines().map(str::trim).filter(|l| !l.is_empty());
        // What comes after a panic is the way there.
        if let Some(panic) = lines.by_ref().find(|l| l.contains("panicked at")) {
            return format!("{panic:?}, {:?}", lines.next().unwrap_or_default());
        }
        let last = words.lines().map(str::trim).rfind(|l| !l.is_empty());
        last.map_or_else(|| "none".to_owned(), |line| format!("{line:?}"))
    }

    /// What it printed so far, stdout and stderr together.
    pub(super) fn words(&self) -> String {
        let mut text = Vec::new();
        if let Some(Ok(file)) = self.child.as_ref().map(|child| File::open(child.output())) {
            // What cannot be read was not said.
            let _ = file.take(WORDS).read_to_end(&mut text);
        }
        String::from_utf8_lossy(&text).into_owned()
    }

    /// Sends a signal to the process that joined.
    pub(super) fn signal(&self, joined: u32, signal: Signal) {
        // The number of a process that was waited for may be another's.
        if self.status.is_some() {
            return;
        }
        let target = if self.is_of_group(joined) { joined } else { self.pid() };
        if let Some(pid) = i32::try_from(target).ok().and_then(Pid::from_raw) {
            // One that has ended shows by not answering.
            let _ = kill_process(pid, signal);
        }
    }
}
