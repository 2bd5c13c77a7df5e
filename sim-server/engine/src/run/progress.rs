//! Telling a person how far a run is, on stderr.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use rusty_contract::errln;

/// Ticks between two looks at the clock.
const TICKS_BETWEEN_LOOKS: u64 = 64;
/// Between two lines where there is no terminal to draw a bar on.
const BETWEEN_LINES: Duration = Duration::from_secs(2);

/// A bar on a terminal, a line now and then elsewhere, nothing when quiet.
pub struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    ticks: u64,
    /// From when on the rate counts: time spent waiting is not part of it.
    began: Instant,
    /// Ticks that were done by then.
    before: u64,
    /// Nothing is under way: participants join, or the run is paused.
    waits: bool,
    last_line: Instant,
    /// The robot that it is about, where there are several.
    about: String,
    /// The last line is out.
    told_all: bool,
    ended: Option<Instant>,
}

impl Progress {
    /// Progress towards `ticks`.
    #[must_use]
    pub fn new(ticks: u64, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(ticks), ProgressDrawTarget::stderr());
            let template = "{bar:32} {pos}/{len} ticks  {per_sec}  {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            bar
        });
        let now = Instant::now();
        Self {
            bar,
            quiet,
            ticks,
            began: now,
            before: 0,
            waits: true,
            last_line: now,
            about: String::new(),
            told_all: false,
            ended: None,
        }
    }

    /// Every text names this robot.
    #[must_use]
    pub(super) fn about(self, robot: Option<&str>) -> Self {
        let about = robot.map(|robot| format!("{robot}: ")).unwrap_or_default();
        Self { about, ..self }
    }

    /// Nothing happens until [`goes_on_at`](Self::goes_on_at).
    pub fn waits(&mut self) {
        self.waits = true;
    }

    /// Ends waiting, if there was any, with `done` ticks done: rate and time left
    /// are about the ticks from here on.
    pub fn goes_on_at(&mut self, done: u64) {
        if std::mem::take(&mut self.waits) {
            self.count_from(done, Instant::now());
        }
    }

    fn count_from(&mut self, done: u64, now: Instant) {
        (self.before, self.began) = (done, now);
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            bar.reset_eta();
        }
    }

    /// N ticks are done.
    pub fn tick(&mut self, done: u64) {
        if !done.is_multiple_of(TICKS_BETWEEN_LOOKS) && done != self.ticks {
            return;
        }
        self.at(done);
    }

    /// The same from a caller that looks at the clock now and then.
    pub fn at(&mut self, all: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(all);
            return;
        }
        if self.quiet || self.told_all {
            return;
        }
        if all == self.ticks || self.last_line.elapsed() >= BETWEEN_LINES {
            self.last_line = Instant::now();
            self.told_all = all == self.ticks;
            let percent = 100.0 * all as f64 / self.ticks as f64;
            let left = self.left(all, Instant::now());
            errln!("  {all}/{} ticks ({percent:.0} %){left}", self.ticks);
        }
    }

    /// The rate and the time left, in words, where there is some.
    fn left(&self, all: u64, now: Instant) -> String {
        let elapsed_s = now.saturating_duration_since(self.began).as_secs_f64();
        let (done, left) = (all.saturating_sub(self.before), self.ticks.saturating_sub(all));
        if done == 0 || left == 0 || elapsed_s == 0.0 {
            return String::new();
        }
        let per_s = done as f64 / elapsed_s;
        format!("  {per_s:.0}/s  {:.0} s left", left as f64 / per_s)
    }

    /// Says something without breaking the bar. Said even when quiet: it is
    /// about a participant in trouble.
    pub fn say(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| errln!("{}{text}", self.about)),
            None => errln!("{}{text}", self.about),
        }
    }

    /// The last tick is over.
    pub fn done(&mut self) {
        self.ended.get_or_insert_with(Instant::now);
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    /// Seconds between `began` and [`done`](Self::done).
    #[must_use]
    pub fn elapsed_s(&self, began: Option<Instant>) -> f64 {
        match (began, self.ended) {
            (Some(began), Some(ended)) => (ended - began).as_secs_f64(),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_leaves_out_the_time_before_the_first_tick_and_in_pauses() {
        let start = Instant::now();
        let at = |seconds| start + Duration::from_secs(seconds);
        let mut progress = Progress::new(1000, true);
        // Sixty seconds until everyone had joined.
        progress.count_from(0, at(60));
        assert_eq!(progress.left(200, at(70)), "  20/s  40 s left");
        // An hour of a pause.
        progress.count_from(200, at(3600));
        assert_eq!(progress.left(200, at(3600)), "");
        assert_eq!(progress.left(300, at(3610)), "  10/s  70 s left");
    }

    #[test]
    fn waiting_ends_once() {
        let mut progress = Progress::new(1000, true);
        progress.goes_on_at(5);
        progress.goes_on_at(6);
        assert_eq!(progress.before, 5);
        progress.waits();
        progress.goes_on_at(7);
        assert_eq!(progress.before, 7);
    }
}
