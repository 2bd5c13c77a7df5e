//! The test of the filter by its own innovations.
//!
//! Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to
//! Tracking and Navigation* (2001), §5.4.2: if the filter is consistent, the sum of its
//! normalised squared innovations (NIS) over a window has the law of χ² with as many
//! degrees of freedom as numbers were measured. §11.2: while the sum is too large, the
//! process noise is raised, and lowered again when the sum is too small.
//!
//! Departures, and why:
//! * A window ends with each alarm: the innovations before it belong to another filter.
//! * The noise is never less than the options say. A filter that passes the test is
//!   therefore not changed by it, to the bit.

use rusty_contract::Innovation;

/// Scans in a window: two seconds at 10 Hz.
const SCANS: usize = 20;
/// Degrees of freedom below which a window is not tested.
const LEAST_DEGREES: u32 = 40;
/// Quantile of the normal law that is exceeded once in a million.
const QUANTILE: f64 = 4.753_424;
/// Largest factor of the process noise.
const MOST_NOISE: f64 = 64.0;

/// Result of the test after a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The window is inside the bounds, or not full.
    Consistent,
    /// The innovations are too large: by this factor per degree of freedom.
    TooLarge(f64),
    /// The innovations are too small.
    TooSmall,
}

/// The innovations of the last scans, and the factor of the process noise.
#[derive(Clone, Debug)]
pub struct Monitor {
    window: [Innovation; SCANS],
    scans: usize,
    noise: f64,
}

impl Default for Monitor {
    fn default() -> Self {
        Self { window: [Innovation { nis: 0.0, degrees: 0 }; SCANS], scans: 0, noise: 1.0 }
    }
}

impl Monitor {
    /// Factor of the process noise, from 1.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// Takes the innovation of a scan, and tests the window.
    pub fn take(&mut self, innovation: Innovation) -> Verdict {
        self.window[self.scans % SCANS] = innovation;
        self.scans += 1;
        let degrees: u32 = self.window.iter().map(|of| of.degrees).sum();
        if self.scans < SCANS || degrees < LEAST_DEGREES {
            return Verdict::Consistent;
        }
        let (nis, degrees) = (self.window.iter().map(|of| of.nis).sum::<f64>(), f64::from(degrees));
        if nis > chi_square(degrees, QUANTILE) {
            return Verdict::TooLarge(nis / degrees);
        }
        if nis < chi_square(degrees, -QUANTILE) { Verdict::TooSmall } else { Verdict::Consistent }
    }

    /// Doubles the process noise, and begins a new window.
    pub fn raise(&mut self) {
        self.noise = (2.0 * self.noise).min(MOST_NOISE);
        self.restart();
    }

    /// Halves the process noise, to 1 at least, and begins a new window.
    pub fn lower(&mut self) {
        self.noise = (0.5 * self.noise).max(1.0);
        self.restart();
    }

    /// Begins a new window.
    pub fn restart(&mut self) {
        *self = Self { noise: self.noise, ..Self::default() };
    }
}

/// The quantile of χ² of these degrees where the normal law has `z`, by the
/// approximation of Wilson and Hilferty.
fn chi_square(degrees: f64, z: f64) -> f64 {
    let a = 2.0 / (9.0 * degrees);
    let root = 1.0 - a + a.sqrt() * z;
    degrees * root * root * root
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// First verdict other than consistent over `scans` scans of 5 lines whose
    /// innovations have this variance.
    fn verdict(variance: f64, scans: usize, seed: u64) -> Option<Verdict> {
        let (mut monitor, mut random) = (Monitor::default(), Random::new(seed, 1));
        let mut of_scan = || {
            let squares = (0..10).map(|_| random.normal()).map(|z| z * z);
            Innovation { nis: variance * squares.sum::<f64>(), degrees: 10 }
        };
        (0..scans).map(|_| monitor.take(of_scan())).find(|v| *v != Verdict::Consistent)
    }

    #[test]
    fn quantiles_are_those_of_the_chi_square_law() {
        for degrees in [40.0, 200.0, 1000.0] {
            for (level, z) in [(0.999_999, QUANTILE), (1e-6, -QUANTILE), (0.5, 0.0)] {
                let exact = rusty_metrics::chi_square::quantile(level, degrees);
                let found = chi_square(degrees, z);
                assert!((found / exact - 1.0).abs() < 0.03, "{found} for {exact}");
            }
        }
    }

    #[test]
    fn a_consistent_filter_raises_no_alarm_and_others_do() {
        for seed in 0..50 {
            assert_eq!(verdict(1.0, 1000, seed), None);
            let too_large = verdict(2.0, SCANS, seed);
            assert!(matches!(too_large, Some(Verdict::TooLarge(by)) if by > 1.4), "{too_large:?}");
            assert_eq!(verdict(0.4, SCANS, seed), Some(Verdict::TooSmall));
        }
    }

    #[test]
    fn few_lines_are_not_judged() {
        let mut monitor = Monitor::default();
        for _ in 0..100 {
            let one = Innovation { nis: 13.0, degrees: 1 };
            assert_eq!(monitor.take(one), Verdict::Consistent);
        }
    }

    #[test]
    fn noise_is_bounded() {
        let mut monitor = Monitor::default();
        monitor.lower();
        assert_eq!(monitor.noise(), 1.0);
        (0..10).for_each(|_| monitor.raise());
        assert_eq!(monitor.noise(), MOST_NOISE);
        monitor.lower();
        assert_eq!(monitor.noise(), MOST_NOISE / 2.0);
    }
}
