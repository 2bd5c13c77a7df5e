//! The rules of the house, checked: sizes of rooms, arrows between them,
//! documents that say what the sources say.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use rusty_tests::repository;
use sim_server::bench::page::{Documents, Notes, markdown};

/// Lines of a file. "About 400", with some air.
const MAX_LINES: usize = 420;

const ROOMS: [(&str, &str); 11] = [
    ("shared/geometry", "rusty-geometry"),
    ("shared/contract", "rusty-contract"),
    ("shared/sim", "rusty-sim"),
    ("shared/link", "rusty-link"),
    ("shared/plot", "rusty-plot"),
    ("sim-server", "sim-server"),
    ("clients", "rusty-clients"),
    ("clients/filters", "rusty-filters"),
    ("clients/python", "rusty-python"),
    ("tests", "rusty-tests"),
    ("tests/wasm", "rusty-wasm-goldens"),
];

fn read(path: impl AsRef<Path>) -> String {
    let path = repository().join(path);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        let name = entry.file_name();
        if path.is_dir() {
            if name != "target" && name != "runs" && name != ".git" {
                walk(&path, found);
            }
        } else {
            found.push(path);
        }
    }
}

fn files(ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    walk(&repository(), &mut found);
    found.retain(|p| p.extension().is_some_and(|e| e == ending));
    found.sort();
    found
}

#[test]
fn every_source_opens_with_a_word_about_itself_and_stays_small() {
    let sources = files("rs");
    assert!(sources.len() > 80);
    for path in sources {
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("//!"), "{} does not open with //!", path.display());
        let lines = text.lines().count();
        assert!(
            lines <= MAX_LINES,
            "{} has {lines} lines: which noun wants a file?",
            path.display()
        );
    }
}

#[test]
fn the_repository_speaks_of_the_project_alone() {
    // Put together here, so that this file does not contain them.
    let banned: Vec<String> = [
        ["/wo", "rk/"],
        ["/fa", "rm/"],
        ["TO", "DO"],
        ["FIX", "ME"],
        ["sub", "agent"],
        ["this ses", "sion"],
        ["DEVELOPERS", ".md"],
        ["crates.io-", "index"],
    ]
    .iter()
    .map(|[a, b]| format!("{a}{b}"))
    .collect();
    for ending in ["rs", "py", "pyi", "md", "toml", "json", "yml"] {
        for path in files(ending) {
            let text = fs::read_to_string(&path).unwrap();
            for word in &banned {
                assert!(!text.contains(word.as_str()), "{} says {word:?}", path.display());
            }
        }
    }
}

/// Dependencies of a room, without those of its tests.
fn dependencies(room: &str) -> BTreeSet<String> {
    let table: toml::Table = toml::from_str(&read(format!("{room}/Cargo.toml"))).unwrap();
    table["dependencies"].as_table().unwrap().keys().cloned().collect()
}

#[test]
fn the_arrows_are_those_of_the_architecture_page() {
    let page = read("ARCHITECTURE.md");
    let packages: BTreeSet<&str> = ROOMS.iter().map(|(_, package)| *package).collect();
    for (room, package) in ROOMS {
        let row = page
            .lines()
            .find(|l| l.starts_with(&format!("| `{room}` | `{package}` |")))
            .unwrap_or_else(|| panic!("no row for {room}"));
        let may_use = row.split('|').nth(3).unwrap();
        for used in dependencies(room).iter().filter(|d| packages.contains(d.as_str())) {
            let allowed = may_use.contains(&format!("`{used}`")) || room == "tests";
            assert!(allowed, "{room} uses {used}, which the page does not allow");
        }
    }
    for room in ["clients", "clients/filters"] {
        assert!(!dependencies(room).contains("rusty-sim"), "models are beliefs, not the world");
    }
    assert!(!dependencies("shared/sim").contains("rusty-link"), "the world needs no transport");
    for (room, _) in ROOMS {
        let names_it = dependencies(room).contains("iceoryx2");
        assert_eq!(names_it, room == "shared/link", "{room}: only link names iceoryx2");
    }
}

#[test]
fn the_modules_are_those_of_the_architecture_page() {
    let page = read("ARCHITECTURE.md");
    let (_, table) = page.split_once("## The modules").unwrap();
    for (room, _) in ROOMS.iter().filter(|(room, _)| !room.starts_with("tests")) {
        let row = table.lines().find(|l| l.starts_with(&format!("| `{room}` |"))).unwrap();
        let named: BTreeSet<String> =
            row.split('`').skip(3).step_by(2).map(str::to_owned).collect();
        let declared: BTreeSet<String> = read(format!("{room}/src/lib.rs"))
            .lines()
            .filter_map(|l| l.strip_prefix("pub mod ").or_else(|| l.strip_prefix("mod ")))
            .filter_map(|l| l.strip_suffix(';').map(str::to_owned))
            .collect();
        assert_eq!(named, declared, "{room}: the page and lib.rs");
    }
}

#[test]
fn what_stands_beside_the_workspace_is_in_nobody_s_build() {
    let root: toml::Table = toml::from_str(&read("Cargo.toml")).unwrap();
    let outside: Vec<&str> =
        root["workspace"]["exclude"].as_array().unwrap().iter().flat_map(|e| e.as_str()).collect();
    let ci = read(".ci/run");
    for room in ["benches/peers", "fuzz"] {
        assert!(outside.contains(&room), "{room} is not excluded");
        let manifest: toml::Table = toml::from_str(&read(format!("{room}/Cargo.toml"))).unwrap();
        assert!(manifest.contains_key("workspace"), "{room} is no workspace of its own");
        assert!(read(format!("{room}/Cargo.lock")).contains("version = "), "{room} is not locked");
        assert!(!ci.contains(room), "CI builds {room}");
        let package = manifest["package"]["name"].as_str().unwrap();
        for (inside, _) in ROOMS {
            assert!(!dependencies(inside).contains(package), "{inside} uses {room}");
        }
    }
}

