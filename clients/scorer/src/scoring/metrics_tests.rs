//! Hand-computed scores, the trap at ±π, and the numbers evo gives.

use super::super::trace::distance_driven_m;
use super::super::trace::tests::empty;
use super::*;
use core::f64::consts::PI;
use rusty_contract::score::Alignment;
use rusty_geometry::SE2;
use rusty_geometry::trig;
use rusty_metrics::trajectory::relative_error;

/// One estimator, one tick per pair of (truth, estimate).
fn trace(ticks: &[(Option<SE2>, Option<SE2>)]) -> RunTrace {
    let mut trace = empty(&["a"]);
    for (k, &(truth, estimate)) in ticks.iter().enumerate() {
        trace.push((k + 1) as f64 * 0.1, truth, None, [estimate].into_iter());
    }
    trace
}

fn pose(x_m: f64, y_m: f64, theta_rad: f64) -> Option<SE2> {
    Some(SE2::new(x_m, y_m, theta_rad))
}

fn near(found: Option<f64>, expected: f64) {
    let found = found.unwrap();
    assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
}

#[test]
fn by_hand() {
    // Errors 0, 3 and 5 m (a 3-4-5 triangle); the robot drives 2 m, then 2 m.
    let run = trace(&[
        (pose(0.0, 0.0, 0.0), pose(0.0, 0.0, 0.0)),
        (pose(2.0, 0.0, 0.0), pose(2.0, 3.0, 0.0)),
        (pose(4.0, 0.0, 0.0), pose(7.0, 4.0, PI / 6.0)),
    ]);
    let score = &score(&run)[0];
    assert_eq!((score.scored_ticks, score.unscored_ticks), (3, 0));
    near(score.final_position_error_m, 5.0);
    near(score.final_heading_error_deg, 30.0);
    near(score.mean_position_error_m, 8.0 / 3.0);
    near(score.p95_position_error_m, 3.0 + 0.9 * 2.0);
    near(score.ate_rmse_m, (34.0_f64 / 3.0).sqrt());
    // Believed motions less true ones: (0, 3), then (3, 1).
    near(score.rpe_rmse_m, (19.0_f64 / 2.0).sqrt());
    near(score.rpe_rmse_deg, 30.0 / 2.0_f64.sqrt());
    assert_eq!(score.distance_m, 4.0);
    near(score.drift_percent, 125.0);
}

#[test]
fn the_trap_at_half_a_turn() {
    // Truth just below +π, estimate just above −π: 0.2 rad apart, where plain
    // subtraction says 6.08 rad.
    let run = trace(&[
        (pose(0.0, 0.0, PI - 0.1), pose(0.0, 0.0, -PI + 0.1)),
        (pose(0.0, 0.0, -PI + 0.1), pose(0.0, 0.0, PI - 0.1)),
    ]);
    let score = &score(&run)[0];
    near(score.final_heading_error_deg, 0.2_f64.to_degrees());
    // Truth turned by +0.2 rad, estimate by −0.2 rad.
    near(score.rpe_rmse_deg, 0.4_f64.to_degrees());
    let signed: Vec<f64> = scored(&run, 0).map(|s| s.heading_error_rad()).collect();
    near(Some(signed[0]), 0.2);
    near(Some(signed[1]), -0.2);
    let half = trace(&[(pose(0.0, 0.0, 0.0), pose(0.0, 0.0, -PI))]);
    near(super::score(&half)[0].final_heading_error_deg, 180.0);
}

#[test]
fn without_a_scored_tick_there_are_no_figures() {
    let here = pose(1.0, 1.0, 0.0);
    for ticks in [
        vec![],
        vec![(None, here), (None, here)],
        vec![(here, None)],
        vec![(here, pose(f64::NAN, 0.0, 0.0)), (pose(0.0, f64::INFINITY, 0.0), here)],
    ] {
        let score = &score(&trace(&ticks))[0];
        assert_eq!(score.scored_ticks, 0);
        assert_eq!(score.distance_m, 0.0);
        for figure in [
            score.final_position_error_m,
            score.final_heading_error_deg,
            score.mean_position_error_m,
            score.p95_position_error_m,
            score.ate_rmse_m,
            score.rpe_rmse_m,
            score.rpe_rmse_deg,
            score.drift_percent,
        ] {
            assert_eq!(figure, None);
        }
    }
}

#[test]
fn one_scored_tick_of_a_robot_that_stands() {
    let score = &score(&trace(&[(pose(1.0, 0.0, 0.0), pose(1.0, 2.0, 0.0))]))[0];
    near(score.ate_rmse_m, 2.0);
    near(score.p95_position_error_m, 2.0);
    assert_eq!((score.rpe_rmse_m, score.rpe_rmse_deg), (None, None));
    assert_eq!(score.drift_percent, None);
}

