//! Events: doors that open and close, boxes that are put somewhere.

use rusty_geometry::SE2;
use serde::{Deserialize, Serialize};

use super::{FieldError, at_least, within};

/// The most of them in a run.
const MOST: usize = 1000;

/// Something that changes the world at the start of a tick. No participant is told:
/// the map that participants are given stays as it was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Event {
    /// The walls of a door are taken away.
    OpenDoor {
        /// The tick before whose motion it happens.
        tick: u64,
        /// Number of the door, as in `Door(3)`.
        door: u8,
    },
    /// The walls of a door are there again.
    CloseDoor {
        /// The tick before whose motion it happens.
        tick: u64,
        /// Number of the door.
        door: u8,
    },
    /// A box is put somewhere; one that was elsewhere moves there.
    PutBox {
        /// The tick before whose motion it happens.
        tick: u64,
        /// Number of the box, chosen by the author.
        number: u8,
        /// Pose of its middle, world frame.
        at: SE2,
        /// Length along the x axis of that pose, and along y, m.
        size_m: [f64; 2],
    },
    /// A box is taken away.
    RemoveBox {
        /// The tick before whose motion it happens.
        tick: u64,
        /// Number of the box.
        number: u8,
    },
}

impl Event {
    /// The tick before whose motion it happens.
    #[must_use]
    pub fn tick(&self) -> u64 {
        match self {
            Self::OpenDoor { tick, .. }
            | Self::CloseDoor { tick, .. }
            | Self::PutBox { tick, .. }
            | Self::RemoveBox { tick, .. } => *tick,
        }
    }

    /// Checks a list of them: in the order of their ticks, boxes of some size.
    ///
    /// # Errors
    /// [`FieldError`] names the first field that cannot be used.
    pub fn check(list: &[Self]) -> Result<(), FieldError> {
        at_least("event (number of)", list.len() as u64, 0, MOST as u64)?;
        for (i, event) in list.iter().enumerate() {
            let field = |name: &str| format!("event[{i}].{name}");
            at_least(&field("tick"), event.tick(), 0, 1 << 40)?;
            if let Self::PutBox { at, size_m: [x, y], .. } = event {
                within(&field("at.x_m"), at.x(), -1e6, 1e6)?;
                within(&field("at.y_m"), at.y(), -1e6, 1e6)?;
                within(&field("at.theta_rad"), at.theta(), -4.0, 4.0)?;
                within(&field("size_m[0]"), *x, 1e-3, 1e4)?;
                within(&field("size_m[1]"), *y, 1e-3, 1e4)?;
            }
            if i > 0 && list[i - 1].tick() > event.tick() {
                let problem = format!("is before the one above it, {}", list[i - 1].tick());
                let remedy = "list events in the order in which they happen";
                return Err(FieldError::new(field("tick"), event.tick(), problem, remedy));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_sizes_are_checked() {
        let open = |tick| Event::OpenDoor { tick, door: 3 };
        let put = |width_m| Event::PutBox {
            tick: 4,
            number: 1,
            at: SE2::new(1.0, 2.0, 0.5),
            size_m: [width_m, 0.5],
        };
        assert!(
            Event::check(&[open(1), open(4), put(0.5), Event::RemoveBox { tick: 9, number: 1 }])
                .is_ok()
        );
        let error = Event::check(&[open(5), open(4)]).unwrap_err();
        assert_eq!(error.field, "event[1].tick");
        for size_m in [0.0, f64::NAN, -1.0] {
            assert_eq!(Event::check(&[put(size_m)]).unwrap_err().field, "event[0].size_m[0]");
        }
        let text = "kind = \"open-door\"\ntick = 3\ndoor = 2\n";
        assert_eq!(toml::from_str::<Event>(text).unwrap(), Event::OpenDoor { tick: 3, door: 2 });
    }
}
