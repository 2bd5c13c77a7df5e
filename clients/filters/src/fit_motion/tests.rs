//! α that are known are found again: those of the book's samples, and those of
//! wheels that slip.

use super::*;
use crate::{OdometryNoise, Random};
use nalgebra::Vector2;
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, tick_length, trig};

/// A robot that drives: what its encoders count, and where it comes.
struct Drive {
    drive: DiffDrive,
    counts: EncoderCounts,
    pose: SE2,
    windows: Windows,
}

impl Drive {
    fn new() -> Self {
        Self::with_reference(Vector2::zeros())
    }

    /// With true poses of these deviations, ahead (m) and round (rad).
    fn with_reference(reference: Vector2<f64>) -> Self {
        let drive = DiffDrive::rusty();
        let mut windows = Windows::new(drive, reference);
        windows.tick(EncoderCounts::default(), Some(SE2::identity()));
        windows.left = Left::default();
        Self { drive, counts: EncoderCounts::default(), pose: SE2::identity(), windows }
    }

    /// The wheels turn by these counts; `slips` says where that leads.
    fn tick(&mut self, left: i64, right: i64, slips: impl FnOnce(SE2, [f64; 2]) -> SE2) {
        let lambda_m = tick_length(&self.drive);
        self.counts.left += left;
        self.counts.right += right;
        let ways = [left, right].map(|n| n as f64 * lambda_m);
        self.pose = slips(self.pose, ways);
    }

    fn see(&mut self) {
        self.windows.tick(self.counts, Some(self.pose));
    }
}

/// Counts of tick `k` of a drive with everything in it: straight on, curves, turns
/// on the spot.
fn wheels(k: u64) -> (i64, i64) {
    match (k / 50) % 4 {
        0 => (200, 200),
        1 => (150, 230),
        2 => (-160, 160),
        _ => (260, 140),
    }
}

/// Table 5.6 with an arc's two equal turns, as the model has it.
fn of_the_book(noise: OdometryNoise, random: &mut Random, pose: SE2, ways: [f64; 2]) -> SE2 {
    let step = DiffDrive::rusty().tangent(ways[0], ways[1]);
    let (rot, way) = (0.5 * step.z, step.x);
    let (turn, straight) = noise.variances(&step);
    let (turn, straight) = (turn.sqrt(), straight.sqrt());
    let chord = way * trig::sinc(rot);
    let rot1 = rot - turn * random.normal();
    let chord = chord - straight * random.normal();
    let rot2 = rot - turn * random.normal();
    let (s, c) = trig::sin_cos(rot1);
    pose.compose(&SE2::new(chord * c, chord * s, rot1 + rot2))
}

/// Wheels whose errors have the variance `k` m² per metre of way, each by itself.
fn slipping(k: f64, random: &mut Random, pose: SE2, ways: [f64; 2]) -> SE2 {
    let [left, right] = ways.map(|way| way + (k * way.abs()).sqrt() * random.normal());
    pose.boxplus(&DiffDrive::rusty().tangent(left, right))
}

fn check(fit: &MotionFit, truth: [f64; 4], context: &str) -> [f64; 4] {
    assert!(fit.converged, "{context}: {:?}", fit.rounds);
    assert!(fit.rounds.windows(2).all(|w| w[1] >= w[0]), "{context}: {:?}", fit.rounds);
    std::array::from_fn(|k| {
        let off = (fit.alphas[k].value - truth[k]) / fit.alphas[k].std_error.unwrap();
        assert!(off.abs() < 3.5, "{context}, alpha{}: {:?} for {}", k + 1, fit.alphas[k], truth[k]);
        off * off
    })
}

#[test]
fn samples_of_the_book_s_table_give_their_alphas_again() {
    let noise = OdometryNoise { alpha1: 1e-4, alpha2: 1e-3, alpha3: 1e-5, alpha4: 1e-6 };
    let truth = [noise.alpha1, noise.alpha2, noise.alpha3, noise.alpha4];
    let (seeds, mut squares) = (10, [0.0; 4]);
    for seed in 0..seeds {
        let (mut robot, mut random) = (Drive::new(), Random::new(seed, 1));
        for k in 0..4000 {
            let (left, right) = wheels(k);
            robot.tick(left, right, |pose, ways| of_the_book(noise, &mut random, pose, ways));
            robot.see();
        }
        let fit = fit(&robot.windows).unwrap();
        assert_eq!((fit.windows, fit.left), (4000, Left::default()));
        let off = check(&fit, truth, &format!("seed {seed}"));
        squares.iter_mut().zip(off).for_each(|(sum, off)| *sum += off / 10.0);
        assert!(fit.alphas.iter().all(|a| a.told == Identifiability::Well), "{fit:?}");
        assert!(fit.flags().starts_with("--alpha1 ") && fit.flags().contains("--alpha4 "));
    }
    // Errors are as large as they are said to be: χ² with 10 degrees over 10.
    assert!(squares.iter().all(|s| (0.2..2.8).contains(s)), "{squares:?}");
}

