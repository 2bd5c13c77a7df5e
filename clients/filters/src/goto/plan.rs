//! Where to go, and how ways there are found.

use nalgebra::Point2;
use rusty_contract::Start;
use rusty_geometry::{SE2, World};
use thiserror::Error;

use super::{Options, Planner, Waypoint};
use crate::OccupancyMap;
use crate::pilot::{Local, Pilot};
use crate::planning::{Chart, Goal, Kinematics, Room, Unknown, hybrid_a_star};

/// The middles of the Apartment's five rooms, in the order of the doors, m.
const ROOMS: [(f64, f64); 5] = [(5.4, 7.0), (1.8, 7.0), (1.3, 2.0), (4.9, 2.0), (9.6, 4.5)];

/// Room between the walls' bounds and the end of the grid, m.
const BORDER_M: f64 = 0.1;

/// The most cells of a plan: ways over more take long, and memory.
const MOST_CELLS: f64 = 4.0 * 1024.0 * 1024.0;

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
    #[error("participant {name:?}: invalid map: {why}")]
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
    /// No way leads from where it starts.
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
    /// A heading is asked for, and ways have none.
    #[error(
        "{name:?}: waypoint {number} has a heading, which only curves have: add \
         --planner hybrid-a-star, or leave out the third number"
    )]
    NeedsCurve {
        /// Who.
        name: String,
        /// Which, from 1.
        number: usize,
    },
    /// A curve is to be followed by what does not reverse.
    #[error(
        "{0:?}: curves are followed by pure pursuit: leave out --local dwa, or \
         --planner hybrid-a-star"
    )]
    CurveByWindow(String),
    /// A place can be reached, but not by a curve.
    #[error(
        "waypoint {number} ({x_m}, {y_m}): no curve with a turning radius of {radius_m} m was \
         found from the one before: give a smaller --turning-radius-m, or another --waypoint"
    )]
    NoCurve {
        /// Which, from 1.
        number: usize,
        /// m.
        x_m: f64,
        /// m.
        y_m: f64,
        /// Turning radius, m.
        radius_m: f64,
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
pub(super) struct Plan {
    chart: Chart,
    pub(super) waypoints: Vec<Waypoint>,
    /// What a curve may be like, where ways are curves.
    kinematics: Option<Kinematics>,
}

impl Plan {
    pub(super) fn new(start: &Start, options: &Options) -> Result<Self, GotoError> {
        let name = start.name.clone();
        let walls = start.map.clone().ok_or_else(|| GotoError::NoMap(name.clone()))?;
        let pose = start.initial_pose.ok_or_else(|| GotoError::NoPose(name.clone()))?;
        let world = World::new(walls)
            .map_err(|e| GotoError::BadMap { name: name.clone(), why: e.to_string() })?;
        let waypoint = |(x_m, y_m)| Waypoint { x_m, y_m, heading_rad: None };
        let waypoints: Vec<Waypoint> = match options.waypoints.as_slice() {
            [] if world.name() == "apartment" => {
                let home = (pose.x(), pose.y());
                ROOMS.into_iter().chain([home]).map(waypoint).collect()
            }
            [] => return Err(GotoError::NoTour { name, world: world.name().to_owned() }),
            given => given.to_vec(),
        };
        let kinematics = kinematics(&name, options, &waypoints)?;
        let chart = chart(&name, &world, start, options)?;
        let plan = Self { chart, waypoints, kinematics };
        plan.check(&name, pose)?;
        Ok(plan)
    }

    /// Whether each waypoint can be reached from the one before.
    fn check(&self, name: &str, mut pose: SE2) -> Result<(), GotoError> {
        let (mut from, needed_m) = (Point2::from(pose.translation()), self.chart.room.needed_m);
        if self.chart.routes_from(from).is_none() {
            let (name, x_m, y_m) = (name.to_owned(), from.x, from.y);
            return Err(GotoError::HemmedIn { name, x_m, y_m, needed_m });
        }
        for (k, to) in self.waypoints.iter().enumerate() {
            let (number, x_m, y_m) = (k + 1, to.x_m, to.y_m);
            if self.chart.way(from, to.point()).is_none() {
                return Err(GotoError::Unreachable { number, x_m, y_m, needed_m });
            }
            if let Some(kinematics) = &self.kinematics {
                let curve = hybrid_a_star(&self.chart, &pose, &to.goal(), kinematics);
                let radius_m = kinematics.radius_m;
                pose = curve.ok_or(GotoError::NoCurve { number, x_m, y_m, radius_m })?.end();
            }
            from = to.point();
        }
        Ok(())
    }

    /// Sends the pilot to a waypoint. A curve that is planned `again` leads round what the
    /// robot has seen besides the walls of the plan. Where no curve does, the obstacle may
    /// have moved on by the time that the robot is there.
    pub(super) fn begin(&self, waypoint: usize, pilot: &mut Pilot, pose: &SE2, again: bool) {
        let to = self.waypoints[waypoint];
        let Some(kinematics) = &self.kinematics else {
            let way = self.chart.way(Point2::from(pose.translation()), to.point());
            return pilot.follow(way.unwrap_or_default());
        };
        let curve = |chart: &Chart| hybrid_a_star(chart, pose, &to.goal(), kinematics);
        let seen = pilot.around().points().iter().map(|point| pose.transform_point(point));
        let round = if again { curve(&self.chart.with_obstacles(seen)) } else { None };
        match round.or_else(|| curve(&self.chart)) {
            Some(curve) => pilot.follow_curve(&curve, kinematics.radius_m),
            None => pilot.follow(Vec::new()),
        }
    }
}

impl Waypoint {
    fn point(&self) -> Point2<f64> {
        Point2::new(self.x_m, self.y_m)
    }

    fn goal(&self) -> Goal {
        Goal { point: self.point(), heading_rad: self.heading_rad }
    }
}

/// What a curve may be like, where ways are curves.
fn kinematics(
    name: &str,
    options: &Options,
    waypoints: &[Waypoint],
) -> Result<Option<Kinematics>, GotoError> {
    if options.planner == Planner::HybridAStar {
        if options.local == Local::Dwa {
            return Err(GotoError::CurveByWindow(name.to_owned()));
        }
        let turning = options.turning;
        return Ok(Some(Kinematics {
            radius_m: turning.turning_radius_m,
            reverse: turning.reverse_cost,
            switch_m: turning.switch_cost_m,
        }));
    }
    match waypoints.iter().position(|waypoint| waypoint.heading_rad.is_some()) {
        Some(k) => Err(GotoError::NeedsCurve { name: name.to_owned(), number: k + 1 }),
        None => Ok(None),
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
