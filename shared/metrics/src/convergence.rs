//! When an estimator has found the robot, and found it again after a kidnapping, as the
//! ticks go by. docs/metrics.md defines a hold and what ends it.

use rusty_contract::score::{Convergence, Recovery, Within};

use super::scored::Scored;

/// Times are compared to this part of themselves: 51 · 0.02 − 0.02 is 1, and
/// stamps that carry the time of day are rounded to 10⁻⁷ s.
const ROUNDING: f64 = 1e-6;

/// The search of one estimator for the robot.
#[derive(Clone, Debug)]
pub struct Search {
    within: Within,
    /// When the run began, s; not known before the first tick where that is what
    /// it began with.
    began_s: Option<f64>,
    /// Ticks at whose start the robot is carried away, in order.
    kidnapped_at: Vec<u64>,
    /// One for each of them that has come.
    recoveries: Vec<Recovery>,
    /// When the last of them began, and when the last tick ended, s.
    kidnapped_s: f64,
    last_s: f64,
    after_s: Option<f64>,
    converged: bool,
    /// The row under way, while there is none that was long enough.
    row: Option<HeldFor>,
    scored: bool,
    since: Squares,
}

#[derive(Clone, Debug)]
struct HeldFor {
    from_s: f64,
    to_s: f64,
    squares: Squares,
}

#[derive(Clone, Copy, Debug, Default)]
struct Squares {
    count: u64,
    position_m2: f64,
    heading_rad2: f64,
}

impl Squares {
    fn add(&mut self, other: Self) {
        self.count += other.count;
        self.position_m2 += other.position_m2;
        self.heading_rad2 += other.heading_rad2;
    }
}

impl Search {
    /// Before the first tick of a run that began at `began_s`; `None`: with its
    /// first tick.
    #[must_use]
    pub fn new(within: Within, kidnapped_at: &[u64], began_s: Option<f64>) -> Self {
        let mut kidnapped_at = kidnapped_at.to_vec();
        kidnapped_at.sort_unstable();
        Self {
            within,
            recoveries: Vec::with_capacity(kidnapped_at.len()),
            kidnapped_at,
            began_s,
            kidnapped_s: 0.0,
            last_s: began_s.unwrap_or_default(),
            after_s: None,
            converged: false,
            row: None,
            scored: false,
            since: Squares::default(),
        }
    }

    /// A tick begins; it ends at `time_s`. To be called for each.
    pub fn begin(&mut self, tick: u64, time_s: f64) {
        if self.began_s.is_none() {
            (self.began_s, self.last_s) = (Some(time_s), time_s);
        }
        while let Some(&at) = self.kidnapped_at.get(self.recoveries.len()).filter(|at| **at <= tick)
        {
            self.recoveries.push(Recovery { kidnapped_at_tick: at, after_s: None });
            self.kidnapped_s = self.last_s;
            self.converged = false;
            self.row = None;
        }
        self.last_s = time_s;
    }

    /// The tick is scored.
    pub fn push(&mut self, scored: &Scored) {
        self.scored = true;
        let (position_m, heading_rad) = (scored.position_error_m(), scored.heading_error_rad());
        let squares = Squares {
            count: 1,
            position_m2: position_m * position_m,
            heading_rad2: heading_rad * heading_rad,
        };
        if self.converged {
            self.since.add(squares);
            return;
        }
        if !(position_m <= self.within.position_m && heading_rad.abs() <= self.within.heading_rad) {
            self.row = None;
            return;
        }
        let first = HeldFor { from_s: self.last_s, to_s: self.last_s, squares: Squares::default() };
        let row = self.row.get_or_insert(first);
        row.to_s = self.last_s;
        row.squares.add(squares);
        if row.to_s - row.from_s >= self.within.hold_s * (1.0 - ROUNDING) {
            self.found();
        }
    }

    /// The tick has a truth and no estimate.
    pub fn silent(&mut self) {
        let most_s = self.within.hold_s * (1.0 + ROUNDING);
        self.row.take_if(|row| self.last_s - row.to_s > most_s);
    }

    /// The row is a hold.
    fn found(&mut self) {
        let Some(row) = self.row.take() else { return };
        self.converged = true;
        self.after_s.get_or_insert(row.from_s - self.began_s.unwrap_or_default());
        if let Some(recovery) = self.recoveries.last_mut() {
            recovery.after_s = Some(row.from_s - self.kidnapped_s);
        }
        self.since.add(row.squares);
    }

    /// Whether the robot was carried away.
    #[must_use]
    pub fn is_kidnapped(&self) -> bool {
        !self.recoveries.is_empty()
    }

    /// The result; `None` without a scored tick.
    #[must_use]
    pub fn convergence(&self) -> Option<Convergence> {
        let Squares { count, position_m2, heading_rad2 } = self.since;
        let rmse = |sum: f64| (count > 0).then(|| (sum / count as f64).sqrt());
        self.scored.then(|| Convergence {
            within: self.within,
            after_s: self.after_s,
            position_rmse_m: rmse(position_m2),
            heading_rmse_rad: rmse(heading_rad2),
            recoveries: self.recoveries.clone(),
        })
    }
}

#[cfg(test)]
#[path = "convergence_tests.rs"]
mod tests;
