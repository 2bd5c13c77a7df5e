//! A driver with a floor plan, to a list of waypoints.
//!
//! The plan becomes cells, ways are found over them ([`crate::planning`]) and
//! followed ([`crate::pilot`]) by pure pursuit or in the dynamic window. The pose comes from an EKF.

use std::str::FromStr;
use std::sync::Arc;

use clap::Args;
use nalgebra::Point2;
use rusty_clients::ClientError;
use rusty_contract::{Start, errln};
use rusty_geometry::{Twist, World};
use thiserror::Error;

use crate::OccupancyMap;
use crate::driver::{Driver, Known, Task};
use crate::dynamic_window::{Acceleration, DynamicWindow};
use crate::ekf::{self, Ekf};
use crate::numbers::positive;
use crate::pilot::{Local, Pilot, Progress};
use crate::planning::{Chart, Room, Unknown};
use crate::surroundings::Caution;

/// The most cells of a plan: ways over more take long, and memory.
const MOST_CELLS: f64 = 4.0 * 1024.0 * 1024.0;

/// Room between the walls' bounds and the end of the grid, m.
const BORDER_M: f64 = 0.1;

/// So often a way to a waypoint is planned anew before it is given up.
const TRIES: u32 = 5;

/// The middles of the Apartment's five rooms, in the order of the doors, m.
const ROOMS: [(f64, f64); 5] = [(5.4, 7.0), (1.8, 7.0), (1.3, 2.0), (4.9, 2.0), (9.6, 4.5)];

/// A place to go to, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// m.
    pub x_m: f64,
    /// m.
    pub y_m: f64,
}

impl FromStr for Waypoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| word.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        match text.split_once(',').map(|(x, y)| (number(x), number(y))) {
            Some((Some(x_m), Some(y_m))) => Ok(Self { x_m, y_m }),
            _ => Err("give two numbers, x and y in metres: 5.4,7".to_owned()),
        }
    }
}

/// Drive to a list of waypoints on a floor plan
///
/// The driver uses its own pose estimate (an EKF on straight walls, like `ekf`). The
/// default waypoints are the middle of every room of the Apartment and back. It sends
/// no command that could touch, before the next scan, a wall that its laser has hit, and
/// none at all while its EKF abstains.
/// It does not see walls between the beams, and it assumes that commands take effect
/// within the time of one scan. At the end it prints the number of waypoints reached
/// and of ticks used. The scenario needs a script of kind "driver"; the role is driver.
#[derive(Args, Clone, Debug)]
// A program that flattens these next to those of a filter has two of this name.
#[group(skip)]
pub struct Options {
    /// Waypoint in the world frame, m, repeatable
    #[arg(long = "waypoint", value_name = "X,Y", allow_hyphen_values = true)]
    pub waypoints: Vec<Waypoint>,

    /// Distance at which a waypoint counts as reached, m
    #[arg(long, value_name = "METRES", default_value_t = 0.15, value_parser = positive)]
    pub within_m: f64,

    /// Preferred distance from walls, m
    #[arg(long, value_name = "METRES", default_value_t = 0.5, value_parser = positive)]
    pub liked_m: f64,

    /// End the run at the last waypoint
    #[arg(long)]
    pub end: bool,

    /// Side of a cell for path planning, m
    #[arg(long, value_name = "METRES", default_value_t = 0.05, value_parser = positive)]
    pub cell_m: f64,

    /// How a way is followed
    #[arg(long, value_enum, default_value_t = Local::Pursuit)]
    pub local: Local,

    /// How fast it changes its motion.
    #[command(flatten)]
    pub acceleration: Acceleration,

    /// How careful it is.
    #[command(flatten)]
    pub caution: Caution,

    /// The filter.
    #[command(flatten)]
    pub ekf: ekf::Options,
}

crate::numbers::default_of_command_line!(Options);

