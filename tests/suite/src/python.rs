//! A Python with numpy and our package in it, for tests. Where python3 makes no
//! virtual environment, or pip finds no numpy, tests are skipped with a printed
//! reason; whatever else goes wrong fails them.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use crate::{binaries, repository, skipped};

/// The interpreter of a virtual environment below the target folder, with numpy
/// from wherever pip takes it and the package as it was just built. `None`, with
/// a printed reason, where that cannot be had.
pub fn python() -> Option<&'static Path> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    or_skipped(PYTHON.get_or_init(prepare))
}

/// What was found; or says that the test is skipped, and why.
pub(crate) fn or_skipped(found: &Result<PathBuf, String>) -> Option<&Path> {
    found.as_deref().inspect_err(|reason| skipped(reason)).ok()
}

/// A script next to the tests.
pub fn script(name: &str) -> String {
    let path = repository().join("tests/suite/tests/python").join(name);
    path.to_str().unwrap().to_owned()
}

fn prepare() -> Result<PathBuf, String> {
    let (built, (place, _lock)) = (binaries(), locked("python"));
    let python = made(&place, ("has-numpy", ""), "import numpy", &[&["numpy"]], run)?;
    let package = Path::new(&packages(&python)).join("rusty");
    fs::create_dir_all(&package).unwrap();
    let sources = repository().join("clients/python/python/rusty");
    for entry in fs::read_dir(sources).unwrap().flatten().filter(|entry| entry.path().is_file()) {
        refresh(&entry.path(), &package.join(entry.file_name()));
    }
    refresh(&built.join("lib_rusty.so"), &package.join("_rusty.abi3.so"));
    refresh(&built.join("lib_gym.so"), &package.join("_gym.abi3.so"));
    Ok(python)
}

/// The folder of the packages of an interpreter.
fn packages(python: &Path) -> String {
    let find = "import sysconfig; print(sysconfig.get_path('platlib'))";
    run(Command::new(python).args(["-c", find])).unwrap().trim().to_owned()
}

/// A command of another interpreter that also finds our package, and what it needs.
pub(crate) fn with_ours(other: &Path) -> Option<Command> {
    let ours = python()?;
    let mut command = Command::new(other);
    command.env("PYTHONPATH", packages(ours));
    Some(command)
}

/// The package and the version of Rerun that exported files are tested with.
const RERUN: &str = "rerun-sdk==0.41.0";

/// The program `rerun`, from wherever pip takes it; made once. `None`, with a printed
/// reason, where that cannot be had.
pub fn rerun() -> Option<PathBuf> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let prepare = || environment("rerun", ("ready", RERUN), "import rerun", &[&[RERUN]], run);
    Some(or_skipped(PYTHON.get_or_init(prepare))?.with_file_name("rerun"))
}

/// A folder below the target folder, and the lock on it: tests of several processes come
/// there at once.
fn locked(name: &str) -> (PathBuf, File) {
    let place = binaries().parent().unwrap().join(name);
    fs::create_dir_all(&place).unwrap();
    let lock = File::create(place.join("lock")).unwrap();
    lock.lock().unwrap();
    (place, lock)
}

/// The interpreter of a virtual environment in which `tried` works, made once in the
/// folder `name` below the target folder. The file `ready`, with its text, is there when
/// it is. Each of `installs` is what pip is asked for, the next one where the one before
/// did not suffice.
pub(crate) fn environment(
    name: &str,
    ready: (&str, &str),
    tried: &str,
    installs: &[&[&str]],
    run: fn(&mut Command) -> Result<String, String>,
) -> Result<PathBuf, String> {
    let (place, _lock) = locked(name);
    made(&place, ready, tried, installs, run)
}

/// The same in a folder that is locked.
fn made(
    place: &Path,
    (ready, text): (&str, &str),
    tried: &str,
    installs: &[&[&str]],
    run: fn(&mut Command) -> Result<String, String>,
) -> Result<PathBuf, String> {
    let (environment, ready) = (place.join("environment"), place.join(ready));
    let python = environment.join("bin/python");
    let works = || run(Command::new(&python).args(["-c", tried]));
    if fs::read_to_string(&ready).is_ok_and(|made| made == text) && works().is_ok() {
        return Ok(python);
    }
    // Python may have been replaced since it was made.
    let _ = fs::remove_file(&ready);
    let _ = fs::remove_dir_all(&environment);
    run(Command::new("python3").args(["-m", "venv"]).arg(&environment))?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    let install = |packages: &&[&str]| run(Command::new(&python).args(pip).args(*packages));
    let (last, others) = installs.split_last().unwrap();
    if !others.iter().any(|packages| install(packages).and_then(|_| works()).is_ok()) {
        install(last)?;
        works().unwrap();
    }
    fs::write(ready, text).unwrap();
    Ok(python)
}

/// Copies a file unless it is there. A process that uses the old one keeps it.
fn refresh(from: &Path, to: &Path) {
    let bytes = fs::read(from).unwrap();
    if fs::read(to).is_ok_and(|there| there == bytes) {
        return;
    }
    let beside = to.with_extension("new");
    fs::write(&beside, bytes).unwrap();
    fs::rename(beside, to).unwrap();
}

/// What a command prints, or why it failed, in its words.
pub(crate) fn run(command: &mut Command) -> Result<String, String> {
    let output = command.stdin(Stdio::null()).output().map_err(|e| format!("{command:?}: {e}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() {
        return Ok(text(&output.stdout));
    }
    Err(format!("{command:?}: {}", text(&output.stderr)))
}
