//! `view`: shows a run or a log in a browser.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::Parser;
use rustix::process::{DumpableBehavior, set_dumpable_behavior};
use rusty_clients::{ClientError, parsed, stop_by_signal};
use rusty_contract::log::LogReader;
use rusty_contract::{Brief, Credentials, Exit, Phase, RunName, errln, outln, output};
use rusty_link::Peer;
use rusty_ros::Description;
use tempfile::NamedTempFile;

use crate::access::Rights;
use crate::command::Command as DriveCommand;
use crate::drive::Remote;
use crate::hub::Hub;
use crate::live::{LiveRun, control};
use crate::playback::Playback;
use crate::record::Moment;
use crate::recording::Recording;
use crate::scene::{PageRequest, Scene, Status};
use crate::server::{Server, Shared};

/// A page that was closed may be loaded again within this time.
const RELOAD_TIME: Duration = Duration::from_secs(3);
/// Time for the participants of a run to end after its last tick.
const LOG_TIME: Duration = Duration::from_secs(60);

/// Show a run or a log in a browser
///
/// Prints the address of a page on this machine. The page shows map, robot, scan, every
/// estimator with its path and 95 % ellipse, beliefs, and errors, NEES and compute times
/// as they come. It pauses and steps a run, and plays a log at any pace.
///
/// A run does not wait for the viewer, and no bit of it depends on it. Of a run that
/// `launch` started without --watch, the truth, the map and the answers are hidden.
#[derive(Parser)]
#[command(name = "view", version, after_help = AFTER_HELP)]
struct Cli {
    /// Log to show
    #[arg(required_unless_present = "run", conflicts_with = "run")]
    log: Option<PathBuf>,

    /// Run to show
    #[arg(long, value_name = "NAME")]
    run: Option<RunName>,

    /// Let the page drive the robot, if the driver is `drive`
    #[arg(long, conflicts_with = "log")]
    drive: bool,

    /// Port of the page on 127.0.0.1, 0 for any
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,

    /// Let apps of this site connect, as the Origin they send
    #[arg(long, value_name = "ORIGIN")]
    allow_origin: Vec<String>,

    /// Open no browser
    #[arg(long)]
    no_open: bool,

    /// End when the process with this ID has ended
    #[arg(long, value_name = "PID")]
    launcher: Option<u32>,

    /// Read the keys from standard input until it ends
    #[arg(long, conflicts_with = "log")]
    key_stdin: bool,
}

const AFTER_HELP: &str = "\
Examples:
  sim-server launch --watch            start a run and show it
  sim-server serve --run lab           in one terminal, and in another:
  view --run lab
  view runs/NAME/run.log               play a log

The page is for this machine and this user only: its address has a secret after `#`.
The second address is for Foxglove and Lichtblick, and has the same secret.
The viewer ends when the page is closed, or with Ctrl-C. docs/view.md has the keys.";

pub(super) fn main() -> Exit {
    let cli: Cli = parsed();
    // It may hold the key: no core dumps, and no other process of this user reads its
    // memory. Where that cannot be had, it goes on.
    let _ = set_dumpable_behavior(DumpableBehavior::NotDumpable);
    let exit = view(&cli).unwrap_or_else(|e| {
        errln!("view: {e}");
        e.exit()
    });
    output::finish("view", exit)
}

fn view(cli: &Cli) -> Result<Exit, ClientError> {
    let viewer = Viewer::new(cli)?;
    match (&cli.log, &cli.run) {
        (Some(log), _) => viewer.log(cli, log),
        (None, Some(run)) => viewer.run(cli, run),
        (None, None) => Ok(Exit::Usage),
    }
}

/// The page, and what decides for how long it is served.
struct Viewer {
    hub: Arc<Hub>,
    rights: Rights,
    stop: Arc<AtomicBool>,
    launcher: Option<Peer>,
    /// Where the requests of pages go now.
    requests: Arc<Mutex<Option<Sender<PageRequest>>>>,
    /// The folder of the run, for commands to its driver.
    folder: Arc<Mutex<Option<PathBuf>>>,
}

