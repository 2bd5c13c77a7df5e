//! Modelled compute time: when an answer takes effect.
//!
//! A run waits for every answer, however long a computer takes for it, so the
//! time that a filter would need on a robot must be *said*. A scenario may give
//! a participant a compute time in simulated seconds; its answer to tick t then
//! takes effect k = ⌈time / dt⌉ ticks later, always, whatever the computer does.
//! That is the logical execution time of Henzinger, Horowitz & Kirsch (Giotto,
//! Proc. IEEE 91(1), 2003): outputs appear when they are due, not when they are
//! ready, so they can be repeated. An answer that is modelled to take longer
//! than its budget is an *overrun*, and part of the run like everything else.
//!
//! * A driver's command in effect after tick t is that of tick t + 1.
//! * The estimate in effect at tick t is what a scorer compares with the truth
//!   of tick t: a late estimate is judged as late as it is.
//! * Answers take effect in order: one that is late delays those behind it.
//!   Work on one tick overlaps with work on the next (a pipeline).
//!
//! The reply that is logged, and in the digest, is the one that was given; what
//! is in effect when follows from it and the roster.

use std::collections::VecDeque;

use rusty_geometry::Twist;
use serde::Serialize;

use crate::log::LogHeader;
use crate::reply::Reply;
use crate::scenario::Role;
use crate::timing::ComputeTime;

/// Times are compared with ticks to this part of a tick: 3 × 0.02 s is 0.06 s.
const ROUNDING: f64 = 1e-9;

/// The effects of a participant's compute times, for reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Timing {
    /// Name in the roster.
    pub name: String,
    /// What it may take, s.
    pub budget_s: Option<f64>,
    /// Answers that took longer.
    pub overruns: u64,
    /// The greatest number of ticks between an answer and its effect.
    pub latest_ticks: u64,
}

/// The answers of a run on their way to taking effect: one pipeline per
/// answering participant, in roster order.
#[derive(Clone, Debug)]
pub struct Effects {
    dt_s: f64,
    pipelines: Vec<Pipeline>,
    driver: Option<usize>,
}

#[derive(Clone, Debug)]
struct Pipeline {
    compute: ComputeTime,
    /// Answers that have no effect yet, with the tick at which they will.
    waiting: VecDeque<(u64, Reply)>,
    in_effect: Reply,
    timing: Timing,
}

impl Effects {
    /// Before the first tick of a run with this header.
    #[must_use]
    pub fn of(header: &LogHeader) -> Self {
        let pipeline = |p: &crate::Participant| Pipeline {
            compute: p.compute,
            waiting: VecDeque::new(),
            in_effect: Reply::Missing,
            timing: Timing {
                name: p.name.clone(),
                budget_s: p.compute.budget_s,
                ..Timing::default()
            },
        };
        Self {
            dt_s: header.config.dt_s,
            pipelines: header.answering().map(pipeline).collect(),
            driver: header.answering().position(|p| p.role == Role::Driver),
        }
    }

    /// Tick `tick` is complete with these replies, in roster order.
    pub fn close(&mut self, tick: u64, has_scan: bool, replies: impl Iterator<Item = Reply>) {
        for (pipeline, reply) in self.pipelines.iter_mut().zip(replies) {
            pipeline.close(tick, has_scan, reply, self.dt_s);
        }
    }

    /// The replies in effect after the tick that was closed last.
    pub fn replies(&self) -> impl ExactSizeIterator<Item = Reply> {
        self.pipelines.iter().map(|p| p.in_effect)
    }

    /// The driver's command in effect, for the next tick.
    #[must_use]
    pub fn command(&self) -> Option<Twist> {
        self.pipelines.get(self.driver?)?.in_effect.command()
    }

    /// The effects on those whose compute time is modelled.
    #[must_use]
    pub fn timings(&self) -> Vec<Timing> {
        let modelled = self.pipelines.iter().filter(|p| !p.compute.is_none());
        modelled.map(|p| p.timing.clone()).collect()
    }
}

impl Pipeline {
    fn close(&mut self, tick: u64, has_scan: bool, reply: Reply, dt_s: f64) {
        if self.compute.is_none() {
            self.in_effect = reply;
            return;
        }
        let time_s = self.compute.of_answer_s(has_scan);
        let late = self.compute.budget_s.is_some_and(|b| time_s > b * (1.0 + ROUNDING));
        self.timing.overruns += u64::from(late);
        let ticks = (time_s / dt_s - ROUNDING).ceil().max(0.0) as u64;
        let behind = self.waiting.back().map_or(0, |(due, _)| *due);
        let due = tick.saturating_add(ticks).max(behind);
        self.timing.latest_ticks = self.timing.latest_ticks.max(due - tick);
        self.waiting.push_back((due, reply));
        while let Some((_, reply)) = self.waiting.pop_front_if(|(due, _)| *due <= tick) {
            self.in_effect = reply;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::SE2;

    fn pipeline(answer_s: f64, scan_s: f64, budget_s: Option<f64>) -> Pipeline {
        Pipeline {
            compute: ComputeTime { answer_s, scan_s, budget_s },
            waiting: VecDeque::new(),
            in_effect: Reply::Missing,
            timing: Timing::default(),
        }
    }

    /// The tick whose answer is in effect at each of ten ticks, a scan at every
    /// fourth.
    fn in_effect(mut p: Pipeline) -> (Vec<Option<u64>>, Timing) {
        let seen = (0..10).map(|tick| {
            let reply = Reply::from(SE2::new(tick as f64, 0.0, 0.0));
            p.close(tick, tick % 4 == 0, reply, 0.02);
            p.in_effect.estimate().map(|e| e.pose_in_world.x() as u64)
        });
        (seen.collect(), p.timing)
    }

    #[test]
    fn an_answer_takes_effect_when_its_time_is_over() {
        let all = |delay: u64| (0..10u64).map(move |t| t.checked_sub(delay)).collect::<Vec<_>>();
        assert_eq!(in_effect(pipeline(0.0, 0.0, None)).0, all(0));
        assert_eq!(in_effect(pipeline(0.001, 0.0, None)).0, all(1));
        // Three ticks to the bit, though 0.06 / 0.02 is not 3 in floating point.
        assert_eq!(in_effect(pipeline(0.06, 0.0, None)).0, all(3));
        assert_eq!(in_effect(pipeline(0.061, 0.0, None)).0, all(4));
    }

    #[test]
    fn a_late_answer_is_counted_and_delays_those_behind_it() {
        let (seen, timing) = in_effect(pipeline(0.0, 0.04, Some(0.03)));
        // Ticks 0, 4 and 8 have scans: their answers, and the next, wait.
        let expected = [None, None, Some(2), Some(3), Some(3), Some(3), Some(6), Some(7)];
        assert_eq!(seen[..8], expected);
        assert_eq!((timing.overruns, timing.latest_ticks), (3, 2));
    }

    #[test]
    fn what_is_no_time_is_refused_by_name() {
        let bad = ComputeTime { scan_s: f64::NAN, ..ComputeTime::default() };
        let error = bad.check("participant[1].compute").unwrap_err().to_string();
        assert!(error.contains("participant[1].compute.scan_s = NaN"), "{error}");
        let bad = ComputeTime { budget_s: Some(-1.0), ..ComputeTime::default() };
        assert!(bad.check("x").is_err());
    }
}
