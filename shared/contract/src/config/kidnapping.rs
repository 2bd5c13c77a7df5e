//! The robot is carried away.

use rusty_geometry::SE2;
use serde::{Deserialize, Serialize};

use super::run::check_pose;
use super::{FieldError, at_least};

/// The most of them in a run.
const MOST: usize = 1000;

/// The robot is lifted at the start of a tick and put down elsewhere; its wheels
/// do not turn meanwhile, and no participant is told. The *kidnapped robot problem* of
/// Thrun, Burgard, Fox, *Probabilistic Robotics*, §7.1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kidnapping {
    /// The tick before whose motion it happens.
    pub tick: u64,
    /// Where the robot is put, world frame.
    pub to: SE2,
}

impl Kidnapping {
    /// Checks a list of them: poses that are numbers, ticks that grow.
    ///
    /// # Errors
    /// [`FieldError`] names the first field that cannot be used.
    pub fn check(list: &[Self]) -> Result<(), FieldError> {
        at_least("kidnapping (number of)", list.len() as u64, 0, MOST as u64)?;
        for (i, k) in list.iter().enumerate() {
            at_least(&format!("kidnapping[{i}].tick"), k.tick, 0, 1 << 40)?;
            check_pose(&format!("kidnapping[{i}].to"), k.to)?;
            if i > 0 && list[i - 1].tick >= k.tick {
                let problem = format!("is not after the one before it, {}", list[i - 1].tick);
                let remedy = "list them in the order in which they happen, one a tick";
                return Err(FieldError::new(
                    format!("kidnapping[{i}].tick"),
                    k.tick,
                    problem,
                    remedy,
                ));
            }
        }
        Ok(())
    }
}
