//! The viewer under test: `view`, or `launch --watch`, and the address it prints.

use std::io::{BufRead as _, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use rusty_contract::RunName;

use crate::{arg, binary, until};

/// A program that prints the address of a page.
pub struct Viewed {
    pub child: Child,
    output: Printed,
    errors: Printed,
    pub address: String,
}

/// What a program has printed up to now. A thread reads it: a pipe that another process
/// keeps open would otherwise hold up a test for ever.
struct Printed {
    text: Arc<Mutex<String>>,
    reader: JoinHandle<()>,
}

impl Printed {
    fn of(pipe: impl Read + Send + 'static) -> Self {
        let text = Arc::new(Mutex::new(String::new()));
        let shared = Arc::clone(&text);
        let reader = std::thread::spawn(move || {
            let mut lines = BufReader::new(pipe);
            let mut line = String::new();
            while lines.read_line(&mut line).is_ok_and(|n| n > 0) {
                shared.lock().unwrap().push_str(&line);
                line.clear();
            }
        });
        Self { text, reader }
    }

    fn text(&self) -> String {
        self.text.lock().unwrap().clone()
    }

    /// The rest of the first whole line that begins so.
    fn line(&self, beginning: &str) -> Option<String> {
        let text = self.text();
        let mut whole = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        whole.find_map(|line| Some(line.strip_prefix(beginning)?.trim().to_owned()))
    }

    /// All of it, once the pipe is closed.
    #[track_caller]
    fn all(&self) -> String {
        until("the end of the output", || self.reader.is_finished());
        self.text()
    }
}

impl Viewed {
    /// `view` with these arguments.
    #[track_caller]
    pub fn view(args: &[&str]) -> Self {
        let mut viewed = Self::start(Command::new(binary("view")).arg("--no-open").args(args));
        viewed.address = viewed.first(|viewed| viewed.output.line(""));
        viewed
    }

    /// `launch --watch` with these arguments.
    #[track_caller]
    pub fn launch(run: &RunName, out: &Path, args: &[&[&str]]) -> Self {
        let mut command = Command::new(binary("sim-server"));
        command.args(["launch", "--watch", "--json", "--run", run.as_str(), "--out", arg(out)]);
        let mut viewed = Self::start(command.args(args.concat()));
        viewed.address = viewed.first(|viewed| viewed.errors.line("watch "));
        viewed
    }

    fn start(command: &mut Command) -> Self {
        for display in ["DISPLAY", "WAYLAND_DISPLAY"] {
            command.env_remove(display);
        }
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let output = Printed::of(child.stdout.take().unwrap());
        let errors = Printed::of(child.stderr.take().unwrap());
        Self { child, output, errors, address: String::new() }
    }

    /// Waits for a line, under the watchdog; empty if the program has ended without it.
    #[track_caller]
    fn first(&self, line: impl Fn(&Self) -> Option<String>) -> String {
        let mut found = None;
        until("the address of the page", || {
            let is_over = self.output.reader.is_finished() && self.errors.reader.is_finished();
            found = line(self);
            found.is_some() || is_over
        });
        found.unwrap_or_default()
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

    /// What it has printed on its standard output up to now.
    pub fn printed(&self) -> String {
        self.output.text()
    }

    /// Waits for the end, with this exit code; returns what it printed.
    #[track_caller]
    pub fn ends_with(mut self, code: i32) -> (String, String) {
        let mut status = None;
        until("the end", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        let (output, errors) = (self.output.all(), self.errors.all());
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
