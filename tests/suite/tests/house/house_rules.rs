//! The rules of the house: sizes of files, words, and pages that agree with the
//! sources.

use std::collections::BTreeSet;

use rusty_bench::page::{Documents, render};
use rusty_tests::*;

use crate::{read, table};

/// Lines of a file. "About 400", with some air.
const MAX_LINES: usize = 420;

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
        // Programs are not built for tests: what needs one is in the library.
        let is_program = path.components().any(|part| part.as_os_str() == "bin");
        assert!(!(is_program && text.contains("#[test]")), "{} has tests", path.display());
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

/// Words that pages, help texts and doc comments do not use, and their replacements.
const PLAIN: [(&str, &str); 27] = [
    ("onlooker", "observer"),
    ("witness", "observer"),
    ("beside", "next to, with or compared with"),
    ("somebody", "a process or a participant"),
    ("someone", "a process or a participant"),
    ("nobody", "no process or no participant"),
    ("whoever", "a process that"),
    ("goodbye", "leave message"),
    ("last word", "end of run"),
    ("last words", "last lines"),
    ("comes of", "results from"),
    ("come of", "result from"),
    ("came of", "resulted from"),
    ("wishes", "control requests"),
    ("is gone", "has ended"),
    ("are gone", "have ended"),
    ("of its own", "separate"),
    ("of their own", "separate"),
    ("so many", "N"),
    ("so-manyth", "every N"),
    ("stand in", "are in"),
    ("stands in", "is in"),
    ("lie in", "are in"),
    ("lies in", "is in"),
    ("has a seat", "is a participant"),
    ("that is none", "invalid"),
    ("looks on", "observes"),
];

/// The numbers of the lines in which a phrase begins; it may end in the next line.
fn lines_with(text: &str, phrase: &str) -> Vec<usize> {
    let prose = |line: &str| line.trim_start_matches([' ', '/', '!', '*', '>']).to_lowercase();
    let lines: Vec<String> = text.lines().map(prose).collect();
    let is_name = |c: char| c.is_alphanumeric() || "_-`".contains(c);
    let begins_in = |number: &usize| {
        let line = &lines[number - 1];
        let both = format!("{line} {}", lines.get(*number).map_or("", String::as_str));
        both.match_indices(phrase).any(|(at, _)| {
            let (before, after) = (&both[..at], &both[at + phrase.len()..]);
            // A field or an option of this name is not prose.
            let is_prose = !before.ends_with(is_name) && !after.starts_with(is_name);
            at < line.len() && is_prose && !after.starts_with(':')
        })
    };
    (1..=lines.len()).filter(begins_in).collect()
}

/// The doc comments of a source, at their lines.
fn doc_comments(source: &str) -> String {
    let is_doc = |line: &&str| ["///", "//!"].iter().any(|s| line.trim_start().starts_with(s));
    let lines: Vec<&str> =
        source.lines().map(|line| Some(line).filter(is_doc).unwrap_or("")).collect();
    lines.join("\n")
}

#[test]
fn pages_help_texts_and_doc_comments_use_plain_words() {
    let is_read = |path: &str| match path.rsplit_once('/') {
        None => path == "README.md",
        Some(("docs", page)) => page != "benchmarks.md" && page.ends_with(".md"),
        Some(_) => {
            path.starts_with("sim-server/src/")
                || (path.starts_with("clients/") && path.contains("/src/program"))
                || path == "clients/sdk/src/args.rs"
        }
    };
    let mut found = Vec::new();
    for path in [files("md"), files("rs")].concat() {
        let name = arg(path.strip_prefix(repository()).unwrap());
        let mut text = read(&path);
        match (is_read(name), name.ends_with(".rs")) {
            (true, _) => {}
            (false, true) => text = doc_comments(&text),
            (false, false) => continue,
        }
        for (word, plain) in PLAIN {
            let lines = lines_with(&text, word);
            found.extend(lines.iter().map(|n| format!("{name}:{n}: {word:?}: write {plain}")));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert_eq!(lines_with("/// So\n/// many of it,\n--beside, beside", "so many"), [1]);
    assert_eq!(lines_with("pub beside: u8\n--beside\nput beside it", "beside"), [3]);
    assert_eq!(lines_with(&doc_comments("// beside\n    /// beside it"), "beside"), [2]);
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
    let example = read("clients/sdk/examples/01_first_estimator.rs");
    assert!(example.lines().count() <= 15);
    assert_eq!(blocks(&read("README.md"), "rust"), [example]);
}

#[test]
fn the_scenarios_of_the_pages_can_be_read() {
    for page in ["README.md", "docs/scenarios.md"] {
        let scenario = &blocks(&read(page), "toml")[0];
        rusty_contract::Scenario::from_toml(scenario).unwrap_or_else(|e| panic!("{page}: {e}"));
    }
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
        let table = table(file);
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

/// The tests that docs/promises.md names: path and function.
fn promised() -> Vec<(String, String)> {
    let text = read("docs/promises.md");
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
    let text = read("docs/promises.md");
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

/// The reports of the benchmarks, and the template of their page.
fn benched() -> (Documents, String) {
    let folder = repository().join("docs/benchmarks");
    let documents = Documents::read(&folder.join("latest.json")).unwrap();
    (documents, read(folder.join("notes.md")))
}

#[test]
fn the_page_of_benchmarks_is_what_its_command_writes() {
    let (documents, template) = benched();
    let page = render::render(&documents, &template).unwrap();
    assert!(
        read("docs/benchmarks.md") == page,
        "docs/benchmarks.md is not what its documents and notes make: sim-server bench page \
         --write docs/benchmarks.md --from docs/benchmarks/latest.json"
    );
}

#[test]
fn the_page_of_benchmarks_has_the_rows_that_the_benches_have() {
    let (documents, _) = benched();
    let stale = render::stale_rows(&documents).unwrap();
    assert!(stale.is_empty(), "measure again, these rows are new or gone: {stale:#?}");
}

#[test]
fn every_goal_that_was_missed_is_explained() {
    let (documents, template) = benched();
    let silent = render::unexplained(&documents, &template).unwrap();
    assert!(silent.is_empty(), "docs/benchmarks/notes.md says nothing on {silent:?}");
}

/// What the top level holds in the repository; a file that a command left there is not added
/// unnoticed.
#[test]
fn the_top_level_holds_the_folders_and_the_configuration_of_tools() {
    let mut list = Command::new("git");
    let listed = list.arg("ls-files").current_dir(repository()).output();
    let Some(listed) =
        listed.ok().filter(|output| output.status.success() && !output.stdout.is_empty())
    else {
        return println!("skipped: no list of files here, for this is not a checkout of git");
    };
    let listed = String::from_utf8(listed.stdout).unwrap();
    let found: BTreeSet<&str> = listed.lines().filter_map(|path| path.split('/').next()).collect();
    let expected = ".ci .gitignore CHANGELOG.md Cargo.lock Cargo.toml LICENSE-APACHE LICENSE-MIT \
        README.md clients clippy.toml deny.toml docs rust-toolchain.toml rustfmt.toml shared \
        sim-server tests";
    assert_eq!(found, expected.split_whitespace().collect());
}
