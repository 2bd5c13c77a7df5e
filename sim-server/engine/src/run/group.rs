//! The process group of a participant: all that it started, unless it left.

use std::collections::BTreeSet;
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Child, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rustix::process::{
    Pid, Signal, WaitId, WaitIdOptions, WaitOptions, getpid, kill_process_group,
    set_child_subreaper, waitid, waitpgid,
};

fn pid_of(number: u32) -> Option<Pid> {
    i32::try_from(number).ok().and_then(Pid::from_raw)
}

/// Kills a process and all that it started in its group.
pub fn kill_group(leader: u32) {
    if let Some(pid) = pid_of(leader) {
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

/// Returns how a child has ended, if it has. It is not waited for: until then no
/// other process gets its number, nor that of its group.
pub(super) fn exit_status(child: &Child) -> Option<ExitStatus> {
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    let ended = waitid(WaitId::Pid(pid_of(child.id())?), options).ok()??;
    let code = ended.exit_status().map(|code| (code & 0xFF) << 8);
    Some(ExitStatus::from_raw(code.or(ended.terminating_signal())?))
}

/// The groups whose leaders were started and not waited for. Only these are
/// signalled: the number of a leader that was waited for may belong to a group
/// of another user's program.
#[derive(Clone, Debug, Default)]
pub struct Groups(Arc<Mutex<BTreeSet<u32>>>);

impl Groups {
    fn lock(&self) -> MutexGuard<'_, BTreeSet<u32>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether this is one of them.
    pub(super) fn has(&self, leader: u32) -> bool {
        self.lock().contains(&leader)
    }

    /// Starts a leader. [`end_with_all`](Self::end_with_all) does not miss it.
    pub(super) fn start<E>(&self, spawn: impl FnOnce() -> Result<Child, E>) -> Result<Child, E> {
        let mut groups = self.lock();
        let child = spawn()?;
        groups.insert(child.id());
        Ok(child)
    }

    /// Kills a leader and its group. Does nothing if it was waited for.
    pub(super) fn kill(&self, leader: &mut Child) {
        if self.lock().contains(&leader.id()) {
            kill_group(leader.id());
            // It may have left the group it was given.
            let _ = leader.kill();
        }
    }

    /// Waits for a leader, whose group is never signalled again. Returns whether
    /// it had not been waited for.
    pub(super) fn wait(&self, leader: &mut Child) -> bool {
        let is_new = self.lock().remove(&leader.id());
        let _ = leader.wait();
        is_new
    }

    /// Kills all groups, then calls `end`, which does not return: no group is
    /// started meanwhile.
    pub(super) fn end_with_all(&self, end: impl FnOnce()) {
        let groups = self.lock();
        groups.iter().copied().for_each(kill_group);
        end();
    }
}

/// Makes processes whose parent has ended children of this process, so that
/// their end can be waited for.
pub(super) fn adopt_orphans() {
    // A kernel that refuses leaves them to another process; they are killed all
    // the same.
    let _ = set_child_subreaper(Some(getpid()));
}

/// Waits until a group that was killed is empty. An orphan is a child of this
/// process before its parent's end can be waited for, so none is missed.
pub(super) fn wait_for_group(leader: u32) {
    let Some(group) = pid_of(leader) else { return };
    let wait = || waitpgid(group, WaitOptions::empty());
    while matches!(rustix::io::retry_on_intr(wait), Ok(Some(_))) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::process::CommandExt as _;
    use std::process::Command;

    #[test]
    fn a_group_that_was_killed_is_empty_once_waited_for() {
        adopt_orphans();
        let mut shell = Command::new("sh");
        shell.args(["-c", "(sleep 300 & sleep 300) & exit 0"]).process_group(0);
        let mut leader = shell.spawn().unwrap();
        while exit_status(&leader).is_none() {
            std::thread::yield_now();
        }
        let group = pid_of(leader.id()).unwrap();
        let is_there = || rustix::process::test_kill_process_group(group);
        assert_eq!(is_there(), Ok(()));
        kill_group(leader.id());
        leader.wait().unwrap();
        wait_for_group(leader.id());
        assert_eq!(is_there(), Err(rustix::io::Errno::SRCH));
    }

    #[test]
    fn a_group_whose_leader_was_waited_for_is_never_signalled() {
        let groups = Groups::default();
        let start = |script: &str| {
            let mut shell = Command::new("sh");
            groups.start(|| shell.args(["-c", script]).process_group(0).spawn()).unwrap()
        };
        let (mut waited, mut other) = (start("sleep 300 & exit 7"), start("sleep 300"));
        let status = loop {
            match exit_status(&waited) {
                Some(status) => break status,
                None => std::thread::yield_now(),
            }
        };
        assert_eq!(status.code(), Some(7));
        assert!(groups.wait(&mut waited) && !groups.wait(&mut waited));
        groups.kill(&mut waited);
        groups.end_with_all(|| ());
        assert_eq!(other.wait().unwrap().signal(), Some(9));
        // The number of the first is that of its group, which lives.
        let group = pid_of(waited.id()).unwrap();
        assert_eq!(rustix::process::test_kill_process_group(group), Ok(()));
        kill_group(waited.id());
    }
}
