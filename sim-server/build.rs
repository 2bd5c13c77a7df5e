//! Makes a link to the binary for each client in it, next to where cargo puts the binary:
//! `target/release/ekf` is `target/release/sim-server` under another name.

use std::io;
use std::path::Path;

#[path = "src/names.rs"]
mod names;

/// The file name of the binary.
const BINARY: &str = "sim-server";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=src/names.rs");
    let out = std::env::var_os("OUT_DIR").unwrap_or_default();
    // OUT_DIR is `<folder of the binary>/build/<package>-<hash>/out`.
    let build = Path::new(&out).ancestors().find(|folder| folder.ends_with("build"));
    let Some(folder) = build.and_then(Path::parent) else {
        println!(
            "cargo:warning=no links next to {BINARY}; make them: {BINARY} programs --link DIR"
        );
        return;
    };
    for name in names::NAMES {
        if let Err(error) = link(folder, name) {
            let path = folder.join(name);
            println!("cargo:warning=linking {} to {BINARY} failed: {error}", path.display());
        }
    }
}

/// Links one name, in place of a program of this name that an earlier version built.
fn link(folder: &Path, name: &str) -> io::Result<()> {
    let path = folder.join(name);
    if std::fs::read_link(&path).is_ok_and(|target| target == Path::new(BINARY)) {
        return Ok(());
    }
    let new = folder.join(format!(".{name}.{}", std::process::id()));
    std::os::unix::fs::symlink(BINARY, &new)?;
    std::fs::rename(&new, &path).inspect_err(|_| {
        let _ = std::fs::remove_file(&new);
    })
}
