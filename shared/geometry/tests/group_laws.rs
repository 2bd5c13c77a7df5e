//! The laws of SE(2), as one set: for the identity, for angles from 1e-300 up,
//! for half turns of either sign and for random elements.
#![allow(clippy::unwrap_used)]

use core::f64::consts::PI;

use nalgebra::{Point2, Vector3};
use proptest::prelude::*;
use rusty_geometry::{SE2, wrap_angle};

const TOLERANCE: f64 = 1e-12;

fn close(a: &SE2, b: &SE2) -> bool {
    (a.x() - b.x()).abs() < TOLERANCE
        && (a.y() - b.y()).abs() < TOLERANCE
        && wrap_angle(a.theta() - b.theta()).abs() < TOLERANCE
}

/// Every law that involves up to three elements.
fn check_laws(a: &SE2, b: &SE2, c: &SE2) {
    let one = SE2::identity();
    assert!(close(&(*a * one), a) && close(&(one * *a), a), "identity: {a:?}");
    assert!(close(&(*a * a.inverse()), &one), "right inverse: {a:?}");
    assert!(close(&(a.inverse() * *a), &one), "left inverse: {a:?}");
    assert!(close(&((*a * *b) * *c), &(*a * (*b * *c))), "associativity: {a:?} {b:?} {c:?}");
    assert!(
        close(&(*a * *b).inverse(), &(b.inverse() * a.inverse())),
        "inverse of a product: {a:?} {b:?}"
    );
    assert!(close(&SE2::exp(&a.log()), a), "exp of log: {a:?}");
    assert!(close(&a.boxplus(&b.boxminus(a)), b), "a + (b - a): {a:?} {b:?}");
    let tau = b.log();
    let back = a.boxplus(&tau).boxminus(a);
    // Near a half turn the two ways round are equally short; both are right.
    if (PI - tau.z.abs()) > 1e-9 {
        assert!((back - tau).abs().max() < 1e-11, "(a + t) - a: {a:?} {tau:?} {back:?}");
    }
    let p = Point2::new(0.3, -1.7);
    let gap = (*a * *b).transform_point(&p) - a.transform_point(&b.transform_point(&p));
    assert!(gap.abs().max() < TOLERANCE, "action: {a:?} {b:?}");
    for element in [a, b, c, &(*a * *b), &a.inverse(), &a.boxplus(&tau)] {
        assert!(element.theta() > -PI && element.theta() <= PI, "wrapped: {element:?}");
    }
}

#[test]
fn laws_at_the_special_angles() {
    let mut angles_rad = vec![0.0, PI, -PI, PI.next_down(), (-PI).next_up(), 0.5 * PI, -0.5 * PI];
    for tiny in [5e-324, 1e-300, 1e-200, 1e-100, 1e-30, 1e-16, 1e-12, 1e-9, 1e-8, 1e-6, 1e-4, 1e-3]
    {
        angles_rad.extend([tiny, -tiny, PI - tiny, tiny - PI]);
    }
    for (i, theta_rad) in angles_rad.iter().enumerate() {
        for (j, other_rad) in angles_rad.iter().enumerate() {
            let a = SE2::new(0.7 * i as f64 / 50.0, -0.4, *theta_rad);
            let b = SE2::new(-1.3, 0.9 * j as f64 / 50.0, *other_rad);
            check_laws(&a, &b, &SE2::new(0.25, 0.5, 1.0));
            check_laws(&b, &SE2::new(0.0, 0.0, *theta_rad), &a);
        }
    }
}

#[test]
fn exp_near_zero_agrees_with_its_series() {
    for theta_rad in [0.0, 5e-324, 1e-300, 1e-100, 1e-16, 1e-9, 1e-6, 1e-4] {
        for theta_rad in [theta_rad, -theta_rad] {
            let (rho_x, rho_y) = (1.25, -0.75);
            let pose = SE2::exp(&Vector3::new(rho_x, rho_y, theta_rad));
            let sine = 1.0 - theta_rad * theta_rad / 6.0;
            let versine = theta_rad / 2.0 * (1.0 - theta_rad * theta_rad / 12.0);
            assert!((pose.x() - (sine * rho_x - versine * rho_y)).abs() < 4e-16);
            assert!((pose.y() - (versine * rho_x + sine * rho_y)).abs() < 4e-16);
            assert_eq!(pose.theta().to_bits(), theta_rad.to_bits());
            let tau = pose.log();
            assert!((tau.x - rho_x).abs() < 4e-16 && (tau.y - rho_y).abs() < 4e-16);
        }
    }
}

#[test]
fn a_straight_motion_is_a_translation_to_the_bit() {
    let pose = SE2::exp(&Vector3::new(0.1, 0.0, 0.0));
    assert_eq!((pose.x(), pose.y(), pose.theta()), (0.1, 0.0, 0.0));
}

#[test]
fn near_poses_far_from_the_origin_keep_their_difference() {
    let far = SE2::new(1e6, -1e6, 2.0);
    let tau = Vector3::new(0.01, 0.0, 0.02);
    let back = far.boxplus(&tau).boxminus(&far);
    assert!((back - tau).abs().max() < 1e-9);
}

fn any_pose() -> impl Strategy<Value = SE2> {
    (-10.0_f64..10.0, -10.0_f64..10.0, -PI..=PI).prop_map(|(x, y, theta)| SE2::new(x, y, theta))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 1024, ..ProptestConfig::default() })]

    #[test]
    fn laws_of_random_elements(a in any_pose(), b in any_pose(), c in any_pose()) {
        check_laws(&a, &b, &c);
    }

    #[test]
    fn log_of_exp_is_the_twist(x in -5.0_f64..5.0, y in -5.0_f64..5.0, theta in (-PI).next_up()..PI) {
        let tau = Vector3::new(x, y, theta);
        prop_assert!((SE2::exp(&tau).log() - tau).abs().max() < TOLERANCE);
    }

    #[test]
    fn a_motion_is_the_same_in_one_step_or_many(
        x in -2.0_f64..2.0, y in -2.0_f64..2.0, theta in -9.0_f64..9.0, steps in 1_u32..50,
    ) {
        let whole = Vector3::new(x, y, theta);
        let mut pose = SE2::identity();
        for _ in 0..steps {
            pose = pose.boxplus(&(whole / f64::from(steps)));
        }
        prop_assert!(close(&pose, &SE2::exp(&whole)));
    }
}
