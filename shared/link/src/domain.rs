//! The folder of one run: its lock, its keys and its shared memory.
//!
//! The folder is `/dev/shm/rusty-<uid>/<run>`, open to its user alone. All
//! shared memory of the run is in files of this folder, next to the sockets and
//! the service files. A process that is killed while it creates a service leaves
//! a name that cannot be used again; in a separate folder this affects no other
//! run, and removing the folder removes every trace.
//!
//! The server locks the file `lock` in the folder for as long as it lives. The
//! kernel drops the lock with the process, so a free lock means that the run is
//! dead. The lock is in the same file system as the memory: containers that share
//! the memory share the lock, and other containers see neither.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use iceoryx2::prelude::{Config, FileName, SemanticString as _};
use rustix::fs::{FlockOperation, flock};
use rusty_contract::RunName;

use crate::Peer;
pub use crate::domain_error::DomainError;
use crate::domain_error::io;
use crate::lock::{
    SWEEP_TIME, check_own_folder, ensure_own_folder, is_current, read_lock, read_pid, take_lock,
};
use crate::memory::{SHARED_MEMORY, files_in};
use crate::sweep::sweep_folder;

/// One run's place on this machine.
#[derive(Debug)]
pub struct Domain {
    run: RunName,
    folder: PathBuf,
    /// Drawn at every start and written into the lock: the folder of the memory
    /// is named after it, so that a process that outlives its run cannot touch a
    /// later run of the same name.
    nonce: u32,
    /// Held by the server for its life; `None` in a client.
    lock: Option<File>,
}

/// What is known of a run's folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunState {
    /// Its server lives.
    Alive {
        /// The server's process.
        pid: u32,
    },
    /// Its server has ended; what is left can be swept.
    Dead,
}

impl Domain {
    /// The folder of all runs of this user.
    #[must_use]
    pub fn base() -> PathBuf {
        let uid = rustix::process::getuid().as_raw();
        Path::new(SHARED_MEMORY).join(format!("rusty-{uid}"))
    }

    /// Makes the domain of a new run and takes its lock. What a dead run of
    /// the same name left is swept first.
    ///
    /// # Errors
    /// [`DomainError::InUse`] names the process that has it.
    pub fn create(run: &RunName) -> Result<Self, DomainError> {
        let base = Self::base();
        ensure_own_folder(&base)?;
        let nonce = getrandom::u32().unwrap_or_else(|_| std::process::id());
        let folder = base.join(run.as_str());
        let deadline = Instant::now() + SWEEP_TIME;
        // A sweep at the same time may remove folder and lock between two of our
        // steps; then the lock we hold is on a file that is removed: once more.
        loop {
            ensure_own_folder(&folder)?;
            let Some(mut lock) = take_lock(&folder)? else {
                let pid = read_pid(&folder);
                // Who holds the lock but is no living server only looks or
                // sweeps, and is soon done.
                if Peer::new(pid).is_dead() && Instant::now() < deadline {
                    std::thread::sleep(Duration::from_millis(1));
                    continue;
                }
                return Err(DomainError::InUse { run: run.to_string(), pid });
            };
            if !is_current(&lock, &folder) {
                continue;
            }
            let path = folder.join("lock");
            // Empty first: a process that looks meanwhile sees that no process serves yet.
            lock.set_len(0).map_err(io(&path, "empty the lock"))?;
            sweep_folder(&folder, false)?;
            let mut domain = Self { run: run.clone(), folder, nonce, lock: None };
            ensure_own_folder(&domain.memory())?;
            let text = format!("{} {nonce}", std::process::id());
            lock.write_all(text.as_bytes()).map_err(io(&path, "write the lock"))?;
            domain.lock = Some(lock);
            return Ok(domain);
        }
    }

    /// Finds the domain of a run that is being served.
    ///
    /// # Errors
    /// [`DomainError::NoSuchRun`] lists the runs there are.
    pub fn find(run: &RunName) -> Result<Self, DomainError> {
        let folder = Self::base().join(run.as_str());
        let (pid, nonce) = read_lock(&folder);
        let domain = Self { run: run.clone(), folder, nonce, lock: None };
        match domain.state() {
            // A lock that is still empty: the server is on its way.
            Some(RunState::Alive { .. }) if pid != 0 => Ok(domain),
            _ => {
                // A confined process cannot list them, and looks again like any other.
                let all = Self::list().unwrap_or_default();
                let alive: Vec<String> = all
                    .into_iter()
                    .filter(|(_, state)| matches!(state, RunState::Alive { .. }))
                    .map(|(run, _)| run.to_string())
                    .collect();
                let remedy = if alive.is_empty() {
                    format!("start one with `sim-server serve --run {run}`")
                } else {
                    format!("being served: {}", alive.join(", "))
                };
                let folder = domain.folder.display().to_string();
                Err(DomainError::NoSuchRun { run: run.to_string(), folder, remedy })
            }
        }
    }

