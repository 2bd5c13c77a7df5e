//! When the next tick may happen: pace, pauses and steps.

use std::time::{Duration, Instant};

/// How fast simulated time goes. It never changes a bit of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pace {
    /// As fast as everyone answers.
    #[default]
    Max,
    /// Simulated seconds per second; 1 is real time.
    Factor(f64),
}

impl Pace {
    /// When tick `tick` is due after the first frame; `None`: at once.
    #[must_use]
    pub fn due(self, tick: u64, dt_s: f64) -> Option<Duration> {
        match self {
            Self::Max => None,
            Self::Factor(factor) => {
                let due = Duration::try_from_secs_f64(tick as f64 * dt_s / factor);
                // Later than the clock can say is never, not at once.
                Some(due.unwrap_or(Duration::MAX))
            }
        }
    }
}

impl std::str::FromStr for Pace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "max" => Ok(Self::Max),
            "real" => Ok(Self::Factor(1.0)),
            _ => match text.parse::<f64>() {
                Ok(f) if f.is_finite() && f > 0.0 => Ok(Self::Factor(f)),
                _ => Err(format!("{text:?} is no pace; use max, real, or a factor such as 2.5")),
            },
        }
    }
}

/// The pace, the pauses, and the first frame of a run.
#[derive(Clone, Debug)]
pub(super) struct Pacer {
    pace: Pace,
    dt_s: f64,
    /// The tick and the moment from which the pace counts.
    origin: Option<(u64, Instant)>,
    /// Ticks that may still happen; `None` while the run is not paused.
    allowed: Option<u64>,
    /// Ticks whose frame was published.
    pub(super) begun: u64,
    /// The first tick was allowed.
    pub(super) began: Option<Instant>,
    /// The monotonic clock when the first frame was published, ns.
    pub(super) first_frame_ns: Option<u64>,
}

/// When a tick may happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum May {
    /// It may happen.
    Now,
    /// After this time.
    In(Duration),
    /// After a request to step or resume.
    Paused,
}

impl Pacer {
    pub(super) fn new(pace: Pace, dt_s: f64, paused: bool) -> Self {
        let allowed = paused.then_some(0);
        Self { pace, dt_s, origin: None, allowed, begun: 0, began: None, first_frame_ns: None }
    }

    /// Whether `tick` may happen now. The clock is looked at only where there
    /// is a pace to keep.
    pub(super) fn may(&mut self, tick: u64) -> May {
        match (self.allowed, self.pace) {
            (Some(0), _) => May::Paused,
            (_, Pace::Max) => May::Now,
            _ => self.may_at(tick, Instant::now()),
        }
    }

    /// Whether `tick` may happen at `now`.
    fn may_at(&mut self, tick: u64, now: Instant) -> May {
        if self.allowed == Some(0) {
            return May::Paused;
        }
        let (from, since) = *self.origin.get_or_insert((tick, now));
        let Some(due) = self.pace.due(tick.saturating_sub(from), self.dt_s) else {
            return May::Now;
        };
        match due.checked_sub(now.saturating_duration_since(since)) {
            Some(early) if !early.is_zero() => May::In(early),
            _ => May::Now,
        }
    }

    /// The frame of `tick` was published at `now_ns`.
    pub(super) fn published(&mut self, tick: u64, now_ns: u64) {
        self.first_frame_ns.get_or_insert(now_ns);
        self.begun = tick + 1;
        self.allowed = self.allowed.map(|n| n.saturating_sub(1));
    }

    /// Restarts the pace at the next tick.
    pub(super) fn stand_still(&mut self) {
        self.origin = None;
    }

    pub(super) fn pause(&mut self) {
        self.allowed = Some(0);
    }

    /// Allows `ticks` more. Returns the number of ticks by which they have
    /// happened.
    pub(super) fn step(&mut self, ticks: u64) -> u64 {
        let allowed = self.allowed.unwrap_or(0).saturating_add(ticks);
        self.allowed = Some(allowed);
        // Standing still is not made up for by running.
        self.origin = None;
        // The tick that is being worked on does not count.
        self.begun.saturating_add(allowed)
    }

    pub(super) fn resume(&mut self) {
        self.allowed = None;
        self.origin = None;
    }

    /// Keeps another pace from the next tick on.
    pub(super) fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
        self.origin = None;
    }

    /// Simulated seconds per second; `None` at full speed.
    pub(super) fn factor(&self) -> Option<f64> {
        match self.pace {
            Pace::Max => None,
            Pace::Factor(factor) => Some(factor),
        }
    }

    /// Whether ticks wait for a clock.
    pub(super) fn has_pace(&self) -> bool {
        self.pace != Pace::Max
    }

    pub(super) fn is_paused(&self) -> bool {
        self.allowed == Some(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_hold_and_steps_are_counted() {
        let now = Instant::now();
        let mut pacer = Pacer::new(Pace::Max, 0.02, true);
        assert_eq!(pacer.may_at(0, now), May::Paused);
        pacer.step(2);
        for tick in 0..2 {
            assert_eq!(pacer.may_at(tick, now), May::Now);
            pacer.published(tick, 0);
        }
        assert_eq!(pacer.may_at(2, now), May::Paused);
        pacer.resume();
        assert_eq!(pacer.may_at(2, now), May::Now);
        pacer.pause();
        assert!(pacer.is_paused());
    }

    #[test]
    fn a_pause_is_not_made_up_for() {
        let start = Instant::now();
        let mut pacer = Pacer::new(Pace::Factor(1.0), 0.5, false);
        assert_eq!(pacer.may_at(0, start), May::Now);
        assert_eq!(pacer.may_at(2, start), May::In(Duration::from_secs(1)));
        pacer.pause();
        pacer.resume();
        let later = start + Duration::from_secs(60);
        assert_eq!(pacer.may_at(2, later), May::Now);
        assert_eq!(pacer.may_at(3, later), May::In(Duration::from_millis(500)));
    }

    #[test]
    fn another_pace_counts_from_the_next_tick() {
        let start = Instant::now();
        let mut pacer = Pacer::new(Pace::Factor(1.0), 0.5, false);
        assert_eq!(pacer.may_at(0, start), May::Now);
        pacer.set_pace(Pace::Factor(2.0));
        let later = start + Duration::from_secs(60);
        assert_eq!(pacer.may_at(1, later), May::Now);
        assert_eq!(pacer.may_at(2, later), May::In(Duration::from_millis(250)));
        pacer.set_pace(Pace::Max);
        assert_eq!(pacer.may_at(2, later), May::Now);
        pacer.pause();
        pacer.set_pace(Pace::Factor(9.0));
        assert!(pacer.is_paused());
    }

    #[test]
    fn a_pace_is_a_word_or_a_factor() {
        assert_eq!("max".parse(), Ok(Pace::Max));
        assert_eq!("real".parse(), Ok(Pace::Factor(1.0)));
        assert_eq!("0.5".parse(), Ok(Pace::Factor(0.5)));
        for bad in ["0", "-1", "nan", "inf", "fast"] {
            assert!(bad.parse::<Pace>().is_err(), "{bad}");
        }
        assert_eq!(Pace::Factor(2.0).due(100, 0.02), Some(Duration::from_secs(1)));
    }
}
