//! Processes with a watchdog, and what they leave when they end.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

use rusty_contract::RunName;
use rusty_link::Domain;
use serde_json::Value;
use signal_hook::consts::SIGINT;
use signal_hook::flag::register_conditional_shutdown;

use crate::{Folder, WATCHDOG, arg, binary, folder, fresh_run, participants};

/// What a process left when it ended.
#[derive(Debug)]
pub struct Ended {
    /// Exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    /// The JSON document on stdout.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|e| panic!("stdout is no JSON document ({e}):\n{self:#?}"))
    }

    /// Fails the test unless the exit code is this one.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// Fails the test unless stderr contains these words.
    #[track_caller]
    pub fn says(&self, words: &str) -> &Self {
        assert!(self.stderr.contains(words), "{words:?} is not on stderr of {self:#?}");
        self
    }

    /// Fails the test unless stdout contains these words.
    #[track_caller]
    pub fn prints(&self, words: &str) -> &Self {
        assert!(self.stdout.contains(words), "{words:?} is not on stdout of {self:#?}");
        self
    }
}

/// A process with a watchdog, which ends it in [`wait`](Self::wait).
pub struct Process {
    child: Child,
    stdout: std::thread::JoinHandle<String>,
    stderr: std::thread::JoinHandle<String>,
    what: String,
}

/// Lets programs that are started from now on end by SIGINT, also where these tests run in
/// the background of a shell, which ignores it: a program inherits that, but no handler.
fn heed_interrupts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        register_conditional_shutdown(SIGINT, 130, Arc::new(AtomicBool::new(true))).unwrap();
    });
}

fn collect(mut pipe: impl std::io::Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = pipe.read_to_end(&mut text);
        String::from_utf8_lossy(&text).into_owned()
    })
}

impl Process {
    /// Starts a program of ours.
    pub fn start(program: &str, args: &[&str]) -> Self {
        Self::spawn(Command::new(binary(program)).args(args))
    }

    /// Starts any command.
    pub fn spawn(command: &mut Command) -> Self {
        heed_interrupts();
        let what = format!("{command:?}");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|e| panic!("{what}: {e}"));
        let stdout = collect(child.stdout.take().unwrap());
        let stderr = collect(child.stderr.take().unwrap());
        Self { child, stdout, stderr, what }
    }

    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal.
    pub fn signal(&self, signal: rustix::process::Signal) {
        send_signal(self.pid(), signal);
    }

    /// Waits for the end, under the watchdog.
    #[track_caller]
    pub fn wait(self) -> Ended {
        self.wait_within(WATCHDOG)
    }

    /// The same under a shorter one: for what must not come about by a timeout
    /// of the run.
    #[track_caller]
    pub fn wait_within(mut self, limit: Duration) -> Ended {
        let deadline = Instant::now() + limit;
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            if Instant::now() > deadline {
                let _ = self.child.kill();
                let _ = self.child.wait();
                let (out, err) = (self.stdout.join().unwrap(), self.stderr.join().unwrap());
                panic!("{} hangs.\nstdout: {out}\nstderr: {err}", self.what);
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        let (stdout, stderr) = (self.stdout.join().unwrap(), self.stderr.join().unwrap());
        Ended { code: status.code(), stdout, stderr }
    }
}

/// Sends a signal to a process.
pub fn send_signal(pid: u32, signal: rustix::process::Signal) {
    let pid = rustix::process::Pid::from_raw(pid as i32).unwrap();
    let _ = rustix::process::kill_process(pid, signal);
}

/// Runs a program of ours to its end.
#[track_caller]
pub fn execute(program: &str, args: &[&str]) -> Ended {
    Process::start(program, args).wait()
}

/// Runs `sim-server` to its end.
#[track_caller]
pub fn sim_server(args: &[&str]) -> Ended {
    execute("sim-server", args)
}

/// A shell that runs this script, in which `"$0" "$@"` is the program with its arguments.
pub fn shell(script: &str, program: &str, args: &[&str]) -> Command {
    let mut shell = Command::new("sh");
    shell.args(["-c", script]).arg(binary(program)).args(args);
    shell
}

/// A verb that makes a run, with `--json` and a fresh name, in a folder; fails if
/// it leaves anything behind.
#[track_caller]
pub fn run_to(tag: &str, out: &Path, args: &[&str]) -> Ended {
    let run = fresh_run(tag);
    let ended = sim_server(&[args, &["--json", "--run", run.as_str(), "--out", arg(out)]].concat());
    assert_eq!(participants(&run), [], "processes of the run live on");
    nothing_left(&run);
    ended
}

/// A whole run by `launch --json` in a separate folder, exit code 0
/// expected; fails if it leaves anything behind.
#[track_caller]
pub fn launch(tag: &str, out: &Path, args: &[&str]) -> Value {
    launch_to(tag, out, args, 0)
}

/// The same, with another exit code expected. A run that was in the folder before
/// is replaced.
#[track_caller]
pub fn launch_to(tag: &str, out: &Path, args: &[&str], code: i32) -> Value {
    run_to(tag, out, &[&["launch", "--force"], args].concat()).expect(code).json()
}

/// A run by `launch` in a new folder, and its log.
#[track_caller]
pub fn logged(tag: &str, args: &[&str]) -> (Folder, PathBuf) {
    let out = folder();
    launch(tag, out.path(), args);
    let log = out.at("run.log");
    (out, log)
}

/// Plays a log into a folder.
#[track_caller]
pub fn replay(log: &Path, out: &Path, args: &[&str]) -> Ended {
    run_to("replay", out, &[&["replay", arg(log)], args].concat())
}

/// Imports a CARMEN log.
#[track_caller]
pub fn import(input: &Path, output: &Path, args: &[&str]) -> Ended {
    sim_server(&[&["import", "carmen", arg(input), "-o", arg(output)], args].concat())
}

/// Makes a blind log and its key.
#[track_caller]
pub fn seal(log: &Path, blind: &Path, key: &Path) -> Ended {
    sim_server(&["seal", arg(log), "-o", arg(blind), "--key-file", arg(key), "--json"])
}

/// Runs a verb about a log.
#[track_caller]
pub fn about(verb: &str, log: &Path, args: &[&str]) -> Ended {
    sim_server(&[&[verb, arg(log)], args].concat())
}

/// Fails if the run has left anything in shared memory or its folder. Another
/// server that starts, or `clean`, sweeps at the same time: one that looks at a folder
/// in the moment in which it goes makes it once more, takes its lock, and
/// removes it. What is still there after that was left.
#[track_caller]
pub fn nothing_left(run: &RunName) {
    const SWEEPER: Duration = Duration::from_secs(5);
    let deadline = Instant::now() + SWEEPER;
    loop {
        let traces = Domain::traces(run);
        if traces.is_empty() {
            return;
        }
        assert!(Instant::now() < deadline, "left behind: {traces:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
