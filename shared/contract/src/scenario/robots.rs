//! `[robot]` for one robot, `[[robot]]` once for each of several.

use std::fmt;
use std::ops::{Deref, DerefMut};

use rusty_geometry::SE2;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};

use crate::config::{FieldError, Kidnapping, LidarConfig, RobotConfig, ScriptConfig, Sensors};

/// The robots of a scenario. It reads and writes as the parameters of the first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Robots {
    /// One, to which all of the scenario belongs.
    One(RobotConfig),
    /// Several, in the order in which they move within a tick; never empty.
    Several(Vec<RobotEntry>),
}

/// One robot of several. What is left out is as the scenario has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Map<String, Value>")]
pub struct RobotEntry {
    /// Its name, 1 to 8 characters.
    pub name: String,
    /// The robot, whose fields are those of the entry.
    #[serde(flatten)]
    pub robot: RobotConfig,
    /// What differs from the scenario.
    #[serde(flatten)]
    pub own: RobotsOwn,
}

/// What one robot of several has differently from the scenario.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobotsOwn {
    /// Where it starts, world frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<SE2>,
    /// Its LiDAR.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lidar: Option<LidarConfig>,
    /// Its small sensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Sensors>,
    /// Where its commands come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub script: Option<ScriptConfig>,
    /// Where it is carried away, in the order of the ticks.
    #[serde(rename = "kidnapping", skip_serializing_if = "Vec::is_empty")]
    pub kidnappings: Vec<Kidnapping>,
}

/// The keys of [`RobotsOwn`].
const OWN: [&str; 5] = ["start", "lidar", "sensors", "script", "kidnapping"];

impl TryFrom<Map<String, Value>> for RobotEntry {
    type Error = String;

    /// Reads an entry; every other key than `name` and those of [`RobotsOwn`] is one of
    /// the robot.
    fn try_from(mut fields: Map<String, Value>) -> Result<Self, String> {
        if let Some((key, _)) = fields.iter().find(|(_, value)| has_null(value)) {
            return Err(format!("robot.{key}: is NaN or infinite; give a finite number"));
        }
        let name = match fields.remove("name") {
            Some(Value::String(name)) => name,
            Some(other) => return Err(format!("robot.name = {other}: is no text; write \"b\"")),
            None => return Err("missing field `name`; give every [[robot]] one".to_owned()),
        };
        let own = OWN.iter().filter_map(|key| Some(((*key).to_owned(), fields.remove(*key)?)));
        let own: Map<String, Value> = own.collect();
        let within = |e: serde_json::Error| format!("robot {name:?}: {e}");
        Ok(Self {
            robot: RobotConfig::deserialize(&Value::Object(fields)).map_err(within)?,
            own: RobotsOwn::deserialize(&Value::Object(own)).map_err(within)?,
            name,
        })
    }
}

impl Default for Robots {
    fn default() -> Self {
        Self::One(RobotConfig::default())
    }
}

impl Deref for Robots {
    type Target = RobotConfig;

    fn deref(&self) -> &RobotConfig {
        match self {
            Self::One(robot) => robot,
            Self::Several(list) => &list[0].robot,
        }
    }
}

impl DerefMut for Robots {
    fn deref_mut(&mut self) -> &mut RobotConfig {
        match self {
            Self::One(robot) => robot,
            Self::Several(list) => &mut list[0].robot,
        }
    }
}

impl<'de> Deserialize<'de> for Robots {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrSeveral;

        impl<'de> Visitor<'de> for OneOrSeveral {
            type Value = Robots;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table [robot], or a list of tables [[robot]]")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Robots, A::Error> {
                RobotConfig::deserialize(MapAccessDeserializer::new(map)).map(Robots::One)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Robots, A::Error> {
                let list = Vec::deserialize(SeqAccessDeserializer::new(list))?;
                if list.is_empty() {
                    return Err(A::Error::custom("robot = []: has no robot; leave it out for one"));
                }
                Ok(Robots::Several(list))
            }
        }

        deserializer.deserialize_any(OneOrSeveral)
    }
}

impl Robots {
    /// The entries, where there are several.
    #[must_use]
    pub fn entries(&self) -> &[RobotEntry] {
        match self {
            Self::One(_) => &[],
            Self::Several(list) => list,
        }
    }

    /// Checks every robot that has parameters; what the scenario lends it is checked there.
    pub(super) fn check(&self) -> Result<(), FieldError> {
        if let Self::One(robot) = self {
            return robot.check();
        }
        for (place, entry) in self.entries().iter().enumerate() {
            let within = |e: FieldError| in_entry(place, e);
            entry.robot.check().map_err(within)?;
            entry.own.lidar.map_or(Ok(()), |lidar| lidar.check()).map_err(within)?;
            entry.own.sensors.as_ref().map_or(Ok(()), Sensors::check).map_err(within)?;
            entry.own.script.as_ref().map_or(Ok(()), ScriptConfig::check).map_err(within)?;
            Kidnapping::check(&entry.own.kidnappings).map_err(within)?;
        }
        Ok(())
    }
}

