//! One convention for angles: radians in (−π, π].
//!
//! A half turn is written +π, never −π, so every heading has exactly one stored
//! form. "π" is the `f64` constant, which lies 1.2e-16 below the true number;
//! the turn taken out is the `f64` constant τ = 2π, so each full turn removed
//! changes the angle by 2.4e-16 rad against exact arithmetic.

use core::f64::consts::{PI, TAU};

/// The angle in (−π, π] that differs from `theta_rad` by whole turns.
///
/// - An angle already in (−π, π] comes back with its exact bits, −0.0 included.
/// - Every step is exact (`%` is, and the one subtraction is by Sterbenz's
///   lemma), so even a huge finite angle is reduced without error relative to
///   the `f64` turn.
/// - NaN stays NaN; an infinite angle has no direction and gives NaN.
#[inline]
#[must_use]
pub fn wrap_angle(theta_rad: f64) -> f64 {
    if theta_rad > -PI && theta_rad <= PI {
        return theta_rad;
    }
    let rest_rad = theta_rad % TAU;
    if rest_rad > PI {
        rest_rad - TAU
    } else if rest_rad <= -PI {
        rest_rad + TAU
    } else {
        rest_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ends_of_the_interval() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
        assert_eq!(wrap_angle(PI.next_up()), -PI.next_down());
        assert_eq!(wrap_angle((-PI).next_up()), (-PI).next_up());
        assert_eq!(wrap_angle(TAU), 0.0);
        assert_eq!(wrap_angle(3.0 * PI), PI);
        assert_eq!(wrap_angle(-3.0 * PI), PI);
        assert_eq!(wrap_angle(-0.0).to_bits(), (-0.0_f64).to_bits());
    }

    #[test]
    fn not_finite_and_huge() {
        assert!(wrap_angle(f64::NAN).is_nan());
        assert!(wrap_angle(f64::INFINITY).is_nan());
        assert!(wrap_angle(f64::NEG_INFINITY).is_nan());
        for huge in [1e6, 1e17, 1e300, f64::MAX] {
            for theta_rad in [wrap_angle(huge), wrap_angle(-huge)] {
                assert!(theta_rad > -PI && theta_rad <= PI);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn inside_keeps_bits(theta_rad in (-PI).next_up()..=PI) {
            prop_assert_eq!(wrap_angle(theta_rad).to_bits(), theta_rad.to_bits());
        }

        #[test]
        fn idempotent_and_congruent(theta_rad in -1e3_f64..1e3) {
            let wrapped_rad = wrap_angle(theta_rad);
            prop_assert_eq!(wrap_angle(wrapped_rad).to_bits(), wrapped_rad.to_bits());
            let turns = (theta_rad - wrapped_rad) / TAU;
            prop_assert!((turns - turns.round()).abs() < 1e-12);
        }
    }
}
