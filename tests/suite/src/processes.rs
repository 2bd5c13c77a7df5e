//! Processes of the machine, as the kernel lists them.

use std::fs;
use std::os::fd::OwnedFd;

use rustix::process::{Pid, PidfdFlags, pidfd_open};
use rusty_contract::RunName;

/// Number and command line of every process.
pub fn processes() -> Vec<(u32, Vec<String>)> {
    let entries = fs::read_dir("/proc").unwrap().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let words = |pid| {
        let line = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        line.split(|b| *b == 0).map(|word| String::from_utf8_lossy(word).into_owned()).collect()
    };
    pids.map(|pid| (pid, words(pid))).collect()
}

/// The processes that have the run's name on their command line.
pub fn processes_of(run: &RunName) -> Vec<(u32, Vec<String>)> {
    let mut all = processes();
    all.retain(|(_, words)| words.iter().any(|word| word == run.as_str()));
    all
}

/// The processes of a run but its server: those that are told `--run NAME`
/// and a separate name, or are called by their program.
pub fn participants(run: &RunName) -> Vec<(u32, String)> {
    let clients = processes_of(run).into_iter().filter(|(_, w)| !w[0].ends_with("sim-server"));
    let name = |words: Vec<String>| {
        words.iter().skip_while(|w| *w != "--name").nth(1).unwrap_or(&words[0]).clone()
    };
    clients.map(|(pid, words)| (pid, name(words))).collect()
}

/// A field of a process's status; empty if it has ended.
pub fn status(pid: u32, key: &str) -> String {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let value = status.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'));
    value.unwrap_or_default().trim().to_owned()
}

/// Whether a signal has stopped a process.
pub fn is_stopped(pid: u32) -> bool {
    status(pid, "State").starts_with('T')
}

/// Whether a process has ended, even if its parent has not waited for it yet.
pub fn has_ended(pid: u32) -> bool {
    fs::read(format!("/proc/{pid}/cmdline")).map_or(true, |line| line.is_empty())
}

/// A process held by a descriptor: its number cannot become another's.
pub fn hold(pid: u32) -> Option<OwnedFd> {
    pidfd_open(Pid::from_raw(pid as i32)?, PidfdFlags::empty()).ok()
}
