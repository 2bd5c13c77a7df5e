//! The process group of a participant: all that it started, unless it left.

use std::process::Child;

use rustix::process::{
    Pid, Signal, WaitId, WaitIdOptions, WaitOptions, getpid, kill_process_group,
    set_child_subreaper, waitid, waitpgid,
};

fn pid_of(number: u32) -> Option<Pid> {
    i32::try_from(number).ok().and_then(Pid::from_raw)
}

/// Kills a process and all that it started in its group.
pub(crate) fn kill_group(leader: u32) {
    if let Some(pid) = pid_of(leader) {
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

/// Returns whether a child has ended. It is not waited for: until then no other
/// process gets its number, nor that of its group.
pub(crate) fn has_exited(child: &Child) -> bool {
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    let ended = pid_of(child.id()).and_then(|pid| waitid(WaitId::Pid(pid), options).ok().flatten());
    ended.is_some()
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
        while !has_exited(&leader) {
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
}