impl Viewer {
    fn new(cli: &Cli) -> Result<Self, ClientError> {
        let unusable = |e: &dyn std::fmt::Display| ClientError::Unusable(e.to_string());
        Ok(Self {
            hub: Arc::default(),
            rights: Rights::draw(cli.drive).map_err(|e| unusable(&e))?,
            stop: stop_by_signal(),
            launcher: cli.launcher.map(Peer::new),
            requests: Arc::default(),
            folder: Arc::default(),
        })
    }

    /// Serves the page, prints its address, and opens a browser if there is a display.
    fn serve(&self, cli: &Cli) -> Result<Option<NamedTempFile>, ClientError> {
        let failed = |e: std::io::Error| {
            let is_taken = e.kind() == std::io::ErrorKind::AddrInUse;
            let remedy = if is_taken { "; any free port is --port 0" } else { "" };
            ClientError::Unusable(format!("--port {}: 127.0.0.1: {e}{remedy}", cli.port))
        };
        let server = Server::bind(cli.port).map_err(failed)?;
        let [address, foxglove] =
            [server.address(&self.rights), server.foxglove_address(&self.rights)];
        let (requests, folder) = (Arc::clone(&self.requests), Arc::clone(&self.folder));
        let remote = Mutex::new(None::<Remote>);
        let on_command = move |command: DriveCommand| {
            let mut remote = remote.lock().unwrap_or_else(PoisonError::into_inner);
            let folder = folder.lock().unwrap_or_else(PoisonError::into_inner);
            *remote = remote.take().or_else(|| Remote::open(folder.as_ref()?));
            remote.iter().for_each(|way| way.send(command));
        };
        let on_request = move |request| {
            let to = requests.lock().unwrap_or_else(PoisonError::into_inner);
            let _ = to.as_ref().map(|to| to.send(request));
        };
        let (hub, rights) = (Arc::clone(&self.hub), self.rights);
        let (on_request, on_command) = (Box::new(on_request), Box::new(on_command));
        let origins = cli.allow_origin.clone();
        let shared = Shared { hub, rights, origins, on_request, on_command };
        server.serve(shared).map_err(failed)?;
        outln!("{address}\nfoxglove {foxglove}");
        let has_display =
            ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
        Ok((has_display && !cli.no_open).then(|| open_browser(&address)).flatten())
    }

    /// Takes the requests of pages from now on.
    fn take_requests(&self) -> Receiver<PageRequest> {
        let (sender, receiver) = channel();
        *self.requests.lock().unwrap_or_else(PoisonError::into_inner) = Some(sender);
        receiver
    }

    fn status(&self, status: &Status) {
        self.hub.set_status(&serde_json::to_string(status).unwrap_or_default());
    }

    fn scene(&self, scene: &Scene, about: Description, ticks: &[Arc<Moment>]) {
        let json = serde_json::to_string(scene).unwrap_or_default();
        self.hub.set_scene(&json, about, ticks);
    }

    fn log(&self, cli: &Cli, log: &Path) -> Result<Exit, ClientError> {
        // What is not a log is refused before there is a page.
        drop(LogReader::open(log)?);
        let _page = self.serve(cli)?;
        self.status(&Status::new("waiting", Some(1.0), "Reading the log."));
        let recording = Recording::read(log)?;
        if let Some(cut) = &recording.cut {
            errln!("{}: {cut}", log.display());
        }
        self.play(&recording, recording.scene(), false);
        Ok(if recording.cut.is_some() { Exit::Lost } else { Exit::Done })
    }

    fn play(&self, recording: &Recording, scene: Scene, from_end: bool) {
        let requests = self.take_requests();
        self.scene(&scene, recording.description(), &recording.ticks);
        let mut page = PageWatch::new(self);
        Playback::new(recording, from_end).run(&requests, &self.hub, || page.is_wanted());
        self.hub.close_all();
    }

