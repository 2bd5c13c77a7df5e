//! The clients in this binary: it is one of them if it is started under that name.

use std::convert::Infallible;
use std::ffi::{CString, OsStr, OsString};
use std::os::unix::process::CommandExt as _;
use std::path::Path;

use rusty_contract::{Exit, Program};
use rusty_engine::executable::Executable;

const PACKAGES: [&[Program]; 4] = [
    rusty_filters::PROGRAMS,
    rusty_logger::PROGRAMS,
    rusty_scorer::PROGRAMS,
    rusty_viewer::PROGRAMS,
];

/// Returns the clients.
pub fn all() -> impl Iterator<Item = &'static Program> {
    PACKAGES.into_iter().flatten()
}

/// Returns the client whose name a path ends with.
pub fn named(path: &OsStr) -> Option<&'static Program> {
    let name = Path::new(path).file_name()?;
    all().find(|program| name == program.name)
}

/// Runs a client as this process, which gets its name in `ps`, too.
pub fn run(program: &Program) -> Exit {
    if let Ok(name) = CString::new(program.name) {
        // Without it the process has the name of the file.
        let _ = rustix::thread::set_name(&name);
    }
    (program.main)()
}

/// Becomes a client with other arguments: `sim-server ekf …` is `ekf …`.
///
/// # Errors
/// The binary cannot be started again.
pub fn become_client(
    program: &Executable,
    args: impl Iterator<Item = OsString>,
) -> std::io::Result<Infallible> {
    Err(program.command().args(args).exec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::NAMES;

    #[test]
    fn every_name_is_a_client_and_every_client_has_a_name() {
        let names: Vec<&str> = all().map(|program| program.name).collect();
        assert_eq!(names, NAMES);
        assert!(names.iter().all(|name| named(OsStr::new(name)).is_some()));
        assert!(named(OsStr::new("bin/ekf")).is_some_and(|program| program.name == "ekf"));
        for other in ["sim-server", "ekf2", "ekf/x", ""] {
            assert!(named(OsStr::new(other)).is_none(), "{other}");
        }
    }
}
