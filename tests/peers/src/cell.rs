//! One measurement: a server's process, started and waited for.

use std::io::Read;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};

use rustix::io::Errno;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};

use crate::cli::ServerPlan;
use crate::error::BenchError;
use crate::meter::Measured;
use crate::stop::Stop;

/// Starts a server and its clients by `plan` and waits for what they measure.
/// No process of them is left when this returns.
pub fn run(plan: &ServerPlan, stop: &Stop) -> Result<Measured, BenchError> {
    let program = Path::new("/proc/self/exe");
    let mut command = Command::new(program);
    command.arg("server").args(plan.to_args());
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // Ctrl-C on the terminal reaches this process alone; it tells the server.
    command.process_group(0);
    let mut server = command.spawn().map_err(BenchError::io(program))?;
    stop.covers(server.id());
    let measured = read(server.stdout.take());
    let status = end(&mut server, stop).map_err(BenchError::io(program))?;
    let words = read(server.stderr.take());
    if stop.is_raised() {
        return Err(BenchError::Stopped);
    }
    if status.success() {
        return serde_json::from_str(&measured).map_err(|e| BenchError::NoResult(e.to_string()));
    }
    let words = words.lines().rev().find(|line| !line.trim().is_empty());
    Err(BenchError::NoResult(words.map_or_else(|| status.to_string(), str::to_owned)))
}

/// All that comes; what cannot be read is missed later.
fn read(from: Option<impl Read>) -> String {
    let mut bytes = Vec::new();
    if let Some(mut from) = from {
        let _ = from.read_to_end(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Waits for the server's end and kills the processes that it left in its group. Its
/// number is not given to another process before that is done.
fn end(server: &mut Child, stop: &Stop) -> std::io::Result<ExitStatus> {
    let leader = Pid::from_child(server);
    let look = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT;
    while matches!(waitid(WaitId::Pid(leader), look), Err(Errno::INTR)) {}
    stop.covers(0);
    let _ = kill_process_group(leader, Signal::KILL);
    server.wait()
}
