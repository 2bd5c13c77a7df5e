//! What a participant's arguments say once the run has a folder.
//!
//! In any argument of a `command`, `{out}` stands for the run's folder: that of
//! `--out`, `runs/NAME`, or the one that `verify --clients` throws away. So what a
//! filter writes is next to the log of its run, wherever that is. The log keeps
//! the words as they were written, and a replay gives them its own folder.
//!
//! For a participant with a `sandbox` it is a separate folder in there, named
//! after it, in which it may read and write: the run's folder holds the log, and
//! the log the truth. It is so on every kernel, with or without a gate.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use rusty_contract::Participant;
use rusty_contract::output::make_folder;
use rusty_link::with_umask;

/// What stands for the run's folder.
pub const OUT: &str = "{out}";

/// Whether an argument of this participant names the run's folder.
fn names_it(participant: &Participant) -> bool {
    participant.command.iter().skip(1).any(|word| word.contains(OUT))
}

/// The separate folder that a participant with a sandbox writes to, if its
/// arguments name one. It is made.
///
/// # Errors
/// The path, and what the operating system said.
pub(super) fn own_folder(
    participant: &Participant,
    out_dir: &Path,
) -> Result<Option<PathBuf>, (PathBuf, std::io::Error)> {
    if participant.sandbox.is_none() || !names_it(participant) {
        return Ok(None);
    }
    let folder = out_dir.join(&participant.name);
    match with_umask(|| make_folder(&folder)) {
        Ok(()) => Ok(Some(folder)),
        Err(error) => Err((folder, error)),
    }
}

/// The arguments, with `folder` for every `{out}` in them.
pub fn with_folder(words: &[String], folder: &Path) -> impl Iterator<Item = OsString> {
    words.iter().map(move |word| {
        let mut parts = word.split(OUT);
        let mut text = OsString::from(parts.next().unwrap_or_default());
        for part in parts {
            text.push(folder);
            text.push(part);
        }
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::{Role, Sandbox};
    use std::os::unix::ffi::OsStringExt as _;

    #[test]
    fn every_mention_becomes_the_folder_and_nothing_else_changes() {
        let words = ["{out}/map", "--a={out}:{out}", "{ out }", "", "out"].map(str::to_owned);
        let folder = Path::new("/r/1");
        let found: Vec<OsString> = with_folder(&words, folder).collect();
        assert_eq!(found, ["/r/1/map", "--a=/r/1:/r/1", "{ out }", "", "out"].map(OsString::from));
        // Names of folders are bytes.
        let odd = PathBuf::from(OsString::from_vec(vec![b'/', 0xff]));
        let found: Vec<OsString> = with_folder(&words[..1], &odd).collect();
        assert_eq!(found[0].clone().into_vec(), b"/\xff/map");
    }

    #[test]
    fn one_with_a_sandbox_has_a_folder_of_its_own_if_it_asks_for_one() {
        let out = tempfile::tempdir().unwrap();
        let mut mapper = Participant::new("mapper", Role::Estimator);
        mapper.command = ["gridmap", "--save", "{out}/map"].map(str::to_owned).to_vec();
        assert_eq!(own_folder(&mapper, out.path()).unwrap(), None);
        mapper.sandbox = Sandbox::IfPossible;
        assert_eq!(own_folder(&mapper, out.path()).unwrap(), Some(out.path().join("mapper")));
        assert!(out.path().join("mapper").is_dir());
        std::fs::write(out.path().join("file"), "").unwrap();
        mapper.name = "file".to_owned();
        let (path, error) = own_folder(&mapper, out.path()).unwrap_err();
        assert!(path.ends_with("file") && error.kind() == std::io::ErrorKind::AlreadyExists);
        mapper.command.pop();
        assert_eq!(own_folder(&mapper, out.path()).unwrap(), None);
    }
}
