//! The program of a participant: where it is looked up.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use rusty_contract::Participant;
use rusty_contract::suggest::did_you_mean;

use super::ChildrenError;
use crate::executable::{Executable, built_in};

/// A path is taken as it is. A bare name is a program in the file of this process, or
/// is looked up next to it, in `examples` next to it, then on the path.
pub fn find_program(name: &str, program: &str) -> Result<Executable, ChildrenError> {
    match Executable::built_in(program) {
        Some(found) => Ok(found),
        None => find_file(name, program).map(Executable::from),
    }
}

/// Checks that the program of each participant is there, before anything else is touched.
///
/// # Errors
/// [`ChildrenError`] names the first participant whose program is not.
pub fn check_programs(roster: &[Participant]) -> Result<(), ChildrenError> {
    for participant in roster {
        let Some(program) = participant.command.first() else { continue };
        find_program(&participant.name, program)?;
    }
    Ok(())
}

fn find_file(name: &str, program: &str) -> Result<PathBuf, ChildrenError> {
    if program.contains('/') {
        let (name, program) = (name.to_owned(), program.to_owned());
        return match fs::metadata(&program) {
            Ok(_) => Ok(PathBuf::from(program)),
            Err(error) => Err(ChildrenError::Spawn { name, program, error }),
        };
    }
    let beside = std::env::current_exe()
        .ok()
        .and_then(|exe| exe.parent().map(Path::to_owned))
        .unwrap_or_default();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut places = vec![beside.clone(), beside.join("examples")];
    places.extend(std::env::split_paths(&path));
    places.into_iter().map(|place| place.join(program)).find(|file| file.is_file()).ok_or_else(
        || ChildrenError::NotFound {
            name: name.to_owned(),
            program: program.to_owned(),
            hint: similar_program(&beside, program),
            beside: beside.display().to_string(),
        },
    )
}

/// Returns a suggestion from the programs in a folder and in the file of this process.
fn similar_program(folder: &Path, program: &str) -> String {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    let runs = |f: &fs::DirEntry| {
        f.metadata().is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
    };
    let names: Vec<String> =
        files.filter(runs).filter_map(|f| f.file_name().into_string().ok()).collect();
    let built_in = built_in().iter().copied();
    did_you_mean(program, names.iter().map(String::as_str).chain(built_in))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelled_program_gets_a_suggestion() {
        let folder = tempfile::tempdir().unwrap();
        for (name, mode) in [("dead-reckoning", 0o755), ("dead-reckonin.d", 0o644)] {
            let path = folder.path().join(name);
            fs::write(&path, "").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        }
        let found = similar_program(folder.path(), "dead-reckonin");
        assert!(found.contains("did you mean \"dead-reckoning\"?"), "{found}");
        assert_eq!(similar_program(folder.path(), "mcl"), "");
        assert_eq!(similar_program(Path::new("/no/such"), "mcl"), "");
    }
}
