//! The folder, the lock and the shared memory that belong to one run.
//!
//! Every run has a domain of its own: the folder `/tmp/rusty-<uid>/<run>` for
//! sockets and service files, and a prefix of its own for names in shared
//! memory. A process killed in the middle of creating a service leaves a name
//! that nobody can use again; in a domain of its own that hurts nobody else,
//! and sweeping the domain removes every trace.
//!
//! The file `lock` in the folder is locked by the server for as long as it
//! lives. The kernel drops the lock with the process, so a free lock means
//! that the run is dead and may be swept.

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
    SWEEP_TIME, check_own_folder, ensure_own_folder, is_current, prefix_of, read_lock, read_pid,
    take_lock,
};
use crate::sweep::{
    memory_files, memory_of_runs, memory_without_run, remove_memory, sweep_folder, sweep_memory,
};

/// One run's place on this machine.
#[derive(Debug)]
pub struct Domain {
    run: RunName,
    folder: PathBuf,
    /// Drawn at every start and written into the lock, so that nothing that
    /// outlives a run can touch a later one of the same name.
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
    /// Its server is gone; what is left can be swept.
    Dead,
}

impl Domain {
    /// The folder of all runs of this user.
    #[must_use]
    pub fn base() -> PathBuf {
        PathBuf::from(format!("/tmp/rusty-{}", rustix::process::getuid().as_raw()))
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
        // A sweep beside us may remove folder and lock between two of our
        // steps; then the lock we hold is on a file that is gone: once more.
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
            // Empty first: whoever looks meanwhile sees that nobody serves yet.
            lock.set_len(0).map_err(io(&path, "empty the lock"))?;
            sweep_folder(&folder, false)?;
            sweep_memory(&prefix_of(run))?;
            let text = format!("{} {nonce}", std::process::id());
            lock.write_all(text.as_bytes()).map_err(io(&path, "write the lock"))?;
            return Ok(Self { run: run.clone(), folder, nonce, lock: Some(lock) });
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
                let alive: Vec<String> = Self::list()?
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

    /// Removes shared memory of this user's runs that has no folder any more,
    /// and says what it was: what a process left that was killed while it
    /// opened its ports in a run that others swept. For a person to ask for,
    /// not for a start to do: where two containers share memory but not `/tmp`,
    /// the other's runs have no folder here.
    ///
    /// # Errors
    /// [`DomainError::Io`] names what could not be removed.
    pub fn sweep_orphans() -> Result<Vec<PathBuf>, DomainError> {
        let mut names = Ok(Vec::new());
        let orphans = memory_without_run(|| {
            names = Self::names();
            names.iter().flatten().map(prefix_of).collect()
        });
        names?;
        orphans.iter().try_for_each(|path| remove_memory(path))?;
        Ok(orphans)
    }

    /// The domain of this name, whatever its state.
    pub(crate) fn named(run: &RunName) -> Self {
        let folder = Self::base().join(run.as_str());
        Self { run: run.clone(), folder, nonce: 0, lock: None }
    }

    /// Sweeps this run if its server is gone, and says whether it did.
    ///
    /// # Errors
    /// [`DomainError::Io`] names what could not be removed.
    pub fn sweep_if_dead(&self) -> Result<bool, DomainError> {
        // A process that was opening its ports while another swept leaves
        // memory without a folder; the lock makes the folder again.
        if Self::traces(&self.run).is_empty() {
            return Ok(false);
        }
        let deadline = Instant::now() + SWEEP_TIME;
        loop {
            match take_lock(&self.folder) {
                Ok(Some(lock)) if is_current(&lock, &self.folder) => {
                    self.sweep()?;
                    return Ok(true);
                }
                // Somebody else sweeps, perhaps past what came after it looked.
                Ok(_) if Peer::new(self.server_pid()).is_dead() && Instant::now() < deadline => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Ok(_) => return Ok(false),
                // Somebody else swept it meanwhile.
                Err(_) if !self.folder.exists() => {}
                Err(e) => return Err(e),
            }
            if Self::traces(&self.run).is_empty() {
                return Ok(false);
            }
        }
    }

    /// Removes folder and memory. The caller holds the lock.
    fn sweep(&self) -> Result<(), DomainError> {
        sweep_memory(&prefix_of(&self.run))?;
        sweep_folder(&self.folder, true)
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

    /// What the names of this run's shared memory begin with.
    #[must_use]
    pub fn memory_prefix(&self) -> String {
        format!("{}{:06x}_", prefix_of(&self.run), self.nonce & 0xFF_FFFF)
    }

    /// What a run has on this machine right now: its folder and its shared
    /// memory. Empty for a run that left nothing behind.
    #[must_use]
    pub fn traces(run: &RunName) -> Vec<PathBuf> {
        let folder = Self::base().join(run.as_str());
        let mut traces: Vec<PathBuf> = folder.exists().then_some(folder).into_iter().collect();
        traces.extend(memory_files(&prefix_of(run)));
        traces
    }

    /// Files of this user in shared memory that no run of ours has made, by name.
    #[must_use]
    pub fn other_memory() -> Vec<PathBuf> {
        memory_of_runs(false)
    }

    /// Removes all that a run has on this machine, whoever uses it: for a
    /// server that must end at once. What cannot be removed stays.
    pub fn remove_traces(run: &RunName) {
        let _ = sweep_memory(&prefix_of(run));
        let _ = sweep_folder(&Self::base().join(run.as_str()), true);
    }

    /// The transport's configuration for this domain. Given in code: a
    /// configuration file in the working directory must change nothing.
    pub(crate) fn transport(&self) -> Result<Config, crate::LinkError> {
        let mut config = Config::default();
        let root = iceoryx2::prelude::Path::new(self.folder.as_os_str().as_encoded_bytes())
            .map_err(crate::LinkError::transport("use the run's folder"))?;
        config.global.set_root_path(&root);
        config.global.prefix = FileName::new(self.memory_prefix().as_bytes())
            .map_err(crate::LinkError::transport("use the run's prefix"))?;
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
            let _ = self.sweep();
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
        let folder = Domain::base().join(dead.as_str());
        fs::create_dir_all(folder.join("services")).unwrap();
        fs::write(folder.join("services/x"), "x").unwrap();
        let memory = Path::new("/dev/shm").join(format!("{}x", prefix_of(&dead)));
        fs::write(&memory, "x").unwrap();
        let corpse = Domain { run: dead.clone(), folder: folder.clone(), nonce: 0, lock: None };
        assert!(corpse.sweep_if_dead().unwrap());
        assert!(!folder.exists() && !memory.exists());
        let view = Domain::find(&alive).unwrap();
        assert!(!view.sweep_if_dead().unwrap());
        assert!(living.folder().exists());
    }

    #[test]
    fn memory_without_a_folder_is_an_orphan_unless_it_is_not_ours() {
        let living = Domain::create(&name("kept")).unwrap();
        let file = |text: &str| {
            let path = Path::new("/dev/shm").join(text);
            fs::write(&path, "x").unwrap();
            path
        };
        let orphan = file(&format!("{}0a1b2c_x", prefix_of(&name("orphan"))));
        let kept = file(&format!("{}x", living.memory_prefix()));
        let strange = file(&format!("rusty-nail-{}", std::process::id()));
        assert!(Domain::sweep_orphans().unwrap().contains(&orphan));
        assert!(!orphan.exists() && kept.exists() && strange.exists());
        fs::remove_file(strange).unwrap();
        drop(living);
        assert!(!kept.exists());
    }
}
