//! What of two estimators is compared. Less is better in all of it.

use clap::ValueEnum;
use rusty_geometry::trig;
use serde::{Deserialize, Serialize};

use crate::sweep::Row;
use rusty_contract::score::{degrees, metres};

/// A figure of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    /// Absolute trajectory error: rmse of the position
    Ate,
    /// Position error at the last tick
    Final,
    /// Rmse of the heading error
    Heading,
    /// 95th percentile of the position error
    P95,
    /// Absolute trajectory error after alignment in SE(2)
    AteSe2,
    /// Relative pose error from tick to tick: rmse of the translation
    RpeTick,
    /// Relative pose error per metre driven: rmse of the translation
    RpeMetre,
    /// How far the mean NEES is from 3, either way: |ln(mean / 3)|
    Nees,
    /// Time until the estimate had found the robot
    Converged,
    /// Rmse of the position once the estimate had found the robot
    Found,
    /// Time from the first kidnapping until it had found the robot again
    Recovered,
    /// Time until the robot had been at all goals of the scorer
    Goals,
    /// Distance driven until then
    GoalsDriven,
    /// Ticks in which something blocked the robot
    Blocked,
    /// Compute time, 99th percentile, as reported
    Compute,
}

/// Degrees of freedom of a pose.
const POSE: f64 = 3.0;

impl Metric {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Ate,
        Self::Final,
        Self::Heading,
        Self::P95,
        Self::AteSe2,
        Self::RpeTick,
        Self::RpeMetre,
        Self::Nees,
        Self::Converged,
        Self::Found,
        Self::Recovered,
        Self::Goals,
        Self::GoalsDriven,
        Self::Blocked,
        Self::Compute,
    ];

    /// Those that are compared unless others are asked for.
    pub const USUAL: [Self; 6] =
        [Self::Ate, Self::Final, Self::Heading, Self::P95, Self::RpeMetre, Self::Nees];

    /// Whether it is about the errors of the ticks that were answered: one that answers
    /// where it is easy has less of it.
    #[must_use]
    pub fn is_of_answers(self) -> bool {
        match self {
            Self::Ate | Self::Final | Self::Heading | Self::P95 | Self::AteSe2 => true,
            Self::RpeTick | Self::RpeMetre | Self::Nees => true,
            Self::Converged | Self::Found | Self::Recovered => false,
            Self::Goals | Self::GoalsDriven | Self::Blocked | Self::Compute => false,
        }
    }

    /// The column of a sweep's table that it is taken from.
    #[must_use]
    pub fn column(self) -> &'static str {
        match self {
            Self::Ate => "ate_rmse_m",
            Self::Final => "final_position_error_m",
            Self::Heading => "rmse_heading_error_rad",
            Self::P95 => "p95_position_error_m",
            Self::AteSe2 => "ate_se2_rmse_m",
            Self::RpeTick => "rpe_per_tick_rmse_m",
            Self::RpeMetre => "rpe_per_metre_rmse_m",
            Self::Nees => "nees_mean",
            Self::Converged => "converged_after_s",
            Self::Found => "converged_position_rmse_m",
            Self::Recovered => "recovered_after_s",
            Self::Goals => "goals_after_s",
            Self::GoalsDriven => "goals_driven_m",
            Self::Blocked => "blocked_ticks",
            Self::Compute => "compute_reported_p99_s",
        }
    }

    /// The figure of a run; NaN where it has none.
    #[must_use]
    pub fn of_row(self, row: &Row) -> f64 {
        let Some(c) = &row.clients else { return f64::NAN };
        self.of(match self {
            Self::Ate => row.ate_rmse_m,
            Self::Final => row.final_position_error_m,
            Self::Heading => row.rmse_heading_error_rad,
            Self::P95 => row.p95_position_error_m,
            Self::AteSe2 => c.ate_se2_rmse_m,
            Self::RpeTick => c.rpe_per_tick_rmse_m,
            Self::RpeMetre => c.rpe_per_metre_rmse_m,
            Self::Nees => c.nees_mean,
            Self::Converged => c.converged_after_s,
            Self::Found => c.found.position_rmse_m,
            Self::Recovered => c.recovered_after_s,
            Self::Goals => c.goals_after_s,
            Self::GoalsDriven => c.goals_driven_m,
            Self::Blocked => row.blocked_ticks.map_or(f64::NAN, |ticks| ticks as f64),
            Self::Compute => c.compute_reported_p99_s,
        })
    }

    /// The figure, from that column.
    #[must_use]
    pub fn of(self, value: f64) -> f64 {
        match self {
            // Twice too large is as far off as twice too small.
            Self::Nees => trig::ln(value / POSE).abs(),
            _ => value,
        }
    }

    /// Whether a run without the figure is worse than any with it: what is measured
    /// did not happen.
    #[must_use]
    pub fn may_never_end(self) -> bool {
        let goals = matches!(self, Self::Goals | Self::GoalsDriven);
        goals || matches!(self, Self::Converged | Self::Found | Self::Recovered)
    }

    /// What it is called in a sentence.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Ate => "ATE rmse",
            Self::Final => "final position error",
            Self::Heading => "heading rmse",
            Self::P95 => "95th percentile of the position error",
            Self::AteSe2 => "ATE rmse, SE(2)",
            Self::RpeTick => "RPE rmse per tick",
            Self::RpeMetre => "RPE rmse per metre",
            Self::Nees => "|ln(mean NEES / 3)|",
            Self::Converged => "convergence time",
            Self::Found => "position rmse once found",
            Self::Recovered => "recovery time",
            Self::Goals => "time to the last goal",
            Self::GoalsDriven => "distance to the last goal",
            Self::Blocked => "blocked ticks",
            Self::Compute => "compute time p99",
        }
    }

    /// The unit of the figure; that of its words is [`shown`](Self::shown).
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Heading => "rad",
            Self::Nees | Self::Blocked => "",
            Self::Converged | Self::Recovered | Self::Goals | Self::Compute => "s",
            _ => "m",
        }
    }

    /// A figure in words, without its unit: angles in degrees, compute times in
    /// milliseconds.
    #[must_use]
    pub fn shown(self, value: f64) -> String {
        match self {
            Self::Heading => degrees(self.scale() * value),
            _ => metres(self.scale() * value),
        }
    }

    /// From the unit of the figure to that of its words.
    #[must_use]
    pub fn scale(self) -> f64 {
        match self {
            Self::Heading => 180.0 / core::f64::consts::PI,
            Self::Compute => 1e3,
            _ => 1.0,
        }
    }

    /// The unit of [`shown`](Self::shown), with a space before it.
    #[must_use]
    pub fn shown_unit(self) -> &'static str {
        match self {
            Self::Heading => " °",
            Self::Nees | Self::Blocked => "",
            Self::Converged | Self::Recovered | Self::Goals => " s",
            Self::Compute => " ms",
            _ => " m",
        }
    }

    /// The word of the command line.
    #[must_use]
    pub fn word(self) -> String {
        self.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
    }
}