/// Why it cannot begin.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GotoError {
    /// It is told no walls.
    #[error("{0:?} is given no map to plan on: write map = \"given\" in the scenario")]
    NoMap(String),
    /// It is not told where it starts.
    #[error(
        "{0:?} is not told where it starts, and its filter follows a robot without finding it: \
         write initial_pose = \"given\" in the scenario"
    )]
    NoPose(String),
    /// The walls are not valid.
    #[error("{name:?} is given a map that is none: {why}")]
    BadMap {
        /// Who.
        name: String,
        /// What is wrong with the map.
        why: String,
    },
    /// The plan is too large for its cells.
    #[error(
        "{name:?} would plan on {width_m:.0} m × {height_m:.0} m in cells of {cell_m} m, which are \
         more than 4 million: give it larger ones with --cell-m"
    )]
    TooLarge {
        /// Who.
        name: String,
        /// Extent of the plan along x, m.
        width_m: f64,
        /// Along y, m.
        height_m: f64,
        /// Side of a cell, m.
        cell_m: f64,
    },
    /// There is no way from where it starts.
    #[error(
        "{name:?} starts at ({x_m}, {y_m}), where it has less than {needed_m:.2} m to the walls \
         and no place with more near it: start elsewhere, or give a smaller --margin-m"
    )]
    HemmedIn {
        /// Who.
        name: String,
        /// m.
        x_m: f64,
        /// m.
        y_m: f64,
        /// Room that it needs, m.
        needed_m: f64,
    },
    /// There is nowhere to go.
    #[error("{name:?} knows no tour of {world:?}: give it places with --waypoint X,Y")]
    NoTour {
        /// Who.
        name: String,
        /// Name of the world.
        world: String,
    },
    /// A place cannot be reached.
    #[error(
        "waypoint {number} ({x_m}, {y_m}) cannot be reached from the one before with {needed_m:.2} m \
         to every wall: give another --waypoint, or a smaller --margin-m"
    )]
    Unreachable {
        /// Which, from 1.
        number: usize,
        /// m.
        x_m: f64,
        /// m.
        y_m: f64,
        /// Room that it needs, m.
        needed_m: f64,
    },
}

/// Where to go, and a chart to find the ways on.
#[derive(Debug)]
struct Plan {
    chart: Chart,
    waypoints: Vec<Point2<f64>>,
}

impl Plan {
    fn new(start: &Start, options: &Options) -> Result<Self, GotoError> {
        let name = start.name.clone();
        let walls = start.map.clone().ok_or_else(|| GotoError::NoMap(name.clone()))?;
        let pose = start.initial_pose.ok_or_else(|| GotoError::NoPose(name.clone()))?;
        let world = World::new(walls)
            .map_err(|e| GotoError::BadMap { name: name.clone(), why: e.to_string() })?;
        let home = Point2::from(pose.translation());
        let point = |w: &Waypoint| Point2::new(w.x_m, w.y_m);
        let waypoints: Vec<Point2<f64>> = match options.waypoints.as_slice() {
            [] if world.name() == "apartment" => {
                ROOMS.iter().map(|(x, y)| Point2::new(*x, *y)).chain([home]).collect()
            }
            [] => return Err(GotoError::NoTour { name, world: world.name().to_owned() }),
            given => given.iter().map(point).collect(),
        };
        let chart = chart(&name, &world, start, options)?;
        let needed_m = chart.room.needed_m;
        if chart.routes_from(home).is_none() {
            let (x_m, y_m) = (home.x, home.y);
            return Err(GotoError::HemmedIn { name, x_m, y_m, needed_m });
        }
        let mut from = home;
        for (k, to) in waypoints.iter().enumerate() {
            if chart.way(from, *to).is_none() {
                let number = k + 1;
                return Err(GotoError::Unreachable { number, x_m: to.x, y_m: to.y, needed_m });
            }
            from = *to;
        }
        Ok(Self { chart, waypoints })
    }
}

