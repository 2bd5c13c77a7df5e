//! Rerun converts an exported file, and has all of it.

use std::collections::BTreeMap;

use rusty_tests::python::rerun;
use rusty_tests::*;

/// Components of Rerun, each with the topic that has it and its number of rows. Of poses
/// with covariances it makes none.
const EXPECTED: [(&str, &str, u64); 5] = [
    ("/scan_points", "Points3D:positions", 40),
    ("/map", "GridMap:data", 1),
    ("/tf", "Transform3D:translation", 400),
    ("/tf_static", "Transform3D:translation", 1),
    ("/truth/pose", "InstancePoses3D:translations", 200),
];

#[test]
fn rerun_has_every_scan_frame_and_pose() {
    let Some(rerun) = rerun() else { return };
    let (place, log) = logged("rerun", &["--ticks", "200"]);
    let (file, converted) = (place.at("run.mcap"), place.at("run.rrd"));
    sim_server(&["export", "mcap", arg(&log), "--truth"]).expect(0);
    let run = |args: &[&str]| {
        let output = Command::new(&rerun).args(args).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    run(&["mcap", "convert", arg(&file), "-o", arg(&converted)]);
    let mut rows = BTreeMap::<(&str, &str), u64>::new();
    let printed = run(&["rrd", "print", "-v", arg(&converted)]);
    // Chunk(…) with 7 rows (3.0 KiB) - /tf - … data columns: [/tf@Transform3D:translation …]
    for line in printed.lines().filter(|line| line.starts_with("Chunk(")) {
        let count = line.split(" with ").nth(1).and_then(|rest| rest.split(" rows").next());
        let digits = count.unwrap().chars().filter(char::is_ascii_digit).collect::<String>();
        for (topic, component, _) in EXPECTED {
            let column = format!("{topic}@{component}");
            if line.split([' ', '[', ']']).any(|word| word == column) {
                *rows.entry((topic, component)).or_default() += digits.parse::<u64>().unwrap();
            }
        }
    }
    let expected = EXPECTED.map(|(topic, component, count)| ((topic, component), count));
    assert_eq!(rows, BTreeMap::from(expected));
}
