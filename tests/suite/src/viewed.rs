//! The viewer under test: `view`, or `launch --watch`, and the address it prints.

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::JoinHandle;

use rusty_contract::RunName;

use crate::{arg, binary, until};

/// A program that prints the address of a page.
pub struct Viewed {
    pub child: Child,
    output: Option<BufReader<ChildStdout>>,
    errors: JoinHandle<String>,
    pub address: String,
}

impl Viewed {
    /// `view` with these arguments.
    pub fn view(args: &[&str]) -> Self {
        let mut viewed = Self::start(Command::new(binary("view")).arg("--no-open").args(args));
        let mut line = String::new();
        viewed.output.as_mut().unwrap().read_line(&mut line).unwrap();
        viewed.address = line.trim().to_owned();
        viewed
    }

    /// `launch --watch` with these arguments.
    pub fn launch(run: &RunName, out: &Path, args: &[&[&str]]) -> Self {
        let mut command = Command::new(binary("sim-server"));
        command.args(["launch", "--watch", "--json", "--run", run.as_str(), "--out", arg(out)]);
        Self::start(command.args(args.concat()))
    }

    fn start(command: &mut Command) -> Self {
        for display in ["DISPLAY", "WAYLAND_DISPLAY"] {
            command.env_remove(display);
        }
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut errors = BufReader::new(child.stderr.take().unwrap());
        let output = child.stdout.take().map(BufReader::new);
        let (mut address, mut text) = (String::new(), String::new());
        let is_launch = command.get_args().next() == Some("launch".as_ref());
        while is_launch && address.is_empty() && errors.read_line(&mut text).unwrap() > 0 {
            let last = text.lines().next_back().unwrap_or_default();
            address = last.strip_prefix("watch ").unwrap_or_default().to_owned();
        }
        let errors = std::thread::spawn(move || {
            let _ = errors.read_to_string(&mut text);
            text
        });
        Self { child, output, errors, address }
    }

    pub fn port(&self) -> u16 {
        let port = self.address.split(['/', ':']).nth(4).unwrap_or_default();
        port.parse().unwrap_or_else(|_| panic!("no port in {:?}", self.address))
    }

    /// The part of the address with the tokens.
    pub fn tokens(&self) -> &str {
        self.address.split_once('#').unwrap().1
    }

    pub fn view_token(&self) -> &str {
        self.tokens().split('&').next().unwrap().strip_prefix("view=").unwrap()
    }

    /// The address for apps.
    pub fn foxglove(&self) -> String {
        format!("ws://127.0.0.1:{}/foxglove?{}", self.port(), self.tokens())
    }

    /// Waits for the end, with this exit code; returns what it printed.
    #[track_caller]
    pub fn ends_with(mut self, code: i32) -> (String, String) {
        let mut status = None;
        until("the end", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        let mut output = String::new();
        self.output.take().unwrap().read_to_string(&mut output).unwrap();
        let none = std::thread::spawn(String::new);
        let errors = std::mem::replace(&mut self.errors, none).join().unwrap();
        assert_eq!(status.unwrap().code(), Some(code), "{output}\n{errors}");
        (output, errors)
    }
}

impl Drop for Viewed {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
