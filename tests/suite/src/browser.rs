//! A browser that is driven as a person would: pages, keys, sizes, colours.
//!
//! It is Chromium without a window, spoken to in its DevTools protocol through
//! a pair of pipes: <https://chromedevtools.github.io/devtools-protocol/>. It has
//! a separate profile, which goes with it, and is told to ask no server for
//! anything.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use crate::{Folder, WATCHDOG, folder, skipped};

/// Names that the program goes by.
const PROGRAMS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// The file of what it says on its standard error.
const WORDS: &str = "words.txt";

/// What it is started with, so that it is alone with its page.
const ARGS: [&str; 12] = [
    "--headless",
    "--remote-debugging-pipe",
    // Tests run as root, too, and open nothing but their own files.
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-extensions",
    "--disable-sync",
    "--hide-scrollbars",
];

/// A browser with one page.
pub struct Browser {
    child: Child,
    input: ChildStdin,
    messages: Receiver<Value>,
    /// Events that no call has waited for yet.
    events: VecDeque<Value>,
    asked: u64,
    session: Option<String>,
    /// Its own folder, with what it said on its standard error.
    profile: Folder,
}

impl Browser {
    /// Starts one. `None`, with a printed reason, where there is none; one that
    /// is there and does not start is a failure.
    pub fn start() -> Option<Self> {
        let Some(program) = program() else {
            skipped(&format!("there is no {} in PATH", PROGRAMS.join(", no ")));
            return None;
        };
        Some(Self::of(&program, &[]))
    }

    /// Starts one with further arguments.
    pub fn start_with(args: &[&str]) -> Option<Self> {
        match program() {
            Some(program) => Some(Self::of(&program, args)),
            None => Self::start(),
        }
    }

