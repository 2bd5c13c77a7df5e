//! A log as if it happened now: play, pause, pace, seek.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use crate::hub::Hub;
use crate::recording::Recording;
use crate::scene::{PageRequest, Status};

/// Time between two looks while the log is played.
const LOOK: Duration = Duration::from_millis(8);
/// Most ticks that are shown at a look; of more the last ones.
const MOST_AT_ONCE: usize = 64;
/// Ticks back to look for a scan after a jump.
const MOST_BACK: usize = 200;
/// Simulated seconds per second that stand for "as fast as possible".
const FASTEST: f64 = 1e3;

/// The position in a log. No clock: the caller says how much time has passed.
pub struct Playback<'a> {
    recording: &'a Recording,
    /// Index of the tick that is shown, once one is.
    at: usize,
    is_shown: bool,
    /// The time of the log that has come, s.
    clock_s: f64,
    is_playing: bool,
    factor: Option<f64>,
}

impl<'a> Playback<'a> {
    /// At the first tick of a log, or at its last.
    #[must_use]
    pub fn new(recording: &'a Recording, from_end: bool) -> Self {
        let last = recording.ticks.len().saturating_sub(1);
        let at = if from_end { last } else { 0 };
        let clock_s = recording.times_s.get(at).copied().unwrap_or(0.0);
        Self { recording, at, is_shown: false, clock_s, is_playing: !from_end, factor: Some(1.0) }
    }

    /// Plays for as long as it is wanted.
    pub fn run(
        mut self,
        requests: &Receiver<PageRequest>,
        hub: &Hub,
        mut is_wanted: impl FnMut() -> bool,
    ) {
        self.jump(hub, self.at);
        let mut before = Instant::now();
        while is_wanted() {
            match requests.recv_timeout(LOOK) {
                Ok(request) => self.carry_out(request, hub),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let now = Instant::now();
            // It waits for its first page.
            if hub.counts().1 > 0 {
                self.advance(now - before, hub);
            }
            before = now;
        }
    }

    fn carry_out(&mut self, request: PageRequest, hub: &Hub) {
        let last = self.recording.ticks.len().saturating_sub(1);
        match request {
            PageRequest::Pause => self.is_playing = false,
            PageRequest::Resume => {
                if self.at == last {
                    self.jump(hub, 0);
                }
                self.is_playing = true;
            }
            PageRequest::Step { ticks } => {
                self.is_playing = false;
                let ticks = usize::try_from(ticks).unwrap_or(last);
                self.jump(hub, self.at.saturating_add(ticks).min(last));
            }
            PageRequest::Seek { tick } => {
                self.jump(hub, usize::try_from(tick).unwrap_or(last).min(last));
            }
            PageRequest::Pace { factor } => {
                self.factor = factor.filter(|factor| factor.is_finite() && *factor > 0.0);
            }
            PageRequest::Drive { .. } => return,
        }
        self.tell(hub);
    }

    /// Shows the ticks that come in this time.
    fn advance(&mut self, passed: Duration, hub: &Hub) {
        if !self.is_playing {
            return;
        }
        self.clock_s += passed.as_secs_f64() * self.factor.unwrap_or(FASTEST);
        let to = self.recording.times_s.partition_point(|time_s| *time_s <= self.clock_s);
        let from = (self.at + 1).max(to.saturating_sub(MOST_AT_ONCE));
        for at in from..to {
            self.show(hub, at);
        }
        if self.at + 1 >= self.recording.ticks.len() {
            self.is_playing = false;
            self.tell(hub);
        }
    }

    fn jump(&mut self, hub: &Hub, to: usize) {
        let ticks = &self.recording.ticks;
        // The scan that was the latest one there.
        let from = to.saturating_sub(MOST_BACK);
        if let Some(scan) = (from..to).rev().find(|&at| ticks[at].ranges_m.is_some())
            && !(self.is_shown && (scan..=to).contains(&self.at))
        {
            self.show(hub, scan);
        }
        let beliefs = self.recording.beliefs.range(..=to as u64).next_back();
        if let Some((_, found)) = beliefs {
            found.iter().for_each(|(index, record)| hub.belief(*index, record.clone(), false));
        }
        self.show(hub, to);
        self.clock_s = self.recording.times_s.get(to).copied().unwrap_or(0.0);
        self.tell(hub);
    }

    fn show(&mut self, hub: &Hub, at: usize) {
        let Some(moment) = self.recording.ticks.get(at) else { return };
        (self.at, self.is_shown) = (at, true);
        hub.feed.go_to(&self.recording.ticks[..at]);
        hub.tick(moment, false);
        for (index, record) in self.recording.beliefs.get(&(at as u64)).into_iter().flatten() {
            hub.belief(*index, record.clone(), false);
        }
    }

    fn tell(&self, hub: &Hub) {
        let state = if self.is_playing { "running" } else { "paused" };
        let status = Status::new(state, self.factor, "");
        hub.set_status(&serde_json::to_string(&status).unwrap_or_default());
    }
}
