//! The files that the commands of participants name, with digests of what is in them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use rusty_contract::Participant;
use xxhash_rust::xxh3::xxh3_128;

/// Digests of the files that participants run and may read, by the name that the scenario
/// has for them. Names that are no files are programs of the server or of the system.
pub fn program_files(rosters: &[Vec<Participant>]) -> BTreeMap<String, String> {
    let words = rosters.iter().flatten().flat_map(|p| p.command.iter().chain(&p.files));
    // Many settings name the same few files.
    let words: BTreeSet<&String> = words.collect();
    let digest = |word: &String| {
        let bytes = Path::new(word).is_file().then(|| fs::read(word).ok()).flatten()?;
        Some((word.clone(), format!("{:032x}", xxh3_128(&bytes))))
    };
    words.into_iter().filter_map(digest).collect()
}

#[cfg(test)]
mod tests {
    use rusty_contract::Role;

    use super::*;

    #[test]
    fn a_program_that_changes_has_another_digest() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("mine.py").display().to_string();
        let mut mine = Participant::new("mine", Role::Estimator);
        mine.command = ["python3", &program, "--gain", "2"].map(str::to_owned).to_vec();
        let rosters = [vec![Participant::new("score", Role::Scorer)], vec![mine]];
        let digests = ["one", "two", "one"].map(|text| {
            fs::write(&program, text).unwrap();
            let found = program_files(&rosters);
            assert_eq!(found.keys().collect::<Vec<_>>(), [&program]);
            found[&program].clone()
        });
        assert_ne!(digests[0], digests[1]);
        assert_eq!(digests[0], digests[2]);
    }
}