fn chart(name: &str, world: &World, start: &Start, options: &Options) -> Result<Chart, GotoError> {
    let cell_m = options.cell_m;
    let [x0_m, y0_m, x1_m, y1_m] = world.bounds();
    let [width_m, height_m] = [x1_m - x0_m, y1_m - y0_m].map(|m| m + 2.0 * BORDER_M);
    if (width_m / cell_m) * (height_m / cell_m) > MOST_CELLS {
        let name = name.to_owned();
        return Err(GotoError::TooLarge { name, width_m, height_m, cell_m });
    }
    // A cell's centre is up to half a diagonal from the robot in it.
    let room = Room::on_cells(start, &options.caution, options.liked_m, cell_m);
    let map = OccupancyMap::of_world(world, BORDER_M, cell_m);
    Ok(Chart::new(&map, Unknown::Wall, room))
}

/// A plan, for the next run in which the same is told.
#[derive(Debug)]
pub struct Prepared {
    told: Start,
    plan: Arc<Plan>,
}

/// Goes from place to place.
#[derive(Debug)]
pub struct Goto {
    plan: Arc<Plan>,
    within_m: f64,
    next: usize,
    /// Whether there is a way to the next one, and how often it was planned.
    planned: bool,
    tries: u32,
    missed: usize,
    /// When it was done.
    done_at: Option<u64>,
    /// Whether the run ends then.
    end: bool,
}

/// Makes a driver to waypoints.
///
/// # Errors
/// [`GotoError`], as text: no map, no pose, no waypoint, no way there; or the
/// filter's.
pub fn driver(start: &Start, options: Options) -> Result<Driver<Ekf, Goto>, ClientError> {
    next_driver(start, options, &mut None)
}

/// Makes a driver to waypoints, whose plan takes long to make: that of `prepared` is taken
/// where all is told that was told then, and kept there for the next run. The options are
/// those of then.
///
/// # Errors
/// As [`driver`].
pub fn next_driver(
    start: &Start,
    options: Options,
    prepared: &mut Option<Prepared>,
) -> Result<Driver<Ekf, Goto>, ClientError> {
    let told = start.without_run();
    let plan = match prepared.take().filter(|known| known.told == told) {
        Some(known) => known.plan,
        None => {
            let plan = Plan::new(start, &options);
            Arc::new(plan.map_err(|e| ClientError::Unusable(e.to_string()))?)
        }
    };
    *prepared = Some(Prepared { told, plan: Arc::clone(&plan) });
    let (within_m, end) = (options.within_m, options.end);
    let done_at = None;
    let task = Goto { plan, within_m, next: 0, planned: false, tries: 0, missed: 0, done_at, end };
    let mut driver = Driver::new(start, &options.caution, Ekf::new(start, &options.ekf)?, task);
    if options.local == Local::Dwa {
        driver.pilot.use_window(DynamicWindow::new(options.acceleration));
    }
    Ok(driver)
}

impl Goto {
    fn go_on(&mut self, ticks: u64) {
        (self.next, self.planned, self.tries) = (self.next + 1, false, 0);
        if self.next == self.plan.waypoints.len() {
            self.done_at = Some(ticks);
        }
    }

    /// How many waypoints it believes to have been at.
    pub fn reached(&self) -> usize {
        self.next - self.missed
    }

    /// In which tick it was done, from 1.
    pub fn done_at(&self) -> Option<u64> {
        self.done_at
    }
}

impl Task<Ekf> for Goto {
    const NEEDS_POSE: bool = true;

    fn command(&mut self, pilot: &mut Pilot, known: &Known<'_, Ekf>) -> Twist {
        let pose = &known.pose_in_world;
        let Some(to) = self.plan.waypoints.get(self.next).copied() else {
            return Twist::default();
        };
        if !self.planned {
            let way = self.plan.chart.way(Point2::from(pose.translation()), to);
            pilot.follow(way.unwrap_or_default());
            (self.planned, self.tries) = (true, self.tries + 1);
        }
        let (command, progress) = pilot.command(pose, self.within_m);
        match progress {
            Progress::Under => {}
            Progress::Arrived => self.go_on(pilot.around().tick_count()),
            Progress::Stuck | Progress::NoWay if self.tries < TRIES => self.planned = false,
            Progress::Stuck | Progress::NoWay => {
                self.missed += 1;
                self.go_on(pilot.around().tick_count());
            }
        }
        command
    }

