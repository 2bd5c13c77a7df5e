//! A participant's process.

use std::fs::{self, File};
use std::io::Write as _;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use rusty_contract::{Credentials, Participant, RunName, TruthKey};
use rusty_link::{WaitPolicy, with_umask};
use thiserror::Error;

use super::group::{Groups, exit_status, wait_for_group};
use super::limits::remedy;
use super::program::find_program;
use super::{arguments, printed};
use crate::confine;
use crate::executable::Executable;

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

/// How participants are started.
#[derive(Clone, Copy)]
pub struct Spawn<'a> {
    /// The run to join.
    pub run: &'a RunName,
    /// How they wait.
    pub wait: WaitPolicy,
    /// The run's key: each participant gets the credentials of its role.
    pub key: &'a TruthKey,
    /// Where what they print and write goes.
    pub out_dir: &'a Path,
    /// Where their process groups are kept for signals.
    pub groups: &'a Groups,
}

/// A participant that this process started, in a separate process group, which
/// is killed when this is dropped.
pub struct ChildProcess {
    pub(super) slot: usize,
    child: Child,
    status: Option<ExitStatus>,
    output: PathBuf,
    command: Command,
    name: String,
    program: Executable,
    /// What it reads from its standard input.
    credentials: Credentials,
    /// Whether the kernel keeps it and its children in its process group.
    confined: bool,
    groups: Groups,
}

impl ChildProcess {
    /// Starts the program of the participant at `slot`.
    ///
    /// # Errors
    /// [`ChildrenError`] names the participant and what is in the way.
    pub fn start(
        slot: usize,
        participant: &Participant,
        confined: bool,
        spawn: &Spawn<'_>,
    ) -> Result<Self, ChildrenError> {
        let name = participant.name.clone();
        let program = find_program(&name, &participant.command[0])?;
        let output = spawn.out_dir.join(format!("{name}.txt"));
        let streams = File::create(&output).and_then(|out| Ok((out.try_clone()?, out)));
        let (stdout, stderr) = streams.map_err(|error| {
            let path = output.display().to_string();
            ChildrenError::Talk { name: name.clone(), path, error }
        })?;
        let own = arguments::own_folder(participant, spawn.out_dir).map_err(|(path, error)| {
            let path = path.display().to_string();
            ChildrenError::Folder { name: name.clone(), path, error }
        })?;
        let mut command = if confined {
            // What is started is not the program itself, which may be missing.
            fs::metadata(program.file()).map_err(failed_spawn(&name, &program))?;
            confine::command(&program, spawn.run, participant, own.as_deref())
        } else {
            program.command()
        };
        let folder = own.as_deref().unwrap_or(spawn.out_dir);
        command
            .args(arguments::with_folder(&participant.command[1..], folder))
            .args(["--run", spawn.run.as_str(), "--name", &name])
            .args(["--wait", &spawn.wait.to_string()])
            // Should this process be killed, they need not wait for their run.
            .args(["--launcher", &std::process::id().to_string()])
            .arg("--key-stdin")
            .stdin(Stdio::piped())
            .stdout(stdout)
            .stderr(stderr)
            // Ctrl-C on the terminal reaches the server alone; it tells the others.
            .process_group(0);
        let credentials = Credentials::new(spawn.key, slot, participant.role.holds_key());
        let groups = spawn.groups.clone();
        let child = start(&groups, &mut command, &credentials);
        let child = child.map_err(failed_spawn(&name, &program))?;
        let status = None;
        Ok(Self {
            slot,
            child,
            status,
            output,
            command,
            name,
            program,
            credentials,
            confined,
            groups,
        })
    }

    /// Its process, which leads its group.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// The file for all that it prints.
    #[must_use]
    pub fn output(&self) -> &Path {
        &self.output
    }

    /// How it ended, if it has. One that has ended is waited for when it is started
    /// again or dropped, so that its group keeps its number. What a confined one
    /// started ends with it.
    pub fn status(&mut self) -> Option<ExitStatus> {
        if self.status.is_none() {
            self.status = exit_status(&self.child);
            if self.status.is_some() && self.confined {
                self.end();
            }
        }
        self.status
    }

    /// Kills it and its group, unless it was waited for.
    pub fn end(&mut self) {
        self.groups.kill(&mut self.child);
        // A confined process cannot leave its group, which has been killed.
        if self.groups.wait(&mut self.child) && self.confined {
            wait_for_group(self.child.id());
        }
    }

    /// Kills it and its group unless it has ended, and knows that it has.
    pub(super) fn end_now(&mut self) {
        if self.status().is_none() {
            self.end();
            self.status = self.child.try_wait().ok().flatten();
        }
    }

    /// Its name in the roster.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Ends what is left of it and starts it once more, with `between` in between.
    pub(super) fn restart(&mut self, between: impl FnOnce()) -> Result<(), ChildrenError> {
        self.end();
        between();
        self.status = None;
        let child = start(&self.groups, &mut self.command, &self.credentials);
        self.child = child.map_err(failed_spawn(&self.name, &self.program))?;
        Ok(())
    }

    /// The status that was seen last.
    pub(super) fn last_status(&self) -> Option<ExitStatus> {
        self.status
    }

    /// How it ended, in words, if it has.
    pub(super) fn ending(&mut self) -> Option<String> {
        let status = self.status()?;
        let how = match (status.code(), status.signal()) {
            (Some(code), _) => format!("its process exited with code {code}"),
            (_, Some(signal)) => format!("its process was killed by signal {signal}"),
            _ => "its process has ended".to_owned(),
        };
        Some(match printed::excerpt(&self.output) {
            Some(lines) => format!("{how}; it printed:{lines}"),
            None if !status.success() && printed::is_full(&self.output) => {
                let output = self.output.display();
                format!("{how}; its output is lost: {output}: No space left on device")
            }
            None => how,
        })
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        if self.status.is_none() {
            self.end();
        } else {
            self.groups.wait(&mut self.child);
        }
    }
}

fn failed_spawn(name: &str, program: &Executable) -> impl FnOnce(std::io::Error) -> ChildrenError {
    let (name, program) = (name.to_owned(), program.to_string());
    move |error| ChildrenError::Spawn { name, program, error }
}

/// Starts a program, and gives it its credentials by its standard input, which
/// ends after them.
fn start(
    groups: &Groups,
    command: &mut Command,
    credentials: &Credentials,
) -> std::io::Result<Child> {
    groups.start(|| {
        let mut child = with_umask(|| command.spawn())?;
        if let Some(mut pipe) = child.stdin.take() {
            // A child that does not read them cannot join, and that shows.
            let _ = pipe.write_all(credentials.to_text().as_bytes());
        }
        Ok(child)
    })
}
