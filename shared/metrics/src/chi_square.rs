//! χ²: how large a sum of squared normal deviates is, and how large it may be.
//!
//! Source: M. Abramowitz and I. Stegun, *Handbook of Mathematical Functions*
//! (1964): P(χ² ≤ x | ν) is the regularized incomplete gamma function P(ν/2, x/2)
//! (26.4.19), computed by its series (6.5.29) below ν/2 + 1 and by its continued
//! fraction (6.5.31), in the evaluation of W. Lentz (1976), above; quantiles by
//! bisection. Degrees of freedom need not be whole. A crate would take logarithms of
//! the platform; a score, with its verdicts, has the same bits on every machine.

use rusty_geometry::trig;

/// Nothing up to [`MANY_DEGREES`] needs as many terms; nothing hangs.
const MOST_TERMS: u32 = 1 << 22;
/// Beyond this many degrees quantiles are those of E. Wilson and M. Hilferty (*The
/// distribution of chi-square*, PNAS 17, 1931; Abramowitz and Stegun 26.4.17),
/// right to 10⁻⁹ there.
const MANY_DEGREES: f64 = 1e6;

/// Probability that χ² with N degrees of freedom is at most `x`. 0 for
/// what is not positive.
#[must_use]
pub fn cdf(x: f64, degrees: f64) -> f64 {
    if !(x > 0.0 && degrees > 0.0) {
        return 0.0;
    }
    if x == f64::INFINITY {
        return 1.0;
    }
    let (a, x) = (0.5 * degrees, 0.5 * x);
    let front = trig::exp(a * trig::ln(x) - x - trig::ln_gamma(a));
    let p = if x < a + 1.0 { front * series(a, x) } else { 1.0 - front * fraction(a, x) };
    p.clamp(0.0, 1.0)
}

/// The value that χ² with N degrees of freedom (positive) stays below
/// with this probability (between 0 and 1).
#[must_use]
pub fn quantile(probability: f64, degrees: f64) -> f64 {
    if !(degrees > 0.0 && (0.0..=1.0).contains(&probability)) {
        return f64::NAN;
    }
    if degrees > MANY_DEGREES {
        return wilson_hilferty(probability, degrees);
    }
    bisected(probability, degrees)
}

/// d (1 − 2/(9d) + z √(2/(9d)))³, z the normal quantile, whose square is χ² with
/// one degree.
fn wilson_hilferty(probability: f64, degrees: f64) -> f64 {
    let two_sided = 2.0 * probability - 1.0;
    let z = bisected(two_sided.abs(), 1.0).sqrt().copysign(two_sided);
    let part = 2.0 / (9.0 * degrees);
    let root = 1.0 - part + z * part.sqrt();
    degrees * root * root * root
}

