//! Transcendental functions whose bits are the same on every machine.
//!
//! `f64::sin` and its relatives call whatever mathematics library the platform
//! ships; two correct libraries differ in the last bit, and a simulator that
//! must replay a log bit for bit cannot live with that. This module is the one
//! door to such functions: each is a thin wrapper of the [`libm`] crate, which
//! is plain Rust arithmetic and therefore gives the same bits natively and in
//! wasm32. Functions that IEEE 754 already rounds correctly (`sqrt`, `abs`,
//! `floor`, `round`, `copysign`, `%`) may be taken from `std`.
//!
//! All angles are in radians. NaN in gives NaN out; nothing here panics.

/// Sine and cosine of an angle, `(sin, cos)`.
#[inline]
#[must_use]
pub fn sin_cos(angle_rad: f64) -> (f64, f64) {
    libm::sincos(angle_rad)
}

/// Sine of an angle.
#[inline]
#[must_use]
pub fn sin(angle_rad: f64) -> f64 {
    libm::sin(angle_rad)
}

/// Cosine of an angle.
#[inline]
#[must_use]
pub fn cos(angle_rad: f64) -> f64 {
    libm::cos(angle_rad)
}

/// Tangent of an angle.
#[inline]
#[must_use]
pub fn tan(angle_rad: f64) -> f64 {
    libm::tan(angle_rad)
}

/// Arc sine of `x` in [−1, 1], in radians in [−π/2, π/2]; NaN outside.
#[inline]
#[must_use]
pub fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// Arc cosine of `x` in [−1, 1], in radians in [0, π]; NaN outside.
#[inline]
#[must_use]
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// Arc tangent of `x`, in radians in [−π/2, π/2].
#[inline]
#[must_use]
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// Bearing of the vector `(x, y)` from the x axis, in radians in [−π, π].
///
/// The order of the arguments is the usual one, `y` first.
#[inline]
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Length of the vector `(x, y)` without overflow on the way.
#[inline]
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// e to the power `x`.
#[inline]
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm of `x`; NaN for negative `x`, −∞ for zero.
#[inline]
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Natural logarithm of the gamma function's absolute value at `x`.
#[inline]
#[must_use]
pub fn ln_gamma(x: f64) -> f64 {
    libm::lgamma(x)
}

/// `sin(x) / x`, the ratio of a chord to its arc when `x` is half the turn;
/// exactly 1 at zero. Even in `x`; in [2/π, 1] for `x` in [−π/2, π/2].
///
/// There is no series near zero because none is needed. The textbook hazard,
/// cancellation, sits in `1 − cos x`, which this crate never forms. `sin(x)` is
/// good to less than one unit in the last place for every `x` (below 2⁻²⁶ it
/// *is* `x`), so the quotient is too, down to the smallest subnormal. The only
/// switch is therefore at `x = 0` itself, where the quotient would be 0/0.
#[inline]
#[must_use]
pub fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_is_the_pair_of_sin_and_cos_bit_for_bit() {
        for k in -4000..4000 {
            let angle_rad = f64::from(k) * 0.010_203;
            let (s, c) = sin_cos(angle_rad);
            assert_eq!(s.to_bits(), sin(angle_rad).to_bits());
            assert_eq!(c.to_bits(), cos(angle_rad).to_bits());
        }
    }

    #[test]
    fn pinned_bits() {
        // Measured once; any platform that prints other bits breaks replay.
        assert_eq!(sin(1.0).to_bits(), 0x3fea_ed54_8f09_0cee);
        assert_eq!(cos(1.0).to_bits(), 0x3fe1_4a28_0fb5_068c);
        assert_eq!(atan2(1.0, 1.0).to_bits(), core::f64::consts::FRAC_PI_4.to_bits());
        // One unit above the rounded e: not an error to mend, but the bits.
        assert_eq!(exp(1.0), core::f64::consts::E.next_up());
        assert_eq!(hypot(3.0, 4.0), 5.0);
        assert_eq!(ln(1.0), 0.0);
        assert_eq!(ln_gamma(1.0), 0.0);
        assert!((ln_gamma(0.5) - 0.5 * ln(core::f64::consts::PI)).abs() < 1e-15);
    }

    #[test]
    fn sinc_agrees_with_its_series_where_both_hold() {
        assert_eq!(sinc(0.0), 1.0);
        assert_eq!(sinc(-0.0), 1.0);
        for x in [5e-324, 1e-300, 1e-160, 1e-20, 1e-9, 1e-8] {
            assert_eq!(sinc(x), 1.0);
        }
        for x in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
            let x2 = x * x;
            let series = 1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0));
            assert!((sinc(x) - series).abs() <= 3e-16, "x = {x}");
            assert_eq!(sinc(x), sinc(-x));
        }
    }
}
