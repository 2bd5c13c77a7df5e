//! Slip: heavy tails have the moments of their law, patches begin where they say, and
//! what is off changes no bit.
#![allow(clippy::unwrap_used, reason = "part of tests, though not of test functions")]

mod common;

use rusty_contract::config::PatchConfig;
use rusty_contract::{Frame, RunConfig};
use rusty_geometry::{SE2, open};
use rusty_sim::golden::digest_of;
use rusty_sim::slip::Slip;
use rusty_sim::{Sim, StepOutcome};

fn config() -> RunConfig {
    let mut config = common::config(common::patrol(), &open(), common::patrol_start());
    (config.seed, config.robot.slip_std) = (42, 0.02);
    config
}

fn with(change: impl Fn(&mut RunConfig)) -> RunConfig {
    let mut config = config();
    change(&mut config);
    config
}

fn digest(config: RunConfig) -> [u8; 16] {
    digest_of(config).unwrap().world()
}

/// The floor with 0 ≤ y < 6 from `x_min` to `x_max`.
fn patch(x_min: f64, x_max: f64, slip_std: f64) -> PatchConfig {
    PatchConfig {
        corners: vec![[x_min, 0.0], [x_max, 0.0], [x_max, 6.0], [x_min, 6.0]],
        slip_std,
        slip_outlier_rate: 0.0,
        slip_outlier_factor: 10.0,
    }
}

/// Slips of both wheels in many ticks at one place.
fn drawn(config: &RunConfig, ticks: u64) -> Vec<[f64; 2]> {
    let mut slip = Slip::new(&config.robot, &config.patches, config.seed);
    (0..ticks).map(|tick| slip.at(tick, &config.start)).collect()
}

#[test]
fn heavy_tails_have_the_variance_kurtosis_and_share_of_the_law() {
    let (p, k, sigma) = (0.1, 5.0, 0.02);
    let config = with(|c| (c.robot.slip_outlier_rate, c.robot.slip_outlier_factor) = (p, k));
    let all = drawn(&config, 250_000).concat();
    let n = all.len() as f64;
    let moment = |f: fn(f64) -> f64| all.iter().map(|slip| f(slip / sigma)).sum::<f64>() / n;
    let (m2, m4) = (moment(|x| x * x), moment(|x| x * x * x * x));
    // Moments 2, 4 and 8 of the mixture: 1, 3 and 105 of the normal law, k to the same power.
    let of = |normal: f64, k: f64| normal * (1.0 - p + p * k);
    let (v2, v4, v8) = (of(1.0, k * k), of(3.0, k * k * k * k), of(105.0, 390_625.0));
    let (s2, s4) = (((v4 - v2 * v2) / n).sqrt(), ((v8 - v4 * v4) / n).sqrt());
    assert!((m2 - v2).abs() < 4.0 * s2, "{m2}, expected {v2} ± {s2}");
    assert!((m4 - v4).abs() < 4.0 * s4, "{m4}, expected {v4} ± {s4}");
    let kurtosis = m4 / (m2 * m2);
    assert!((kurtosis - 16.453).abs() < 0.5, "{kurtosis}");
    // Beyond 4 σ: 2(1 − Φ(4)) of the usual draws, 2(1 − Φ(0.8)) of the outliers.
    let share = all.iter().filter(|slip| slip.abs() > 4.0 * sigma).count() as f64 / n;
    let expected = (1.0 - p) * 6.334e-5 + p * 0.423_711;
    assert!((share - expected).abs() < 4.0 * (expected / n).sqrt(), "{share}, {expected}");
}

#[test]
fn an_outlier_is_the_usual_slip_times_its_factor_and_changes_no_other() {
    let plain = drawn(&config(), 10_000).concat();
    let config = with(|c| (c.robot.slip_outlier_rate, c.robot.slip_outlier_factor) = (0.2, 4.0));
    let heavy = drawn(&config, 10_000).concat();
    let mut outliers = 0;
    for (plain, heavy) in plain.iter().zip(&heavy) {
        let is_outlier = heavy.to_bits() != plain.to_bits();
        outliers += usize::from(is_outlier);
        assert!(!is_outlier || heavy.to_bits() == (4.0 * plain).to_bits(), "{plain} and {heavy}");
    }
    assert!((3_700..4_300).contains(&outliers), "{outliers} of 20 000");
}

