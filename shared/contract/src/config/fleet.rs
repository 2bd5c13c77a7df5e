//! Several robots in one world.
//!
//! Each has separate frames, participants, sensors, log and scores: for the
//! programs that take part a run of several robots is one run for each, and the runs
//! keep step. What a robot's frames depend on of the others is how these move, and that
//! is in its configuration.

use std::collections::BTreeSet;

use rusty_geometry::SE2;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64_with_seed;

use super::run::check_pose;
use super::{FieldError, Kidnapping, RobotConfig, RunConfig, ScriptConfig, at_least};
use crate::names::{MAX_ROBOT_NAME, check_robot_name};

/// The most robots in a world.
pub const MAX_ROBOTS: usize = 8;

/// One robot among others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fleet {
    /// The robot's name.
    pub name: String,
    /// Its place among all robots, from 0; in this order they move within a tick.
    pub place: usize,
    /// The others, in the order of their places.
    pub others: Vec<OtherRobot>,
}

/// What determines how another robot moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherRobot {
    /// Its name.
    pub name: String,
    /// Where it starts, world frame.
    pub start: SE2,
    /// True parameters included.
    pub robot: RobotConfig,
    /// Where its commands come from.
    pub script: ScriptConfig,
    /// Where it is carried away, in the order of the ticks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kidnappings: Vec<Kidnapping>,
}

impl OtherRobot {
    /// Whether a participant drives it.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.script.is_driver()
    }
}

impl Fleet {
    /// The others with their places.
    pub fn others(&self) -> impl Iterator<Item = (usize, &OtherRobot)> {
        let place = |index: usize| index + usize::from(index >= self.place);
        self.others.iter().enumerate().map(move |(index, other)| (place(index), other))
    }

    /// Checks names, places and all fields of the others; `start` and `body_radius_m`
    /// are those of the robot itself.
    pub(super) fn check(&self, start: SE2, body_radius_m: f64) -> Result<(), FieldError> {
        at_least("robot (number of)", self.others.len() as u64 + 1, 1, MAX_ROBOTS as u64)?;
        at_least("robot (place)", self.place as u64, 0, self.others.len() as u64)?;
        let mut names = BTreeSet::from([self.name.as_str()]);
        let mut bodies = vec![(self.place, start, body_radius_m)];
        check_name(&self.name, self.place)?;
        for (place, other) in self.others() {
            let field = |name: &str| format!("robot[{place}].{name}");
            check_name(&other.name, place)?;
            if !names.insert(&other.name) {
                let remedy = "give every robot another name";
                return Err(FieldError::new(field("name"), &other.name, "is there twice", remedy));
            }
            let within = |e: FieldError| {
                let name = e.field.strip_prefix("robot.").unwrap_or(&e.field);
                FieldError { field: field(name), ..e }
            };
            check_pose("start", other.start).map_err(within)?;
            other.robot.check().map_err(within)?;
            other.script.check().map_err(within)?;
            Kidnapping::check(&other.kidnappings).map_err(within)?;
            bodies.push((place, other.start, other.robot.body_radius_m));
        }
        for (i, (place, a, a_radius_m)) in bodies.iter().enumerate() {
            for (other, b, b_radius_m) in &bodies[i + 1..] {
                let apart = a.translation() - b.translation();
                let least_m = a_radius_m + b_radius_m;
                if apart.norm_squared() < least_m * least_m {
                    let value = format!("({}, {}) m", b.x(), b.y());
                    let problem = format!("touches robot[{place}] at its start");
                    let remedy = format!("start them at least {least_m} m apart");
                    return Err(FieldError::new(
                        format!("robot[{other}].start"),
                        value,
                        problem,
                        remedy,
                    ));
                }
            }
        }
        Ok(())
    }
}

fn check_name(name: &str, place: usize) -> Result<(), FieldError> {
    check_robot_name(name).map_err(|e| {
        let remedy = format!(
            "use 1 to {MAX_ROBOT_NAME} letters, digits, '-' or '_', starting with a letter or digit"
        );
        FieldError::new(format!("robot[{place}].name"), format!("{name:?}"), e.problem(), remedy)
    })
}

/// The seed of the noise of a robot in a run with this seed. The first draws with the
/// run's, any other with one that depends on its name: a robot more changes no number
/// that another draws.
#[must_use]
pub fn robot_seed(seed: u64, place: usize, name: &str) -> u64 {
    if place == 0 { seed } else { xxh3_64_with_seed(name.as_bytes(), seed) }
}

impl RunConfig {
    /// The seed of this robot's noise; people draw with that of the run.
    #[must_use]
    pub fn robot_seed(&self) -> u64 {
        match &self.fleet {
            None => self.seed,
            Some(fleet) => robot_seed(self.seed, fleet.place, &fleet.name),
        }
    }

    /// Where robots start, in the order of their places, world frame.
    pub fn starts(&self) -> impl Iterator<Item = SE2> + Clone {
        let fleet = self.fleet.as_deref();
        let (before, after) =
            fleet.map_or((&[][..], &[][..]), |fleet| fleet.others.split_at(fleet.place));
        let start = |other: &OtherRobot| other.start;
        before.iter().map(start).chain([self.start]).chain(after.iter().map(start))
    }
}