/// k of the defaults, m²/m.
const K: f64 = 2e-5;

/// α of wheels that slip with `k`, on straights and on the spot. (In a curve |Δθ| adds
/// nothing to the way of both wheels, so that curves have less than the model says.)
fn of_slip(k: f64) -> [f64; 4] {
    let track = 0.16;
    [k / track, 2.0 * k / (track * track), 0.5 * k, 0.25 * k * track]
}

/// Counts of tick `k` on straights and on the spot.
fn without_curves(k: u64) -> (i64, i64) {
    if (k / 50).is_multiple_of(2) { (200, 200) } else { (-160, 160) }
}

#[test]
fn wheels_that_slip_have_the_alphas_of_their_slip() {
    let (mut robot, mut random) = (Drive::new(), Random::new(3, 1));
    for k in 0..8000 {
        let (left, right) = without_curves(k);
        robot.tick(left, right, |pose, ways| slipping(K, &mut random, pose, ways));
        robot.see();
    }
    let fit = fit(&robot.windows).unwrap();
    let _ = check(&fit, of_slip(K), "slip");
    let [said, default] = [of_slip(K), {
        let d = OdometryNoise::default();
        [d.alpha1, d.alpha2, d.alpha3, d.alpha4]
    }];
    assert!(said.iter().zip(default).all(|(a, b)| (a / b - 1.0).abs() < 1e-9));
    for systematic in [fit.ahead_per_m, fit.turn_per_m, fit.turn_per_rad] {
        assert!(!systematic.unwrap().is_there(), "{systematic:?}");
    }
}

#[test]
fn windows_of_many_ticks_tell_the_alphas_of_one() {
    let (mut robot, mut random) = (Drive::new(), Random::new(4, 1));
    for k in 0..40_000 {
        let (left, right) = without_curves(k);
        robot.tick(left, right, |pose, ways| slipping(K, &mut random, pose, ways));
        if k % 5 == 4 {
            robot.see();
        } else {
            robot.windows.tick(robot.counts, None);
        }
    }
    let fit = fit(&robot.windows).unwrap();
    assert_eq!((fit.windows, fit.ticks_a_window), (8000, 5.0));
    let _ = check(&fit, of_slip(K), "windows");
}

#[test]
fn what_a_drive_does_not_tell_is_not_made_up() {
    let drive = |wheels: fn(u64) -> (i64, i64)| {
        let (mut robot, mut random) = (Drive::new(), Random::new(5, 1));
        for k in 0..2000 {
            let (left, right) = wheels(k);
            robot.tick(left, right, |pose, ways| slipping(K, &mut random, pose, ways));
            robot.see();
        }
        let fit = fit(&robot.windows).unwrap();
        assert!(fit.alphas.iter().all(|a| a.value.is_finite() && a.value >= 0.0), "{fit:?}");
        (fit.alphas.map(|a| a.told), fit.flags())
    };
    // Straight on: nothing of turns.
    let (told, flags) = drive(|_| (200, 200));
    assert_eq!(
        told,
        [Identifiability::Not, Identifiability::Well, Identifiability::Well, Identifiability::Not]
    );
    assert!(flags.starts_with("--alpha2") && !flags.contains("alpha4"), "{flags}");
    // On the spot: nothing of ways.
    let (told, _) = drive(|_| (-200, 200));
    assert_eq!(
        told,
        [Identifiability::Well, Identifiability::Not, Identifiability::Not, Identifiability::Well]
    );
    // Always the same curve: only sums.
    let (told, flags) = drive(|_| (150, 230));
    assert_eq!((told, flags.as_str()), ([Identifiability::Not; 4], ""));
    // Wide curves: hardly anything of turns.
    let (told, _) = drive(|k| if k % 100 < 50 { (190, 210) } else { (200, 200) });
    assert_eq!(
        told,
        [
            Identifiability::Hardly,
            Identifiability::Well,
            Identifiability::Well,
            Identifiability::Hardly
        ]
    );
}

