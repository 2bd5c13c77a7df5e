//! Compute times of an estimator, in memory of a fixed size.

use rusty_contract::score::{ComputeTimes, Durations};

use super::series::{EXACT_MEDIANS, Series};

/// The times of one estimator's answers.
#[derive(Clone, Debug)]
pub(super) struct Times {
    reported_s: Series,
    observed_s: Series,
}

impl Times {
    /// No answer yet, with room for as many as are expected.
    pub fn expecting(answers: u64) -> Self {
        let series = || Series::keeping(EXACT_MEDIANS, answers);
        Self { reported_s: series(), observed_s: series() }
    }

    /// Takes the next. An answer that was not observed is left out: a recorder that
    /// catches up receives what it missed without its times.
    pub fn push(&mut self, [reported_ns, observed_ns]: [u64; 2]) {
        if observed_ns > 0 {
            self.reported_s.push(reported_ns as f64 * 1e-9);
            self.observed_s.push(observed_ns as f64 * 1e-9);
        }
    }

    /// `None` without an answer.
    pub fn figures(&mut self) -> Option<ComputeTimes> {
        let (reported, observed) =
            (durations(&mut self.reported_s)?, durations(&mut self.observed_s)?);
        Some(ComputeTimes { reported, observed })
    }
}

fn durations(of: &mut Series) -> Option<Durations> {
    Some(Durations { p50_s: of.at(0.5)?, p99_s: of.at(0.99)?, max_s: of.moments().greatest() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_that_were_not_observed_are_left_out() {
        let mut times = Times::expecting(3);
        times.push([7, 0]);
        assert_eq!(times.figures(), None);
        (1..=101).for_each(|k| times.push([k * 1000, k * 2000]));
        let found = times.figures().unwrap();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a}, {b}");
        near(found.reported.p50_s, 51e-6);
        near(found.reported.p99_s, 100e-6);
        assert_eq!(found.reported.max_s, 101_000.0 * 1e-9);
        near(found.observed.p50_s, 102e-6);
    }
}
