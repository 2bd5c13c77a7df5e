//! The time axis that map and charts have in common.

use rusty_plot::Step;

use super::scored::scored;
use super::trace::RunTrace;

/// The time axis: what its zero is, and how far it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Timeline {
    /// Time of the run at the axis' zero, s: 0, or the first tick's for
    /// recordings that carry the time of day.
    pub origin_s: f64,
    /// First and last second on the axis.
    pub range_s: [f64; 2],
    /// Time between two marks of an estimator, s.
    pub mark_every_s: f64,
    /// Whether all of these are ticks instead of seconds.
    is_in_ticks: bool,
}

impl Timeline {
    /// The time axis of a run.
    pub fn of(trace: &RunTrace) -> Self {
        let finite = || trace.time_s.iter().copied().filter(|t| t.is_finite());
        let first_s = finite().reduce(f64::min).unwrap_or(0.0);
        let last_s = finite().reduce(f64::max).unwrap_or(1.0);
        let span_s = last_s - first_s;
        let origin_s = if first_s.abs() <= span_s.max(1.0) { 0.0 } else { first_s };
        let start_s = (first_s - origin_s).min(0.0);
        let end_s = last_s - origin_s;
        let end_s = if end_s > start_s { end_s } else { start_s + 1.0 };
        let mark_every_s = Step::of(end_s - start_s, 8.0).size();
        let is_in_ticks = trace.is_in_ticks;
        Self { origin_s, range_s: [start_s, end_s], mark_every_s, is_in_ticks }
    }

    /// Length of the run, s.
    pub fn span_s(&self) -> f64 {
        self.range_s[1] - self.range_s[0]
    }

    /// Place of a tick on the axis, s, if its time is a number.
    pub fn at_s(&self, trace: &RunTrace, tick: usize) -> Option<f64> {
        self.place_s(*trace.time_s.get(tick)?)
    }

    /// Place of a time of the run on the axis, s, if it is a number.
    pub fn place_s(&self, time_s: f64) -> Option<f64> {
        Some(time_s - self.origin_s).filter(|t| t.is_finite())
    }

    /// What the axis shows.
    pub fn title(&self) -> &'static str {
        match self.origin_s == 0.0 {
            _ if self.is_in_ticks => "tick",
            true => "time (s)",
            false => "time since the first tick (s)",
        }
    }

    /// The unit of the axis, as a word.
    pub fn unit(&self) -> &'static str {
        if self.is_in_ticks { "ticks" } else { "s" }
    }

    /// A place on the axis, as words.
    pub fn words(&self, place_s: f64) -> String {
        match self.is_in_ticks {
            true => format!("tick {place_s:.0}"),
            false => format!("{place_s:.2} s"),
        }
    }

    /// The ticks that are marked on an estimator's lines, the same on the map
    /// and on the errors. Estimators are marked in turn, so that marks of those
    /// that agree do not hide each other.
    pub fn marks(&self, trace: &RunTrace, estimator: usize) -> Vec<usize> {
        let mut ticks: Vec<usize> = scored(trace, estimator).map(|s| s.tick).collect();
        if ticks.is_empty() {
            let given = |&tick: &usize| trace.estimate(estimator, tick).is_some();
            ticks = (0..trace.tick_count()).filter(given).collect();
        }
        let turn = (estimator as f64 + 0.5) / trace.names.len().max(1) as f64;
        let mut due_s = self.range_s[0] + turn * self.mark_every_s;
        let mut marks = Vec::new();
        for tick in ticks {
            let Some(at_s) = self.at_s(trace, tick).filter(|&at_s| at_s >= due_s) else {
                continue;
            };
            marks.push(tick);
            let periods = ((at_s - due_s) / self.mark_every_s).floor() + 1.0;
            due_s += periods * self.mark_every_s;
        }
        marks
    }
}

#[cfg(test)]
mod tests {
    use super::super::trace::tests::empty;
    use super::*;
    use rusty_geometry::SE2;

    fn standing(times_s: impl Iterator<Item = f64>) -> RunTrace {
        let mut trace = empty(&["a", "b"]);
        let here = Some(SE2::identity());
        times_s.for_each(|t| trace.push(t, here, None, [here, here].into_iter()));
        trace
    }

    #[test]
    fn time_starts_at_zero_or_with_a_recording() {
        let simulated = Timeline::of(&standing((1..=1500).map(|k| f64::from(k) * 0.02)));
        assert_eq!((simulated.origin_s, simulated.range_s), (0.0, [0.0, 30.0]));
        assert_eq!(simulated.mark_every_s, 5.0);
        let recorded = Timeline::of(&standing((0..100).map(|k| 1.2e9 + f64::from(k))));
        assert_eq!((recorded.origin_s, recorded.range_s), (1.2e9, [0.0, 99.0]));
        for odd in [vec![], vec![f64::NAN], vec![0.02], vec![7e8, f64::INFINITY]] {
            let time = Timeline::of(&standing(odd.into_iter()));
            assert!(time.span_s() > 0.0 && time.mark_every_s > 0.0, "{time:?}");
        }
    }

    #[test]
    fn marks_take_turns() {
        let trace = standing((1..=1500).map(|k| f64::from(k) * 0.02));
        let time = Timeline::of(&trace);
        // Every 5 s is every 250 ticks; due at 1.25 s and 3.75 s.
        assert_eq!(time.marks(&trace, 0), [62, 312, 562, 812, 1062, 1312]);
        assert_eq!(time.marks(&trace, 1), [187, 437, 687, 937, 1187, 1437]);
    }
}
