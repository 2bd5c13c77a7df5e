//! Who may use whom: between packages as the architecture page has it, between the
//! modules of a package without cycles.

use std::collections::{BTreeMap, BTreeSet};

use rusty_tests::*;

use crate::{read, table};

/// A package of the workspace: its folder, its name, what it depends on.
struct Package {
    folder: String,
    name: String,
    uses: BTreeSet<String>,
}

fn packages() -> Vec<Package> {
    let root = table("Cargo.toml");
    let members = root["workspace"]["members"].as_array().unwrap();
    let package = |folder: &str| {
        let manifest = table(&format!("{folder}/Cargo.toml"));
        let name = manifest["package"]["name"].as_str().unwrap().to_owned();
        let uses = manifest["dependencies"].as_table().unwrap().keys().cloned().collect();
        Package { folder: folder.to_owned(), name, uses }
    };
    members.iter().map(|folder| package(folder.as_str().unwrap())).collect()
}

#[test]
fn packages_use_each_other_as_the_architecture_page_allows() {
    let page = read("docs/architecture.md");
    let packages = packages();
    let names: BTreeSet<&String> = packages.iter().map(|p| &p.name).collect();
    for package in &packages {
        let Package { folder, name, uses } = package;
        let head = format!("| `{folder}` | `{name}` |");
        let row = page.lines().find(|l| l.starts_with(&head));
        let row = row.unwrap_or_else(|| panic!("the page has no row for {folder}"));
        let allowed = row.split('|').nth(3).unwrap();
        for used in uses.iter().filter(|used| names.contains(used)) {
            let is_allowed =
                allowed.contains(&format!("`{used}`")) || allowed.contains("everything");
            assert!(is_allowed, "{folder} uses {used}, which the page does not allow");
        }
    }
}

#[test]
fn the_arrows_that_do_not_exist_do_not_exist() {
    let packages = packages();
    let direct: BTreeMap<String, BTreeSet<String>> =
        packages.iter().map(|p| (p.name.clone(), p.uses.clone())).collect();
    for Package { folder, name, uses } in &packages {
        let of = |start: &str| folder.starts_with(start);
        // Also by way of other packages.
        let has = |names: &[&str]| names.iter().any(|used| reaches(&direct, name, used));
        assert!(
            !of("clients") || !has(&["rusty-sim", "rusty-engine"]),
            "{folder}: models are beliefs"
        );
        assert!(folder != "shared/sim" || !has(&["rusty-link"]), "the world needs no transport");
        let draws = ["rusty-plot", "plotters", "clap", "csv", "parquet", "rusty-study"];
        let draw = |names: &[&str]| names.iter().any(|name| uses.contains(*name));
        assert!(folder != "sim-server/engine" || !draw(&draws), "the engine draws nothing");
        assert!(folder != "clients/sdk" || !draw(&draws[..2]), "the SDK draws nothing");
        let manifest = table(&format!("{folder}/Cargo.toml"));
        let kinds = ["dependencies", "build-dependencies", "dev-dependencies"];
        let named = kinds.iter().filter_map(|kind| manifest.get(*kind)?.as_table());
        let names_it = named.flat_map(toml::Table::keys).any(|used| used.starts_with("iceoryx2"));
        assert_eq!(names_it, folder == "shared/link", "{folder}: only link names iceoryx2");
    }
}

/// The path of a module below its crate, and the text of its source without
/// comments and unit tests.
type Modules = BTreeMap<Vec<String>, String>;

fn modules(folder: &Path, at: &[String], found: &mut Modules) {
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let (path, mut module) = (entry.path(), at.to_vec());
        let stem = arg(&path.file_stem().unwrap()).to_owned();
        if stem.contains("test") || stem == "bin" {
            continue;
        }
        if !["lib", "main", "mod"].contains(&stem.as_str()) {
            module.push(stem);
        }
        if path.is_dir() {
            modules(&path, &module, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
            let lines = text.lines().map(|line| line.split("//").next().unwrap());
            found.insert(module, lines.collect::<Vec<_>>().join(" "));
        }
    }
}

