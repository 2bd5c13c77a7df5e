//! The ticks of a trace that are scored, and their scores.

use rusty_contract::score::Score;
pub(super) use rusty_metrics::Scored;
use rusty_metrics::{Given, Meter, Moment, Planned, Yardstick};

use super::trace::RunTrace;

/// The scored ticks of an estimator (index of its name), in order.
pub(super) fn scored(trace: &RunTrace, estimator: usize) -> impl Iterator<Item = Scored> {
    (0..trace.tick_count()).filter_map(move |tick| {
        let truth = trace.true_pose(tick)?;
        let estimate = trace.estimate(estimator, tick)?;
        Some(Scored { tick, truth, estimate })
    })
}

/// One score per estimator of a trace, in roster order. A trace has no innovations,
/// compute times and covariances, so the figures of those are `None`.
#[must_use]
pub fn score(trace: &RunTrace) -> Vec<Score> {
    let planned = Planned {
        ticks: trace.tick_count() as u64,
        start: trace.start,
        kidnapped_at: trace.kidnapped_at.clone(),
        // What has no seed has separate stamps.
        began_s: trace.seed.map(|_| 0.0),
    };
    let mut meter = Meter::new(&trace.names, &planned, Yardstick::default());
    for tick in 0..trace.tick_count() {
        let given =
            |i| Given { estimate: trace.estimate(i, tick).map(Into::into), ..Given::default() };
        let moment =
            Moment { tick: tick as u64, time_s: trace.time_s[tick], truth: trace.true_pose(tick) };
        meter.push(&moment, (0..trace.names.len()).map(given));
    }
    scores(&mut meter, trace)
}

/// One score per estimator; `trace` has the ticks that are left for the alignment.
#[must_use]
pub fn scores(meter: &mut Meter, trace: &RunTrace) -> Vec<Score> {
    meter.scores(&trace.told, |estimator| scored(trace, estimator).collect())
}

#[cfg(test)]
#[path = "metrics_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "evo_tests.rs"]
mod evo_tests;