    /// All runs of this user that have left a folder, by name.
    ///
    /// # Errors
    /// [`DomainError::Io`] if the base folder cannot be read.
    pub fn list() -> Result<Vec<(RunName, RunState)>, DomainError> {
        let with_state = |run: RunName| {
            let state = Self::named(&run).state()?;
            Some((run, state))
        };
        Ok(Self::names()?.into_iter().filter_map(with_state).collect())
    }

    /// The names of all folders of runs, in order.
    fn names() -> Result<Vec<RunName>, DomainError> {
        let base = Self::base();
        match check_own_folder(&base) {
            Err(DomainError::Io { error, .. }) if error.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Vec::new());
            }
            checked => checked?,
        }
        let entries = fs::read_dir(&base).map_err(io(&base, "list the runs"))?;
        let mut runs: Vec<RunName> = entries
            .flatten()
            // A link is none of ours: what it points to is not swept.
            .filter(|entry| entry.file_type().is_ok_and(|t| t.is_dir()))
            .filter_map(|entry| RunName::new(entry.file_name().to_str()?).ok())
            .collect();
        runs.sort_by(|a, b| a.as_str().cmp(b.as_str()));
        Ok(runs)
    }

    /// Sweeps every dead run of this user and says which there were.
    ///
    /// # Errors
    /// [`DomainError::Io`] names what could not be removed.
    pub fn sweep_dead() -> Result<Vec<RunName>, DomainError> {
        let mut swept = Vec::new();
        for run in Self::names()? {
            if Self::named(&run).sweep_if_dead()? {
                swept.push(run);
            }
        }
        Ok(swept)
    }

    /// The domain of this name, whatever its state.
    pub(crate) fn named(run: &RunName) -> Self {
        let folder = Self::base().join(run.as_str());
        Self { run: run.clone(), folder, nonce: 0, lock: None }
    }

    /// Sweeps this run if its server has ended, and returns whether it did.
    ///
    /// # Errors
    /// [`DomainError::Io`] names what could not be removed.
    pub fn sweep_if_dead(&self) -> Result<bool, DomainError> {
        if !self.folder.exists() {
            return Ok(false);
        }
        let deadline = Instant::now() + SWEEP_TIME;
        loop {
            match take_lock(&self.folder) {
                Ok(Some(lock)) if is_current(&lock, &self.folder) => {
                    sweep_folder(&self.folder, true)?;
                    return Ok(true);
                }
                // Another process sweeps, perhaps past what came after it looked.
                Ok(_) if Peer::new(self.server_pid()).is_dead() && Instant::now() < deadline => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Ok(_) => return Ok(false),
                // Another process swept it meanwhile.
                Err(_) if !self.folder.exists() => {}
                Err(e) => return Err(e),
            }
            if !self.folder.exists() {
                return Ok(false);
            }
        }
    }

    fn state(&self) -> Option<RunState> {
        if !self.folder.is_dir() {
            return None;
        }
        match File::open(self.folder.join("lock")) {
            Ok(lock) => match flock(&lock, FlockOperation::NonBlockingLockShared) {
                Ok(()) => Some(RunState::Dead),
                Err(_) => Some(RunState::Alive { pid: read_pid(&self.folder) }),
            },
            Err(_) => Some(RunState::Dead),
        }
    }

    /// The run this domain belongs to.
    #[must_use]
    pub fn run(&self) -> &RunName {
        &self.run
    }

    /// The run's folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The server's process, as the lock file has it; 0 if it has none.
    #[must_use]
    pub fn server_pid(&self) -> u32 {
        read_pid(&self.folder)
    }

    /// The folder of this run's shared memory and sockets.
    #[must_use]
    pub fn memory(&self) -> PathBuf {
        self.folder.join(format!("{:08x}", self.nonce))
    }

    /// The folder of a run and all files in it. Empty for a run that left
    /// nothing behind.
    #[must_use]
    pub fn traces(run: &RunName) -> Vec<PathBuf> {
        let folder = Self::base().join(run.as_str());
        let mut traces: Vec<PathBuf> =
            folder.exists().then(|| folder.clone()).into_iter().collect();
        traces.extend(files_in(&folder));
        traces
    }

    /// Removes all that a run has on this machine, whatever process uses it: for a
    /// server that must end at once. What cannot be removed stays.
    pub fn remove_traces(run: &RunName) {
        let _ = sweep_folder(&Self::base().join(run.as_str()), true);
    }

    /// The transport's configuration for this domain. Given in code: a
    /// configuration file in the working directory must change nothing.
    pub(crate) fn transport(&self) -> Result<Config, crate::LinkError> {
        let mut config = Config::default();
        let memory = self.memory();
        let root = iceoryx2::prelude::Path::new(memory.as_os_str().as_encoded_bytes())
            .map_err(crate::LinkError::transport("use the run's folder"))?;
        config.global.set_root_path(&root);
        // The kernel cuts paths of sockets at 108 bytes.
        config.global.prefix =
            FileName::new(b"r").map_err(crate::LinkError::transport("use a prefix"))?;
        // Sweeping is done by the domain, never in the middle of a run.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        Ok(config)
    }
}

