//! The loop of every driver: localise, choose a command, stay clear of walls.
//!
//! Drivers differ in their [`Task`]. Each carries a filter that estimates the pose,
//! and answers every tick with that estimate and the command for the next tick. While the
//! filter abstains, the robot of a task that needs a pose stands. A driver has no access
//! to the truth.

use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Reply, Start, errln};
use rusty_geometry::{SE2, Twist};

use crate::pilot::Pilot;
use crate::surroundings::Caution;

/// What a driver does with its filter `F`: the part in which drivers differ.
pub trait Task<F> {
    /// Whether the robot must stand while the filter abstains.
    const NEEDS_POSE: bool = false;

    /// Returns the command for the next tick, from what is known at the end of this one.
    fn command(&mut self, pilot: &mut Pilot, known: &Known<'_, F>) -> Twist;

    /// The filter abstained for a while, and the pose may have jumped.
    fn relocated(&mut self) {}

    /// Whether it has nothing left to do, and the run is to end.
    fn is_done(&self) -> bool;

    /// Writes and prints results at the end of the run.
    ///
    /// # Errors
    /// The reason why they cannot be written.
    fn finish(self, name: &str, pilot: &Pilot, filter: &F) -> Result<(), ClientError>;
}

/// What a task knows at the end of a tick.
#[derive(Debug)]
pub struct Known<'a, F> {
    /// The filter after this tick.
    pub filter: &'a F,
    /// Its answer, world frame; the identity while it abstains.
    pub pose_in_world: SE2,
    /// The scan at the end of this tick, if there is one, m.
    pub ranges_m: Option<&'a [f64]>,
}

/// A driver: a filter, a task, and a pilot that executes it.
#[derive(Debug)]
pub struct Driver<F, T> {
    name: String,
    filter: F,
    /// What executes it.
    pub pilot: Pilot,
    /// Whether the filter has abstained since its last answer.
    is_lost: bool,
    /// What it does.
    pub task: T,
}

impl<F: Filter, T: Task<F>> Driver<F, T> {
    /// A driver before the first tick.
    pub fn new(start: &Start, caution: &Caution, filter: F, task: T) -> Self {
        Self {
            name: start.name.clone(),
            filter,
            pilot: Pilot::new(start, caution),
            is_lost: false,
            task,
        }
    }
}

impl<F, T: Task<F>> Driver<F, T> {
    /// Returns whether the robot is lost, and prints when that changes.
    fn stands(&mut self, is_lost: bool, time_s: f64) -> bool {
        if is_lost != std::mem::replace(&mut self.is_lost, is_lost) {
            let name = &self.name;
            if is_lost {
                errln!("{name}: stops at {time_s:.2} s, because it does not know its pose");
            } else {
                errln!("{name}: continues at {time_s:.2} s, with its pose found");
                self.task.relocated();
            }
        }
        is_lost
    }
}

impl<F: Filter, T: Task<F>> Filter for Driver<F, T> {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        let estimate = self.filter.update(tick).estimate().copied();
        self.pilot.tick(tick.encoders(), tick.ranges_m());
        if T::NEEDS_POSE && self.stands(estimate.is_none(), tick.time_s()) {
            return Reply::Command(Twist::default());
        }
        let pose_in_world = estimate.map(|estimate| estimate.pose_in_world).unwrap_or_default();
        let known = Known { filter: &self.filter, pose_in_world, ranges_m: tick.ranges_m() };
        let command = self.task.command(&mut self.pilot, &known);
        estimate.map_or(Reply::Command(command), |estimate| Reply::Both(estimate, command))
    }

    fn is_done(&self) -> bool {
        self.task.is_done()
    }

    fn finish(self) -> Result<(), ClientError> {
        self.task.finish(&self.name, &self.pilot, &self.filter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surroundings::tests::start;
    use rusty_contract::{Estimate, Frame};
    use rusty_geometry::apartment;

    /// Abstains in some ticks.
    struct Gaps(u32);

    impl Filter for Gaps {
        fn update(&mut self, _: &Tick<'_>) -> Reply {
            self.0 += 1;
            let is_known = ![2, 3, 6].contains(&self.0);
            if is_known { Estimate::new(SE2::identity()).into() } else { Reply::Abstain }
        }
    }

    /// Drives on, and counts how often it was relocated.
    struct Onwards<const NEEDS: bool>(u32);

    const ONWARDS: Twist = Twist { v_m_s: 0.2, omega_rad_s: 0.0 };

    impl<const NEEDS: bool> Task<Gaps> for Onwards<NEEDS> {
        const NEEDS_POSE: bool = NEEDS;

        fn command(&mut self, _: &mut Pilot, _: &Known<'_, Gaps>) -> Twist {
            ONWARDS
        }

        fn relocated(&mut self) {
            self.0 += 1;
        }

        fn is_done(&self) -> bool {
            false
        }

        fn finish(self, _: &str, _: &Pilot, _: &Gaps) -> Result<(), ClientError> {
            Ok(())
        }
    }

    /// In which of eight ticks it stands, from 1, and how often it was relocated.
    fn stands<const NEEDS: bool>() -> (Vec<u32>, u32) {
        let told = start(&apartment(), SE2::identity());
        let task = Onwards::<NEEDS>(0);
        let mut driver = Driver::new(&told, &Caution::default(), Gaps(0), task);
        let frame = Frame::boxed();
        let mut stood = Vec::new();
        for tick in 1..=8 {
            let reply = driver.update(&Tick::detached(&frame));
            let command = reply.command().unwrap();
            assert!(command == ONWARDS || command == Twist::default());
            if command == Twist::default() {
                stood.push(tick);
            }
        }
        (stood, driver.task.0)
    }

    #[test]
    fn it_stands_while_its_filter_abstains_if_its_task_needs_a_pose() {
        assert_eq!(stands::<true>(), (vec![2, 3, 6], 2));
        assert_eq!(stands::<false>(), (vec![], 0));
    }
}