    /// Starts a program that is a browser.
    fn of(program: &Path, args: &[&str]) -> Self {
        let profile = folder();
        let mut command = Command::new("sh");
        // It reads what it is asked from descriptor 3 and answers to 4.
        command.args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null"]);
        command.arg(program).args(ARGS).args(args);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        command.stderr(File::create(profile.at(WORDS)).unwrap());
        let mut child = command.spawn().unwrap();
        let (input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut output = BufReader::new(output);
            let mut bytes = Vec::new();
            while output.read_until(0, &mut bytes).is_ok_and(|n| n > 0) {
                let message = serde_json::from_slice(bytes.strip_suffix(&[0]).unwrap_or(&bytes));
                bytes.clear();
                if message.is_ok_and(|message| sender.send(message).is_err()) {
                    return;
                }
            }
        });
        let events = VecDeque::new();
        let mut browser = Self { child, input, messages, events, asked: 0, session: None, profile };
        let page = browser.ask("Target.createTarget", json!({ "url": "about:blank" }));
        let page = json!({ "targetId": page["targetId"], "flatten": true });
        let session = browser.ask("Target.attachToTarget", page);
        browser.session = Some(session["sessionId"].as_str().unwrap().to_owned());
        for part in ["Page", "Runtime", "Log", "Network"] {
            browser.ask(&format!("{part}.enable"), json!({}));
        }
        browser
    }

    /// Calls a method, and waits for what it returns.
    #[track_caller]
    pub fn ask(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let mut message = json!({ "id": self.asked, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        if let Err(why) = self.input.write_all(format!("{message}\0").as_bytes()) {
            self.is_gone(&why);
        }
        let deadline = Instant::now() + WATCHDOG;
        loop {
            let mut message = self.next(deadline);
            if message["id"] == self.asked {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].take();
            }
            self.events.push_back(message);
        }
    }

    /// The next message; other messages do not put the deadline off.
    #[track_caller]
    fn next(&mut self, deadline: Instant) -> Value {
        match self.messages.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(message) => message,
            Err(why) => self.is_gone(&why),
        }
    }

    /// Fails with what the browser said last.
    #[track_caller]
    fn is_gone(&mut self, why: &dyn std::fmt::Display) -> ! {
        let _ = self.child.kill();
        let ended = self.child.wait().unwrap();
        let words = std::fs::read(self.profile.path().join(WORDS)).unwrap_or_default();
        panic!("the browser is gone ({why}; {ended}): {}", String::from_utf8_lossy(&words));
    }

    /// Opens a file, at a place in it (`#…`) or at its beginning, and waits
    /// until all of it is there.
    #[track_caller]
    pub fn open(&mut self, file: &Path, place: &str) {
        // A place in the page that is open already would not load it again.
        self.visit(&format!("file://{}{place}", file.display()));
    }

    /// Opens an address, and waits until all of it is there.
    #[track_caller]
    pub fn visit(&mut self, address: &str) {
        for url in ["about:blank", address] {
            let opened = self.ask("Page.navigate", json!({ "url": url }));
            assert!(opened["errorText"].is_null(), "{url}: {opened}");
            self.loaded();
        }
    }

    /// Waits under the watchdog until an expression in the page is true.
    #[track_caller]
    pub fn until(&mut self, expression: &str) {
        crate::until(expression, || self.value(&format!("Boolean({expression})")) == true);
    }

    /// Goes to another page and comes back to this one.
    #[track_caller]
    pub fn leave_and_come_back(&mut self) {
        self.ask("Page.navigate", json!({ "url": "about:blank" }));
        self.loaded();
        self.value("history.back()");
        self.loaded();
    }

    #[track_caller]
    fn loaded(&mut self) {
        let is_it = |event: &Value| event["method"] == "Page.loadEventFired";
        if let Some(at) = self.events.iter().position(is_it) {
            self.events.remove(at);
            return;
        }
        let deadline = Instant::now() + WATCHDOG;
        loop {
            let message = self.next(deadline);
            if is_it(&message) {
                return;
            }
            self.events.push_back(message);
        }
    }

    /// The value of an expression in the page.
    #[track_caller]
    pub fn value(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true });
        let mut came = self.ask("Runtime.evaluate", params);
        assert!(came["exceptionDetails"].is_null(), "{expression}: {came}");
        came["result"]["value"].take()
    }

    /// Presses a key and lets go of it: its name, and its number on Windows.
    pub fn press(&mut self, key: &str, number: u32) {
        let text = if key == " " { " " } else { "" };
        self.key("keyDown", key, number, text);
        self.key("keyUp", key, number, text);
    }

    /// Presses a key (`keyDown`) or lets go of it (`keyUp`).
    pub fn key(&mut self, kind: &str, key: &str, number: u32, text: &str) {
        let code = if key == " " { "Space" } else { key };
        let key = json!({ "type": kind, "key": key, "code": code,
            "windowsVirtualKeyCode": number, "text": text });
        self.ask("Input.dispatchKeyEvent", key);
    }

    /// Moves the mouse (`mouseMoved`), presses its left button (`mousePressed`)
    /// or lets go of it (`mouseReleased`), at a place in CSS pixels.
    pub fn mouse(&mut self, what: &str, [x, y]: [f64; 2]) {
        let event = json!({ "type": what, "x": x, "y": y, "button": "left", "clickCount": 1 });
        self.ask("Input.dispatchMouseEvent", event);
    }

    /// Reports no longer what pages load and log, for measurements: it copies every
    /// message of a socket otherwise.
    pub fn report_nothing(&mut self) {
        for part in ["Log", "Network"] {
            self.ask(&format!("{part}.disable"), json!({}));
        }
        self.events.clear();
    }

    /// Its process; those that it starts are below it.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Makes the window so large, in CSS pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.ask("Emulation.setDeviceMetricsOverride", size);
    }

    /// Prefers `light` or `dark`, on `screen` or in `print`.
    pub fn media(&mut self, scheme: &str, media: &str) {
        let scheme = json!({ "name": "prefers-color-scheme", "value": scheme });
        self.ask("Emulation.setEmulatedMedia", json!({ "media": media, "features": [scheme] }));
    }

    /// The whole page as PNG.
    pub fn picture(&mut self) -> Vec<u8> {
        let params = json!({ "format": "png", "captureBeyondViewport": true });
        self.bytes("Page.captureScreenshot", params)
    }

    /// The page on paper, as PDF.
    pub fn paper(&mut self) -> Vec<u8> {
        self.bytes("Page.printToPDF", json!({ "printBackground": true, "preferCSSPageSize": true }))
    }

    fn bytes(&mut self, method: &str, params: Value) -> Vec<u8> {
        let came = self.ask(method, params);
        BASE64_STANDARD.decode(came["data"].as_str().unwrap()).unwrap()
    }

    /// What went wrong up to now, and who was asked for something over a network.
    pub fn complaints(&mut self) -> Vec<String> {
        // When this is answered, all effects of earlier calls have come.
        self.value("0");
        let complaint = |event: &Value| {
            let params = &event["params"];
            let url = params["request"]["url"].as_str().unwrap_or_default();
            match event["method"].as_str().unwrap_or_default() {
                "Runtime.exceptionThrown" => true,
                "Log.entryAdded" => params["entry"]["level"] == "error",
                "Network.requestWillBeSent" => !url.starts_with("file:"),
                _ => false,
            }
        };
        self.events.drain(..).filter(complaint).map(|event| event.to_string()).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn program() -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let all = PROGRAMS.iter().flat_map(|name| folders.iter().map(move |f| f.join(name)));
    all.into_iter().find(|file| file.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "exit status: 7): no library of that name")]
    fn one_that_is_there_and_does_not_start_is_a_failure() {
        use std::os::unix::fs::PermissionsExt;

        let out = folder();
        let program = out.at("chromium");
        std::fs::write(&program, "#!/bin/sh\necho no library of that name >&2\nexit 7\n").unwrap();
        std::fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).unwrap();
        let _ = Browser::of(&program, &[]);
    }
}
