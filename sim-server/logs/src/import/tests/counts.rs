//! Quantization: bounded in every increment, and never accumulating.

use rusty_geometry::{EncoderCounts, SE2, odometry_delta, tick_length, wrap_angle};

use super::super::recording::Event;
use super::super::wheels::{LeverFit, Mount, WHEELS, Wheels};

const PLAIN: Mount = Mount { offset_m: 0.0, odometry_is_laser: false, scans_are_laser: false };

/// A linear congruential generator (Knuth's MMIX constants), as numbers in
/// [-1, 1): the same on every machine.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let step = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = step.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Compares the counts with the raw increments of a path of poses: Δs and each
/// wheel's travel, of every step and of the whole way, metres.
fn worst_errors_m(poses: impl Iterator<Item = SE2>) -> [f64; 4] {
    let mut wheels = Wheels::new(PLAIN);
    let (mut last, mut before) = (None, EncoderCounts::default());
    let (mut sum_m, mut worst_m) = ([0.0; 2], [0.0f64; 4]);
    for (line, pose) in (1..).zip(poses) {
        let event = Event::Reading { pose, stamp_s: 0.0, line };
        let counts = wheels.take(&event).unwrap().counts;
        if let Some(last) = last {
            let tau = pose.boxminus(&last);
            let half_m = 0.5 * WHEELS.track_m * tau.z;
            let delta = odometry_delta(before, counts, &WHEELS);
            let delta_half_m = 0.5 * WHEELS.track_m * delta.z;
            sum_m = [sum_m[0] + tau.x - half_m, sum_m[1] + tau.x + half_m];
            let whole = tick_length(&WHEELS);
            let errors_m = [
                delta.x - tau.x,
                (delta.x - delta_half_m) - (tau.x - half_m),
                (delta.x + delta_half_m) - (tau.x + half_m),
                (counts.left as f64 * whole - sum_m[0])
                    .abs()
                    .max((counts.right as f64 * whole - sum_m[1]).abs()),
            ];
            for (worst, error) in worst_m.iter_mut().zip(errors_m) {
                *worst = worst.max(error.abs());
            }
        }
        last = Some(pose);
        before = counts;
    }
    worst_m
}

#[test]
fn a_count_is_five_micrometres() {
    assert!((tick_length(&WHEELS) - 4.794e-6).abs() < 1e-9);
}

#[test]
fn rounding_stays_within_a_count_and_never_adds_up() {
    let count_m = tick_length(&WHEELS);
    for (seed, step_m, turn_rad) in
        [(1, 0.2, 0.1), (2, 3e-6, 1e-6), (3, 1e-3, 3.0), (4, 100.0, 0.5), (5, 0.0, 0.3)]
    {
        let mut noise = Noise(seed);
        let mut pose = SE2::new(40.0, -25.0, 3.0);
        let poses = (0..20_000).map(|_| {
            let theta_rad = wrap_angle(pose.theta() + turn_rad * noise.next());
            // Not along the heading, so that there is a sideways part too.
            let (dx, dy) = (step_m * noise.next(), step_m * noise.next());
            pose = SE2::new(pose.x() + dx, pose.y() + dy, theta_rad);
            pose
        });
        let worst_m = worst_errors_m(poses);
        let per_step = 1.0 + 1e-3;
        assert!(worst_m[0] < per_step * count_m, "seed {seed}: {worst_m:?}");
        assert!(worst_m[1] < per_step * count_m, "seed {seed}: {worst_m:?}");
        assert!(worst_m[2] < per_step * count_m, "seed {seed}: {worst_m:?}");
        assert!(worst_m[3] < 0.501 * count_m, "seed {seed}: {worst_m:?}");
        assert!(worst_m.iter().all(|m| *m < 1e-4));
    }
}

#[test]
fn a_scan_holds_the_counts_and_an_anchor_moves_nothing() {
    let mut wheels = Wheels::new(PLAIN);
    let at = |x: f64| SE2::new(x, 0.0, 0.0);
    let reading = |x: f64| Event::Reading { pose: at(x), stamp_s: 0.0, line: 1 };
    wheels.take(&reading(0.0));
    let moved = wheels.take(&reading(0.5)).unwrap();
    let scan =
        Event::Scan { pose: Some(at(0.7)), odometry: None, stamp_s: 0.0, ranges_m: &[], line: 2 };
    let held = wheels.take(&scan).unwrap();
    assert_eq!(held.counts, moved.counts);
    assert_eq!(held.truth, Some(at(0.7)));
    let anchor = Event::Anchor { pose: at(0.7), line: 3 };
    assert!(wheels.take(&anchor).is_none());
    let still = wheels.take(&reading(0.7)).unwrap();
    assert_eq!(still.counts, moved.counts);
    assert_eq!(wheels.distance_m, 0.5);
}

#[test]
fn turns_in_place_tell_the_lever_arm_too() {
    let mut fit = LeverFit::default();
    assert_eq!(fit.arm_m(), None);
    for i in 0..100 {
        let body = SE2::new(1.0, 2.0, 0.2 * f64::from(i));
        fit.take(&Event::Reading { pose: body * SE2::new(-0.04, 0.0, 0.0), stamp_s: 0.0, line: 1 });
    }
    assert!((fit.arm_m().unwrap() + 0.04).abs() < 1e-9);
}
