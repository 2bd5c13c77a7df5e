//! The other robots of a world: bodies that drive.
//!
//! Within a tick the robots move one after the other, in the order of their places. Each
//! meets the others where they are at that moment: those before it have moved, those
//! after it have not, so no step brings two into one another. Every robot's simulation moves
//! all of them, with the same numbers, and senses for its own alone.

use nalgebra::Point2;
use rusty_contract::RunConfig;
use rusty_contract::config::{Kidnapping, OtherRobot, robot_seed};
use rusty_geometry::{Disc, SE2, Twist, World};

use crate::robot::Robot;
use crate::scene::Scene;
use crate::script::BuiltInScript;
use crate::slip::Slip;

/// Another robot.
#[derive(Clone, Debug)]
struct Other {
    place: usize,
    robot: Robot,
    script: BuiltInScript,
    slip: Slip,
    kidnappings: Vec<Kidnapping>,
    /// The command of a driver, as applied in the next tick.
    driver: Option<Twist>,
}

/// All robots but the simulation's own.
#[derive(Clone, Debug)]
pub(crate) struct Fleet {
    /// The place of the simulation's own robot.
    place: usize,
    others: Vec<Other>,
    /// Where all robots stand, in the order of their places.
    discs: Vec<Disc>,
    /// What a robot meets: people, and all robots but itself.
    met: Vec<Disc>,
    dt_s: f64,
}

/// A body of this radius at a pose.
pub(crate) fn disc(pose: &SE2, radius_m: f64) -> Disc {
    Disc { centre: Point2::from(pose.translation()), radius_m }
}

/// The slip of another robot on the floor of `config`.
fn slip(config: &RunConfig, place: usize, other: &OtherRobot) -> Slip {
    Slip::new(&other.robot, &config.patches, robot_seed(config.seed, place, &other.name))
}

impl Fleet {
    /// The others of `config` before the first tick, if there are any.
    pub(crate) fn of(config: &RunConfig) -> Option<Self> {
        let fleet = config.fleet.as_deref()?;
        let others = fleet.others().map(|(place, other)| Other {
            place,
            robot: Robot::new(&other.robot, other.start),
            script: BuiltInScript::new(&other.script, config.dt_s, other.start),
            slip: slip(config, place, other),
            kidnappings: other.kidnappings.clone(),
            driver: None,
        });
        let others: Vec<Other> = others.collect();
        let start = |other: &OtherRobot| disc(&other.start, other.robot.body_radius_m);
        let mut discs: Vec<Disc> = fleet.others.iter().map(start).collect();
        discs.insert(fleet.place, disc(&config.start, config.robot.body_radius_m));
        Some(Self { place: fleet.place, others, discs, met: Vec::new(), dt_s: config.dt_s })
    }

    /// Goes on with the slip of another seed.
    pub(crate) fn reseed(&mut self, config: &RunConfig) {
        let Some(fleet) = config.fleet.as_deref() else { return };
        for (other, (place, spec)) in self.others.iter_mut().zip(fleet.others()) {
            other.slip = slip(config, place, spec);
        }
    }

    /// Sets the command of the driver of the robot at `place` for the next tick.
    pub(crate) fn drive(&mut self, place: usize, command: Twist) {
        let driven = self.others.iter_mut().filter(|other| other.place == place);
        driven.for_each(|other| other.driver = Some(command));
    }

    /// Carries away those that are due.
    pub(crate) fn carry_away(&mut self, tick: u64) {
        for other in &mut self.others {
            let due = other.kidnappings.binary_search_by_key(&tick, |k| k.tick);
            if let Ok(index) = due {
                other.robot.put(other.kidnappings[index].to);
                self.discs[other.place].centre =
                    Point2::from(other.kidnappings[index].to.translation());
            }
        }
    }

    /// Where all robots stand, in the order of their places, the own one at `own`.
    pub(crate) fn stand(&mut self, own: &SE2) -> &[Disc] {
        self.discs[self.place].centre = Point2::from(own.translation());
        &self.discs
    }

    /// Moves the robots before the own one, which stands at `own`.
    pub(crate) fn move_before(&mut self, world: &World, people: &[Disc], own: &SE2, tick: u64) {
        let _ = self.stand(own);
        // As many others are before it as its place says.
        (0..self.place).for_each(|index| self.step(index, world, people, tick));
        self.meet(self.place, people);
    }

    /// Moves the robots after the own one, which has come to `own`.
    pub(crate) fn move_after(&mut self, world: &World, people: &[Disc], own: &SE2, tick: u64) {
        let _ = self.stand(own);
        (self.place..self.others.len()).for_each(|index| self.step(index, world, people, tick));
        self.meet(self.place, people);
    }

    /// Gathers what the own robot meets before the first tick.
    pub(crate) fn look_around(&mut self, people: &[Disc]) {
        self.meet(self.place, people);
    }

    /// What the own robot meets: people, and the others where they are.
    pub(crate) fn met(&self) -> &[Disc] {
        &self.met
    }

    /// One robot's tick.
    fn step(&mut self, index: usize, world: &World, people: &[Disc], tick: u64) {
        self.meet(self.others[index].place, people);
        let other = &mut self.others[index];
        let applied = other.driver.take().unwrap_or_else(|| {
            other.robot.limit(other.script.command_at(tick, &other.robot.pose_in_world(), None))
        });
        let slip = other.slip.at(tick, &other.robot.pose_in_world());
        // Whether it was blocked shows in its own simulation.
        let _ = other.robot.step(Scene { world, bodies: &self.met }, applied, self.dt_s, slip);
        self.discs[other.place].centre = Point2::from(other.robot.pose_in_world().translation());
    }

    /// Gathers what the robot at `place` meets.
    fn meet(&mut self, place: usize, people: &[Disc]) {
        self.met.clear();
        self.met.extend_from_slice(people);
        let others = self.discs.iter().enumerate().filter(|(i, _)| *i != place);
        self.met.extend(others.map(|(_, disc)| *disc));
    }
}

/// A robot, other than the own one, with a driver, whose commands must be known: its
/// place and name.
pub(crate) fn driven_other(config: &RunConfig) -> Option<(usize, &str)> {
    let mut others = config.fleet.as_deref()?.others();
    let driven = others.find(|(_, other)| other.is_driven());
    driven.map(|(place, other)| (place, other.name.as_str()))
}

#[cfg(test)]
mod tests;
