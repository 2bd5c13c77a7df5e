//! Things that are undone or reported when a test ends, even if it fails.

use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::{Folder, folder, skipped};

/// Raises a flag when it is dropped.
pub struct Raise<'a>(pub &'a AtomicBool);

impl Drop for Raise<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Prints how to repeat a case, if it fails.
pub struct Repeat(pub String);

impl Drop for Repeat {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("{}", self.0);
        }
    }
}

/// A disk of 200 kB. Where a disk must not be written, permission bits would not do:
/// they do not bind everybody.
pub struct Disk(pub Folder);

impl Disk {
    /// Mounts it with further options; `None`, with a printed reason, where that is
    /// not allowed.
    pub fn mount(options: &str) -> Option<Self> {
        let place = folder();
        let options = format!("size=200k{options}");
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &options, "tmpfs"])
            .arg(place.path())
            .output();
        if mount.as_ref().is_ok_and(|m| m.status.success()) {
            return Some(Self(place));
        }
        skipped(&format!("a disk ({options}) cannot be mounted here: {mount:?}"));
        None
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}
