//! `sim-server doctor`: what it says of the machine these tests run on.

use rusty_sim::GOLDENS;
use rusty_tests::*;

#[test]
fn the_doctor_finds_the_bits_and_the_memory_in_order() {
    let found = sim_server(&["doctor", "--json"]).expect(0).json();
    assert_eq!(found["same_bits"], true);
    let goldens = list(&found, "goldens");
    assert_eq!(goldens.len(), GOLDENS.len());
    for (said, golden) in goldens.iter().zip(&GOLDENS) {
        assert_eq!((text(said, "name"), text(said, "pins")), (golden.name, golden.pins));
        assert_eq!(text(said, "expected"), golden.expected);
        assert_eq!(text(said, "found"), golden.expected);
        assert_eq!(said["ok"], true);
    }
    assert_eq!(text(&found["build"], "arch"), std::env::consts::ARCH);
    // The binaries under test are built in the profile of the tests.
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    assert_eq!(text(&found["build"], "profile"), profile);
    assert_eq!(found["shared_memory"]["writable"], true);
    assert!(found["sandbox"]["landlock_abi"].is_u64(), "{}", found["sandbox"]);
    assert!(found["shared_memory"]["free_bytes"].as_u64().unwrap() > 0);

    let said = sim_server(&["doctor"]).expect(0).stdout;
    for golden in &GOLDENS {
        let row = said.lines().find(|line| line.starts_with(golden.name)).unwrap();
        assert!(row.matches(golden.expected).count() == 2 && row.ends_with("ok"), "{row}");
    }
    assert!(said.contains("same bits      yes"), "{said}");
    assert_eq!(said.lines().last(), found["verdict"].as_str());
}
