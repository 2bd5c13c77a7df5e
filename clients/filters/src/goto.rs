//! A driver with a floor plan: to one place after the other, by its own estimate
//! of where it is.
//!
//! The plan becomes cells, ways are found over them ([`crate::planning`]) and
//! followed ([`crate::pilot`]). Where the robot is, the filter that it carries
//! says: [`Localiser`]. It never sees the truth, and answers each tick with its
//! estimate and the command for the next.

use std::str::FromStr;

use clap::Args;
use nalgebra::Point2;
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Reply, Start, errln};
use rusty_geometry::{EncoderTicks, SE2, Twist, World};
use thiserror::Error;

use crate::OccupancyMap;
use crate::localiser::Localiser;
use crate::numbers::positive;
use crate::pilot::{Pilot, Progress};
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

/// Where to go, and how.
#[derive(Args, Clone, Debug)]
// Whoever flattens these beside those of a filter has two of this name.
#[group(skip)]
pub struct Options {
    /// A place to go to, m, world frame; give it once for each [default: in the
    /// Apartment the middle of every room, and back to the start]
    #[arg(long = "waypoint", value_name = "X,Y", allow_hyphen_values = true)]
    pub waypoints: Vec<Waypoint>,

    /// It has been at a waypoint when it was this near to it, or to the middle of the
    /// nearest cell with enough room, m
    #[arg(long, value_name = "METRES", default_value_t = 0.15, value_parser = positive)]
    pub within_m: f64,

    /// Distance from walls that it likes to keep, m
    #[arg(long, value_name = "METRES", default_value_t = 0.5, value_parser = positive)]
    pub liked_m: f64,

    /// Side of the cells that ways are found over, m
    #[arg(long, value_name = "METRES", default_value_t = 0.05, value_parser = positive)]
    pub cell_m: f64,

    /// How careful it is.
    #[command(flatten)]
    pub caution: Caution,
}

impl Default for Options {
    fn default() -> Self {
        let caution = Caution::default();
        Self { waypoints: Vec::new(), within_m: 0.15, liked_m: 0.5, cell_m: 0.05, caution }
    }
}

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

/// Goes from place to place.
#[derive(Debug)]
pub struct Goto<L> {
    name: String,
    dt_s: f64,
    localiser: L,
    pilot: Pilot,
    plan: Plan,
    within_m: f64,
    next: usize,
    /// Whether there is a way to the next one, and how often it was planned.
    planned: bool,
    tries: u32,
    missed: usize,
    ticks: u64,
    /// When it was done.
    done_at: Option<u64>,
}

impl<L: Localiser> Goto<L> {
    /// Begins, with a filter that says where it is, which is made when there is
    /// somewhere to go.
    ///
    /// # Errors
    /// [`GotoError`], as text: no map, no pose, nowhere to go, no way there; or the
    /// filter's.
    pub fn new(
        start: &Start,
        options: &Options,
        localiser: impl FnOnce(&Start) -> Result<L, ClientError>,
    ) -> Result<Self, ClientError> {
        let plan = Plan::new(start, options).map_err(|e| ClientError::Unusable(e.to_string()))?;
        Ok(Self {
            name: start.name.clone(),
            dt_s: start.dt_s,
            localiser: localiser(start)?,
            pilot: Pilot::new(start, &options.caution),
            plan,
            within_m: options.within_m,
            next: 0,
            planned: false,
            tries: 0,
            missed: 0,
            ticks: 0,
            done_at: None,
        })
    }

    /// A tick: encoder counts and, if there is one, the scan at its end. The
    /// answer to it.
    pub fn step(&mut self, ticks: EncoderTicks, ranges_m: Option<&[f64]>) -> Reply {
        self.ticks += 1;
        self.localiser.advance(ticks);
        let innovation = ranges_m.and_then(|ranges_m| self.localiser.scan(ranges_m));
        self.pilot.tick(ticks, ranges_m);
        let pose = self.localiser.pose_in_world();
        let command = self.command(&pose);
        Reply::Both(self.localiser.estimate(innovation), command)
    }

    fn command(&mut self, pose: &SE2) -> Twist {
        let Some(to) = self.plan.waypoints.get(self.next).copied() else {
            return Twist::default();
        };
        if !self.planned {
            let way = self.plan.chart.way(Point2::from(pose.translation()), to);
            self.pilot.follow(way.unwrap_or_default());
            (self.planned, self.tries) = (true, self.tries + 1);
        }
        let (command, progress) = self.pilot.command(pose, self.within_m);
        match progress {
            Progress::Under => {}
            Progress::Arrived => self.go_on(),
            Progress::Stuck | Progress::NoWay if self.tries < TRIES => self.planned = false,
            Progress::Stuck | Progress::NoWay => {
                self.missed += 1;
                self.go_on();
            }
        }
        command
    }

    fn go_on(&mut self) {
        (self.next, self.planned, self.tries) = (self.next + 1, false, 0);
        if self.next == self.plan.waypoints.len() {
            self.done_at = Some(self.ticks);
        }
    }

    /// How many waypoints it believes to have been at.
    #[must_use]
    pub fn reached(&self) -> usize {
        self.next - self.missed
    }

    /// In which tick it was done, from 1.
    #[must_use]
    pub fn done_at(&self) -> Option<u64> {
        self.done_at
    }
}

impl<L: Localiser> Filter for Goto<L> {
    const SHOWS_BELIEF: bool = false;

    fn tick(&mut self, tick: &Tick<'_>) -> Reply {
        self.step(tick.ticks(), tick.ranges_m())
    }

    /// Says how far it came.
    fn finish(self) -> Result<(), ClientError> {
        let (reached, all, name) = (self.reached(), self.plan.waypoints.len(), &self.name);
        let (when, ticks) = match self.done_at {
            Some(ticks) => ("done in", ticks),
            None => ("not done in", self.ticks),
        };
        let time_s = ticks as f64 * self.dt_s;
        errln!(
            "{name}: {reached} of {all} waypoints, {when} {ticks} ticks ({time_s:.1} s){}",
            self.pilot.remark()
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OdometryNoise;
    use crate::localiser::Reckoning;
    use crate::surroundings::tests::start;
    use rusty_geometry::{apartment, hallway};

    fn begin(told: &Start, waypoints: &[&str]) -> Result<usize, String> {
        let waypoints = waypoints.iter().map(|w| w.parse().unwrap()).collect();
        let options = Options { waypoints, ..Options::default() };
        let reckoning = |told: &Start| Ok(Reckoning::new(told, OdometryNoise::default()));
        let begun = Goto::new(told, &options, reckoning);
        begun.map(|g| g.plan.waypoints.len()).map_err(|e| e.to_string())
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
        let reckoning = |told: &Start| Ok(Reckoning::new(told, OdometryNoise::default()));
        let why = Goto::new(&told, &options, reckoning).unwrap_err().to_string();
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