#[test]
fn standing_holding_and_carrying_are_left_out() {
    let mut robot = Drive::new();
    robot.see();
    robot.tick(200, 200, |pose, _| pose);
    robot.see();
    robot.tick(200, 200, |_, _| SE2::new(5.0, 5.0, 1.0));
    robot.see();
    assert_eq!(robot.windows.left, Left { standing: 1, held: 1, carried: 1 });
    assert!(robot.windows.all.is_empty() && fit(&robot.windows).is_none());
    // Lifted by plan: no window at all.
    robot.windows.interrupt();
    robot.tick(200, 200, |_, _| SE2::new(0.0, 5.0, 1.0));
    robot.see();
    assert_eq!(robot.windows.left.carried, 1);
}

#[test]
fn a_wheel_that_is_larger_than_said_shows() {
    let (mut robot, mut random) = (Drive::new(), Random::new(6, 1));
    for k in 0..4000 {
        let (left, right) = wheels(k);
        robot.tick(left, right, |pose, [l, r]| slipping(K, &mut random, pose, [l, 1.01 * r]));
        robot.see();
    }
    let fit = fit(&robot.windows).unwrap();
    // 1 % on one of two wheels: half a percent of the way, 0.01/ℓ · ½ of heading.
    let (way, turn) = (fit.ahead_per_m.unwrap(), fit.turn_per_m.unwrap());
    assert!(turn.is_there() && (turn.value - 0.01 / 0.16).abs() < 4.0 * turn.std_error, "{turn:?}");
    assert!(way.value > 0.0, "{way:?}");
}

#[test]
fn where_no_way_up_is_known_it_is_not_said_to_be_at_the_top() {
    let mut windows = Windows::new(DiffDrive::rusty(), Vector2::zeros());
    let each = nalgebra::Matrix2::identity();
    let window = |size: f64| Window {
        error: Vector2::new(1.0, 1.0),
        of_alpha: [each * size; 4],
        known: each,
        driven: Vector2::new(1.0, 1.0),
        ticks: 1,
    };
    windows.all = vec![window(1e200)];
    assert!(!fit(&windows).unwrap().converged);
    windows.all = vec![window(1.0)];
    assert!(fit(&windows).unwrap().converged);
}

#[test]
fn noise_of_the_true_poses_is_not_taken_for_that_of_the_wheels() {
    let noise = Vector2::new(0.004, 0.02);
    let told = |reference: Vector2<f64>| {
        let (mut robot, mut random) = (Drive::with_reference(reference), Random::new(7, 1));
        for k in 0..40_000 {
            let (left, right) = without_curves(k);
            robot.tick(left, right, |pose, ways| slipping(K, &mut random, pose, ways));
            let off = SE2::new(noise.x * random.normal(), 0.0, noise.y * random.normal());
            let seen = (k % 5 == 4).then(|| robot.pose.compose(&off));
            robot.windows.tick(robot.counts, seen);
        }
        fit(&robot.windows).unwrap()
    };
    let _ = check(&told(noise), of_slip(K), "known noise");
    let without = told(Vector2::zeros());
    let [_, alpha2, alpha3, _] = of_slip(K);
    assert!(without.alphas[1].value > 2.0 * alpha2, "{:?}", without.alphas);
    assert!(without.alphas[2].value > 2.0 * alpha3, "{:?}", without.alphas);
}

#[test]
fn true_poses_that_contradict_the_wheels_are_refused() {
    let drive = |reference_m: f64| {
        let (mut robot, mut random) = (Drive::new(), Random::new(6, 1));
        for k in 0..2000 {
            let (left, right) = without_curves(k);
            robot.tick(left, right, |pose, ways| slipping(K, &mut random, pose, ways));
            let off = reference_m * random.normal();
            let seen = robot.pose.compose(&SE2::new(off, 0.0, off));
            robot.windows.tick(robot.counts, Some(seen));
        }
        fit(&robot.windows).unwrap()
    };
    let good = drive(0.0);
    assert_eq!(good.problem(), None);
    assert!(good.flags().contains("--alpha3"));
    let bad = drive(0.3);
    assert!(bad.alphas.iter().any(|a| a.value > MOST), "{:?}", bad.alphas);
    assert!(bad.problem().is_some() && bad.flags().is_empty());
    let early = MotionFit { converged: false, ..good };
    assert!(early.problem().unwrap().contains("converge") && early.flags().is_empty());
}