/// The fenced blocks of a language.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    text.split(&fence).skip(1).map(|t| t.split("```").next().unwrap().to_owned()).collect()
}

#[test]
fn the_first_screen_has_two_commands_and_ci_runs_both() {
    let readme = read("README.md");
    let (first, _) = readme.split_once("## Your first filter").unwrap();
    let commands = blocks(first, "sh");
    assert_eq!(commands.len(), 2, "exactly two commands");
    let ci = read(".ci/run");
    for command in commands {
        assert!(ci.contains(command.trim()), "CI does not run {command:?}");
    }
}

#[test]
fn the_readme_s_first_filter_is_the_first_example() {
    let example = read("clients/examples/01_first_estimator.rs");
    assert!(example.lines().count() <= 15);
    assert_eq!(blocks(&read("README.md"), "rust"), [example]);
}

#[test]
fn the_readme_s_scenario_can_be_read() {
    let scenario = &blocks(&read("README.md"), "toml")[0];
    rusty_contract::Scenario::from_toml(scenario).unwrap();
}

#[test]
fn the_changelog_opens_with_what_changes_bits() {
    let text = read("CHANGELOG.md");
    let (_, newest) = text.split_once("\n## ").unwrap();
    let section = newest.lines().find(|l| l.starts_with("### ")).unwrap();
    assert_eq!(section, "### Changes bits");
}

#[test]
fn every_ban_has_a_reason() {
    for file in ["clippy.toml", "shared/clippy.toml", "shared/link/clippy.toml"] {
        let table: toml::Table = toml::from_str(&read(file)).unwrap();
        for key in ["disallowed-methods", "disallowed-types"] {
            for ban in table.get(key).and_then(|b| b.as_array()).into_iter().flatten() {
                let reason = ban.get("reason").and_then(|r| r.as_str()).unwrap_or_default();
                assert!(reason.len() > 10, "{file}: {ban} has no reason");
            }
        }
    }
}

/// Rows of a layout table in a module's documentation: name, offset, size.
fn documented(source: &str) -> Vec<(String, usize, usize)> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.strip_prefix("//! |")?.split('|').map(str::trim).collect();
        let name = cells.get(2)?.trim_matches('`').to_owned();
        Some((name, cells.first()?.parse().ok()?, cells.get(1)?.parse().ok()?))
    };
    read(source).lines().filter_map(row).collect()
}

#[test]
fn the_documented_layouts_are_the_real_ones() {
    let tables = rusty_contract::layout::tables();
    for (source, table) in [
        ("shared/contract/src/frame.rs", tables[0]),
        ("shared/contract/src/answer.rs", tables[1]),
        ("shared/contract/src/tally.rs", tables[2]),
    ] {
        let real: Vec<(String, usize, usize)> =
            table.fields.iter().map(|f| (f.name.to_owned(), f.offset, f.size)).collect();
        assert_eq!(documented(source), real, "{source}");
    }
}

/// The tests that PROMISES.md names: path and function.
fn promised() -> Vec<(String, String)> {
    let text = read("PROMISES.md");
    let quoted = text.split('`').skip(1).step_by(2);
    let test = |words: &str| {
        let (path, name) = words.split_once(".rs::")?;
        Some((format!("{path}.rs"), name.to_owned()))
    };
    quoted.filter_map(test).collect()
}

#[test]
fn every_promise_names_a_test_that_is_there() {
    let tests = promised();
    assert!(tests.len() > 30, "{} tests are named", tests.len());
    for (path, name) in tests {
        let head = format!("fn {name}(");
        let source = read(&path);
        let at = source.find(&head).unwrap_or_else(|| panic!("{path} has no test {name}"));
        let before = source[..at].trim_end();
        assert!(before.ends_with("#[test]"), "{path}: {name} is no test");
    }
}

#[test]
fn every_promise_has_a_test() {
    let text = read("PROMISES.md");
    let promises = text.split("## The long runs").next().unwrap();
    for row in promises.lines().filter(|l| l.starts_with("| ")) {
        let cells: Vec<&str> = row.split(" | ").collect();
        if cells[0] == "| promise" {
            continue;
        }
        let held = cells.last().unwrap_or(&"");
        assert!(held.contains(".rs::") || held.contains("compile-fail"), "nothing holds {row}");
    }
}

/// What the benches found, and the notes on it.
fn benched() -> (Documents, Notes) {
    let folder = repository().join("benchmarks");
    let documents = Documents::read(&folder.join("latest.json")).unwrap();
    (documents, Notes::read(&folder.join("notes.md")).unwrap())
}

#[test]
fn the_page_of_benchmarks_is_what_its_command_writes() {
    let (documents, notes) = benched();
    let page = markdown::render(&documents, &notes).unwrap();
    assert!(
        read("BENCHMARKS.md") == page,
        "BENCHMARKS.md is not what its documents and notes make: sim-server bench page \
         --write BENCHMARKS.md --from benchmarks/latest.json"
    );
}

#[test]
fn the_page_of_benchmarks_has_the_rows_that_the_benches_have() {
    let (documents, _) = benched();
    let stale = markdown::stale_rows(&documents).unwrap();
    assert!(stale.is_empty(), "measure again, these rows are new or gone: {stale:#?}");
}

#[test]
fn every_goal_that_was_missed_is_explained() {
    let (documents, notes) = benched();
    let silent = markdown::unexplained(&documents, &notes).unwrap();
    assert!(silent.is_empty(), "benchmarks/notes.md says nothing on {silent:?}");
}
