//! The loop of every driver: localise, choose a command, stay clear of walls.
//!
//! Drivers differ in their [`Task`]. Each carries a filter that estimates the pose,
//! and answers every tick with that estimate and the command for the next tick. A
//! driver has no access to the truth.

use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Reply, Start};
use rusty_geometry::{SE2, Twist};

use crate::pilot::Pilot;
use crate::surroundings::Caution;

/// What a driver does: the part in which drivers differ.
pub trait Task {
    /// Returns the command for the next tick, from the estimated pose and the scan at
    /// the end of this tick, if there is one.
    fn command(&mut self, pilot: &mut Pilot, pose: &SE2, ranges_m: Option<&[f64]>) -> Twist;

    /// Whether it has nothing left to do, and the run is to end.
    fn is_done(&self) -> bool;

    /// Writes and prints results at the end of the run.
    ///
    /// # Errors
    /// The reason why they cannot be written.
    fn finish(self, name: &str, pilot: &Pilot) -> Result<(), ClientError>;
}

/// A driver: a filter, a task, and a pilot that executes it.
#[derive(Debug)]
pub struct Driver<F, T> {
    name: String,
    filter: F,
    pilot: Pilot,
    /// What it does.
    pub task: T,
}

impl<F: Filter, T: Task> Driver<F, T> {
    /// A driver before the first tick.
    pub fn new(start: &Start, caution: &Caution, filter: F, task: T) -> Self {
        Self { name: start.name.clone(), filter, pilot: Pilot::new(start, caution), task }
    }
}

impl<F: Filter, T: Task> Filter for Driver<F, T> {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        let estimate = self.filter.update(tick).estimate().copied();
        self.pilot.tick(tick.encoders(), tick.ranges_m());
        let pose = estimate.map(|estimate| estimate.pose_in_world).unwrap_or_default();
        let command = self.task.command(&mut self.pilot, &pose, tick.ranges_m());
        estimate.map_or(Reply::Command(command), |estimate| Reply::Both(estimate, command))
    }

    fn is_done(&self) -> bool {
        self.task.is_done()
    }

    fn finish(self) -> Result<(), ClientError> {
        self.task.finish(&self.name, &self.pilot)
    }
}
