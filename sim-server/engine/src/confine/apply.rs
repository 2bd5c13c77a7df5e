//! The rules, applied to the process that calls: files, sockets and signals by
//! Landlock, then capabilities, then system calls.

use std::path::{Path, PathBuf};

use landlock::{
    ABI, Access as _, AccessFs, AccessNet, BitFlags, PathBeneath, PathFd, Ruleset,
    RulesetAttr as _, RulesetCreated, RulesetCreatedAttr as _, RulesetError, RulesetStatus, Scope,
    path_beneath_rules,
};
use rustix::thread::{CapabilitySet, CapabilitySets};
use rusty_contract::{RunName, Sandbox};
use rusty_link::{Domain, DomainError};
use thiserror::Error;

use super::calls;

/// The newest Landlock ABI whose rights the rules name.
const TESTED_ABI: ABI = ABI::V7;

/// Read, so that programs find what they are linked with.
const LIBRARIES: [&str; 6] =
    ["/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib", "/etc/ld.so.cache"];
/// What the kernel starts in a program's stead, so that it finds its libraries.
const LOADERS: [&str; 6] = [
    "/lib64/ld-linux-x86-64.so.2",
    "/lib/ld-linux-aarch64.so.1",
    "/lib/ld-linux-riscv64-lp64d.so.1",
    "/lib/ld-musl-x86_64.so.1",
    "/lib/ld-musl-aarch64.so.1",
    "/lib/ld-musl-riscv64.so.1",
];
const DEVICES: [&str; 4] = ["/dev/null", "/dev/zero", "/dev/urandom", "/dev/random"];

/// What one confined process may reach.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Its run.
    pub run: RunName,
    /// The program it is to become.
    pub program: PathBuf,
    /// The name under which it is started, if not by its path.
    pub name: Option<String>,
    /// What it may read in addition.
    pub files: Vec<PathBuf>,
    /// Where it may write, if anywhere.
    pub own_folder: Option<PathBuf>,
    /// Whether anything less than all rules will do.
    pub sandbox: Sandbox,
}

/// Why a process cannot be confined.
#[derive(Debug, Error)]
pub enum ConfineError {
    /// A file it is to read or run is not there.
    #[error("{path}: {error}; a confined participant needs its program and all its `files`")]
    Path {
        /// Which.
        path: String,
        /// The kernel's words.
        error: String,
    },
    /// Its run has no folder.
    #[error(transparent)]
    Run(#[from] DomainError),
    /// The kernel does not take the rules.
    #[error("the kernel does not take the rules for files: {0}; see `sandbox` in the scenario")]
    Rules(#[from] RulesetError),
    /// It took fewer than are required.
    #[error("the kernel took only part of the rules; use sandbox = \"if-possible\"")]
    Weaker,
    /// The kernel does not take the filter.
    #[error("the kernel does not take the filter of system calls: {0}")]
    Calls(#[from] seccompiler::Error),
    /// Something else.
    #[error("cannot {what}: {error}")]
    Os {
        /// What was tried.
        what: &'static str,
        /// What the kernel said.
        error: std::io::Error,
    },
    /// The program does not start.
    #[error(
        "cannot start {program}: {error}; a confined participant is a program that the kernel \
         starts itself: for a script, name the interpreter in `command`, the script in `files`"
    )]
    Exec {
        /// Which.
        program: String,
        /// What the kernel said.
        error: std::io::Error,
    },
}

impl ConfineError {
    pub(super) fn os(what: &'static str) -> impl FnOnce(rustix::io::Errno) -> Self {
        move |error| Self::Os { what, error: error.into() }
    }
}

/// Confines this thread and all that it starts. There is no way back.
pub(super) fn apply(cell: &Cell) -> Result<(), ConfineError> {
    let status = rules(cell)?.restrict_self()?;
    if cell.sandbox == Sandbox::Required && status.ruleset != RulesetStatus::FullyEnforced {
        return Err(ConfineError::Weaker);
    }
    drop_capabilities()?;
    match calls::can_be_filtered() {
        true => Ok(calls::refuse()?),
        false if cell.sandbox == Sandbox::Required => Err(ConfineError::Weaker),
        false => Ok(()),
    }
}

/// Exactly what it may do with which files; ports and other processes: nothing.
fn rules(cell: &Cell) -> Result<RulesetCreated, ConfineError> {
    use AccessFs::{Execute, MakeDir, MakeReg, MakeSock, ReadDir, ReadFile, RemoveDir};
    use AccessFs::{RemoveFile, Truncate, WriteFile};
    let domain = Domain::find(&cell.run)?;
    let read = ReadFile | ReadDir;
    let write = WriteFile | MakeReg | MakeDir | RemoveFile | RemoveDir | Truncate;
    let rules = Ruleset::default()
        .handle_access(AccessFs::from_all(TESTED_ABI))?
        .handle_access(AccessNet::from_all(TESTED_ABI))?
        .scope(Scope::from_all(TESTED_ABI))?
        .create()?
        .add_rules(path_beneath_rules(LIBRARIES, read))?
        .add_rules(path_beneath_rules(LOADERS, ReadFile | Execute))?
        .add_rules(path_beneath_rules(DEVICES, ReadFile | WriteFile))?;
    let mut own: Vec<(PathBuf, BitFlags<AccessFs>)> = vec![
        (cell.program.clone(), ReadFile | Execute),
        (domain.folder().join("lock"), ReadFile.into()),
        (domain.memory(), read | write | MakeSock),
    ];
    own.extend(cell.files.iter().map(|file| (file.clone(), read)));
    own.extend(cell.own_folder.iter().map(|folder| (folder.clone(), read | write)));
    own.into_iter().try_fold(rules, |rules, (path, access)| allow(rules, &path, access))
}

/// Adds one rule; the path must be there.
fn allow(
    rules: RulesetCreated,
    path: &Path,
    access: BitFlags<AccessFs>,
) -> Result<RulesetCreated, ConfineError> {
    let error = |error: String| ConfineError::Path { path: path.display().to_string(), error };
    let is_folder = path.metadata().map_err(|e| error(e.to_string()))?.is_dir();
    let access = if is_folder { access } else { access & AccessFs::from_file(TESTED_ABI) };
    let place = PathFd::new(path).map_err(|e| error(e.to_string()))?;
    Ok(rules.add_rule(PathBeneath::new(place, access))?)
}

/// Takes from root what makes it more than any other user.
fn drop_capabilities() -> Result<(), ConfineError> {
    // One by one up to the last that this kernel knows. A process that may not drop
    // them has none to drop.
    for n in 0..64 {
        let one = CapabilitySet::from_bits_retain(1 << n);
        if rustix::thread::remove_capability_from_bounding_set(one).is_err() {
            break;
        }
    }
    let none = CapabilitySet::empty();
    let sets = CapabilitySets { effective: none, permitted: none, inheritable: none };
    rustix::thread::set_capabilities(None, sets).map_err(ConfineError::os("drop capabilities"))
}
