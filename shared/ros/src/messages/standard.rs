//! `builtin_interfaces`, `std_msgs` and `rosgraph_msgs`.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::cdr::RosMessage;

/// A text: a constant where it is written, owned where it was read.
pub type Text = Cow<'static, str>;

/// A point in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// The rest, ns.
    pub nanosec: u32,
}

impl Time {
    /// Returns the time `ns` nanoseconds after zero, at most 2³¹ s.
    #[must_use]
    pub fn from_ns(ns: u64) -> Self {
        let sec = i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX);
        Self { sec, nanosec: (ns % 1_000_000_000) as u32 }
    }

    /// Returns the time in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        // One rounding: 1.3 s is the number 1.3.
        (f64::from(self.sec) * 1e9 + f64::from(self.nanosec)) / 1e9
    }
}

/// A length of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    /// Whole seconds.
    pub sec: i32,
    /// The rest, ns.
    pub nanosec: u32,
}

/// Time and frame of a message.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Time of the measurement.
    pub stamp: Time,
    /// Frame of the coordinates.
    pub frame_id: Text,
}

/// A colour, each part from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColorRgba {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity.
    pub a: f32,
}

/// The time of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// The time.
    pub clock: Time,
}

impl RosMessage for Clock {
    const NAME: &'static str = "rosgraph_msgs/msg/Clock";
}
