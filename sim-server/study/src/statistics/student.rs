//! Student's t distribution: how far to go from the mean of few numbers.
//!
//! Source: "Student", *The probable error of a mean*, Biometrika 6 (1908). The
//! tail beyond ±t with ν degrees of freedom is the regularized incomplete beta
//! function I_x(ν/2, 1/2) at x = ν/(ν + t²) (Abramowitz and Stegun, 26.7.1),
//! which is computed by its continued fraction (26.5.8) in the evaluation of
//! W. Lentz (1976), and inverted by bisection: slow, and with nothing to go
//! wrong. Where ν is large, and that loses digits, the expansion in 1/ν takes
//! over (26.7.5). Degrees of freedom need not be whole, see
//! [`super::pairs`].

use rusty_contract::score::chi_square;
use rusty_geometry::trig;

/// From here on the expansion has all digits that are asked for.
const MANY: f64 = 1e3;
/// The standard normal's quantile at 0.975.
const NORMAL_975: f64 = 1.959_963_984_540_054;
/// The level of [`t_975`].
const USUAL: f64 = 0.95;

/// Half the width of a 95 % interval in standard errors: the 0.975 quantile of
/// Student's t with `degrees` degrees of freedom. NaN below, or at, zero.
///
/// Relative error below 10⁻⁹.
#[must_use]
pub fn t_975(degrees: f64) -> f64 {
    t_two_sided(degrees, USUAL)
}

/// Half the width of an interval that holds with probability `level`, in
/// standard errors, for `degrees` degrees of freedom. NaN where the degrees are
/// not above zero, or the level is not between 0 and 1.
///
/// Relative error below 10⁻⁹ for levels up to 0.999.
#[must_use]
pub fn t_two_sided(degrees: f64, level: f64) -> f64 {
    let possible = degrees > 0.0 && level > 0.0 && level < 1.0;
    if !possible {
        return f64::NAN;
    }
    let outside = if level == USUAL { 0.05 } else { 1.0 - level };
    if degrees >= MANY {
        // χ² of one degree is the square of a normal deviate.
        let z = if level == USUAL { NORMAL_975 } else { chi_square::quantile(level, 1.0).sqrt() };
        return expansion(degrees, z);
    }
    // Bisection on x, where the whole axis of t is the interval (0, 1) and the
    // tail grows with x.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..200 {
        let x = 0.5 * (low + high);
        if incomplete_beta(x, 0.5 * degrees, 0.5) < outside {
            low = x;
        } else {
            high = x;
        }
    }
    let x = 0.5 * (low + high);
    (degrees * (1.0 - x) / x).sqrt()
}

/// The quantile as a power series in 1/ν about the normal one, `z`; what is left
/// out is below 10 ν⁻⁴ for the usual levels.
fn expansion(degrees: f64, z: f64) -> f64 {
    let z2 = z * z;
    let first = z * (z2 + 1.0) / 4.0;
    let second = z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let third = z * (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    z + (first + (second + third / degrees) / degrees) / degrees
}

/// The regularized incomplete beta function I_x(a, b) for x in [0, 1].
pub(super) fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x;
    }
    // The fraction converges fast on one side of the mean; the other side is the
    // mirror image.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let ln_beta = trig::ln_gamma(a) + trig::ln_gamma(b) - trig::ln_gamma(a + b);
    let front = trig::exp(a * trig::ln(x) + b * trig::ln(1.0 - x) - ln_beta) / a;
    front * fraction(x, a, b)
}

/// The continued fraction of I_x(a, b), front factor apart.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let away = |v: f64| if v.abs() < TINY { TINY } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / away(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for m in 1..100_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut last = 1.0;
        for term in [even, odd] {
            d = 1.0 / away(1.0 + term * d);
            c = away(1.0 + term / c);
            last = c * d;
            value *= last;
        }
        if (last - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Fisher and Yates, to the digits printed there and two more.
        for (degrees, expected) in [
            (1.0, 12.706_204_74),
            (2.0, 4.302_652_73),
            (3.0, 3.182_446_31),
            (4.0, 2.776_445_11),
            (9.0, 2.262_157_16),
            (29.0, 2.045_229_64),
            (120.0, 1.979_930_41),
            (499.0, 1.964_729_39),
        ] {
            let found = t_975(degrees);
            assert!((found - expected).abs() < 1e-8, "{degrees}: {found}");
        }
    }

    #[test]
    fn other_levels_are_those_of_the_tables() {
        for (degrees, level, expected) in [
            (4.0, 0.99, 4.604_094_871_35),
            (9.0, 0.9, 1.833_112_932_66),
            (29.0, 0.99, 2.756_385_903_67),
            (2000.0, 0.99, 2.578_289_787_56),
            (5000.0, 0.9, 1.645_158_437_60),
        ] {
            let found = t_two_sided(degrees, level);
            assert!((found - expected).abs() < 1e-9, "{degrees}, {level}: {found}");
        }
        for level in [0.5, 0.9, 0.99] {
            let seam = t_two_sided(MANY.next_down(), level) - t_two_sided(MANY, level);
            assert!(seam.abs() < 1e-8, "{level}: {seam:e}");
        }
        assert!([0.0, 1.0, f64::NAN].iter().all(|level| t_two_sided(5.0, *level).is_nan()));
    }

    #[test]
    fn one_and_two_degrees_have_closed_forms() {
        // ν = 1 is Cauchy's: tan(π·0.475). ν = 2: p = t/√(2 + t²) with p = 0.95.
        let cauchy = trig::tan(core::f64::consts::PI * 0.475);
        assert!((t_975(1.0) / cauchy - 1.0).abs() < 1e-12);
        let two = 0.95 * (2.0_f64 / (1.0 - 0.95 * 0.95)).sqrt();
        assert!((t_975(2.0) / two - 1.0).abs() < 1e-12);
    }

    #[test]
    fn it_falls_smoothly_to_the_normal_one() {
        let mut before = f64::INFINITY;
        for degrees in [0.5, 1.0, 1.7, 2.5, 7.3, 33.3, 200.0, 999.0, 1001.0, 1e5, 1e9] {
            let t = t_975(degrees);
            assert!(t < before, "{degrees}: {t} after {before}");
            before = t;
        }
        assert!((t_975(1e9) - NORMAL_975).abs() < 1e-8);
        let seam = (t_975(MANY.next_down()) - t_975(MANY)).abs();
        assert!(seam < 1e-10, "{seam:e}");
        for none in [0.0, -1.0, f64::NAN] {
            assert!(t_975(none).is_nan());
        }
    }
}
