//! The viewer: what its page shows, that it costs a run nothing, who may see and drive.

mod attacks;
mod costs;
mod driving;
mod page;

use std::io::{BufRead as _, BufReader, Read as _};
use std::net::TcpStream;
use std::process::{Child, ChildStdout, Stdio};
use std::thread::JoinHandle;

use rusty_tests::*;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// A program that prints the address of a page.
struct Viewed {
    child: Child,
    output: Option<BufReader<ChildStdout>>,
    errors: JoinHandle<String>,
    address: String,
}

impl Viewed {
    /// `view` with these arguments.
    fn view(args: &[&str]) -> Self {
        let mut viewed = Self::start(Command::new(binary("view")).arg("--no-open").args(args));
        let mut line = String::new();
        viewed.output.as_mut().unwrap().read_line(&mut line).unwrap();
        viewed.address = line.trim().to_owned();
        viewed
    }

    /// `launch --watch` with these arguments.
    fn launch(run: &RunName, out: &Path, args: &[&[&str]]) -> Self {
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

    fn port(&self) -> u16 {
        let port = self.address.split(['/', ':']).nth(4).unwrap_or_default();
        port.parse().unwrap_or_else(|_| panic!("no port in {:?}", self.address))
    }

    /// The part of the address with the tokens.
    fn tokens(&self) -> &str {
        self.address.split_once('#').unwrap().1
    }

    fn view_token(&self) -> &str {
        self.tokens().split('&').next().unwrap().strip_prefix("view=").unwrap()
    }

    /// A page without a browser.
    fn page(&self) -> Page {
        let origin = format!("http://127.0.0.1:{}", self.port());
        let mut page = Page::connect(self.port(), &origin).expect("the socket opens");
        let token = format!(r#"{{"view":"{}"}}"#, self.view_token());
        page.0.send(Message::text(token)).unwrap();
        page
    }

    /// Waits for the end, with this exit code; returns what it printed.
    #[track_caller]
    fn ends_with(mut self, code: i32) -> (String, String) {
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

/// The socket of a page.
struct Page(WebSocket<TcpStream>);

impl Page {
    fn connect(port: u16, origin: &str) -> Option<Self> {
        let mut request = format!("ws://127.0.0.1:{port}/socket").into_client_request().unwrap();
        request.headers_mut().insert("Origin", origin.parse().unwrap());
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(WATCHDOG)).unwrap();
        tungstenite::client(request, stream).ok().map(|(socket, _)| Self(socket))
    }

    /// Reads until a message in JSON is the one that is wanted; returns it and the number
    /// of bytes of records before it.
    #[track_caller]
    fn until(&mut self, is_it: impl Fn(&Value) -> bool) -> (Value, usize) {
        let mut bytes = 0;
        loop {
            match self.0.read().expect("a message") {
                Message::Text(text) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    if is_it(&message) {
                        return (message, bytes);
                    }
                }
                Message::Binary(records) => bytes += records.len(),
                other => panic!("{other:?}"),
            }
        }
    }

    fn ask(&mut self, request: &Value) {
        self.0.send(Message::text(request.to_string())).unwrap();
    }
}
