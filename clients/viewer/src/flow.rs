//! The part of a run that its pages get.
//!
//! Pages get every tick of a run that they can show: one at a pace. At full speed the
//! processes of the run use all cores, and on a machine with few cores every picture takes
//! the time of ticks. There, pages get a few whole ticks per second, and between them
//! ticks without scans for paths and charts.

use std::time::{Duration, Instant};

/// Most ticks that pages get in a second, and at once: a page that draws more takes the
/// time of the run.
const MOST_PER_S: f64 = 2000.0;
const MOST_AT_ONCE: f64 = 64.0;
/// Ticks per second up to which pages get all of them, also where cores are scarce.
const ALL_PER_S: f64 = 500.0;
/// Where cores are scarce, time between two whole ticks, and traces between them.
const WHOLE_EVERY: Duration = Duration::from_millis(250);
const TRACES_PER_S: f64 = 400.0;
/// Time over which the ticks per second are measured.
const WINDOW: Duration = Duration::from_millis(200);
/// Processes next to those of the run: server, viewer, and two of a browser.
const OTHERS: usize = 4;

/// The part of a tick that pages get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// All of it.
    Whole,
    /// Poses and errors, with the next whole tick.
    Trace,
    /// Nothing.
    Nothing,
}

/// Decides which part of a tick pages get.
pub struct Flow {
    ticks: Allowance,
    traces: Allowance,
    /// The last whole tick.
    whole_at: Option<Instant>,
    /// The tick at which the window began, and when.
    window: Option<(u64, Instant)>,
    per_s: f64,
    are_cores_scarce: bool,
}

impl Flow {
    /// Of a run with this number of participants, on a machine with this number of cores.
    #[must_use]
    pub fn new(participants: usize, cores: usize, now: Instant) -> Self {
        Self {
            ticks: Allowance { per_s: MOST_PER_S, left: MOST_AT_ONCE, at: now },
            traces: Allowance { per_s: TRACES_PER_S, left: 1.0, at: now },
            whole_at: None,
            window: None,
            per_s: 0.0,
            are_cores_scarce: cores < participants + OTHERS,
        }
    }

    /// Returns the part of `tick` that pages get now.
    pub fn share(&mut self, tick: u64, is_at_full_speed: bool, now: Instant) -> Share {
        self.count(tick, now);
        if !self.is_reduced(is_at_full_speed) {
            return if self.ticks.take(now) { Share::Whole } else { Share::Nothing };
        }
        if self.whole_at.is_none_or(|at| now - at >= WHOLE_EVERY) {
            self.whole_at = Some(now);
            return Share::Whole;
        }
        if self.traces.take(now) { Share::Trace } else { Share::Nothing }
    }

    /// Whether pages get a few ticks only.
    #[must_use]
    pub fn is_reduced(&self, is_at_full_speed: bool) -> bool {
        let most_per_s = if is_at_full_speed { ALL_PER_S } else { MOST_PER_S };
        self.are_cores_scarce && self.per_s > most_per_s
    }

    fn count(&mut self, tick: u64, now: Instant) {
        let (from, since) = *self.window.get_or_insert((tick, now));
        let passed = now - since;
        if passed >= WINDOW {
            self.per_s = tick.saturating_sub(from) as f64 / passed.as_secs_f64();
            self.window = Some((tick, now));
        }
    }
}

/// How many may be taken now.
struct Allowance {
    per_s: f64,
    left: f64,
    at: Instant,
}

impl Allowance {
    fn take(&mut self, now: Instant) -> bool {
        let more = self.per_s * (now - self.at).as_secs_f64();
        (self.left, self.at) = ((self.left + more).min(MOST_AT_ONCE), now);
        let is_there = self.left >= 1.0;
        self.left -= f64::from(u8::from(is_there));
        is_there
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shares of a run of `seconds` at this rate.
    fn shares(flow: &mut Flow, per_s: u64, seconds: u64, is_at_full_speed: bool) -> [usize; 3] {
        let start = Instant::now();
        let mut counts = [0; 3];
        for tick in 0..per_s * seconds {
            let now = start + Duration::from_micros(tick * 1_000_000 / per_s);
            counts[flow.share(tick, is_at_full_speed, now) as usize] += 1;
        }
        counts
    }

    fn flow(cores: usize) -> Flow {
        Flow::new(5, cores, Instant::now())
    }

    #[test]
    fn at_a_pace_pages_get_two_thousand_ticks_a_second_and_some_at_once() {
        let start = Instant::now();
        let mut allowance = Allowance { per_s: MOST_PER_S, left: MOST_AT_ONCE, at: start };
        let taken = |allowance: &mut Allowance, at_ms: u64, wanted: usize| {
            let now = start + Duration::from_millis(at_ms);
            (0..wanted).filter(|_| allowance.take(now)).count()
        };
        assert_eq!(taken(&mut allowance, 0, 100), 64);
        assert_eq!(taken(&mut allowance, 10, 100), 20);
        assert_eq!(taken(&mut allowance, 1010, 100), 64);
        for per_s in [50, 500, 1000, 1900] {
            let all = usize::try_from(per_s * 3).unwrap();
            assert_eq!(shares(&mut flow(2), per_s, 3, false), [all, 0, 0], "{per_s}");
        }
    }

    #[test]
    fn at_full_speed_on_few_cores_pages_get_four_whole_ticks_a_second_and_traces() {
        // A slow filter leaves time.
        assert_eq!(shares(&mut flow(2), 400, 3, true), [1200, 0, 0]);
        for (per_s, is_at_full_speed) in [(900, true), (8000, true), (8000, false)] {
            let [whole, traces, nothing] = shares(&mut flow(2), per_s, 10, is_at_full_speed);
            // Before the rate is known, pages get all that they may.
            let first = usize::try_from(per_s / 4).unwrap();
            assert!((38..=42 + first).contains(&whole), "{per_s}: {whole}");
            assert!((3000..=4000).contains(&traces), "{per_s}: {traces}");
            assert_eq!(whole + traces + nothing, usize::try_from(per_s * 10).unwrap());
        }
    }

    #[test]
    fn with_cores_to_spare_full_speed_is_not_reduced() {
        let [whole, traces, _] = shares(&mut flow(16), 8000, 10, true);
        assert_eq!(((19_900..=20_200).contains(&whole), traces), (true, 0), "{whole}");
    }
}
