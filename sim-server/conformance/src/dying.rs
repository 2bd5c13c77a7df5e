//! A server that is killed: this program once more, as a separate process.
//!
//! To a client a server is dead when its process is, so the server has to be
//! another process than the kit. It plays five ticks, says so, and waits to be
//! killed. Should the kit die first, its standard input ends, and so does it.

use std::fs::File;
use std::io::{BufRead as _, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rusty_contract::{RunName, TruthKey, outln};
use rusty_link::Domain;

use super::Kit;
use super::client::Client;
use super::fault::{Fault, Halt};
use super::player::Player;
use super::setting::Setting;
use rusty_engine::run::RunError;

/// Ticks before the death.
const TICKS: u64 = 5;
/// What the server says when they are over.
const PLAYED: &str = "played";

/// A server in a separate process, and the client on it.
pub(super) struct DyingServer<'k> {
    kit: &'k Kit,
    client: Client,
    child: Child,
    talk: PathBuf,
    run: RunName,
}

impl<'k> DyingServer<'k> {
    /// Starts server and client.
    pub(super) fn start(kit: &'k Kit, folder: &Path) -> Result<Self, Halt> {
        let run = kit.fresh_run()?;
        let key = kit.identity(folder)?.key;
        let io = |error| RunError::io(Path::new("sim-server"))(error);
        // No participant has a dot in its name.
        let talk = folder.join("dying.server");
        let out = File::create(&talk).map_err(RunError::io(&talk))?;
        let mut child = Command::new(std::env::current_exe().map_err(io)?)
            .args(["conformance", "--dies-as", run.as_str(), "--name", &kit.name])
            .args(["--role", kit.role.word(), "--wait", &kit.wait.to_string()])
            .args(["--patience", &kit.patience.as_secs_f64().to_string()])
            .stdin(Stdio::piped())
            .stdout(out.try_clone().map_err(io)?)
            .stderr(out)
            .spawn()
            .map_err(io)?;
        if let Some(pipe) = &mut child.stdin {
            let told = format!("{}\n{}\n", key.to_hex(), folder.display());
            let written = pipe.write_all(told.as_bytes());
            if let Err(error) = written {
                let _ = child.kill();
                let _ = child.wait();
                return Err(io(error).into());
            }
        }
        match Client::start(kit, &run, &key, folder) {
            Ok(client) => Ok(Self { kit, client, child, talk, run }),
            Err(error) => {
                let _ = child.kill();
                let _ = child.wait();
                Domain::remove_traces(&run);
                Err(error.into())
            }
        }
    }

    /// Waits until the server has played its ticks.
    pub(super) fn until_played(&mut self) -> Result<(), Halt> {
        // It waits for request, Ready and five answers, each for as long.
        let until = Instant::now() + self.kit.patience * 3;
        loop {
            let said = std::fs::read_to_string(&self.talk).unwrap_or_default();
            if said.lines().any(|line| line == PLAYED) {
                return Ok(());
            }
            self.kit.go_on()?;
            if self.client.has_ended() {
                let when = "before the server was killed".to_owned();
                return Err(Fault::Ended { when, how: self.client.end() }.into());
            }
            let ended = self.child.try_wait().ok().flatten().is_some();
            if ended || Instant::now() >= until {
                return Err(Fault::NotPlayed(said.trim().to_owned()).into());
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Kills the server, without a warning.
    pub(super) fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Waits for the client's end, and says what it left of the run.
    pub(super) fn until_client_ended(&mut self) -> Result<Vec<PathBuf>, Halt> {
        let until = Instant::now() + self.kit.patience;
        while !self.client.has_ended() {
            self.kit.go_on()?;
            if Instant::now() >= until {
                return Err(Fault::NeverEnded(self.kit.patience).into());
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        // Another process's sweep of dead runs may be at it just now.
        loop {
            let left = Domain::traces(&self.run);
            if left.is_empty() || Instant::now() >= until {
                return Ok(left);
            }
            self.kit.go_on()?;
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// The client.
    pub(super) fn client(&self) -> &Client {
        &self.client
    }
}

impl Drop for DyingServer<'_> {
    fn drop(&mut self) {
        self.kill();
        self.client = Client::elsewhere();
        Domain::remove_traces(&self.run);
    }
}

/// The other side: serves `run` for five ticks, says so, and waits for the
/// kill. Key and folder come on standard input.
///
/// # Errors
/// [`RunError`] if there is no shared memory; [`Halt::Client`] in words if the
/// client does not play along.
pub fn serve_until_killed(kit: &Kit, run: &RunName) -> Result<(), Halt> {
    let stdin = std::io::stdin();
    let io = |error| RunError::io(Path::new("standard input"))(error);
    let mut lines = stdin.lock();
    let (mut key, mut folder) = (String::new(), String::new());
    lines.read_line(&mut key).map_err(io)?;
    lines.read_line(&mut folder).map_err(io)?;
    let mut identity = kit.identity(Path::new(folder.trim_end()))?;
    identity.key = TruthKey::from_hex(&key).map_err(rusty_link::LinkError::from)?;
    let mut player = Player::serve(kit, &Setting::usual(kit.role), run, identity)?;
    player.gather()?;
    player.ticks(TICKS)?;
    outln!("{PLAYED}");
    // The kit's end ends this: no other process holds the other end of the pipe.
    let _ = lines.read_to_end(&mut Vec::new());
    Ok(())
}
