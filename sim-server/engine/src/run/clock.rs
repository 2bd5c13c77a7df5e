//! When the next tick may happen: the pace, and what was said to the run.

use std::time::{Duration, Instant};

use super::Pace;

/// When the next tick may happen.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    pace: Pace,
    dt_s: f64,
    /// The tick and the moment from which the pace counts.
    origin: Option<(u64, Instant)>,
    /// Ticks that may still happen; `None` while nobody has paused the run.
    allowed: Option<u64>,
}

/// What the clock says of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum May {
    /// It may happen.
    Now,
    /// Not before so long.
    In(Duration),
    /// Not before somebody says so.
    Paused,
}

impl Clock {
    pub(super) fn new(pace: Pace, dt_s: f64, paused: bool) -> Self {
        Self { pace, dt_s, origin: None, allowed: paused.then_some(0) }
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

    /// A tick happens.
    pub(super) fn tick(&mut self) {
        self.allowed = self.allowed.map(|n| n.saturating_sub(1));
    }

    /// The pace counts anew from the next tick.
    pub(super) fn stand_still(&mut self) {
        self.origin = None;
    }

    pub(super) fn pause(&mut self) {
        self.allowed = Some(0);
    }

    /// So many ticks more than those that were allowed already. Says how many
    /// are allowed now.
    pub(super) fn step(&mut self, ticks: u64) -> u64 {
        let allowed = self.allowed.unwrap_or(0).saturating_add(ticks);
        self.allowed = Some(allowed);
        // Standing still is not made up for by running.
        self.origin = None;
        allowed
    }

    pub(super) fn resume(&mut self) {
        self.allowed = None;
        self.origin = None;
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
        let mut clock = Clock::new(Pace::Max, 0.02, true);
        assert_eq!(clock.may_at(0, now), May::Paused);
        clock.step(2);
        for tick in 0..2 {
            assert_eq!(clock.may_at(tick, now), May::Now);
            clock.tick();
        }
        assert_eq!(clock.may_at(2, now), May::Paused);
        clock.resume();
        assert_eq!(clock.may_at(2, now), May::Now);
        clock.pause();
        assert!(clock.is_paused());
    }

    #[test]
    fn a_pause_is_not_made_up_for() {
        let start = Instant::now();
        let mut clock = Clock::new(Pace::Factor(1.0), 0.5, false);
        assert_eq!(clock.may_at(0, start), May::Now);
        assert_eq!(clock.may_at(2, start), May::In(Duration::from_secs(1)));
        clock.pause();
        clock.resume();
        let later = start + Duration::from_secs(60);
        assert_eq!(clock.may_at(2, later), May::Now);
        assert_eq!(clock.may_at(3, later), May::In(Duration::from_millis(500)));
    }
}
