//! Known errors are recovered, alone and together, with either sign.

use rusty_contract::RunConfig;

use super::*;
use rusty_metrics::Moments;

const SQUARE: Square = Square { side_m: 4.0, speed_m_s: 0.5, turn_rad_s: 1.0 };

/// Rusty, wrong about himself; encoders so fine that rounding is no error.
fn config(track_bias: f64, radius_bias_right: f64, slip_std: f64) -> RunConfig {
    let mut config = rusty_engine::scenario_file::load("patrol", &[]).unwrap().config().unwrap();
    config.dt_s = 0.05;
    config.robot.track_bias = track_bias;
    config.robot.radius_bias_right = radius_bias_right;
    config.robot.slip_std = slip_std;
    config.robot.ticks_per_rev = 1 << 26;
    config
}

fn errors(found: &factors::Factors, truth: &factors::Factors) -> [f64; 2] {
    [found.wheelbase - truth.wheelbase, found.diameters - truth.diameters]
}

#[test]
fn known_errors_are_recovered() {
    for (track, radius) in [
        (0.0, 0.0),
        (0.01, 0.0),
        (-0.01, 0.0),
        (0.0, 0.005),
        (0.0, -0.005),
        (0.01, 0.005),
        (-0.01, 0.005),
        (0.01, -0.005),
    ] {
        let report = umbmark(&config(track, radius, 0.0), &SQUARE, 1).unwrap();
        // Exact arcs leave one thing out: the square is larger by half the
        // radius bias, 0.25 %, and so is every return. So each deviation is
        // found 0.25 % too large, at most 0.0127 · 0.0025.
        let [b, d] = errors(&report.estimate.exact.factors, &report.truth);
        let within = 4e-5 * f64::from(u8::from(radius != 0.0)) + 1e-7;
        assert!(b.abs() < within && d.abs() < within, "{track} {radius}: {b:e} {d:e}");
        // The paper's formulas are of first order. With β up to 7.2° second
        // order is β² = 0.016 rad, a hundredth of a corner; type A is nearly
        // lost in it, type B still found to a few percent.
        let [b, d] = errors(&report.estimate.paper.factors, &report.truth);
        assert!(b.abs() < 0.012 && d.abs() < 4e-4, "{track} {radius}: {b:e} {d:e}");
        if track != 0.0 || radius != 0.0 {
            let shrunk = report.shrunk(&report.corrected_by_exact);
            assert!(shrunk > 100.0, "{track} {radius}: {shrunk}");
        }
    }
}

#[test]
fn wheels_that_differ_by_percents_are_not_taken_for_others() {
    // Sides are bent by 0.8 rad and more; the paper's estimate leads to other minima.
    for radius in [0.034, -0.032, 0.05] {
        let report = umbmark(&config(0.0, radius, 0.0), &SQUARE, 1).unwrap();
        let [b, d] = errors(&report.estimate.exact.factors, &report.truth);
        // Exact arcs leave out that the square is larger by half the bias.
        assert!(b.abs() < 0.006 && d.abs() < 0.001, "{radius}: {b:e} {d:e}");
    }
}

#[test]
fn where_errors_are_small_the_paper_is_exact() {
    let square = Square { side_m: 0.4, ..SQUARE };
    let report = umbmark(&config(0.001, 0.0005, 0.0), &square, 1).unwrap();
    // β is 0.07°, second order 10⁻⁶.
    let [b, d] = errors(&report.estimate.paper.factors, &report.truth);
    assert!(b.abs() < 3e-5 && d.abs() < 3e-5, "{b:e} {d:e}");
    assert!(report.shrunk(&report.corrected_by_paper) > 10.0);
}

#[test]
fn coarse_encoders_cost_a_little() {
    let mut coarse = config(0.01, 0.005, 0.0);
    coarse.robot.ticks_per_rev = 4096;
    let report = umbmark(&coarse, &SQUARE, 1).unwrap();
    let [b, d] = errors(&report.estimate.exact.factors, &report.truth);
    // Half a count in each wheel is 0.3 mrad of heading; a corner is known no
    // better, which is 2·10⁻⁴ of it.
    assert!(b.abs() < 3e-4 && d.abs() < 4e-5, "{b:e} {d:e}");
    assert!(b.abs() > 1e-9);
}

