//! The participants that the server starts itself.

use std::fs::{self, File};
use std::io::Write as _;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rusty_contract::{Credentials, Exit, Participant, RunName, TruthKey};
use rusty_link::WaitPolicy;
use thiserror::Error;

use super::group::{Groups, adopt_orphans, exit_status, wait_for_group};
use super::limits::remedy;
use super::program::find_program;
use super::{arguments, printed};
use crate::confine::{self, Gate};

/// How long participants may take to end after their goodbye.
const PATIENCE: Duration = Duration::from_secs(10);
/// The same for those that nobody misses.
const SHORT_PATIENCE: Duration = Duration::from_millis(300);
/// The same for those that reported a failure: an interpreter writes down what
/// happened and takes itself apart before it ends, and its last words are wanted.
const FAILED_PATIENCE: Duration = Duration::from_secs(3);

/// Why a participant cannot be started.
#[derive(Debug, Error)]
pub enum ChildrenError {
    /// The program is not there.
    #[error(
        "participant {name:?}: program {program:?} is neither beside {beside} nor on the path; \
         build it (`cargo build --release`), or give its path in the scenario's `command`{hint}"
    )]
    NotFound {
        /// Whose.
        name: String,
        /// What was asked for.
        program: String,
        /// Where it was looked for first.
        beside: String,
        /// A suggestion: a program there with a similar name.
        hint: String,
    },
    /// The operating system does not start it.
    #[error("participant {name:?}: cannot start {program}: {error}{}", remedy(.error))]
    Spawn {
        /// Whose.
        name: String,
        /// The file.
        program: String,
        /// What it said.
        error: std::io::Error,
    },
    /// There is no folder for what it writes.
    #[error(
        "participant {name:?}: {path}: {error}; its `command` has `{{out}}` and its `sandbox` gives \
         it a folder of its own for that: give another folder with --out"
    )]
    Folder {
        /// Whose.
        name: String,
        /// The folder.
        path: String,
        /// What the operating system said.
        error: std::io::Error,
    },
    /// There is no place for what it prints.
    #[error(
        "participant {name:?}: what it prints cannot be kept: {path}: {error}; give a folder \
         that can be written with --out"
    )]
    Talk {
        /// Whose.
        name: String,
        /// The file.
        path: String,
        /// What the operating system said.
        error: std::io::Error,
    },
}

struct Running {
    seat: usize,
    child: Child,
    status: Option<ExitStatus>,
    talk: PathBuf,
    /// How it was started.
    again: Command,
    name: String,
    program: PathBuf,
    /// What it reads from its standard input.
    credentials: Credentials,
    /// Whether the kernel keeps it and its children in its process group.
    confined: bool,
    groups: Groups,
}

/// How a participant left the run, for how long its process is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaving {
    /// It took part to the end.
    AtTheEnd,
    /// It took part until the run was aborted.
    Aborted,
    /// It said that it failed.
    Failed,
    /// It never took part, or was lost in another way.
    Lost,
    /// Its process was found dead: the loss has all that there is to report.
    Dead,
    /// The run was aborted before it had joined.
    TooLate,
}

impl Leaving {
    fn patience(self) -> Duration {
        match self {
            Self::AtTheEnd | Self::Aborted => PATIENCE,
            Self::Failed => FAILED_PATIENCE,
            Self::Lost | Self::Dead | Self::TooLate => SHORT_PATIENCE,
        }
    }

    /// Whether ending like this is a failure that nothing else reports. Of an
    /// aborted run the logger ends with code 3, and one that asks to join it with
    /// code 1.
    fn is_own_fault(self, status: ExitStatus) -> bool {
        let follows = match self {
            Self::Dead => return false,
            Self::Aborted => Some(Exit::Lost as i32),
            Self::TooLate => Some(Exit::Failed as i32),
            _ => None,
        };
        !status.success() && (follows.is_none() || status.code() != follows)
    }
}

/// The participants that the server started, each in a process group of its
/// own. A group that is still there when this is dropped is killed.
#[derive(Default)]
pub struct Children(Vec<Running>);

/// How participants are started.
pub struct Spawn<'a> {
    /// The run to join.
    pub run: &'a RunName,
    /// How they wait.
    pub wait: WaitPolicy,
    /// For those who hold it.
    pub key: &'a TruthKey,
    /// Where what they print and write goes.
    pub out_dir: &'a Path,
    /// How each of them is confined, in roster order.
    pub gates: &'a [Gate],
    /// Where their process groups are kept for signals.
    pub groups: &'a Groups,
}

