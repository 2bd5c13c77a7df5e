//! Two simple paths: how slip spreads a straight one, and how little counts of
//! a fine encoder lose on a curved one.

mod common;

use common::{config, mean, run, sim};
use rusty_contract::{Frame, ScriptConfig};
use rusty_geometry::{SE2, open, trig};

const SEEDS: u64 = 480;

/// True positions of all seeds after every tenth of a second, 3 s at 0.5 m/s
/// straight ahead with a slip of 0.05: `[tick][seed]`, x along, y across, m.
fn fan() -> Vec<Vec<[f64; 2]>> {
    let mut positions = vec![Vec::new(); 30];
    let mut frame = Frame::boxed();
    for seed in 0..SEEDS {
        let script = ScriptConfig::Straight { v_m_s: 0.5 };
        let mut config = config(script, &open(), SE2::identity());
        config.seed = seed;
        config.robot.slip_std = 0.05;
        let mut sim = sim(config);
        for row in &mut positions {
            let _ = sim.step(None, &mut frame);
            row.push([sim.truth().x(), sim.truth().y()]);
        }
    }
    positions
}

/// Variances along and across of one row, m².
fn variances(row: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let values: Vec<f64> = row.iter().map(|p| p[axis]).collect();
        let middle = mean(&values);
        let squares: Vec<f64> = values.iter().map(|v| (v - middle) * (v - middle)).collect();
        squares.iter().sum::<f64>() / (values.len() - 1) as f64
    })
}

fn assert_near(found: f64, expected: f64, share: f64) {
    let limit = share * expected;
    assert!((found - expected).abs() <= limit, "{found} for {expected}");
}

#[test]
fn slip_spreads_a_straight_leg_across() {
    let fan = fan();
    let spread_m: Vec<f64> =
        fan.iter().map(|row| variances(row).iter().sum::<f64>().sqrt()).collect();
    let [one, two, three] = [spread_m[9], spread_m[19], spread_m[29]];
    assert_near(one, 0.021, 0.10);
    assert_near(two, 0.057, 0.10);
    assert_near(three, 0.101, 0.10);
    assert_near(two / one, 2.7, 0.08);
    assert_near(three / one, 4.9, 0.08);

    let [along, across] = variances(&fan[29]);
    let anisotropy = (across / along).sqrt();
    assert!((8.0..=10.0).contains(&anisotropy), "{anisotropy}");

    // Heading does a random walk and position integrates it: t to the 3/2, with
    // the linear part still to be seen at the beginning.
    let points: Vec<[f64; 2]> =
        (4..30).map(|i| [trig::ln(0.1 * (i + 1) as f64), trig::ln(spread_m[i])]).collect();
    let slope = slope(&points);
    assert!((1.40..=1.50).contains(&slope), "{slope}");
}

/// Slope of the least-squares line.
fn slope(points: &[[f64; 2]]) -> f64 {
    let [x0, y0] = [0, 1].map(|i| mean(&points.iter().map(|p| p[i]).collect::<Vec<_>>()));
    let sum = |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(f).sum::<f64>();
    sum(&|p| (p[0] - x0) * (p[1] - y0)) / sum(&|p| (p[0] - x0) * (p[0] - x0))
}

#[test]
fn a_fine_encoder_follows_the_figure_eight() {
    let script = ScriptConfig::FigureEight { v_m_s: 0.5, omega_rad_s: 0.6, half_s: 10.48 };
    let mut config = config(script, &open(), SE2::identity());
    config.ticks = 3000;
    config.dt_s = 0.02;
    config.robot.ticks_per_rev = 1 << 26;
    let run = run(config);
    // Beyond 32 bits.
    assert_eq!((run.ticks.left, run.ticks.right), (9_664_991_574, 9_754_476_482));
    let error = run.reckoned.boxminus(&run.truth).norm();
    assert!(error < 1e-7, "{error:e}");
    assert!(error > 0.0, "rounding to counts costs something");
}

#[test]
fn the_figure_eight_fits_into_the_living_room() {
    let script = ScriptConfig::FigureEight { v_m_s: 0.5, omega_rad_s: 0.6, half_s: 10.48 };
    let start = SE2::new(9.6, 3.0, 0.0);
    let mut config = config(script, &rusty_geometry::apartment(), start);
    config.ticks = 2096;
    config.dt_s = 0.02;
    let run = run(config);
    assert_eq!(run.blocked, 0);
    assert!(run.truth.boxminus(&start).norm() < 0.02, "{:?}", run.truth);
}