#[test]
fn with_slip_the_estimates_scatter_as_they_say() {
    let truth = factors::Factors::of(&config(0.01, 0.005, 0.0).robot);
    let mut found = Vec::new();
    for k in 0..40 {
        let mut slipping = config(0.01, 0.005, 0.01);
        slipping.dt_s = 0.1;
        slipping.seed = 1000 * k;
        let nominal = Belief::nominal(slipping.robot.nominal().drive);
        let returns = laps(&slipping, &nominal, &SQUARE, 5).unwrap();
        found.push(estimate(&returns, SQUARE.side_m, nominal.track_m));
    }
    for of in [|f: &factors::Factors| f.wheelbase, |f: &factors::Factors| f.diameters] {
        let values: Vec<f64> = found.iter().map(|e| of(&e.exact.factors)).collect();
        let all = Moments::of(&values);
        // The mean of forty is within three of its standard errors.
        let off = (all.mean - of(&truth)).abs();
        assert!(off < 3.0 * all.standard_error() + 4e-5, "{off} of {}", all.standard_error());
        // Each claims the scatter that there is; five laps know it to a third,
        // forty times five far better, and forty estimates to 11 %.
        let squares =
            found.iter().map(|e| of(&e.exact.standard_errors) * of(&e.exact.standard_errors));
        let claimed = (squares.sum::<f64>() / 40.0).sqrt();
        let ratio = claimed / all.standard_deviation;
        assert!((0.65..1.5).contains(&ratio), "claims {claimed}, {ratio} of the scatter");
    }
}

#[test]
fn five_laps_with_slip_improve_a_robot() {
    let report = umbmark(&config(0.02, 0.01, 0.002), &SQUARE, 5).unwrap();
    assert_eq!(report.returns.len(), 10);
    let e = &report.estimate.exact;
    let [b, d] = errors(&e.factors, &report.truth);
    // Student's t for the few degrees of freedom there are, and the scale.
    assert!(b.abs() < 5.0 * e.standard_errors.wheelbase + 2e-4, "{b:e}");
    assert!(d.abs() < 5.0 * e.standard_errors.diameters + 2e-4, "{d:e}");
    assert!(report.shrunk(&report.corrected_by_exact) > 10.0);
    let text = report.to_string();
    for part in ["E_max,syst", "Borenstein and Feng", "E_b", "E_d", "cw", "ccw", "5 laps each way"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let json = serde_json::to_value(&report).unwrap();
    assert!(json["estimate"]["exact"]["factors"]["wheelbase"].is_f64());
    assert!(json["returns"][0].get("path_m").is_none(), "paths are long");
}

#[test]
fn the_robot_believes_to_be_back_and_is_where_it_is_off() {
    let nominal = Belief::nominal(config(0.0, 0.0, 0.0).robot.nominal().drive);
    for way in Way::BOTH {
        let clean = lap(&config(0.0, 0.0, 0.0), &nominal, &SQUARE, way, 1).unwrap();
        let [x, y] = [clean.x_m, clean.y_m];
        assert!(x.abs() < 1e-6 && y.abs() < 1e-6, "{x:e} {y:e}");
        // The corners are where the way says.
        let side = way.sign();
        let far = clean.path_m.iter().map(|p| side * p[1]).fold(0.0, f64::max);
        assert!((far - 4.0).abs() < 1e-3, "{far}");
    }
}

#[test]
fn the_model_is_the_world_without_noise() {
    let nominal = Belief::nominal(config(0.0, 0.0, 0.0).robot.nominal().drive);
    let off = config(0.013, -0.004, 0.0);
    let truth = factors::Factors::of(&off.robot);
    for way in Way::BOTH {
        let found = lap(&off, &nominal, &SQUARE, way, 1).unwrap();
        let scale = 1.0 - 0.002;
        let expected = model::returned_m(&truth, 4.0, 0.16, way).map(|m| scale * m);
        let [x, y] = [found.x_m - expected[0], found.y_m - expected[1]];
        assert!(x.abs() < 1e-4 && y.abs() < 1e-4, "{way:?}: {x:e} {y:e}");
    }
}

#[test]
fn a_square_that_cannot_be_driven_is_refused() {
    let mut slow = config(0.0, 0.0, 0.0);
    slow.robot.wheel_limit_rad_s = 0.01;
    let error = umbmark(&slow, &SQUARE, 1).unwrap_err();
    assert!(matches!(error, LapError::Lost { .. }) && error.to_string().contains("--side"));
}