impl Drop for Domain {
    fn drop(&mut self) {
        if self.lock.is_some() {
            // Nothing can be reported from here; what stays is swept by the
            // next start or by `clean`.
            let _ = sweep_folder(&self.folder, true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(tag: &str) -> RunName {
        RunName::new(&format!("t{}-{tag}", std::process::id())).unwrap()
    }

    #[test]
    fn a_run_has_one_server() {
        let run = name("one");
        let first = Domain::create(&run).unwrap();
        let error = Domain::create(&run).unwrap_err().to_string();
        assert!(error.contains(&std::process::id().to_string()), "{error}");
        assert_eq!(Domain::find(&run).unwrap().server_pid(), std::process::id());
        let folder = first.folder().to_owned();
        drop(first);
        assert!(!folder.exists());
        assert!(Domain::find(&run).unwrap_err().to_string().contains("no run"));
    }

    #[test]
    fn a_link_is_none_of_our_runs() {
        let elsewhere = std::env::temp_dir().join(format!("elsewhere-{}", std::process::id()));
        fs::create_dir_all(elsewhere.join("dear")).unwrap();
        let run = name("link");
        let living = Domain::create(&name("base")).unwrap();
        let link = Domain::base().join(run.as_str());
        std::os::unix::fs::symlink(&elsewhere, &link).unwrap();
        let found = Domain::list().unwrap().into_iter().any(|(r, _)| r == run);
        Domain::sweep_dead().unwrap();
        assert!(!found && elsewhere.join("dear").exists());
        assert!(matches!(Domain::create(&run), Err(DomainError::NotYours { .. })));
        fs::remove_file(link).unwrap();
        fs::remove_dir_all(elsewhere).unwrap();
        drop(living);
    }

    #[test]
    fn what_a_dead_run_left_is_swept_and_a_living_one_is_not() {
        let (dead, alive) = (name("dead"), name("alive"));
        let living = Domain::create(&alive).unwrap();
        let corpse = Domain::named(&dead);
        fs::create_dir_all(corpse.memory().join("services")).unwrap();
        fs::write(corpse.memory().join("services/x"), "x").unwrap();
        fs::write(corpse.memory().join("x"), "x").unwrap();
        assert_eq!(Domain::traces(&dead).len(), 3);
        assert!(corpse.sweep_if_dead().unwrap());
        assert!(!corpse.folder().exists() && Domain::traces(&dead).is_empty());
        let view = Domain::find(&alive).unwrap();
        assert!(!view.sweep_if_dead().unwrap());
        assert!(living.folder().exists());
    }

    #[test]
    fn a_later_run_of_the_same_name_has_other_memory() {
        let run = name("again");
        let first = Domain::create(&run).unwrap();
        let (memory, view) = (first.memory(), Domain::find(&run).unwrap());
        assert!(memory.is_dir() && view.memory() == memory);
        drop(first);
        let second = Domain::create(&run).unwrap();
        assert!(!memory.exists() && second.memory() != memory);
    }

    /// The owner's permissions alone: no other user can reach into a run.
    #[test]
    fn folders_of_a_run_are_open_to_their_user_alone() {
        use std::os::unix::fs::PermissionsExt as _;
        let domain = Domain::create(&name("mode")).unwrap();
        for folder in [Domain::base(), domain.folder().to_owned(), domain.memory()] {
            let mode = fs::metadata(&folder).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o700, "{}", folder.display());
        }
    }
}
