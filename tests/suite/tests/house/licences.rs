//! The licences of all crates are among those that `deny.toml` allows.

use std::collections::BTreeSet;
use std::process::Command;

use serde_json::Value;
use spdx::Expression;

use crate::table;

/// A licence, with its exception if it has one, as `deny.toml` writes it.
fn allowed(deny: &toml::Table) -> BTreeSet<String> {
    let list = deny["licenses"]["allow"].as_array().unwrap();
    list.iter().map(|licence| licence.as_str().unwrap().to_owned()).collect()
}

fn is_allowed(expression: &str, allowed: &BTreeSet<String>) -> bool {
    // `MIT/Apache-2.0` is how older crates write `OR`.
    let expression = Expression::parse_mode(expression, spdx::ParseMode::LAX);
    expression.is_ok_and(|e| e.evaluate(|licence| allowed.contains(&licence.to_string())))
}

#[test]
fn every_crate_has_a_licence_that_is_allowed() {
    let allowed = allowed(&table("deny.toml"));
    let mut metadata = Command::new(env!("CARGO"));
    metadata.args(["metadata", "--format-version", "1", "--locked"]);
    metadata.args(["--filter-platform", "x86_64-unknown-linux-gnu"]);
    let output = metadata.current_dir(rusty_tests::repository()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let resolved = metadata["resolve"]["nodes"].as_array().unwrap();
    let used: BTreeSet<&str> = resolved.iter().map(|node| node["id"].as_str().unwrap()).collect();
    let packages = metadata["packages"].as_array().unwrap();
    let packages = packages.iter().filter(|p| used.contains(p["id"].as_str().unwrap()));
    let refused: Vec<String> = packages
        .filter(|p| !p["license"].as_str().is_some_and(|l| is_allowed(l, &allowed)))
        .map(|p| format!("{} {}: {}", p["name"], p["version"], p["license"]))
        .collect();
    assert!(used.len() > 300, "{}", used.len());
    assert!(refused.is_empty(), "not in deny.toml: {refused:#?}");
}

#[test]
fn a_choice_is_allowed_by_one_and_a_sum_by_all() {
    let allowed = BTreeSet::from(["MIT", "Zlib"].map(str::to_owned));
    for (expression, is) in [
        ("MIT", true),
        ("GPL-3.0-only OR MIT", true),
        ("MIT/Apache-2.0", true),
        ("MIT AND Zlib", true),
        ("GPL-3.0-only AND MIT", false),
        ("GPL-3.0-only", false),
        ("no licence", false),
    ] {
        assert_eq!(is_allowed(expression, &allowed), is, "{expression}");
    }
}
