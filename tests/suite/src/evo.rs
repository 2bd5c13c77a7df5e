//! A Python with evo and two readers of bags in it, for tests. Where python3 makes no virtual environment,
//! or pip finds no evo, tests are skipped with a printed reason; whatever else goes
//! wrong fails them.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::Value;

use crate::python::environment;
use crate::{binaries, repository};

/// The package and the version that is compared with.
pub const EVO: &str = "evo==1.38.1";
/// Two readers of bags that are not ours; evo needs the first one, too.
const ROSBAGS: &str = "rosbags==0.11.9";
const MCAP_ROS2: &str = "mcap-ros2-support==0.6.0";
/// What evo needs to read trajectories and to measure them: half of all that it
/// depends on, and nothing to draw with.
const NEEDED: [&str; 12] = [
    "numpy",
    "scipy",
    ROSBAGS,
    "lz4",
    "ruamel.yaml",
    "apsw",
    "backports.zstd",
    "typing_extensions",
    "colorama",
    MCAP_ROS2,
    "mcap==1.6.0",
    "zstandard",
];
/// What must work before the environment counts as made.
const TRIED: &str = "from evo.core import metrics, sync; from evo.tools import file_interface; \
    from mcap_ros2.decoder import DecoderFactory; from rosbags.highlevel import AnyReader";

/// The interpreter of a virtual environment below the target folder, with evo
/// from wherever pip takes it; made once. `None`, with a printed reason, where
/// that cannot be had.
pub fn python() -> Option<&'static Path> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    crate::python::or_skipped(PYTHON.get_or_init(prepare))
}

fn prepare() -> Result<PathBuf, String> {
    // A dependency may have more dependencies by now: then all of them.
    let few = [&[EVO, "--no-deps"], &NEEDED[..]].concat();
    environment("evo", ("ready", EVO), TRIED, &[&few, &[EVO, ROSBAGS, MCAP_ROS2]], run)
}

/// What evo says of an estimate compared with the truth, both as files that it reads:
/// the fields `ate` and `rpe` of a score.
#[track_caller]
pub fn measure(python: &Path, truth: &Path, estimate: &Path) -> Value {
    let script = repository().join("tests/suite/tests/results/evo/measure.py");
    let said = run(Command::new(python).arg(script).args([truth, estimate])).unwrap();
    serde_json::from_str(&said).unwrap()
}

fn run(command: &mut Command) -> Result<String, String> {
    // evo keeps settings in the home folder, and makes them if they are not there.
    let home = binaries().parent().unwrap().join("evo");
    crate::python::run(command.env("HOME", home))
}
