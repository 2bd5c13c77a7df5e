//! Driving by hand: from a page or a terminal to the driver of a run.
//!
//! The driver answers every tick at once with the latest command. A page sends its
//! commands to the viewer, and the viewer sends them to a socket in the run's folder,
//! which this user alone can open. A command that is not renewed counts for a number of
//! *ticks*: a page that is closed or a key that is stuck stops the robot at the same tick
//! however fast the run goes.
//!
//! At a pace the driver answers shortly before the next tick is due, so that its command
//! is a new one; see [`Hold`]. A command that differs from the last is answered at once,
//! and so is the tick that carries it, whose picture a person waits for.

use std::io;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::{Filter, Tick};
use rusty_contract::{Reply, Start};
use rusty_geometry::Twist;

use crate::command::Command;
use crate::hold::Hold;
use crate::terminal::Terminal;

/// Drive the robot with the arrow keys
///
/// In a run that `launch --watch` shows, the page sends the keys: press Drive there. In
/// a run that `serve` serves, start this program in a terminal: `drive --run lab`. Keys:
/// arrows or W A S D to drive, space to stop, Ctrl-C to leave. A terminal reports no
/// release of a key, so a command holds for --dead-man ticks after each key press.
///
/// The scenario needs a script of kind "driver"; the role is driver. Answers include
/// dead reckoning.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Greatest speed, m/s
    #[arg(long, value_name = "M_S", default_value_t = 0.6)]
    pub speed: f64,

    /// Greatest turn rate, rad/s
    #[arg(long, value_name = "RAD_S", default_value_t = 1.5)]
    pub turn: f64,

    /// Ticks after which a command ends that is not renewed
    #[arg(long, value_name = "TICKS", default_value_t = 25)]
    pub dead_man: u64,
}

/// The socket of the driver in the folder of a run.
fn socket_in(folder: &Path) -> PathBuf {
    folder.join("drive")
}

/// The way from a viewer to the driver.
pub struct Remote {
    socket: UnixDatagram,
    to: PathBuf,
}

impl Remote {
    /// The way to the driver of the run with this folder, if it has one that listens.
    #[must_use]
    pub fn open(folder: &Path) -> Option<Self> {
        let socket = UnixDatagram::unbound().ok()?;
        socket.set_nonblocking(true).ok()?;
        let to = socket_in(folder);
        to.exists().then_some(Self { socket, to })
    }

    /// Sends a command. One that does not arrive is followed by others.
    pub fn send(&self, command: Command) {
        let _ = self.socket.send_to(&command.to_bytes(), &self.to);
    }
}

/// The driver.
pub struct Drive {
    odometry: DeadReckoning,
    options: Options,
    remote: Option<UnixDatagram>,
    terminal: Option<Terminal>,
    command: Command,
    /// Ticks for which it still counts.
    left_ticks: u64,
    /// The command that came last, until a tick takes it.
    news: Option<Command>,
    hold: Hold,
    /// When the latest tick came.
    came: Option<Instant>,
    /// The latest answer had another command than the one before.
    has_changed: bool,
}

impl Drive {
    /// Listens in the folder of a run, and to the terminal if there is one.
    ///
    /// # Errors
    /// [`io::Error`] if the socket cannot be opened.
    pub fn new(start: &Start, options: Options, folder: Option<&Path>) -> io::Result<Self> {
        let listen = |folder: &Path| {
            let path = socket_in(folder);
            // That of the same driver before it was restarted.
            let _ = std::fs::remove_file(&path);
            let socket = UnixDatagram::bind(path)?;
            socket.set_nonblocking(true)?;
            Ok::<_, io::Error>(socket)
        };
        Ok(Self {
            odometry: DeadReckoning::of_start(start),
            options,
            remote: folder.map(listen).transpose()?,
            terminal: folder.and_then(|_| Terminal::open()),
            command: Command::default(),
            left_ticks: 0,
            news: None,
            hold: Hold::new(start.dt_s),
            came: None,
            has_changed: false,
        })
    }

    /// Takes the commands that have come.
    fn receive(&mut self) {
        let mut bytes = [0; Command::BYTES + 1];
        while let Some(Ok(n)) = self.remote.as_ref().map(|remote| remote.recv(&mut bytes)) {
            self.news = Command::from_bytes(&bytes[..n]).or(self.news);
        }
    }

    /// The command for the next tick, from what came since the last one.
    fn next_command(&mut self) -> Twist {
        self.left_ticks = self.left_ticks.saturating_sub(1);
        self.receive();
        let typed = self.terminal.as_mut().and_then(Terminal::command);
        let before = self.command;
        if let Some(command) = typed.or(self.news.take()) {
            (self.command, self.left_ticks) = (command, self.options.dead_man);
        }
        if self.left_ticks == 0 {
            self.command = Command::default();
        }
        self.has_changed = self.command != before;
        let Options { speed, turn, .. } = self.options;
        self.command.velocity(Twist { v_m_s: speed, omega_rad_s: turn })
    }

