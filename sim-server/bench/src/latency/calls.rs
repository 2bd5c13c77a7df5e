//! How many system calls a tick makes, counted by `strace` in separate
//! runs: two lengths of the same run, so that what starting and ending take
//! cancels out.
//!
//! `sched_yield` is left out. It blocks no process, and with a filter in the kernel
//! (`--seccomp-bpf`) the calls that are not counted are not slowed down either,
//! so everyone waits as without `strace`.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group};

use rusty_engine::run::{Stop, kill_group};

/// Between two looks whether they are done.
const LOOK: Duration = Duration::from_millis(10);

/// How long those who are asked to end may take.
const PATIENCE: Duration = Duration::from_secs(10);

/// Calls of all processes of a run together for each tick, by name, `sched_yield`
/// left out; or why they were not counted. Those of which the longer run made no
/// more than the shorter one are left out, too.
pub(super) type Calls = Result<BTreeMap<String, f64>, String>;

/// Returns the most frequent calls as text.
pub(super) fn text(calls: &Calls) -> String {
    let calls = match calls {
        Ok(calls) => calls,
        Err(why) => return format!("not counted: {why}"),
    };
    let names = calls.iter().filter(|(_, n)| **n >= 5e-4);
    names.map(|(name, n)| format!("{name} {n:.3}")).collect::<Vec<_>>().join(", ")
}

/// Counts the system calls of `sim-server launch ARGS`, to which the number of
/// ticks is added: a run of each of two `lengths`. What `strace` writes goes
/// into `folder`.
pub(super) fn count(args: &[String], lengths: [usize; 2], folder: &Path, stop: &Stop) -> Calls {
    let short = count_once(args, lengths[0], folder, stop)?;
    let long = count_once(args, lengths[1], folder, stop)?;
    let ticks = lengths[1].saturating_sub(lengths[0]).max(1) as f64;
    let more = |(name, calls): (String, u64)| {
        let before = short.get(&name).copied().unwrap_or(0);
        (calls > before).then(|| (name, (calls - before) as f64 / ticks))
    };
    Ok(long.into_iter().filter_map(more).collect())
}

/// Asks a launch under `strace` to end, as Ctrl-C does. Not killed at once:
/// without their tracer, whom it counts would get no system call through, not
/// even the one that ends them.
fn interrupt_group(leader: u32) {
    if let Some(leader) = i32::try_from(leader).ok().and_then(Pid::from_raw) {
        // It may have ended by itself.
        let _ = kill_process_group(leader, Signal::INT);
    }
}

fn count_once(
    args: &[String],
    ticks: usize,
    folder: &Path,
    stop: &Stop,
) -> Result<BTreeMap<String, u64>, String> {
    let counts = folder.join("calls");
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let mut command = Command::new("strace");
    command
        .args(["--follow-forks", "--seccomp-bpf", "--trace=!sched_yield", "--summary-only", "-o"])
        .arg(&counts)
        .arg(program)
        .args(args)
        .args(["--ticks", &ticks.to_string()])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0);
    let mut child = command.spawn().map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => "strace is not installed; apt install strace".to_owned(),
        _ => format!("strace cannot be started: {e}"),
    })?;
    let mut told = None;
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if stop.is_raised() => match told {
                None => {
                    interrupt_group(child.id());
                    told = Some(Instant::now());
                }
                Some(since) if since.elapsed() > PATIENCE => {
                    kill_group(child.id());
                    let _ = child.wait();
                    return Err("stopped".to_owned());
                }
                Some(_) => std::thread::sleep(LOOK),
            },
            Ok(None) => std::thread::sleep(LOOK),
            Err(e) => return Err(format!("strace: {e}")),
        }
    };
    if told.is_some() {
        return Err("stopped".to_owned());
    }
    if !status.success() {
        return Err(format!("strace ended with {status}; may this user trace processes?"));
    }
    let text = fs::read_to_string(&counts).map_err(|e| format!("strace wrote nothing: {e}"))?;
    Ok(parse(&text))
}

/// The table of `strace --summary-only`: share, seconds, time per call, calls,
/// errors where there are any, name.
fn parse(table: &str) -> BTreeMap<String, u64> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split_whitespace().collect();
        let name = *cells.last().filter(|name| **name != "total")?;
        Some((name.to_owned(), cells.get(3).filter(|_| cells.len() > 4)?.parse().ok()?))
    };
    table.lines().filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_calls_is_read() {
        let table = "\
% time     seconds  usecs/call     calls    errors syscall
------ ----------- ----------- --------- --------- ----------------
 66.67    0.000200           1       120        20 poll
 33.33    0.000100           2        50           read
------ ----------- ----------- --------- --------- ----------------
100.00    0.000300           1       170        20 total
";
        let calls = parse(table);
        assert_eq!(calls, [("poll".to_owned(), 120), ("read".to_owned(), 50)].into());
    }

    #[test]
    fn what_was_not_counted_says_why() {
        assert_eq!(text(&Err("no reason".to_owned())), "not counted: no reason");
        let calls = [("poll".to_owned(), 0.25), ("brk".to_owned(), 1e-4)].into();
        assert_eq!(text(&Ok(calls)), "poll 0.250");
    }
}