    fn run(&self, cli: &Cli, run: &RunName) -> Result<Exit, ClientError> {
        let text = |input| std::io::read_to_string(input).map_err(ClientError::io(Path::new("-")));
        let told = cli.key_stdin.then(|| text(std::io::stdin())).transpose()?;
        let told = told.map(|text| Credentials::from_text(&text)).transpose()?;
        let open = |told| LiveRun::open(run, cli.launcher, told, &self.stop);
        // A launcher waits for the address before there is a run; by hand, a run that is
        // not there is refused before there is a page.
        let (mut live, _page) = if cli.launcher.is_some() {
            let page = self.serve(cli)?;
            self.status(&Status::new("waiting", None, "Waiting for the run."));
            (open(told)?, page)
        } else {
            let live = open(told)?;
            (live, self.serve(cli)?)
        };
        let folder = live.folder().to_owned();
        *self.folder.lock().unwrap_or_else(PoisonError::into_inner) = Some(folder.clone());
        self.scene(&live.scene(), live.description(), &[]);
        let ended = Arc::new(AtomicBool::new(false));
        let (requests, hub, name) = (self.take_requests(), Arc::clone(&self.hub), run.clone());
        let is_over = Arc::clone(&ended);
        std::thread::spawn(move || control(&name, &requests, &hub, &is_over));
        let ending = live.show(&self.hub, &self.stop)?;
        ended.store(true, Ordering::Relaxed);
        let brief = live.brief().cloned();
        drop(live);
        let text = match ending {
            Some(Phase::Done) => "The run is complete.",
            Some(Phase::Interrupted) => "The run was stopped.",
            Some(Phase::Aborted) => "The run ended because a participant was lost.",
            Some(Phase::Tick) | None => "The server of the run has ended.",
        };
        self.status(&Status::new("ended", None, text));
        if let Some(recording) = brief.and_then(|brief| self.log_of(&brief, &folder)) {
            let remark = format!("{text} The page plays its log.");
            let scene = recording.scene().with_remark(Some(remark));
            self.play(&recording, scene, true);
        } else {
            let mut page = PageWatch::new(self);
            while page.is_wanted() {
                std::thread::sleep(Duration::from_millis(20));
            }
            self.hub.close_all();
        }
        Ok(Exit::Done)
    }

    /// The log of a run that has ended, if it is whole. A logger writes until the run
    /// has left shared memory.
    fn log_of(&self, brief: &Brief, folder: &Path) -> Option<Recording> {
        let deadline = Instant::now() + LOG_TIME;
        let mut page = PageWatch::new(self);
        while folder.exists() && Instant::now() < deadline && page.is_wanted() {
            std::thread::sleep(Duration::from_millis(20));
        }
        let log = Path::new(brief.out_dir.as_ref()?).join("run.log");
        let recording = page.is_wanted().then(|| Recording::read(&log).ok()).flatten()?;
        (recording.cut.is_none() && recording.header.config == brief.header.config)
            .then_some(recording)
    }
}

/// Whether the page is wanted: until a signal, the end of the launcher, or the end of
/// the last page.
struct PageWatch<'a> {
    viewer: &'a Viewer,
    empty_since: Option<Instant>,
}

impl<'a> PageWatch<'a> {
    fn new(viewer: &'a Viewer) -> Self {
        Self { viewer, empty_since: None }
    }

    fn is_wanted(&mut self) -> bool {
        let (open, opened) = self.viewer.hub.counts();
        if open > 0 || opened == 0 {
            self.empty_since = None;
        } else {
            self.empty_since.get_or_insert_with(Instant::now);
        }
        let is_left = self.empty_since.is_some_and(|since| since.elapsed() > RELOAD_TIME);
        let has_launcher = self.viewer.launcher.as_ref().is_none_or(|peer| !peer.is_dead());
        !is_left && has_launcher && !self.viewer.stop.load(Ordering::Relaxed)
    }
}

/// Opens a browser by a file that only this user can read: the address on a command line
/// would show its tokens to all users.
fn open_browser(address: &str) -> Option<NamedTempFile> {
    let folder = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let folder = folder.filter(|f| f.is_dir()).unwrap_or_else(std::env::temp_dir);
    let mut named = tempfile::Builder::new();
    let mut file = named.prefix("rusty-view-").suffix(".html").tempfile_in(folder).ok()?;
    let page = address.replace('&', "&amp;");
    let html = format!("<!doctype html><meta http-equiv=\"refresh\" content=\"0;url={page}\">");
    file.write_all(html.as_bytes()).ok()?;
    let mut browser = Command::new("xdg-open");
    browser.arg(file.path()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut browser = browser.spawn().ok()?;
    // It may be the browser itself.
    std::thread::spawn(move || browser.wait());
    Some(file)
}
