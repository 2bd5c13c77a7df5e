//! One measurement: a server's process, started and waited for.

use std::fs::{self, File};
use std::io::Read as _;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::cli::ServerPlan;
use crate::error::BenchError;
use crate::meter::Measured;
use crate::stop::Stop;

/// Starts a server and its clients by `plan` and waits for what they measure.
/// Nothing of them is left when this returns.
///
/// # Errors
/// [`BenchError::NoResult`] in the server's last words; [`BenchError::Stopped`].
pub fn run(plan: &ServerPlan, stop: &Stop) -> Result<Measured, BenchError> {
    let said = plan.cell.folder.with_extension("said");
    let outcome = started(plan, stop, &said);
    let _ = fs::remove_file(&said);
    if stop.is_raised() { Err(BenchError::Stopped) } else { outcome }
}

fn started(plan: &ServerPlan, stop: &Stop, said: &Path) -> Result<Measured, BenchError> {
    let mut command = Command::new("/proc/self/exe");
    command.arg("server").args(plan.to_args());
    command.stdin(Stdio::null()).stdout(Stdio::piped());
    command.stderr(File::create(said).map_err(BenchError::io(said))?);
    // Ctrl-C on the terminal reaches this process alone; it tells the server.
    command.process_group(0);
    let mut server = Group(command.spawn().map_err(BenchError::io(Path::new("/proc/self/exe")))?);
    stop.covers(server.0.id());
    let mut text = String::new();
    let read = server.0.stdout.take().map(|mut out| out.read_to_string(&mut text));
    let status = server.0.wait();
    stop.covers(0);
    read.transpose().map_err(BenchError::io(Path::new("a server's stdout")))?;
    let status = status.map_err(BenchError::io(Path::new("a server's end")))?;
    if status.success() {
        return serde_json::from_str(&text).map_err(|e| BenchError::NoResult(e.to_string()));
    }
    let words = fs::read_to_string(said).unwrap_or_default();
    let words = words.lines().rev().find(|line| !line.trim().is_empty());
    Err(BenchError::NoResult(words.map_or_else(|| status.to_string(), str::to_owned)))
}

/// A server and whoever is in its process group. What still lives is killed.
struct Group(Child);

impl Drop for Group {
    fn drop(&mut self) {
        if let Some(leader) = i32::try_from(self.0.id()).ok().and_then(Pid::from_raw) {
            let _ = kill_process_group(leader, Signal::KILL);
        }
        let _ = self.0.wait();
    }
}
