//! Driving by hand: from a page or a terminal to the driver of a run.
//!
//! The driver answers every tick at once with the latest command. A page sends its
//! commands to the viewer, and the viewer sends them to a socket in the run's folder,
//! which this user alone can open. A command that is not renewed counts for a number of
//! *ticks*: a page that is closed or a key that is stuck stops the robot at the same tick
//! however fast the run goes.

use std::io;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};

use clap::Args;
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::{Filter, Tick};
use rusty_contract::{Reply, Start};
use rusty_geometry::Twist;

use crate::command::Command;
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
        })
    }

    /// The command for the next tick, from what came since the last one.
    fn next_command(&mut self) -> Twist {
        self.left_ticks = self.left_ticks.saturating_sub(1);
        let mut bytes = [0; Command::BYTES + 1];
        while let Some(Ok(n)) = self.remote.as_ref().map(|remote| remote.recv(&mut bytes)) {
            if let Some(command) = Command::from_bytes(&bytes[..n]) {
                (self.command, self.left_ticks) = (command, self.options.dead_man);
            }
        }
        if let Some(command) = self.terminal.as_mut().and_then(Terminal::command) {
            (self.command, self.left_ticks) = (command, self.options.dead_man);
        }
        if self.left_ticks == 0 {
            self.command = Command::default();
        }
        let Options { speed, turn, .. } = self.options;
        self.command.velocity(Twist { v_m_s: speed, omega_rad_s: turn })
    }
}

impl Filter for Drive {
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

    #[test]
    fn a_command_counts_until_it_is_replaced_or_the_dead_man_s_ticks_are_over() {
        let folder = tempfile::tempdir().unwrap();
        let world = WorldSpec {
            name: "w".to_owned(),
            bounds: [0.0, 0.0, 1.0, 1.0],
            walls: vec![],
            landmarks: vec![],
        };
        let header = LogHeader::simulated("test", &Scenario::default(), world);
        let start = Start::new(&header, 0, &Participant::new("drive", Role::Driver));
        let options = Options { speed: 0.5, turn: 2.0, dead_man: 3 };
        let mut drive = Drive::new(&start, options, Some(folder.path())).unwrap();
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
}
