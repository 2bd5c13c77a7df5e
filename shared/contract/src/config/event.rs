//! Events: doors that open and close, boxes that are put somewhere.

use std::fmt;

use rusty_geometry::SE2;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::{FieldError, at_least, within};

/// The most of them in a run.
const MOST: usize = 1000;

/// Something that changes the world at the start of a tick. No participant is told:
/// the map that participants are given stays as it was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
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

/// An event as a file has it. A reader of the enumeration would not know the place of a
/// field that cannot be used.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    kind: Kind,
    tick: u64,
    door: Option<u8>,
    number: Option<u8>,
    at: Option<SE2>,
    #[serde(default, deserialize_with = "size")]
    size_m: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    OpenDoor,
    CloseDoor,
    PutBox,
    RemoveBox,
}

fn size<'de, D: Deserializer<'de>>(input: D) -> Result<Option<[f64; 2]>, D::Error> {
    rusty_geometry::exactly::numbers(input).map(Some)
}

impl<'de> Deserialize<'de> for Event {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct OfFields;

        impl<'de> Visitor<'de> for OfFields {
            type Value = Event;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an event")
            }

            fn visit_map<A: MapAccess<'de>>(self, fields: A) -> Result<Event, A::Error> {
                let fields = Fields::deserialize(MapAccessDeserializer::new(fields))?;
                Event::try_from(fields).map_err(A::Error::custom)
            }
        }

        input.deserialize_map(OfFields)
    }
}

impl TryFrom<Fields> for Event {
    type Error = String;

    fn try_from(fields: Fields) -> Result<Self, Self::Error> {
        let Fields { kind, tick, door, number, at, size_m } = fields;
        match (kind, door, number, at, size_m) {
            (Kind::OpenDoor, Some(door), None, None, None) => Ok(Self::OpenDoor { tick, door }),
            (Kind::CloseDoor, Some(door), None, None, None) => Ok(Self::CloseDoor { tick, door }),
            (Kind::PutBox, None, Some(number), Some(at), Some(size_m)) => {
                Ok(Self::PutBox { tick, number, at, size_m })
            }
            (Kind::RemoveBox, None, Some(number), None, None) => {
                Ok(Self::RemoveBox { tick, number })
            }
            _ => {
                let (kind, has) = match kind {
                    Kind::OpenDoor => ("open-door", "tick and door"),
                    Kind::CloseDoor => ("close-door", "tick and door"),
                    Kind::PutBox => ("put-box", "tick, number, at and size_m"),
                    Kind::RemoveBox => ("remove-box", "tick and number"),
                };
                Err(format!("the {kind} of tick {tick} must have {has}, and nothing else"))
            }
        }
    }
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

    #[test]
    fn what_cannot_be_read_is_shown_where_it_is() {
        #[derive(Debug, Deserialize)]
        struct File {
            event: Vec<Event>,
        }
        let first = "[[event]]\nkind = \"open-door\"\ntick = 3\ndoor = 2\n";
        let read = |second: &str| toml::from_str::<File>(&format!("{first}[[event]]\n{second}"));
        let put = "kind = \"put-box\"\ntick = 4\nnumber = 1\nat = { x_m = 1, y_m = 2, \
                   theta_rad = 0.5 }\nsize_m = [0.5, 0.2]\n";
        let list = read(put).unwrap().event;
        assert_eq!(list[1], toml::from_str(&toml::to_string(&list[1]).unwrap()).unwrap());
        for (second, line, words) in [
            (put.replace("number = 1", "number = 300"), 8, "300"),
            (put.replace("0.2]", "0.2, 9]"), 10, "2 numbers"),
            (put.replace("number = 1", "number = 1\ncolour = 1"), 9, "colour"),
            (put.replace("number = 1", ""), 5, "put-box of tick 4 must have tick, number, at"),
            (put.replace("put-box", "remove-box"), 5, "remove-box of tick 4 must"),
            ("kind = \"open-door\"\ntick = 5\nnumber = 1\n".to_owned(), 5, "of tick 5 must"),
            ("kind = \"paint\"\ntick = 3\n".to_owned(), 6, "open-door"),
        ] {
            let error = read(&second).unwrap_err().to_string();
            assert!(error.contains(&format!("line {line},")) && error.contains(words), "{error}");
        }
    }
}
