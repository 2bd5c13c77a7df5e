//! The exponent of something that grows: y = c · xᵖ, fitted as a line through
//! (ln x, ln y).

use rusty_geometry::trig;
use serde::Serialize;

/// A power law through points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerLaw {
    /// p.
    pub exponent: f64,
    /// c: the value at x = 1.
    pub factor: f64,
    /// Least and greatest x it was fitted on.
    pub range: [f64; 2],
    /// How many points.
    pub points: usize,
}

impl PowerLaw {
    /// The least-squares line through the logarithms of those `points` (x, y)
    /// whose x is at least `from` and whose both numbers are above zero and
    /// finite. `None` with fewer than three of them, or all at one x.
    #[must_use]
    pub fn fit(points: &[[f64; 2]], from: f64) -> Option<Self> {
        let usable = |v: f64| v > 0.0 && v.is_finite();
        let used: Vec<[f64; 2]> = points
            .iter()
            .filter(|[x, y]| *x >= from && usable(*x) && usable(*y))
            .map(|[x, y]| [trig::ln(*x), trig::ln(*y)])
            .collect();
        let n = used.len() as f64;
        let mean = |i: usize| used.iter().map(|p| p[i]).sum::<f64>() / n;
        let (x0, y0) = (mean(0), mean(1));
        let sxx: f64 = used.iter().map(|p| (p[0] - x0) * (p[0] - x0)).sum();
        let sxy: f64 = used.iter().map(|p| (p[0] - x0) * (p[1] - y0)).sum();
        if used.len() < 3 || sxx < 1e-9 {
            return None;
        }
        let exponent = sxy / sxx;
        let end = |least: bool| {
            let pick = if least { f64::min } else { f64::max };
            let all = points.iter().filter(|[x, y]| *x >= from && usable(*x) && usable(*y));
            all.map(|p| p[0]).reduce(pick).unwrap_or(f64::NAN)
        };
        Some(Self {
            exponent,
            factor: trig::exp(y0 - exponent * x0),
            range: [end(true), end(false)],
            points: used.len(),
        })
    }

    /// c · xᵖ for x above zero.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        self.factor * trig::exp(self.exponent * trig::ln(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(exponent: f64) -> Vec<[f64; 2]> {
        let at = |x: f64| [x, 3.0 * trig::exp(exponent * trig::ln(x))];
        (1..=40).map(|k| at(0.25 * f64::from(k))).collect()
    }

    #[test]
    fn a_power_law_is_found_again() {
        for exponent in [-1.0, 0.0, 0.5, 1.0, 1.5, 3.0] {
            let fit = PowerLaw::fit(&points(exponent), 0.0).unwrap();
            assert!((fit.exponent - exponent).abs() < 1e-12, "{fit:?}");
            assert!((fit.factor - 3.0).abs() < 1e-11, "{fit:?}");
            assert!((fit.at(4.0) - 3.0 * trig::exp(exponent * trig::ln(4.0))).abs() < 1e-9);
        }
    }

    #[test]
    fn only_what_lies_in_the_range_is_used() {
        let mut bent = points(1.5);
        bent.iter_mut().filter(|p| p[0] < 2.0).for_each(|p| p[1] = 100.0);
        bent.push([5.0, 0.0]);
        bent.push([6.0, f64::NAN]);
        let fit = PowerLaw::fit(&bent, 2.0).unwrap();
        assert!((fit.exponent - 1.5).abs() < 1e-12);
        assert_eq!((fit.range, fit.points), ([2.0, 10.0], 33));
    }

    #[test]
    fn too_little_is_no_law() {
        assert_eq!(PowerLaw::fit(&[], 0.0), None);
        assert_eq!(PowerLaw::fit(&[[1.0, 1.0], [2.0, 2.0]], 0.0), None);
        assert_eq!(PowerLaw::fit(&[[2.0, 1.0]; 5], 0.0), None);
        assert_eq!(PowerLaw::fit(&[[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]], 0.0), None);
    }
}
