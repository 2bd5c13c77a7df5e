//! `sim-server umbmark` and `sim-server budget`, as a person uses them.

use rusty_tests::*;

/// A robot to be calibrated: wheelbase off by 1 %, diameters by 0.5 %, and hardly
/// any slip.
const OFF: [&str; 6] = [
    "--set",
    "robot.track_bias=0.01",
    "--set",
    "robot.radius_bias_right=0.005",
    "--set",
    "robot.slip_std=0.001",
];

#[test]
fn a_square_recovers_what_is_wrong_and_draws_it() {
    let place = folder();
    let [svg, png] = ["laps.svg", "laps.png"].map(|name| place.at(name));
    let pictures = ["--svg", arg(&svg), "--png", arg(&png)];
    let args = [&["umbmark", "--json"], &OFF[..], &pictures].concat();
    let found = sim_server(&args).expect(0).json();
    for factor in ["wheelbase", "diameters"] {
        let estimated = number(&found, &format!("estimate.exact.factors.{factor}"));
        let error = number(&found, &format!("estimate.exact.standard_errors.{factor}"));
        let truth = number(&found, &format!("truth.{factor}"));
        // Student's t for five laps each way; rounding to counts.
        let within = 5.0 * error + 3e-4;
        assert!((estimated - truth).abs() < within, "{factor}: {estimated} for {truth}");
    }
    let before = number(&found, "estimate.e_max_syst_m");
    let after = number(&found, "corrected_by_exact.e_max_syst_m");
    assert!(after < 0.1 * before, "{before} to {after}");
    assert!(fs::read_to_string(&svg).unwrap().contains("UMBmark of apartment"));
    assert!(fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    // The same again, to the byte.
    let args = [&args[..], &["--force"]].concat();
    assert_eq!(sim_server(&args).expect(0).json(), found);

    let text = sim_server(&[&["umbmark"], &OFF[..]].concat()).expect(0).stdout;
    assert!(text.contains("E_b") && text.contains("exact arcs"), "{text}");
}

#[test]
fn a_budget_is_the_chapters_table() {
    let args = ["budget", "--seeds", "0..20", "--set", "robot.radius_bias_right=0.01"];
    let found = sim_server(&[&args[..], &["--json"]].concat()).expect(0).json();
    let rows = list(&found, "sources");
    let drift_m: Vec<f64> =
        rows.iter().map(|row| number(row, "final_position_error_m.mean")).collect();
    assert!((drift_m[0] - 1.062_004_987_974e-4).abs() < 1e-12, "{drift_m:?}");
    assert!((drift_m[2] - 2.678_329_605_898).abs() < 1e-10, "{drift_m:?}");
    let text = sim_server(&args).expect(0).stdout;
    for part in ["quantization only", "slip, σ = 0.02", "right radius +1 %", "all together"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn what_cannot_be_used_is_refused() {
    for (args, words) in [
        (&["umbmark", "--side", "0"][..], "--side 0: is out of range"),
        (&["umbmark", "--speed", "nan"], "--speed NaN"),
        (&["umbmark", "--runs", "1"], "1 is not in 2.."),
        (&["umbmark", "--set", "robot.track_bias=2"], "robot.track_bias = 2: is out of range"),
        (&["umbmark", "--set", "robot.wheel_limit_rad_s=0.01"], "--speed 0.5: is out of range"),
        (&["umbmark", "--set", "robot.ticks_per_rev=1"], "finer encoders"),
        (&["budget", "--seeds", "5..5"], "no seed in it"),
        (&["budget", "--seeds", "0..10000001"], "are too many; use at most 10000000"),
        (&["budget", "driver"], "script.kind = driver: needs a client"),
        (&["budget", "office"], "people = 8: stop the robot"),
        (&["budget", "nowhere.toml"], "built-in"),
    ] {
        let ended = sim_server(args).expect(2);
        assert!(ended.stderr.contains(words), "{args:?}: {}", ended.stderr);
    }
    let place = folder();
    let folder = arg(place.path());
    sim_server(&["umbmark", "--runs", "2", "--svg", folder]).expect(1).says(folder);
}

/// Whether a process has a separate handler for SIGINT.
fn listens(pid: u32) -> bool {
    u64::from_str_radix(&status(pid, "SigCgt"), 16).unwrap_or(0) & 2 != 0
}

#[test]
fn a_budget_can_be_stopped() {
    let process = Process::start("sim-server", &["budget", "--seeds", "0..10000000", "--quiet"]);
    until("a handler", || listens(process.pid()));
    process.signal(Signal::INT);
    let ended = process.wait().expect(3);
    assert!(ended.stdout.is_empty() && ended.stderr.contains("stopped"), "{}", ended.stderr);
}
