//! The viewer of a run: a process next to it, for which the run does not wait.

use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::process::CommandExt as _;
use std::process::{Child, Stdio};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, anyhow};
use rustix::process::{Pid, Signal, kill_process};
use rusty_contract::{Credentials, LogHeader, Role, RunName, errln};
use rusty_engine::run::{Stop, find_program};

/// Time in which the viewer gives its address.
const START_TIME: Duration = Duration::from_secs(10);
/// Time in which it ends when it is told to.
const END_TIME: Duration = Duration::from_secs(3);
/// Time between two looks at it.
const LOOK: Duration = Duration::from_millis(20);

/// The process. Dropped, it ends.
pub(super) struct Viewer {
    child: Child,
}

impl Viewer {
    /// Starts the viewer of a run that is about to begin, and prints the address of its
    /// page. Its driver can be driven from the page if it is the program `drive`.
    pub(super) fn start(
        run: &RunName,
        header: &LogHeader,
        key: &Credentials,
        origins: &[String],
    ) -> Result<Self> {
        let is_driven = header.roster.iter().any(|p| {
            let program = p.command.first().map(|word| word.rsplit('/').next());
            p.role == Role::Driver && program.flatten() == Some("drive")
        });
        let mut command = find_program("view", "view")?.command();
        command
            .args(["--run", run.as_str(), "--key-stdin"])
            .args(["--launcher", &std::process::id().to_string()])
            .args(is_driven.then_some("--drive"))
            .args(origins.iter().map(|origin| format!("--allow-origin={origin}")))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            // Ctrl-C reaches this process alone.
            .process_group(0);
        let mut viewer = Self { child: command.spawn().context("cannot start the viewer")? };
        if let Some(mut pipe) = viewer.child.stdin.take() {
            pipe.write_all(key.to_text().as_bytes()).context("cannot give the viewer its key")?;
        }
        let output = viewer.child.stdout.take().context("the viewer has no output")?;
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            let lines: Vec<String> = BufReader::new(output).lines().take(2).flatten().collect();
            let _ = sender.send(lines);
        });
        let lines = receiver.recv_timeout(START_TIME).unwrap_or_default();
        let [address, foxglove] = &lines[..] else {
            return Err(anyhow!("the viewer gave no address; run without --watch"));
        };
        errln!("watch {address}\n{foxglove}");
        Ok(viewer)
    }

    /// Waits until the page is closed or `stop` is raised.
    pub(super) fn stay(mut self, stop: &Stop) {
        let has_ended = |child: &mut Child| !matches!(child.try_wait(), Ok(None));
        if !stop.is_raised() && !has_ended(&mut self.child) {
            errln!("the page stays until you close it or press Ctrl-C");
        }
        while !stop.is_raised() && !has_ended(&mut self.child) {
            std::thread::sleep(LOOK);
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let deadline = Instant::now() + END_TIME;
        let pid = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw);
        if let (Ok(None), Some(pid)) = (self.child.try_wait(), pid) {
            let _ = kill_process(pid, Signal::TERM);
        }
        while matches!(self.child.try_wait(), Ok(None)) && Instant::now() < deadline {
            std::thread::sleep(LOOK);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