    /// Waits for this long for another command than the present one.
    fn wait_for_news(&mut self, time: Duration) {
        let begun = Instant::now();
        while !self.news.is_some_and(|news| news != self.command) {
            let left = time.saturating_sub(begun.elapsed());
            let Some(remote) = self.remote.as_ref().filter(|_| !left.is_zero()) else { return };
            let mut fds = [PollFd::new(remote, PollFlags::IN)];
            // A signal ends the wait: the session then looks at what it was asked.
            let at_most = Timespec { tv_sec: 0, tv_nsec: i64::from(left.subsec_nanos()) };
            if !poll(&mut fds, Some(&at_most)).is_ok_and(|ready| ready > 0) {
                return;
            }
            self.receive();
        }
    }
}

impl Filter for Drive {
    fn wait(&mut self) -> bool {
        let now = Instant::now();
        let interval = self.came.replace(now).map_or(Duration::ZERO, |before| now - before);
        let held = self.hold.after(interval);
        let is_held = !held.is_zero() && !self.has_changed;
        if is_held {
            self.wait_for_news(held);
        }
        is_held
    }

    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        let pose = self.odometry.advance(tick.encoders());
        Reply::Both(pose.into(), self.next_command())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::{LogHeader, Participant, Role, Scenario};
    use rusty_geometry::WorldSpec;

    fn driver(folder: &Path, options: Options) -> Drive {
        let world = WorldSpec {
            name: "w".to_owned(),
            bounds: [0.0, 0.0, 1.0, 1.0],
            walls: vec![],
            landmarks: vec![],
        };
        let header = LogHeader::simulated("test", &Scenario::default(), world);
        let start = Start::new(&header, 0, &Participant::new("drive", Role::Driver));
        Drive::new(&start, options, Some(folder)).unwrap()
    }

    #[test]
    fn a_command_counts_until_it_is_replaced_or_the_dead_man_s_ticks_are_over() {
        let folder = tempfile::tempdir().unwrap();
        let options = Options { speed: 0.5, turn: 2.0, dead_man: 3 };
        let mut drive = driver(folder.path(), options);
        let stand = Twist::default();
        assert_eq!(drive.next_command(), stand);
        let remote = Remote::open(folder.path()).unwrap();
        remote.send(Command::Parts { ahead: -1.0, left: 1.0 });
        remote.send(Command::Parts { ahead: 1.0, left: -0.5 });
        let expected = Twist { v_m_s: 0.5, omega_rad_s: -1.0 };
        let commands: Vec<Twist> = (0..4).map(|_| drive.next_command()).collect();
        assert_eq!(commands, [expected, expected, expected, stand]);
        for bad in [f64::NAN, 1.1, f64::INFINITY] {
            remote.send(Command::Parts { ahead: bad, left: 0.0 });
        }
        remote.send(Command::Velocity(Twist { v_m_s: f64::NAN, omega_rad_s: 0.0 }));
        remote.socket.send_to(b"short", &remote.to).unwrap();
        assert_eq!(drive.next_command(), stand);
        for (asked, given) in [([0.25, -3.0], [0.25, -2.0]), ([-9.0, 0.125], [-0.5, 0.125])] {
            let [asked, given] =
                [asked, given].map(|[v_m_s, omega_rad_s]| Twist { v_m_s, omega_rad_s });
            remote.send(Command::Velocity(asked));
            assert_eq!(drive.next_command(), given);
        }
        assert!(Remote::open(&folder.path().join("other")).is_none());
    }

    #[test]
    fn another_command_ends_the_wait_and_the_tick_that_carries_it_is_not_held_back() {
        let folder = tempfile::tempdir().unwrap();
        let mut drive = driver(folder.path(), Options { speed: 1.0, turn: 1.0, dead_man: 3 });
        let remote = Remote::open(folder.path()).unwrap();
        // A tick that came a minute after the one before would be held back for long.
        drive.hold = Hold::new(f64::MAX);
        let a_minute_ago = |drive: &mut Drive| {
            drive.came = Instant::now().checked_sub(Duration::from_secs(60));
        };
        assert!(!drive.wait(), "the first tick");
        a_minute_ago(&mut drive);
        let ahead = Command::Parts { ahead: 1.0, left: 0.0 };
        remote.send(ahead);
        assert!(drive.wait());
        assert_eq!(drive.news, Some(ahead), "it is there after the wait");
        // The dead man's ticks count from the answer.
        let stand = Twist::default();
        assert_ne!(drive.next_command(), stand);
        a_minute_ago(&mut drive);
        assert!(!drive.wait(), "the tick that carries the command");
        let commands = [(); 3].map(|()| drive.next_command());
        assert_eq!(commands.map(|command| command == stand), [false, false, true]);
        // What is sent again is no other command: the wait lasts.
        remote.send(Command::default());
        let begun = Instant::now();
        drive.has_changed = false;
        a_minute_ago(&mut drive);
        assert!(drive.wait() && begun.elapsed() >= Duration::from_millis(50));
    }
}
