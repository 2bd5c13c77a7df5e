//! Modelled compute time of a participant; see [`crate::effects`].

use serde::{Deserialize, Serialize};

use crate::config::{FieldError, within};

/// Longest modelled time of an answer, s of simulated time.
pub const MAX_COMPUTE_S: f64 = 1e3;

/// How long a participant is modelled to take for an answer, simulated time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ComputeTime {
    /// For every tick, s.
    pub answer_s: f64,
    /// For a tick with a scan, so much more, s.
    pub scan_s: f64,
    /// What it may take, s; more is an overrun. `None`: as long as it likes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget_s: Option<f64>,
}

impl ComputeTime {
    /// Whether nothing is modelled.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Checks every number; `field` is what it is called.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self, field: &str) -> Result<(), FieldError> {
        within(&format!("{field}.answer_s"), self.answer_s, 0.0, MAX_COMPUTE_S)?;
        within(&format!("{field}.scan_s"), self.scan_s, 0.0, MAX_COMPUTE_S)?;
        match self.budget_s {
            Some(budget_s) => within(&format!("{field}.budget_s"), budget_s, 0.0, MAX_COMPUTE_S),
            None => Ok(()),
        }
    }

    /// The time for one answer, s.
    #[must_use]
    pub fn of_answer_s(&self, has_scan: bool) -> f64 {
        if has_scan { self.answer_s + self.scan_s } else { self.answer_s }
    }
}
