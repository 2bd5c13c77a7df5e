//! `GoalScore`: goals that a robot reached.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Goals that a robot reached in order, by its true pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalScore {
    /// Number of goals.
    pub goals: usize,
    /// Goals that were reached.
    pub reached: usize,
    /// Time at the end of the tick in which the last was reached, s; `None` if one was not.
    pub after_s: Option<f64>,
    /// Distance truly driven until then, m.
    pub driven_m: Option<f64>,
}

impl fmt::Display for GoalScore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "goals    {} of {} reached", self.reached, self.goals)?;
        self.after_s.map_or(Ok(()), |after_s| write!(f, " after {after_s:.2} s"))
    }
}
