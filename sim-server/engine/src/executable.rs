//! `Executable`: the program of a participant, and how it is started.

use std::fmt;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The file of this process, also if another one has its path meanwhile.
pub(crate) const THIS_FILE: &str = "/proc/self/exe";

/// The names of the programs that the file of this process contains.
static BUILT_IN: OnceLock<&[&str]> = OnceLock::new();

/// Declares the programs that the file of this process contains: it is one of them if it
/// is started under that name. The first call counts.
pub fn declare_built_in(names: &'static [&'static str]) {
    let _ = BUILT_IN.set(names);
}

/// Returns the names of the programs that the file of this process contains.
pub(crate) fn built_in() -> &'static [&'static str] {
    BUILT_IN.get().copied().unwrap_or_default()
}

/// A program that can be started: a file, or a program in the file of this process.
#[derive(Clone, Debug)]
pub struct Executable {
    file: PathBuf,
    /// The name under which the file is started, if not by its path.
    name: Option<&'static str>,
}

impl Executable {
    /// Returns the program of this name in the file of this process.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        let name = built_in().iter().find(|built_in| **built_in == name)?;
        Some(Self { file: PathBuf::from(THIS_FILE), name: Some(name) })
    }

    /// Returns the command that starts it, without arguments.
    #[must_use]
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.file);
        if let Some(name) = self.name {
            command.arg0(name);
        }
        command
    }

    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    pub(crate) fn name(&self) -> Option<&'static str> {
        self.name
    }
}

impl From<PathBuf> for Executable {
    fn from(file: PathBuf) -> Self {
        Self { file, name: None }
    }
}

impl fmt::Display for Executable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name {
            Some(name) => f.write_str(name),
            None => write!(f, "{}", self.file.display()),
        }
    }
}
