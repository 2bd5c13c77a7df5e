//! The README's first filter, by a reader with only the README: a separate package
//! next to the repository, built, added to a run, scored. So are the examples.

use rusty_engine::scenario_file::{self, BUILT_IN};
use rusty_tests::*;

/// A new package with the README's code and a path to the SDK, which is all that
/// its one `cargo add` gives; and with every example as another program.
fn write_package(at: &Path) {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let code = readme.split("```rust\n").nth(1).unwrap().split("```").next().unwrap();
    fs::create_dir_all(at.join("src")).unwrap();
    fs::write(at.join("src/main.rs"), code).unwrap();
    fs::create_dir(at.join("src/bin")).unwrap();
    for example in fs::read_dir(repository().join("clients/sdk/examples")).unwrap() {
        let example = example.unwrap();
        let program = format!("src/bin/my-{}", example.file_name().to_str().unwrap());
        fs::copy(example.path(), at.join(program)).unwrap();
    }
    let clients = repository().join("clients/sdk");
    let manifest = format!(
        "[package]\nname = \"my-filter\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
         [dependencies]\nrusty-clients = {{ path = {clients:?} }}\n\n[workspace]\n"
    );
    // Without the repository's profiles, as a reader has it; with its versions, so that
    // nothing is fetched.
    fs::write(at.join("Cargo.toml"), manifest).unwrap();
    fs::copy(repository().join("Cargo.lock"), at.join("Cargo.lock")).unwrap();
}

#[test]
fn every_built_in_scenario_starts_programs_of_the_readme_s_build() {
    for (name, _) in BUILT_IN {
        for participant in scenario_file::load(name, &[]).unwrap().scenario.participants {
            // An example would be in another folder, and is not built.
            let program = binaries().join(&participant.command[0]);
            assert!(program.is_file(), "{name}: {}", program.display());
        }
    }
}

#[test]
fn the_readme_s_filter_builds_joins_and_is_scored() {
    let place = folder();
    let package = place.at("my-filter");
    write_package(&package);
    let target = binaries().parent().unwrap();
    let built = Command::new(env!("CARGO"))
        .current_dir(&package)
        .args(["build", "--quiet", "--offline", "--target-dir"])
        .arg(target)
        .status()
        .unwrap();
    assert!(built.success(), "the README's filter or an example does not build");
    let filter = target.join("debug/my-filter");
    let add = format!("my-filter={}", filter.display());
    let out = place.at("run");
    let report = launch("first", &out, &["--ticks", "300", "--add", &add]);
    assert_eq!(list(&report, "scores").len(), 2);
    let [mine, theirs] = ["my-filter", "dead-reckoning"].map(|name| score_of(&report, name));
    assert!(number(mine, "ate_rmse_m") > 0.0);
    assert_eq!(mine["ate_rmse_m"], theirs["ate_rmse_m"], "the same arithmetic, the same score");
}