#[test]
fn what_is_off_or_says_the_same_changes_no_bit() {
    let plain = digest(config());
    let same: [fn(&mut RunConfig); 4] = [
        |c| (c.robot.slip_std_left, c.robot.slip_std_right) = (Some(0.02), Some(0.02)),
        |c| c.robot.slip_outlier_factor = 50.0,
        |c| c.patches.push(patch(-100.0, 100.0, 0.02)),
        |c| c.patches.push(patch(50.0, 100.0, 0.5)),
    ];
    for (i, change) in same.into_iter().enumerate() {
        assert_eq!(digest(with(change)), plain, "change {i}");
    }
    let mut left = drawn(&with(|c| c.robot.slip_std_left = Some(0.06)), 100);
    let plain = drawn(&config(), 100);
    assert!(left.iter().zip(&plain).all(|(a, b)| a[1] == b[1] && a[0] != b[0]));
    left.iter_mut().zip(&plain).for_each(|(a, b)| a[0] = (a[0] - 3.0 * b[0]).abs());
    assert!(left.iter().all(|[off, _]| *off < 1e-15));
}

#[test]
fn a_wheel_is_on_a_patch_exactly_from_its_border_on() {
    let config = with(|c| {
        c.robot.slip_std = 0.0;
        // The second lies over the first.
        c.patches = vec![patch(1.0, 2.0, 0.1), patch(1.5, 2.0, 0.0)];
    });
    let mut slip = Slip::new(&config.robot, &config.patches, config.seed);
    let slips = |slip: &mut Slip, x, y| slip.at(3, &SE2::new(x, y, 0.0)).map(|s| s != 0.0);
    for (x, on) in [
        (1.0_f64.next_down(), false),
        (1.0, true),
        (1.5_f64.next_down(), true),
        (1.5, false),
        (2.0, false),
    ] {
        assert_eq!(slips(&mut slip, x, 1.0), [on, on], "x = {x}");
    }
    // Heading along x the left wheel is 0.08 m to the left, at greater y.
    assert_eq!(slips(&mut slip, 1.2, 0.0), [true, false]);
    assert_eq!(slips(&mut slip, 1.2, 6.0), [false, true]);
}

#[test]
fn a_run_slips_between_the_borders_and_nowhere_else() {
    let mut config = with(|c| {
        c.robot.slip_std = 0.0;
        c.start = SE2::new(0.5, 1.5, 0.0);
        c.script = rusty_contract::ScriptConfig::Straight { v_m_s: 0.5 };
        c.patches = vec![patch(1.0, 2.0, 0.05)];
    });
    config.ticks = 60;
    let half_m = 0.5 * config.robot.track_m;
    let mut sim = Sim::new(config.clone()).unwrap();
    let (mut frame, mut on_it) = (Frame::boxed(), 0);
    for tick in 0..config.ticks {
        let before = sim.truth();
        let is_on = [half_m, -half_m].map(|y| {
            let contact = before.transform_point(&[0.0, y].into());
            (1.0..2.0).contains(&contact.x)
        });
        let StepOutcome::Moved { ds_m, dtheta_rad } = sim.step(None, &mut frame) else {
            panic!("tick {tick}: blocked");
        };
        let slips = [-half_m, half_m].map(|side_m| {
            let wheel_m = ds_m + side_m * dtheta_rad;
            (wheel_m - 0.05).abs() > 1e-9
        });
        assert_eq!(slips, is_on, "tick {tick}");
        on_it += u64::from(is_on == [true, true]);
    }
    assert!((15..25).contains(&on_it), "{on_it} ticks on the patch");
}

#[test]
fn another_seed_and_another_configuration_take_hold() {
    let heavy = |seed| {
        with(move |c| {
            c.seed = seed;
            c.robot.slip_outlier_rate = 0.3;
            c.patches = vec![patch(6.5, 8.0, 0.1)];
        })
    };
    let run = |sim: &mut Sim, ticks: u64| {
        let mut frame = Frame::boxed();
        (0..ticks).for_each(|_| {
            let _ = sim.step(None, &mut frame);
        });
        sim.truth()
    };
    let fresh = run(&mut Sim::new(heavy(7)).unwrap(), 100);
    let mut again = Sim::new(heavy(6)).unwrap();
    assert_ne!(run(&mut again, 100), fresh);
    again.restart(7);
    assert_eq!(run(&mut again, 100), fresh);
    // A patch that comes in the middle.
    let mut changed = Sim::new(config()).unwrap();
    let _ = run(&mut changed, 20);
    let mut kept = changed.clone();
    changed.reconfigure(with(|c| c.patches = vec![patch(-100.0, 100.0, 0.5)])).unwrap();
    assert_ne!(run(&mut changed, 20), run(&mut kept, 20));
}
