//! Removes the folder of a run and all that is in it.

use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::domain_error::{DomainError, io};

/// Empties the folder; with `whole`, removes lock and folder too.
pub(crate) fn sweep_folder(folder: &Path, whole: bool) -> Result<(), DomainError> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(());
    };
    for entry in entries.flatten() {
        let path = entry.path();
        if entry.file_name() == "lock" {
            continue;
        }
        let is_folder = entry.file_type().is_ok_and(|t| t.is_dir());
        // A process on the way out may still write into a folder being emptied.
        let mut tries = 0;
        loop {
            let removed =
                if is_folder { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            match removed {
                Err(e) if e.kind() == std::io::ErrorKind::DirectoryNotEmpty && tries < 20 => {
                    tries += 1;
                    std::thread::sleep(Duration::from_millis(1));
                }
                other => break gone(other).map_err(io(&path, "remove"))?,
            }
        }
    }
    if whole {
        let lock = folder.join("lock");
        gone(fs::remove_file(&lock)).map_err(io(&lock, "remove"))?;
        match fs::remove_dir(folder) {
            // A new server may have moved in already.
            Err(e) if e.kind() == std::io::ErrorKind::DirectoryNotEmpty => {}
            other => gone(other).map_err(io(folder, "remove"))?,
        }
    }
    Ok(())
}

/// Something that is not there any more is removed.
fn gone(result: std::io::Result<()>) -> std::io::Result<()> {
    match result {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}
