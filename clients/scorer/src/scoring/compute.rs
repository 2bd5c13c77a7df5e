//! How long answers took, in memory of a fixed size.

use rusty_contract::score::{ComputeTimes, Durations, Quantiles};

use super::statistics::EXACT_MEDIANS;
use rusty_clients::witness::Delay;

/// The times of one estimator's answers.
#[derive(Clone, Debug)]
pub(super) struct Times {
    reported: Seconds,
    observed: Seconds,
}

#[derive(Clone, Debug)]
struct Seconds {
    sorted: Quantiles,
    longest: f64,
}

impl Seconds {
    fn push(&mut self, time_ns: u64) {
        let time_s = time_ns as f64 * 1e-9;
        self.sorted.push(time_s);
        self.longest = self.longest.max(time_s);
    }

    fn figures(&mut self) -> Option<Durations> {
        let (p50_s, p99_s) = (self.sorted.at(0.5)?, self.sorted.at(0.99)?);
        Some(Durations { p50_s, p99_s, max_s: self.longest })
    }
}

impl Times {
    /// No answer yet, with room for as many as are expected.
    pub fn expecting(answers: u64) -> Self {
        let seconds =
            || Seconds { sorted: Quantiles::keeping(EXACT_MEDIANS, answers), longest: 0.0 };
        Self { reported: seconds(), observed: seconds() }
    }

    /// Takes the next. One that nobody watched arrive is left out: a witness
    /// that came back is shown what it missed, and not told how long that took.
    pub fn push(&mut self, delay: Delay) {
        if delay.observed_ns > 0 {
            self.reported.push(delay.reported_ns);
            self.observed.push(delay.observed_ns);
        }
    }

    /// What they come to; `None` where there is none.
    pub fn figures(&mut self) -> Option<ComputeTimes> {
        let (reported, observed) = (self.reported.figures()?, self.observed.figures()?);
        Some(ComputeTimes { reported, observed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_watched_is_left_out() {
        let mut times = Times::expecting(3);
        times.push(Delay { reported_ns: 7, observed_ns: 0 });
        assert_eq!(times.figures(), None);
        for k in 1..=101 {
            times.push(Delay { reported_ns: k * 1000, observed_ns: k * 2000 });
        }
        let found = times.figures().unwrap();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a}, {b}");
        near(found.reported.p50_s, 51e-6);
        near(found.reported.p99_s, 100e-6);
        assert_eq!(found.reported.max_s, 101_000.0 * 1e-9);
        near(found.observed.p50_s, 102e-6);
    }
}
