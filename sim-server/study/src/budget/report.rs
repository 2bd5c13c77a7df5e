//! A budget: a document, and a text for people.

use std::fmt;

use rusty_contract::TextTable;
use rusty_contract::score::{degrees, mean_and_error, metres, seconds};
use serde::Serialize;

use super::{Line, Source};

/// What a budget came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the scenario.
    pub scenario: String,
    /// Which seeds.
    pub seeds: String,
    /// Ticks of each run.
    pub ticks: u64,
    /// Length of a tick, s.
    pub dt_s: f64,
    /// Distance driven by command with all sources, mean, m.
    pub driven_m: f64,
    /// Each source alone.
    pub sources: Vec<Line>,
    /// Root of the sum of their mean squares: what they would come to if they
    /// had nothing to do with each other, m.
    pub sum_of_squares_rms_m: f64,
    /// What they come to.
    pub together: Line,
    /// Sources that the scenario does not have.
    pub absent: Vec<Source>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "odometry error budget of {} · {} ticks of {} s · {} m driven by command · seeds {}\n",
            self.scenario,
            self.ticks,
            seconds(self.dt_s),
            metres(self.driven_m),
            self.seeds
        )?;
        let lines = || self.sources.iter().chain([&self.together]);
        let mut table = TextTable::new(
            "source  >mean final error  >p95  >mean |heading|  >share  varies with seed?",
        );
        for line in lines() {
            let error = with_error(&line.final_position_error_m, metres, "m");
            let heading = with_error(&line.final_heading_error_deg, degrees, "°");
            let share = line.share.map_or_else(String::new, percent);
            let varies = if line.varies_with_seed { "yes" } else { "no" };
            let p95 = format!("{} m", metres(line.p95_final_position_error_m));
            table.row(&[&line.name, &error, &p95, &heading, &share, &varies]);
        }
        writeln!(f, "{table}")?;
        let together_m = self.together.mean_square_m2.sqrt();
        write!(
            f,
            "\nroot mean square of the final error together {} m; {} m if the sources were independent.\n\
             Final error and heading are those of dead reckoning at the last tick, ± one standard \
             error;\na share is of the sum of the mean squares of all sources alone.",
            metres(together_m),
            metres(self.sum_of_squares_rms_m)
        )?;
        for Line { name, runs, blocked_runs, .. } in lines().filter(|line| line.blocked_runs > 0) {
            write!(f, "\n{name}: something blocked the robot in {blocked_runs} of {runs} runs")?;
        }
        if self.sources.iter().any(|line| line.share.is_none()) {
            write!(f, "\nThere are no shares: the wheels of a robot that is blocked turn on.")?;
        }
        for source in &self.absent {
            write!(f, "\nnot in this scenario: --set {} would add a row", source.field())?;
        }
        Ok(())
    }
}

fn with_error(of: &rusty_metrics::Moments, number: fn(f64) -> String, unit: &str) -> String {
    format!("{} {unit}", mean_and_error(of.mean, of.standard_error(), of.n, number))
}

/// Percent; 0 and 100 only where that is all there is to it.
fn percent(share: f64) -> String {
    match 100.0 * share {
        // No source has an error.
        s if s.is_nan() => "–".to_owned(),
        s if s > 0.0 && s < 0.1 => "<0.1 %".to_owned(),
        s if s > 99.9 && s < 100.0 => ">99.9 %".to_owned(),
        s => format!("{s:.1} %"),
    }
}
