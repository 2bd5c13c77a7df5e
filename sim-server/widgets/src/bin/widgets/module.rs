//! The module: built by cargo, packed for a page.

use std::fmt;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

const TARGET: &str = "wasm32-unknown-unknown";
const PACKAGE: &str = "rusty-widgets";

/// A module for WebAssembly.
pub struct Module {
    name: &'static str,
    bytes: Vec<u8>,
    packed: Vec<u8>,
}

impl Module {
    /// Builds the module, with EKF and MCL or without.
    ///
    /// # Errors
    /// The target is not installed, or cargo fails.
    pub fn build(with_filters: bool) -> Result<Self> {
        check_target()?;
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        cargo.current_dir(repository()).args(["build", "--profile", "widgets", "--lib"]);
        cargo.args(["--package", PACKAGE, "--target", TARGET]);
        if with_filters {
            cargo.args(["--features", "filters"]);
        }
        let target = target_folder();
        cargo.arg("--target-dir").arg(&target);
        // Flags for this machine's processor do not apply.
        cargo.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
        let status = cargo.status().context("starting cargo failed; install Rust by rustup")?;
        if !status.success() {
            bail!("building the module failed ({status}); cargo's message is above");
        }
        let path = target.join(TARGET).join("widgets/rusty_widgets.wasm");
        let bytes =
            fs::read(&path).with_context(|| format!("reading {} failed", path.display()))?;
        let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
        gzip.write_all(&bytes)?;
        let name = if with_filters { "module with EKF and MCL" } else { "module" };
        Ok(Self { name, bytes, packed: gzip.finish()? })
    }

    /// The module as text: gzip in base64.
    #[must_use]
    pub fn base64(&self) -> String {
        BASE64_STANDARD.encode(&self.packed)
    }
}

impl fmt::Display for Module {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} bytes, {} with gzip", self.name, self.bytes.len(), self.packed.len())
    }
}

/// The repository that this program was built from.
fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The folder of this program's own build: `target/PROFILE/widgets` is in it.
fn target_folder() -> PathBuf {
    let program = std::env::current_exe().ok();
    let folder = program.as_deref().and_then(|p| p.ancestors().nth(2)).map(Path::to_owned);
    folder.unwrap_or_else(|| repository().join("target"))
}

/// Checks that the compiler has a standard library for the target.
fn check_target() -> Result<()> {
    let mut rustc = Command::new("rustc");
    rustc.current_dir(repository()).args(["--print", "target-libdir", "--target", TARGET]);
    let printed = rustc.output().context("starting rustc failed; install Rust by rustup")?;
    let folder = String::from_utf8_lossy(&printed.stdout);
    let is_there = fs::read_dir(folder.trim()).is_ok_and(|mut files| files.next().is_some());
    if !is_there {
        bail!("this compiler cannot build for {TARGET}; run `rustup target add {TARGET}`");
    }
    Ok(())
}
