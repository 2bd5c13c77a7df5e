//! All the figures that evo gives of one pair of trajectories.

use super::super::trace::tests::empty;
use super::*;
use core::f64::consts::FRAC_PI_2;
use rusty_contract::score::Statistics;
use rusty_geometry::SE2;
use rusty_geometry::trig;

/// Two turns of a circle of 3 m, and what was believed: shifted, waving, and
/// turned by more and more.
fn trajectories() -> RunTrace {
    let mut trace = empty(&["a"]);
    let (sin, cos) = (trig::sin, trig::cos);
    for k in (0..400).map(f64::from) {
        let (x_m, y_m, theta_rad) =
            (3.0 * cos(0.03 * k), 3.0 * sin(0.03 * k), 0.03 * k + FRAC_PI_2);
        let believed = SE2::new(
            x_m + 0.2 + 1e-3 * k + 0.01 * sin(0.7 * k),
            y_m - 0.1 + 5e-4 * k + 0.01 * cos(0.9 * k),
            theta_rad + 0.1 + 2e-3 * k * sin(0.05 * k),
        );
        let truth = SE2::new(x_m, y_m, theta_rad);
        trace.push(k * 0.02, Some(truth), None, [Some(believed)].into_iter());
    }
    trace
}

/// rmse, mean, median, std, min, max, sse.
type Figures = [f64; 7];

fn assert_same(what: &str, found: &Statistics, count: u64, figures: Figures) {
    let Statistics { rmse, mean, median, std, min, max, sse, .. } = *found;
    assert_eq!(found.count, count, "{what}");
    for (found, expected) in [rmse, mean, median, std, min, max, sse].into_iter().zip(figures) {
        assert!((found - expected).abs() < 1e-9, "{what}: {found} is not {expected}");
    }
}

/// evo 1.38.1 on the same poses: `metrics.APE` and `metrics.RPE` with
/// `PoseRelation.translation_part` (m), then `.rotation_angle_rad`;
/// `align_origin`, `align`; `Unit.frames` and `Unit.meters` with a delta of 1,
/// `pairs_from_reference` and no `all_pairs`.
const EVO: [(&str, u64, Figures, Figures); 5] = [
    (
        "ate.none",
        400,
        [
            0.4200325831647387,
            0.4044767438514756,
            0.3998399610627761,
            0.1132516428284859,
            0.21531526201919735,
            0.6161391940648424,
            70.57094836801726,
        ],
        [
            0.3274712587796853,
            0.2637538203102278,
            0.20731461295572734,
            0.19409108067737596,
            0.0001962711080359118,
            0.8113441461486011,
            42.89497013070065,
        ],
    ),
    (
        "ate.origin",
        400,
        [
            0.5357690329829335,
            0.49196962263275607,
            0.5144032385626156,
            0.21216584812370548,
            5.551115123125783e-17,
            0.8307492247965262,
            114.81938268138708,
        ],
        [
            0.3167313317588286,
            0.24847842003893375,
            0.19244417839967776,
            0.19641082274833122,
            5.859850994498766e-18,
            0.7113441461486008,
            40.127494607088465,
        ],
    ),
    (
        "ate.se2",
        400,
        [
            0.12657922471298033,
            0.11560667466545894,
            0.11498453332273711,
            0.051549945700591196,
            0.018193069275688603,
            0.23256402295052128,
            6.408920051575667,
        ],
        [
            0.32522360044468324,
            0.2615555044445802,
            0.2058613617742408,
            0.193285044379911,
            0.0010833157015146156,
            0.8021762663033383,
            42.30815611448119,
        ],
    ),
    (
        "rpe.per_tick",
        399,
        [
            0.030070303071626316,
            0.02500917137430219,
            0.021527832860281284,
            0.01669624131324901,
            0.000658309525209615,
            0.0683824874481315,
            0.3607850276009642,
        ],
        [
            0.016851403646270902,
            0.013224517684793841,
            0.010982325019615045,
            0.010444229835374512,
            1.992008188225119e-05,
            0.03789802717986925,
            0.11330395213497133,
        ],
    ),
    (
        "rpe.per_metre",
        33,
        [
            0.3303094544962924,
            0.27072738731685125,
            0.1942877489300488,
            0.1892379916566171,
            0.030073730163168517,
            0.6858328876543535,
            3.6004430790780626,
        ],
        [
            0.1990051242943654,
            0.15551607379503463,
            0.13878257843062974,
            0.1241683948788627,
            0.004550643685631291,
            0.4474142696657281,
            1.3069003033487223,
        ],
    ),
];

#[test]
fn every_figure_is_that_of_evo() {
    let score = &score(&trajectories())[0];
    let (ate, rpe) = (score.ate, score.rpe);
    let found = [ate.none, ate.origin, ate.se2, rpe.per_tick, rpe.per_metre];
    for ((what, count, translation, rotation), found) in EVO.into_iter().zip(found) {
        let found = found.unwrap();
        assert_same(&format!("{what}, translation"), &found.translation_m, count, translation);
        assert_same(&format!("{what}, rotation"), &found.rotation_rad, count, rotation);
    }
    // The flat figures are the same numbers.
    let (none, per_tick) = (score.ate.none.unwrap(), score.rpe.per_tick.unwrap());
    assert_eq!(score.ate_rmse_m, Some(none.translation_m.rmse));
    assert_eq!(score.mean_position_error_m, Some(none.translation_m.mean));
    assert_eq!(score.max_position_error_m, Some(none.translation_m.max));
    assert_eq!(score.rmse_heading_error_rad, Some(none.rotation_rad.rmse));
    assert_eq!(score.rpe_rmse_m, Some(per_tick.translation_m.rmse));
}

#[test]
fn an_estimate_beyond_all_measure_has_no_figures_and_breaks_no_document() {
    let mut trace = empty(&["a", "b"]);
    for k in 0..3 {
        let at = |x_m: f64| Some(SE2::new(x_m, 0.0, 0.0));
        let estimates = [at(1e200 * f64::from(k)), at(0.1)];
        trace.push(f64::from(k), at(0.0), None, estimates.into_iter());
    }
    let scores = score(&trace);
    assert_eq!((scores[0].ate.none, scores[0].ate.se2, scores[0].rpe.per_tick), (None, None, None));
    assert!(scores[1].ate.none.is_some() && scores[1].ate.se2.is_some());
    let text = serde_json::to_string(&scores).unwrap();
    assert_eq!(serde_json::from_str::<Vec<Score>>(&text).unwrap().len(), 2);
}
