//! What shells and `man` know of the commands.

use rusty_tests::*;

#[test]
fn bash_completes_verbs_and_options() {
    let script = sim_server(&["completions", "bash"]).expect(0).stdout;
    let place = folder();
    let file = place.write("completions.sh", &script);
    let complete = |words: &str, last: usize| {
        let ask = format!(
            "source {file}; COMP_WORDS=({words}); COMP_CWORD={last}; \
             set -- $(complete -p sim-server | grep -o -e '-F [^ ]*'); \
             $2 sim-server \"${{COMP_WORDS[{last}]}}\" \"${{COMP_WORDS[{last}-1]}}\"; \
             printf '%s\\n' \"${{COMPREPLY[@]}}\""
        );
        let said = Command::new("bash").args(["-c", &ask]).output().unwrap();
        let words = String::from_utf8(said.stdout).unwrap();
        words.lines().map(str::to_owned).collect::<Vec<String>>()
    };
    if Command::new("bash").arg("--version").output().is_err() {
        return skipped("there is no bash");
    }
    assert_eq!(complete("sim-server la", 1), ["launch", "layout"]);
    assert_eq!(complete("sim-server launch --see", 2), ["--seed"]);
}

#[test]
fn every_verb_has_a_page_and_none_is_replaced_unasked() {
    let place = folder();
    let pages = place.at("man1");
    let man = |more: &[&str]| sim_server(&[&["man", arg(&pages)], more].concat());
    man(&[]).expect(0);
    let page = fs::read_to_string(pages.join("sim-server-launch.1")).unwrap();
    assert!(page.contains(".TH") && page.contains(r"\-\-seed"), "{page}");
    assert!(pages.join("sim-server-import-carmen.1").exists());
    assert!(!pages.join("sim-server-bench-peer.1").exists());
    let file = pages.join("sim-server.1");
    fs::write(&file, "mine").unwrap();
    man(&[]).expect(2).says(arg(&file));
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    man(&["--force"]).expect(0);
    assert_ne!(fs::read_to_string(&file).unwrap(), "mine");
}
