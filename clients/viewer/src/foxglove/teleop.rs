//! Commands from an app: messages of `/cmd_vel`.

use std::collections::BTreeMap;

use rusty_geometry::Twist;
use rusty_ros::{from_cdr, messages};
use serde_json::Value;

use super::message::{AppChannel, DATA};
use crate::command::Command;

/// The topic of commands.
const TOPIC: &str = "/cmd_vel";
/// The types of commands, and whether they have a time.
const TYPES: [(&str, bool); 4] = [
    ("geometry_msgs/Twist", false),
    ("geometry_msgs/msg/Twist", false),
    ("geometry_msgs/TwistStamped", true),
    ("geometry_msgs/msg/TwistStamped", true),
];

/// The channels on which an app publishes.
pub struct Publications {
    may_drive: bool,
    channels: BTreeMap<u32, Publication>,
}

struct Publication {
    is_stamped: bool,
    is_json: bool,
    /// A message that was malformed is reported once.
    is_reported: bool,
}

impl Publications {
    /// No channels yet, of an app that may drive or not.
    #[must_use]
    pub fn new(may_drive: bool) -> Self {
        Self { may_drive, channels: BTreeMap::new() }
    }

    /// Adds a channel.
    ///
    /// # Errors
    /// A sentence for people, if no command can come on it.
    pub fn add(&mut self, channel: AppChannel) -> Result<(), String> {
        let AppChannel { id, topic, encoding, schema_name } = channel;
        if !self.may_drive {
            return Err(format!(
                "publishing on {topic} failed: expected an address with the right to drive, got \
                 one without; use the address with drive= of a run whose driver is `drive`"
            ));
        }
        let known = TYPES.into_iter().find(|(name, _)| *name == schema_name);
        let is_json = encoding == "json";
        match known {
            Some((_, is_stamped)) if topic == TOPIC && (is_json || encoding == "cdr") => {
                self.channels.insert(id, Publication { is_stamped, is_json, is_reported: false });
                Ok(())
            }
            _ => Err(format!(
                "publishing on {topic} failed: expected geometry_msgs/Twist or \
                 geometry_msgs/TwistStamped on {TOPIC} in json or cdr, got {schema_name} in \
                 {encoding}; change topic and type in the settings of the panel"
            )),
        }
    }

    /// Removes channels.
    pub fn remove(&mut self, ids: &[u32]) {
        self.channels.retain(|id, _| !ids.contains(id));
    }

    /// Returns the command in a message; `None` of one on another channel, or on one
    /// whose defect is reported.
    ///
    /// # Errors
    /// A sentence for people, if it is malformed.
    pub fn command(&mut self, bytes: &[u8]) -> Result<Option<Command>, String> {
        let Some((&[op, a, b, c, d], content)) = bytes.split_first_chunk() else {
            return Ok(None);
        };
        let channel = self.channels.get_mut(&u32::from_le_bytes([a, b, c, d]));
        let Some(channel) = channel.filter(|_| op == DATA) else { return Ok(None) };
        let twist = channel.twist(content).filter(is_finite);
        if twist.is_none() && !std::mem::replace(&mut channel.is_reported, true) {
            return Err(format!(
                "reading a command on {TOPIC} failed: expected linear.x and angular.z as finite \
                 numbers, got {} bytes without them; check the type of the messages",
                content.len()
            ));
        }
        Ok(twist.map(Command::Velocity))
    }
}

fn is_finite(twist: &Twist) -> bool {
    twist.v_m_s.is_finite() && twist.omega_rad_s.is_finite()
}

impl Publication {
    fn twist(&self, content: &[u8]) -> Option<Twist> {
        if self.is_json {
            let message: Value = serde_json::from_slice(content).ok()?;
            let twist = if self.is_stamped { message.get("twist")? } else { &message };
            let part = |of: &str, axis: &str| twist.get(of)?.get(axis)?.as_f64();
            let (v_m_s, omega_rad_s) = (part("linear", "x")?, part("angular", "z")?);
            return Some(Twist { v_m_s, omega_rad_s });
        }
        let twist: messages::Twist = match self.is_stamped {
            true => from_cdr::<messages::TwistStamped>(content).ok()?.twist,
            false => from_cdr(content).ok()?,
        };
        Some(Twist { v_m_s: twist.linear.x, omega_rad_s: twist.angular.z })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_ros::RosMessage;

    const TWIST: Twist = Twist { v_m_s: 0.3, omega_rad_s: -0.7 };

    fn channel(id: u32, schema_name: &str, encoding: &str) -> AppChannel {
        let [schema_name, encoding] = [schema_name, encoding].map(str::to_owned);
        AppChannel { id, topic: "/cmd_vel".to_owned(), encoding, schema_name }
    }

    fn message(id: u32, content: &[u8]) -> Vec<u8> {
        [&[DATA][..], &id.to_le_bytes(), content].concat()
    }

    #[test]
    fn both_types_in_both_encodings_are_commands() {
        let mut all = Publications::new(true);
        for (id, (name, _)) in (0..).zip(TYPES) {
            all.add(channel(id, name, "json")).unwrap();
            all.add(channel(10 + id, name, "cdr")).unwrap();
        }
        let json = r#"{"linear":{"x":0.3,"y":0,"z":0},"angular":{"x":0,"y":0,"z":-0.7}}"#;
        let stamped = format!(r#"{{"header":{{}},"twist":{json}}}"#);
        let plain: messages::Twist = TWIST.into();
        let with_time = messages::TwistStamped { twist: plain, ..Default::default() };
        let (cdr, cdr_stamped) = (plain.to_cdr().unwrap(), with_time.to_cdr().unwrap());
        let contents: [&[u8]; 4] = [json.as_bytes(), stamped.as_bytes(), &cdr, &cdr_stamped];
        for (id, content) in [0, 2, 11, 12].into_iter().zip(contents) {
            let command = all.command(&message(id, content)).unwrap();
            assert_eq!(command, Some(Command::Velocity(TWIST)), "{id}");
        }
        all.remove(&[0]);
        for ignored in [message(0, json.as_bytes()), message(99, &cdr), vec![DATA], vec![]] {
            assert_eq!(all.command(&ignored), Ok(None));
        }
    }

    #[test]
    fn other_channels_are_refused_and_a_defect_is_reported_once() {
        assert!(Publications::new(false).add(channel(1, TYPES[0].0, "cdr")).is_err());
        let mut all = Publications::new(true);
        for (name, encoding) in [("sensor_msgs/Joy", "cdr"), (TYPES[0].0, "ros1")] {
            assert!(all.add(channel(1, name, encoding)).is_err());
        }
        let elsewhere = AppChannel { topic: "/other".to_owned(), ..channel(1, TYPES[0].0, "cdr") };
        assert!(all.add(elsewhere).is_err());
        all.add(channel(1, TYPES[0].0, "cdr")).unwrap();
        let nan: messages::Twist = Twist { v_m_s: f64::NAN, ..TWIST }.into();
        assert!(all.command(&message(1, &nan.to_cdr().unwrap())).is_err());
        assert_eq!(all.command(&message(1, b"short")), Ok(None));
    }
}