/// All paths of a `use` tree: `a::{b, c::{d}}` has `a::b` and `a::c::d`.
fn expand(tree: &str, before: &str, paths: &mut BTreeSet<String>) {
    let tree = tree.trim();
    let Some((head, body)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap().trim();
        paths.insert(format!("{before}{path}"));
        return;
    };
    let before = format!("{before}{}", head.trim());
    let (mut depth, mut start) = (0, 0);
    let body = body.trim_end().strip_suffix('}').unwrap_or(body);
    for (i, c) in body.char_indices().chain([(body.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !body[start..i].trim().is_empty() {
                    expand(&body[start..i], &before, paths);
                }
                start = i + 1;
            }
            _ => {}
        }
    }
}

/// The paths that a source names: those of its `use` items, and those that begin
/// with `crate`, `super` or `self`.
fn named(text: &str) -> BTreeSet<String> {
    let mut paths = BTreeSet::new();
    for item in text.split(" use ").skip(1) {
        expand(item.split(';').next().unwrap(), "", &mut paths);
    }
    for word in text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')) {
        if ["crate::", "super::", "self::"].iter().any(|start| word.starts_with(start)) {
            paths.insert(word.to_owned());
        }
    }
    paths
}

/// The module that a path leads to, seen from another.
fn leads_to(path: &str, from: &[String], modules: &Modules) -> Option<Vec<String>> {
    let mut words = path.split("::").map(str::trim).peekable();
    let mut at = match *words.peek()? {
        "crate" => Vec::new(),
        "self" => from.to_vec(),
        "super" => {
            let mut at = from.to_vec();
            while words.next_if_eq(&"super").is_some() {
                at.pop();
            }
            at
        }
        first => {
            let child = [from, &[first.to_owned()]].concat();
            modules.contains_key(&child).then(|| from.to_vec())?
        }
    };
    for word in words.filter(|word| !["crate", "self"].contains(word)) {
        let next = [&at[..], &[word.to_owned()]].concat();
        if !modules.contains_key(&next) {
            break;
        }
        at = next;
    }
    Some(at)
}

/// For the modules of one parent: which uses which, with all that is below them.
fn siblings(modules: &Modules) -> BTreeMap<Vec<String>, BTreeMap<String, BTreeSet<String>>> {
    let mut found: BTreeMap<_, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (from, text) in modules {
        for to in named(text).iter().filter_map(|path| leads_to(path, from, modules)) {
            let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if let (Some(a), Some(b)) = (from.get(common), to.get(common)) {
                let of_parent = found.entry(from[..common].to_vec()).or_default();
                of_parent.entry(a.clone()).or_default().insert(b.clone());
            }
        }
    }
    found
}

/// Whether `from` uses `to`, directly or by way of others.
fn reaches(uses: &BTreeMap<String, BTreeSet<String>>, from: &str, to: &str) -> bool {
    let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
    while let Some(module) = next.pop() {
        for used in uses.get(module).into_iter().flatten() {
            if used == to {
                return true;
            }
            if seen.insert(used) {
                next.push(used);
            }
        }
    }
    false
}

#[test]
fn the_modules_of_a_package_have_no_cycles() {
    let mut cycles = Vec::new();
    for Package { folder, .. } in packages() {
        let mut all = Modules::new();
        modules(&repository().join(&folder).join("src"), &[], &mut all);
        for (parent, uses) in siblings(&all) {
            let round = |module: &&String| reaches(&uses, module, module);
            let round: Vec<&String> = uses.keys().filter(round).collect();
            if !round.is_empty() {
                cycles.push(format!("{folder} {}: {round:?}", parent.join("::")));
            }
        }
    }
    assert!(cycles.is_empty(), "modules that use each other:\n{}", cycles.join("\n"));
}

#[test]
fn a_cycle_is_found() {
    let mut all = Modules::new();
    let mut add = |path: &str, text: &str| {
        all.insert(path.split("::").map(str::to_owned).collect(), format!(" {text}"));
    };
    add("a", "use crate::b::{self, deep::{C, D as E}}; fn f() {}");
    add("b", "mod deep;");
    add("b::deep", "fn g() { super::super::c::h() }");
    add("c", "use crate::a::F;");
    add("d", "use super::c;");
    let uses = &siblings(&all)[&Vec::new()];
    for module in ["a", "b", "c"] {
        assert!(reaches(uses, module, module), "{module} in {uses:?}");
    }
    assert!(!reaches(uses, "d", "d"));
}