#[test]
fn drift_is_of_an_error_that_driving_made() {
    let run = |driven_m: f64| {
        trace(&[(pose(0.0, 0.0, 0.0), None), (pose(driven_m, 0.0, 0.0), pose(driven_m, 3.0, 0.0))])
    };
    near(score(&run(2.0))[0].drift_percent, 150.0);
    // 3 m after 4 mm are no 75,000 %.
    assert_eq!(score(&run(0.004))[0].drift_percent, None);
    let kidnapped = RunTrace { kidnapped_at: vec![1], ..run(2.0) };
    assert_eq!(score(&kidnapped)[0].drift_percent, None);
    let later = RunTrace { kidnapped_at: vec![2], ..run(2.0) };
    near(score(&later)[0].drift_percent, 150.0);
    // The first tick is on the way, where it is known from where.
    let started = RunTrace { start: pose(-1.0, 0.0, 0.0), ..run(2.0) };
    assert_eq!(score(&started)[0].distance_m, 3.0);
}

#[test]
fn who_is_not_told_where_it_starts_is_judged_aligned() {
    // Right but for a frame that is moved by 3 m and turned by a quarter.
    let truths = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [2.0, 1.0, 1.0]];
    let moved = SE2::new(3.0, 0.0, PI / 2.0);
    let poses = truths.map(|[x_m, y_m, theta_rad]| SE2::new(x_m, y_m, theta_rad));
    let mut run = trace(&poses.map(|truth| (Some(truth), Some(moved * truth))));
    let told = score(&run)[0].clone();
    assert_eq!(told.alignment, Alignment::None);
    assert!(told.final_position_error_m.unwrap() > 0.5 && told.drift_percent.is_some());
    run.told[0].initial_pose = rusty_contract::scenario::Access::Hidden;
    let hidden = &score(&run)[0];
    assert_eq!((hidden.alignment, hidden.drift_percent), (Alignment::Se2, None));
    // Both are in the document.
    assert_eq!(hidden.final_position_error_m, told.final_position_error_m);
    let aligned = hidden.figures(Alignment::Se2);
    assert_eq!(aligned.ate_rmse_m, hidden.ate.se2.map(|e| e.translation_m.rmse));
    for error in [aligned.final_position_error_m, aligned.p95_position_error_m, aligned.ate_rmse_m]
    {
        assert!(error.unwrap() < 1e-12, "{aligned:?}");
    }
    assert!(aligned.final_heading_error_rad.unwrap() < 1e-12, "{aligned:?}");
}

#[test]
fn ticks_without_truth_or_estimate_are_passed_over() {
    let run = trace(&[
        (pose(0.0, 0.0, 0.0), pose(0.0, 0.0, 0.0)),
        (None, pose(9.0, 9.0, 0.0)),
        (pose(1.0, 0.0, 0.0), None),
        (pose(3.0, 0.0, 0.0), pose(3.5, 0.0, 0.0)),
        (None, None),
    ]);
    let score = &score(&run)[0];
    assert_eq!((score.scored_ticks, score.unscored_ticks), (2, 2));
    near(score.rpe_rmse_m, 0.5);
    near(score.final_position_error_m, 0.5);
    assert_eq!(score.distance_m, 3.0);
}

