//! What is outside the workspace is built by CI, its lock files fit the crates inside, and
//! the profile of the fuzz targets is the workspace's.

use std::process::Command;

use toml::Value;

use crate::{read, table};

#[test]
fn what_is_outside_the_workspace_is_checked_by_ci_with_a_current_lock_file() {
    let workspace = table("Cargo.toml");
    let outside = workspace["workspace"]["exclude"].as_array().unwrap();
    assert_eq!(outside.len(), 2);
    for folder in outside.iter().map(|folder| folder.as_str().unwrap()) {
        let own = table(&format!("{folder}/Cargo.toml"));
        assert!(own.contains_key("workspace"), "{folder} is not a workspace");
        let check = format!("--locked --manifest-path {folder}/Cargo.toml");
        assert!(read(".ci/run").contains(&check), "CI does not check {folder}");
        let manifest = rusty_tests::repository().join(folder).join("Cargo.toml");
        // Resolves, and downloads no crate of any platform.
        let mut update = Command::new(env!("CARGO"));
        update.args(["update", "--workspace", "--locked", "--offline"]);
        let output = update.arg("--manifest-path").arg(&manifest).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(
            !message.contains("lock file"),
            "{message}remedy: cargo check --manifest-path {folder}/Cargo.toml, and commit the lock file"
        );
        if !output.status.success() {
            println!("skipped: {folder}: its crates are not known to this machine: {message}");
        }
    }
}

/// What both use is checked once where the profiles are equal, down to the level of what
/// only builds use.
#[test]
fn the_fuzz_targets_have_the_profile_of_the_workspace() {
    let folders = ["", "tests/fuzz/"];
    let locks = folders.map(|folder| table(&format!("{folder}Cargo.lock"))["package"].clone());
    let is_in = |lock: &Value, name: &str| {
        let mut packages = lock.as_array().unwrap().iter();
        packages.any(|package| package["name"].as_str() == Some(name))
    };
    // Cargo warns of levels for crates that are not used, so that each names its own.
    let [ours, theirs] = folders.map(|folder| {
        let mut profile = table(&format!("{folder}Cargo.toml"))["profile"]["dev"].clone();
        let packages = profile["package"].as_table_mut().unwrap();
        packages.retain(|name, _| name == "*" || locks.iter().all(|lock| is_in(lock, name)));
        profile
    });
    assert_eq!(theirs, ours);
}