/// Whether a value that was read from TOML has a number that is not finite, which JSON
/// does not have; TOML has no null.
#[must_use]
pub fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(values) => values.iter().any(has_null),
        Value::Object(fields) => fields.values().any(has_null),
        Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
    }
}

/// An error about a field of one robot, as an entry names it.
fn in_entry(place: usize, error: FieldError) -> FieldError {
    let field = error.field.strip_prefix("robot.").unwrap_or(&error.field);
    FieldError { field: format!("robot[{place}].{field}"), ..error }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    const TWO: &str = "
        dt_s = 0.02
        [lidar]
        beams = 90
        [[robot]]
        name = \"a\"
        slip_std = 0.0
        [[robot]]
        name = \"b\"
        start = { x_m = 8.0, y_m = 4.5, theta_rad = 3.1 }
        [robot.lidar]
        beams = 30
        [robot.script]
        kind = \"straight\"
        v_m_s = 0.2
        [[robot.kidnapping]]
        tick = 5
        to = { x_m = 7.0, y_m = 4.5, theta_rad = 0.0 }
    ";

    fn error(text: &str) -> String {
        Scenario::from_toml(text).unwrap_err().to_string()
    }

    #[test]
    fn several_robots_differ_in_what_their_entries_say() {
        let scenario = Scenario::from_toml(TWO).unwrap();
        assert_eq!(scenario.robot.slip_std, 0.0);
        let world = rusty_geometry::apartment().spec().clone();
        let [a, b] = [0, 1].map(|place| scenario.config_of(place, world.clone()));
        a.check().unwrap();
        b.check().unwrap();
        assert_eq!((a.lidar.beams, b.lidar.beams), (90, 30));
        assert_eq!((a.start, b.start.x()), (scenario.start, 8.0));
        assert_eq!((a.robot.slip_std, b.robot.slip_std), (0.0, 0.02));
        assert_eq!((a.kidnappings.len(), b.kidnappings.len()), (0, 1));
        assert_eq!(b.script, ScriptConfig::Straight { v_m_s: 0.2 });
        let fleet = |c: &crate::RunConfig| c.fleet.clone().unwrap();
        assert_eq!((fleet(&a).name.as_str(), fleet(&b).name.as_str()), ("a", "b"));
        let other = &fleet(&a).others[0];
        assert_eq!(
            (other.start, &other.script, &other.kidnappings),
            (b.start, &b.script, &b.kidnappings)
        );
        assert!(a.starts().eq(b.starts()) && a.starts().eq([a.start, b.start]));
        assert!(a.robot_seed() == a.seed && b.robot_seed() != b.seed);
        // As it is written down, so it is read.
        let json = serde_json::to_string(&scenario).unwrap();
        assert_eq!(serde_json::from_str::<Scenario>(&json).unwrap(), scenario);
        let toml = toml::to_string(&scenario).unwrap();
        assert_eq!(Scenario::from_toml(&toml).unwrap(), scenario);
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        for (from, to, words) in [
            ("name = \"a\"", "", "missing field `name`"),
            ("name = \"b\"", "name = \"a\"", "robot[1].name = a: is there twice"),
            ("name = \"b\"", "name = \"too-long-for-it\"", "robot[1].name"),
            ("slip_std = 0.0", "slip = 0.0", "unknown field `slip`"),
            ("slip_std = 0.0", "slip_std = -1.0", "robot[0].slip_std = -1"),
            ("x_m = 8.0", "x_m = 6.1", "touches robot[0]"),
            ("slip_std = 0.0", "slip_std_left = nan", "robot.slip_std_left: is NaN or infinite"),
            (
                "dt_s = 0.02",
                "kidnapping = [{ tick = 1, to = { x_m = 2.0, y_m = 2.0, theta_rad = 0.0 } }]",
                "[[robot.kidnapping]]",
            ),
            ("beams = 30", "beams = 0", "robot[1].lidar.beams = 0"),
            ("tick = 5", "tick = -5", "-5"),
        ] {
            let text = TWO.replacen(from, to, 1);
            assert_ne!(text, TWO);
            let found = error(&text);
            assert!(found.contains(words), "{to}: {found}");
        }
        assert!(error("robot = []").contains("has no robot"));
        assert!(error("robot = 3").contains("[[robot]]"));
        let nine: String = (0..9).map(|k| format!("[[robot]]\nname = \"r{k}\"\n")).collect();
        assert!(error(&nine).contains("robot (number of) = 9"), "{}", error(&nine));
    }
}