impl Children {
    /// Starts everyone in the roster who has a command.
    ///
    /// # Errors
    /// [`ChildrenError`] names the participant; those already started are
    /// ended.
    pub fn start(roster: &[Participant], spawn: &Spawn<'_>) -> Result<Self, ChildrenError> {
        let mut children = Self::default();
        if spawn.gates.iter().any(Gate::confines) {
            adopt_orphans();
        }
        for (seat, participant) in roster.iter().enumerate() {
            if !participant.command.is_empty() {
                children.0.push(start_one(seat, participant, spawn)?);
            }
        }
        Ok(children)
    }

    /// The process groups, by the processes that lead them.
    pub fn groups(&self) -> impl Iterator<Item = u32> {
        self.0.iter().map(|r| r.child.id())
    }

    /// How the participant on `seat` ended, if the server started it and it
    /// has ended. `pid` is the process that has the seat, 0 if none has.
    pub fn ended(&mut self, seat: usize, pid: u32) -> Option<String> {
        let running = self.0.iter_mut().find(|r| r.seat == seat)?;
        if pid != 0 && pid != running.child.id() && running.status.is_some() {
            return None;
        }
        running.has_not_ended();
        let status = running.status?;
        let mut how = match (status.code(), status.signal()) {
            (Some(code), _) => format!("its process exited with code {code}"),
            (_, Some(signal)) => format!("its process was killed by signal {signal}"),
            _ => "its process has ended".to_owned(),
        };
        if let Some(lines) = printed::excerpt(&running.talk) {
            how = format!("{how}; it printed:{lines}");
        } else if !status.success() && printed::is_full(&running.talk) {
            let talk = running.talk.display();
            how = format!("{how}; its output is lost: {talk}: No space left on device");
        }
        Some(how)
    }

    /// Whether the program on `seat` has ended because of a wrong argument.
    pub fn is_misused(&self, seat: usize) -> bool {
        let code = self.0.iter().find(|r| r.seat == seat).and_then(|r| r.status?.code());
        code == Some(Exit::Usage as i32)
    }

    /// The file for all that the participant on `seat` prints, if the server
    /// started it.
    pub fn output(&self, seat: usize) -> Option<&Path> {
        self.0.iter().find(|r| r.seat == seat).map(|r| r.talk.as_path())
    }

    /// Ends what is left of the participant on `seat` and starts it once more,
    /// with `between` in between. Says whether there was one to start: others
    /// were started by hand.
    ///
    /// # Errors
    /// [`ChildrenError::Spawn`].
    pub fn restart(&mut self, seat: usize, between: impl FnOnce()) -> Result<bool, ChildrenError> {
        let Some(running) = self.0.iter_mut().find(|r| r.seat == seat) else { return Ok(false) };
        running.end();
        between();
        running.status = None;
        let Running { again, credentials, .. } = running;
        let child = running.groups.start(|| spawn_with_credentials(again, credentials));
        running.child = child.map_err(|error| ChildrenError::Spawn {
            name: running.name.clone(),
            program: running.program.display().to_string(),
            error,
        })?;
        Ok(true)
    }