    /// Plans anew from where it turned out to be; the way before does not count as a try.
    fn relocated(&mut self) {
        (self.planned, self.tries) = (false, self.tries.saturating_sub(1));
    }

    fn is_done(&self) -> bool {
        self.end && self.done_at.is_some()
    }

    /// Prints how many waypoints were reached.
    fn finish(self, name: &str, pilot: &Pilot, _: &Ekf) -> Result<(), ClientError> {
        let (reached, all) = (self.reached(), self.plan.waypoints.len());
        let (when, remark) = (pilot.when(self.done_at), pilot.around().remark());
        errln!("{name}: {reached} of {all} waypoints, {when}{remark}");
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surroundings::tests::start;
    use rusty_geometry::{SE2, apartment, hallway};

    fn begin(told: &Start, waypoints: &[&str]) -> Result<usize, String> {
        let waypoints = waypoints.iter().map(|w| w.parse().unwrap()).collect();
        let options = Options { waypoints, ..Options::default() };
        let begun = driver(told, options);
        begun.map(|driver| driver.task.plan.waypoints.len()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_plan_serves_the_next_run_in_which_the_same_is_told() {
        let mut prepared = None;
        let mut plan =
            |told: &Start| next_driver(told, Options::default(), &mut prepared).unwrap().task.plan;
        let told = start(&apartment(), SE2::new(6.0, 4.5, 0.0));
        let first = plan(&told);
        let next = plan(&Start { run_id: 9, run_number: 1, ticket: 3, ..told });
        assert!(Arc::ptr_eq(&first, &next));
        let elsewhere = plan(&start(&apartment(), SE2::new(6.0, 4.6, 0.0)));
        assert!(!Arc::ptr_eq(&first, &elsewhere));
        assert_ne!(first.waypoints, elsewhere.waypoints);
    }

    #[test]
    fn who_cannot_begin_says_why() {
        let told = start(&apartment(), SE2::new(6.0, 4.5, 0.0));
        assert_eq!(begin(&told, &[]), Ok(6));
        assert_eq!(begin(&told, &["9.6,4.5", "1, 7"]), Ok(2));
        let why = begin(&told, &["9.6,4.5", "3.2,8.7"]).unwrap_err();
        assert!(why.starts_with("waypoint 2 (3.2, 8.7) cannot be reached"), "{why}");
        let why = begin(&Start { map: None, ..told.clone() }, &[]).unwrap_err();
        assert!(why.contains("no map") && why.contains("map = \"given\""), "{why}");
        let why = begin(&Start { initial_pose: None, ..told.clone() }, &[]).unwrap_err();
        assert!(why.contains("initial_pose = \"given\""), "{why}");
        let why = begin(&start(&hallway(), SE2::new(1.0, 0.8, 0.0)), &[]).unwrap_err();
        assert!(why.contains("no tour of \"hallway\"") && why.contains("--waypoint"), "{why}");
        let options = Options { cell_m: 0.001, ..Options::default() };
        let why = driver(&told, options).unwrap_err().to_string();
        assert!(
            why.contains("12 m × 9 m in cells of 0.001 m") && why.contains("--cell-m"),
            "{why}"
        );
        let why = begin(&start(&apartment(), SE2::new(-5.0, 4.5, 0.0)), &[]).unwrap_err();
        assert!(why.contains("starts at (-5, 4.5)"), "{why}");
        for text in ["5", "a,b", "1,nan", "1,2,3"] {
            assert!(text.parse::<Waypoint>().is_err(), "{text}");
        }
    }
}