/// The scores as they are defined, of lists that hold every tick.
fn of_the_whole_run(trace: &RunTrace, estimator: usize) -> Score {
    let ticks: Vec<Scored> = scored(trace, estimator).collect();
    let errors_m: Vec<f64> = ticks.iter().map(Scored::position_error_m).collect();
    let headings_rad: Vec<f64> = ticks.iter().map(|s| s.heading_error_rad().abs()).collect();
    let (rpe_m, rpe_rad): (Vec<f64>, Vec<f64>) =
        ticks.windows(2).map(|pair| relative_error(&pair[0], &pair[1])).unzip();
    let mean = |v: &[f64]| (!v.is_empty()).then(|| v.iter().sum::<f64>() / v.len() as f64);
    let rmse = |v: &[f64]| mean(&v.iter().map(|v| v * v).collect::<Vec<_>>()).map(f64::sqrt);
    let mut sorted = errors_m.clone();
    sorted.sort_by(f64::total_cmp);
    let rank = 0.95 * (sorted.len() - 1) as f64;
    let (low, high) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
    let driven_m = distance_driven_m(trace);
    let given = (0..trace.tick_count()).filter(|&k| trace.estimate(estimator, k).is_some()).count();
    let final_m = ticks.last().map(Scored::position_error_m);
    Score {
        name: trace.names[estimator].clone(),
        scored_ticks: ticks.len() as u64,
        unscored_ticks: (trace.tick_count() - given) as u64,
        // Without covariances.
        wrong_ticks: errors_m.iter().filter(|m| **m > 0.5).count() as u64,
        final_position_error_m: final_m,
        final_heading_error_deg: ticks.last().map(|s| s.heading_error_rad().abs().to_degrees()),
        final_heading_error_rad: ticks.last().map(|s| s.heading_error_rad().abs()),
        max_position_error_m: sorted.last().copied(),
        rmse_heading_error_rad: rmse(&headings_rad),
        max_heading_error_rad: headings_rad.iter().copied().reduce(f64::max),
        mean_position_error_m: mean(&errors_m),
        p95_position_error_m: Some(low + (high - low) * (rank - rank.floor())),
        ate_rmse_m: rmse(&errors_m),
        rpe_rmse_m: rmse(&rpe_m),
        rpe_rmse_deg: rmse(&rpe_rad).map(f64::to_degrees),
        distance_m: driven_m,
        drift_percent: final_m.map(|m| 100.0 * m / driven_m),
        ..Score::default()
    }
}

#[test]
fn tick_by_tick_gives_the_bits_of_the_whole() {
    let mut trace = empty(&["often", "at-scans"]);
    for k in 0..5000u32 {
        let at = |off_m: f64| {
            let turn_rad = f64::from(k) * 0.01;
            let (s, c) = trig::sin_cos(turn_rad);
            SE2::new(3.0 * c + off_m, 3.0 * s - 0.3 * off_m * s, turn_rad + 0.01 * off_m)
        };
        let truth = (k % 7 != 3).then(|| at(0.0));
        let drift_m = 1e-4 * f64::from(k) * (1.0 + trig::sin_cos(f64::from(k) * 0.37).0);
        let estimates = [(k > 20).then(|| at(drift_m)), (k % 5 == 4).then(|| at(0.1))];
        trace.push(f64::from(k) * 0.02, truth, None, estimates.into_iter());
    }
    let whole: Vec<Score> = (0..2).map(|i| of_the_whole_run(&trace, i)).collect();
    let flat = |scores: Vec<Score>| {
        let keep = |s: Score| Score {
            ate: Default::default(),
            rpe: Default::default(),
            convergence: None,
            aligned: Default::default(),
            ..s
        };
        serde_json::to_string(&scores.into_iter().map(keep).collect::<Vec<_>>()).unwrap()
    };
    assert_eq!(flat(score(&trace)), flat(whole));
}

/// Eight poses that turn through ±π, x m, y m, θ rad, and what was believed.
const REFERENCE: [[f64; 3]; 8] = [
    [0.0, 0.0, 3.0],
    [-0.5, 0.07, 3.1],
    [-1.0, 0.05, -3.12],
    [-1.5, 0.0, -3.0],
    [-1.98, -0.1, -2.5],
    [-2.3, -0.45, -1.9],
    [-2.4, -0.9, -1.5],
    [-2.38, -1.4, -1.2],
];
const BELIEVED: [[f64; 3]; 8] = [
    [0.01, 0.0, 3.01],
    [-0.48, 0.09, 3.13],
    [-1.02, 0.04, 3.135],
    [-1.53, -0.02, -3.05],
    [-2.04, -0.08, -2.57],
    [-2.33, -0.4, -2.02],
    [-2.47, -0.88, -1.58],
    [-2.5, -1.36, -1.33],
];

/// evo 1.38.1 on the same poses (quaternions about z, 10 Hz): APE translation
/// part without alignment; RPE with delta 1 frame, not all pairs; numpy's
/// percentile of the APE; the path length of the reference.
#[test]
fn the_numbers_of_evo() {
    let ticks: Vec<_> = REFERENCE
        .iter()
        .zip(&BELIEVED)
        .map(|(r, e)| (pose(r[0], r[1], r[2]), pose(e[0], e[1], e[2])))
        .collect();
    let score = &score(&trace(&ticks))[0];
    near(score.ate_rmse_m, 0.062_649_820_430_708_41);
    near(score.mean_position_error_m, 0.052_193_467_653_557_646);
    near(score.p95_position_error_m, 0.107_699_603_776_859_78);
    near(score.final_position_error_m, 0.126_491_106_406_735_22);
    near(score.rpe_rmse_m, 0.037_498_033_424_339_39);
    near(score.rpe_rmse_deg, 2.298_105_768_610_671);
    near(Some(score.distance_m), 3.433_689_161_571_432);
}