    /// Waits for everyone to end by itself, then ends the rest. Says who did
    /// not end well: seat and how. Nobody waits long for a seat that never took
    /// part, or is known to be lost.
    pub fn finish(mut self, how_left: impl Fn(usize) -> Leaving) -> Vec<(usize, String)> {
        let began = Instant::now();
        let is_missed = |seat| matches!(how_left(seat), Leaving::AtTheEnd | Leaving::Aborted);
        loop {
            let late = self.0.iter_mut().filter_map(|r| r.has_not_ended().then_some(r.seat));
            let patience = late.map(|seat| how_left(seat).patience()).max();
            if patience.is_none_or(|patience| began.elapsed() >= patience) {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let mut bad = Vec::new();
        for i in 0..self.0.len() {
            let seat = self.0[i].seat;
            match (self.ended(seat, 0), self.0[i].status) {
                (None, _) if !is_missed(seat) => {}
                (None, _) => bad.push((seat, "it did not end by itself".to_owned())),
                (Some(how), Some(status)) if how_left(seat).is_own_fault(status) => {
                    bad.push((seat, how));
                }
                _ => {}
            }
            if !printed::has_content(&self.0[i].talk) {
                let _ = fs::remove_file(&self.0[i].talk);
            }
        }
        bad
    }
}

impl Running {
    /// Kills it and its group, unless it was waited for.
    fn end(&mut self) {
        self.groups.kill(&mut self.child);
        // A confined process cannot leave its group, which has been killed.
        if self.groups.wait(&mut self.child) && self.confined {
            wait_for_group(self.child.id());
        }
    }

    /// One that has ended is waited for when it is started again or dropped, so
    /// that its group keeps its number. What a confined one started ends with it.
    fn has_not_ended(&mut self) -> bool {
        if self.status.is_none() {
            self.status = exit_status(&self.child);
            if self.status.is_some() && self.confined {
                self.end();
            }
        }
        self.status.is_none()
    }
}

impl Drop for Children {
    fn drop(&mut self) {
        for running in &mut self.0 {
            if running.status.is_none() {
                running.end();
            } else {
                running.groups.wait(&mut running.child);
            }
        }
    }
}

fn start_one(
    seat: usize,
    participant: &Participant,
    spawn: &Spawn<'_>,
) -> Result<Running, ChildrenError> {
    let name = &participant.name;
    let program = find_program(name, &participant.command[0])?;
    let error = |error| ChildrenError::Spawn {
        name: name.clone(),
        program: program.display().to_string(),
        error,
    };
    let talk = spawn.out_dir.join(format!("{name}.txt"));
    let outputs = open_talk(name, &talk)?;
    let own = arguments::own_folder(participant, spawn.out_dir).map_err(|(path, error)| {
        ChildrenError::Folder { name: name.clone(), path: path.display().to_string(), error }
    })?;
    let confined = spawn.gates.get(seat).is_some_and(Gate::confines);
    let mut command = if confined {
        // What is started is not the program itself, which may be missing.
        fs::metadata(&program).map_err(error)?;
        confine::command(&program, spawn.run, participant, own.as_deref())
    } else {
        Command::new(&program)
    };
    let folder = own.as_deref().unwrap_or(spawn.out_dir);
    command.args(arguments::with_folder(&participant.command[1..], folder));
    invite(&mut command, spawn.run, name, spawn.wait, outputs);
    let credentials = Credentials::new(spawn.key, seat, participant.role.holds_key());
    let start = || spawn_with_credentials(&mut command, &credentials);
    let child = spawn.groups.start(start).map_err(error)?;
    let name = name.clone();
    Ok(Running {
        seat,
        child,
        status: None,
        talk,
        again: command,
        name,
        program,
        credentials,
        confined,
        groups: spawn.groups.clone(),
    })
}

/// Adds what every launched participant is told on its command line, and where
/// it reads and prints.
pub fn invite(
    command: &mut Command,
    run: &RunName,
    name: &str,
    wait: WaitPolicy,
    (out, err): (File, File),
) {
    command
        .args(["--run", run.as_str(), "--name", name, "--wait", &wait.to_string()])
        // Should this process be killed, they need not wait for their run.
        .args(["--launcher", &std::process::id().to_string()])
        .arg("--key-stdin")
        .stdin(Stdio::piped())
        .stdout(out)
        .stderr(err)
        // Ctrl-C on the terminal reaches the server alone; it tells the others.
        .process_group(0);
}

/// Starts it, and gives it its credentials by its standard input, which ends
/// after them.
pub fn spawn_with_credentials(
    command: &mut Command,
    credentials: &Credentials,
) -> std::io::Result<Child> {
    let mut child = command.spawn()?;
    if let Some(mut pipe) = child.stdin.take() {
        // A child that does not read them cannot join, and that shows.
        let _ = pipe.write_all(credentials.to_text().as_bytes());
    }
    Ok(child)
}

/// The file of what a participant prints, for its stdout and its stderr.
pub fn open_talk(name: &str, path: &Path) -> Result<(File, File), ChildrenError> {
    let both = File::create(path).and_then(|out| Ok((out.try_clone()?, out)));
    both.map_err(|error| ChildrenError::Talk {
        name: name.to_owned(),
        path: path.display().to_string(),
        error,
    })
}