fn bisected(probability: f64, degrees: f64) -> f64 {
    let (mut low, mut high) = (0.0, degrees + 1.0);
    while cdf(high, degrees) < probability && high < f64::MAX / 4.0 {
        (low, high) = (high, 2.0 * high);
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if cdf(middle, degrees) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// χ² of N degrees lies between these two with probability `level`, and
/// as probably below as above.
#[must_use]
pub fn band(level: f64, degrees: f64) -> [f64; 2] {
    let tail = 0.5 * (1.0 - level);
    [quantile(tail, degrees), quantile(1.0 - tail, degrees)]
}

/// The mean of `n` independent values of `degrees` each is in here with probability
/// `level`, as often above as below; NaN where there are none.
///
/// Source: Y. Bar-Shalom, X. Li, T. Kirubarajan, *Estimation with Applications to
/// Tracking and Navigation* (2001), §5.4.2.
#[must_use]
pub fn mean_interval(n: f64, degrees: f64, level: f64) -> [f64; 2] {
    band(level, n * degrees).map(|end| end / n)
}

/// 1/a + x/(a (a+1)) + x²/(a (a+1) (a+2)) + …
fn series(a: f64, x: f64) -> f64 {
    let mut term = 1.0 / a;
    let mut sum = term;
    for n in 1..MOST_TERMS {
        term *= x / (a + f64::from(n));
        sum += term;
        if term <= sum * f64::EPSILON {
            break;
        }
    }
    sum
}

/// 1/(x+1−a− 1(1−a)/(x+3−a− 2(2−a)/(x+5−a− …
fn fraction(a: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let far = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / far(b);
    let mut h = d;
    for n in 1..MOST_TERMS {
        let n = f64::from(n);
        let numerator = -n * (n - a);
        b += 2.0;
        d = 1.0 / far(numerator * d + b);
        c = far(b + numerator / c);
        h *= c * d;
        if (c * d - 1.0).abs() <= 4.0 * f64::EPSILON {
            break;
        }
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy 1.17.1: `chi2.ppf([.025, .975], df)`, `chi2.cdf(x, df)`.
    #[test]
    fn the_numbers_of_scipy() {
        for (degrees, low, high) in QUANTILES {
            for (found, expected) in band(0.95, degrees).into_iter().zip([low, high]) {
                assert!((found - expected).abs() <= 2e-10 * expected, "{degrees}: {found}");
            }
        }
        for (x, degrees, expected) in PROBABILITIES {
            let found = cdf(x, degrees);
            assert!((found - expected).abs() <= 1e-12 * expected, "{x}, {degrees}: {found}");
        }
    }

    #[test]
    fn odd_questions_have_answers() {
        assert_eq!((cdf(-1.0, 3.0), cdf(0.0, 3.0), cdf(f64::NAN, 3.0)), (0.0, 0.0, 0.0));
        assert_eq!((cdf(f64::INFINITY, 3.0), cdf(1e300, 3.0), cdf(1.0, 0.0)), (1.0, 1.0, 0.0));
        assert!(quantile(f64::NAN, 3.0).is_nan() && quantile(0.5, f64::NAN).is_nan());
        // Where the two ways meet they agree, and far beyond nothing takes long.
        for tail in [0.005, 0.025, 0.4, 0.5, 0.975] {
            let (exact, near) = (bisected(tail, 1e6), wilson_hilferty(tail, 1e6));
            assert!((exact - near).abs() < 1e-9 * exact, "{tail}: {exact} {near}");
        }
        let [low, high] = band(0.95, 1e15);
        assert!(low < 1e15 && 1e15 < high && high - low < 1e9, "{low} {high}");
        // Two degrees are an exponential distribution.
        assert!((quantile(0.5, 2.0) - 2.0 * core::f64::consts::LN_2).abs() < 1e-14);
    }

    #[test]
    fn intervals_are_those_of_the_book() {
        // Bar-Shalom, Li, Kirubarajan: 50 runs, 2 degrees: χ²₁₀₀ from 74.22 to 129.6.
        let [low, high] = mean_interval(50.0, 2.0, 0.95);
        assert!((low - 74.222 / 50.0).abs() < 1e-4 && (high - 129.561 / 50.0).abs() < 1e-4);
        // One run of 3 degrees: 0.2158 and 9.3484.
        let [low, high] = mean_interval(1.0, 3.0, 0.95);
        assert!((low - 0.215_795).abs() < 1e-5 && (high - 9.348_404).abs() < 1e-5);
        let [low, high] = mean_interval(10_000.0, 3.0, 0.99);
        assert!(low > 2.93 && low < 3.0 && high > 3.0 && high < 3.07);
        assert!(mean_interval(0.0, 3.0, 0.95)[0].is_nan());
    }

    const QUANTILES: [(f64, f64, f64); 7] = [
        (1.0, 0.0009820691171752555, 5.023886187314888),
        (3.0, 0.21579528262389785, 9.348403604496148),
        (4.7, 0.7202198179340555, 12.334466166140999),
        (30.0, 16.79077226556663, 46.97924224367115),
        (180.0, 144.74125626221195, 219.04431678751286),
        (4500.0, 4315.962985549624, 4687.825505126172),
        (3000000.0, 2995200.982910247, 3004802.8057013326),
    ];
    const PROBABILITIES: [(f64, f64, f64); 5] = [
        (0.001, 1.0, 0.02522712063003961),
        (0.5, 3.0, 0.08110858834532418),
        (7.815, 3.0, 0.9500060970251161),
        (20.0, 3.0, 0.9998302575644472),
        (150.0, 180.0, 0.0501921070753036),
    ];
}
