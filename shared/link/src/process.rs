//! What the kernel says of a process: running, stopped, dead.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};

/// Another process, held by a descriptor, so that its number cannot be
/// mistaken for that of a later process.
#[derive(Debug)]
pub struct Peer {
    pid: u32,
    fd: Option<OwnedFd>,
}

/// What the kernel says of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PeerState {
    /// It lives.
    Running,
    /// It lives but is stopped (SIGSTOP, a debugger).
    Stopped,
    /// It has ended.
    Dead,
}

impl Peer {
    /// Takes hold of a process. One that cannot be held counts as dead: it has
    /// ended already, or lives where the kernel does not let us see it.
    #[must_use]
    pub fn new(pid: u32) -> Self {
        let fd = i32::try_from(pid)
            .ok()
            .and_then(Pid::from_raw)
            .and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        Self { pid, fd }
    }

    /// Its number.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.pid
    }

    /// A descriptor that becomes readable when the process ends.
    #[must_use]
    pub fn fd(&self) -> Option<BorrowedFd<'_>> {
        self.fd.as_ref().map(AsFd::as_fd)
    }

    /// Whether it has ended. One system call.
    #[must_use]
    pub fn is_dead(&self) -> bool {
        let Some(fd) = &self.fd else { return true };
        let mut fds = [PollFd::new(fd, PollFlags::IN)];
        poll(&mut fds, Some(&Timespec::default())).is_ok_and(|n| n > 0)
    }

    /// What the kernel says of it now.
    #[must_use]
    pub fn state(&self) -> PeerState {
        if self.is_dead() {
            return PeerState::Dead;
        }
        // The state follows the command name, which is in parentheses and may
        // hold any character.
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.pid)).unwrap_or_default();
        match stat.rsplit_once(')').and_then(|(_, rest)| rest.trim_start().chars().next()) {
            Some('T' | 't') => PeerState::Stopped,
            Some('Z' | 'X') => PeerState::Dead,
            _ => PeerState::Running,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn running_stopped_and_dead_are_told_apart() {
        let mut child = Command::new("sleep").arg("60").spawn().unwrap();
        let peer = Peer::new(child.id());
        assert_eq!(peer.state(), PeerState::Running);
        let pid = Pid::from_raw(child.id() as i32).unwrap();
        rustix::process::kill_process(pid, rustix::process::Signal::STOP).unwrap();
        while peer.state() != PeerState::Stopped {
            std::thread::yield_now();
        }
        child.kill().unwrap();
        while peer.state() != PeerState::Dead {
            std::thread::yield_now();
        }
        child.wait().unwrap();
        assert_eq!(peer.state(), PeerState::Dead);
        assert_eq!(Peer::new(0).state(), PeerState::Dead);
    }
}
