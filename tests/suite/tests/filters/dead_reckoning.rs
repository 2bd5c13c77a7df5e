//! `dead-reckoning` as a process: its rules of integration, on the same frames.

use rusty_tests::*;

#[test]
fn the_rules_are_off_by_what_a_circle_says() {
    let place = folder();
    let add = |name: &str, options: &str| format!("{name}=dead-reckoning {options}");
    let adds = [
        add("plain", "--every 1 --rule exact"),
        add("exact", "--every 10"),
        add("midpoint", "--every 10 --rule midpoint"),
        add("euler", "--every 10 --rule euler"),
        add("euler-25", "--every 25 --rule euler"),
    ];
    let mut args = vec!["figure-eight", "--ticks", "300", "--set", "robot.slip_std=0"];
    args.extend(["--set", "world=open", "--set", "scan_every=0"]);
    adds.iter().for_each(|add| args.extend(["--add", add]));
    let report = launch("rules", place.path(), &args);
    let greatest_m = |name: &str| number(score_of(&report, name), "max_position_error_m");
    // Opposite the start of a circle of radius R, with h half the angle of a step: Euler is
    // 2R·h off, midpoint 2R·(1/sinc h − 1). Counts are worth 0.05 mm.
    let (radius_m, h) = (0.5 / 0.6, 0.5 * 0.6 * 0.2_f64);
    let expected = [
        ("exact", 0.0),
        ("midpoint", 2.0 * radius_m * (h / h.sin() - 1.0)),
        ("euler", 2.0 * radius_m * h),
        ("euler-25", 2.0 * radius_m * 2.5 * h),
    ];
    for (name, expected_m) in expected {
        let off_m = greatest_m(name) - expected_m;
        assert!(off_m.abs() < 1e-4 + 0.01 * expected_m, "{name}: {off_m} from {expected_m}");
    }
    let figures = |name: &str| {
        let keys = ["ate_rmse_m", "max_position_error_m", "final_heading_error_rad"];
        keys.map(|key| number(score_of(&report, name), key).to_bits())
    };
    assert_eq!(figures("plain"), figures("dead-reckoning"));
    // The log has the same answers when they are given again.
    sim_server(&["verify", "--clients", arg(&log_of(&report))]).expect(0);
}

#[test]
fn options_that_are_none_are_refused() {
    for (options, said) in
        [(["--every", "0"], "1.."), (["--every", "x"], "x"), (["--rule", "heun"], "midpoint")]
    {
        execute("dead-reckoning", &[&["--log", "absent"][..], &options].concat())
            .expect(2)
            .says(said);
    }
}
