//! A Python with ROS 2's rclpy in it, for tests, and processes that find each other in
//! ROS, and no other test's. Where the wheels cannot be installed (they are made for CPython
//! 3.11 on x86-64), tests are skipped with a printed reason.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::python::{environment, or_skipped, run, script};
use crate::{binaries, repository};

/// The packages and the versions that the bridge is tested with.
const PACKAGES: [&str; 5] = [
    "ros-kilted-rclpy[fastrtps]==9.1.2",
    "ros-sensor-msgs==5.5.1",
    "ros-nav-msgs==5.5.1",
    "ros-geometry-msgs==5.5.1",
    "ros-rosgraph-msgs==2.3.0",
];
/// What must work before the environment counts as made.
const TRIED: &str = "import rclpy; rclpy.init(); rclpy.create_node('tried'); rclpy.shutdown(); \
    from sensor_msgs.msg import LaserScan; from nav_msgs.msg import OccupancyGrid; \
    from geometry_msgs.msg import TwistStamped; from rosgraph_msgs.msg import Clock";

/// Processes that find each other in ROS, and no other test's.
pub struct Ros {
    python: &'static Path,
    packages: String,
    domain: String,
    namespace: String,
}

impl Ros {
    /// `None`, with a printed reason, where there is no rclpy, or no package of ours.
    pub fn open() -> Option<Self> {
        static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let ours = crate::python::python()?;
        let python = or_skipped(PYTHON.get_or_init(prepare))?;
        let find = "import sysconfig; print(sysconfig.get_path('platlib'))";
        let packages = run(Command::new(ours).args(["-c", find])).unwrap().trim().to_owned();
        let (pid, n) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        // Up to 101 the ports of a domain are not those that Linux gives to clients.
        let domain = ((pid + n) % 101 + 1).to_string();
        Some(Self { python, packages, domain, namespace: format!("__ns:=/t{pid}_{n}") })
    }

    /// A command in the environment of these processes.
    pub fn command(&self, program: impl AsRef<Path>) -> Command {
        let mut command = Command::new(program.as_ref());
        command.env("PYTHONPATH", &self.packages).env("ROS_DOMAIN_ID", &self.domain);
        command.env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
        command.env("ROS_LOG_DIR", binaries().parent().unwrap().join("ros2/log"));
        command
    }

    /// The Python with rclpy.
    pub fn python(&self) -> Command {
        self.command(self.python)
    }

    /// The words that start the bridge.
    pub fn bridge(&self, options: &[&str]) -> Vec<String> {
        let python = self.python.to_str().unwrap();
        let ros = ["--ros-args", "-r", &self.namespace, "--"];
        let words = [&[python, "-m", "rusty.ros2"], options, &ros].concat();
        words.into_iter().map(str::to_owned).collect()
    }

    /// A node of ours, which writes what it received to `out`.
    pub fn node(&self, how: &str, out: &Path) -> Command {
        let mut command = self.command(self.python);
        command.arg(script("ros2_node.py")).arg(how).arg(out);
        command.arg(repository().join("clients/python/examples"));
        command.args(["--ros-args", "-r", &self.namespace]);
        command
    }
}

fn prepare() -> Result<PathBuf, String> {
    environment("ros2", ("ready", &PACKAGES.join(" ")), TRIED, &[&PACKAGES], run)
}
