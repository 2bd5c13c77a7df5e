//! A driver without a map that makes one: always to the nearest place where what
//! it knows ends.
//!
//! Source: B. Yamauchi, *A frontier-based approach for autonomous exploration*
//! (IEEE CIRA 1997). The map is an occupancy grid ([`crate::occupancy_grid`]) from
//! the poses of [`crate::slam`], drawn anew where a loop moves them
//! ([`crate::graph_map`]); [`crate::frontiers`]
//! finds the edges of what is known; the way to the nearest is found over free
//! cells and followed like any other ([`crate::planning`], [`crate::pilot`]).
//!
//! Departures, and why:
//! * *Nearest* is by what the way costs, not by its length: a frontier behind a
//!   narrow door is farther off than one as far away in the open.
//! * A frontier is given up for another as soon as it is none any more: a laser
//!   sees most of a room from its door.
//! * Yamauchi's robot stops at a frontier to look around; a laser with a full
//!   circle need not.
//! * A beam that met nothing is believed where its neighbours met nothing either:
//!   lasers lose beams.
//! * What lies within half a metre of a frontier that the robot has been as near to
//!   as it can get, or that it could not get to, is left out from then on, as Yamauchi
//!   leaves out what was not reached. Where none is left, the map is done.

use std::path::PathBuf;

use clap::Args;
use nalgebra::Point2;
use rusty_clients::ClientError;
use rusty_contract::{Start, errln};
use rusty_geometry::{SE2, Twist};

use crate::beams::believed_lidar;
use crate::driver::{Driver, Known, Task};
use crate::frontiers::{Frontier, frontiers};
use crate::graph_map::GraphMap;
use crate::numbers::positive;
use crate::occupancy_grid::{GridError, InverseModel};
use crate::pilot::{Pilot, Progress};
use crate::planning::{Chart, Room, Routes, Unknown};
use crate::scan_match::ScanMatchOptions;
use crate::slam::{Slam, SlamOptions};
use crate::surroundings::Caution;
use crate::{Beams, Cell, OccupancyGrid, OccupancyMap, OdometryNoise};

/// Scans in the map before anything is concluded from it.
const FIRST_SCANS: u32 = 10;

/// The map is looked at again so often, s.
const LOOK_S: f64 = 1.0;

/// It has arrived when it is this near, m.
const WITHIN_M: f64 = 0.2;

/// A frontier is as good as reached from a place this near, m.
const NEAR_M: f64 = 0.6;

/// What is this near to a place that was tried is left out, m.
const TRIED_M: f64 = 0.5;

/// A map without ways is done when it was looked at so often in a row: one bad
/// scan can shut the robot in.
const LAST_LOOKS: u32 = 3;

/// Explore an unknown world by its frontiers
///
/// The driver maps what its laser sees and drives to the nearest frontier of the
/// map, until no reachable frontier is left (Yamauchi 1997). It localises like `slam`,
/// with loops that correct its map, and does not use the map of the scenario. The
/// scenario needs a script of kind "driver"; the role is driver. With --save it
/// writes its map at the end. The noise of the wheels is learned as in `slam`.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Save the map as STEM.pgm and STEM.yaml
    #[arg(long, value_name = "STEM")]
    pub save: Option<PathBuf>,

    /// End the run when no frontier is left
    #[arg(long)]
    pub end: bool,

    /// Minimum size of a frontier, m
    #[arg(long, value_name = "METRES", default_value_t = 0.3, value_parser = positive)]
    pub frontier_m: f64,

    /// Preferred distance from walls, m
    #[arg(long, value_name = "METRES", default_value_t = 0.4, value_parser = positive)]
    pub liked_m: f64,

    /// How careful it is.
    #[command(flatten)]
    pub caution: Caution,

    /// What is believed of a reading
    #[command(flatten)]
    pub model: InverseModel,

    /// The wheels.
    #[command(flatten)]
    pub wheels: OdometryNoise,
}

crate::numbers::default_of_command_line!(Options);

/// Drives to where its map ends.
#[derive(Debug)]
pub struct Explore {
    options: Options,
    room: Room,
    map: GraphMap,
    /// Place on the edge of the known that it is on its way to.
    target: Option<Point2<f64>>,
    /// Places that were tried.
    tried: Vec<Point2<f64>>,
    dt_s: f64,
    since_look: u64,
    /// How often in a row there was no way to anywhere.
    in_vain: u32,
    done_at: Option<u64>,
    /// Frontiers that are left, none of which it can get any nearer to.
    left: usize,
    /// What the map could not take in first.
    problem: Option<ClientError>,
}

/// Makes a driver that explores, with nothing known.
pub fn driver(start: &Start, options: Options) -> Driver<Slam, Explore> {
    let front = ScanMatchOptions { wheels: options.wheels, ..ScanMatchOptions::default() };
    let slam = SlamOptions { front, model: options.model, ..SlamOptions::default() };
    let (filter, caution) = (Slam::new(start, &slam), options.caution);
    let task = Explore {
        room: Room::on_cells(start, &caution, options.liked_m, options.model.cell_m),
        map: GraphMap::new(options.model, Beams::new(&believed_lidar(start))),
        options,
        target: None,
        tried: Vec::new(),
        dt_s: start.dt_s,
        since_look: 0,
        in_vain: 0,
        done_at: None,
        left: 0,
        problem: None,
    };
    Driver::new(start, &caution, filter, task)
}

impl Explore {
    /// Looks at the map: on to the old target, to a new one, or done.
    fn look(&mut self, pilot: &mut Pilot, pose: &SE2) {
        let map = by_the_prior(self.map.grid());
        let least_cells = (self.options.frontier_m / map.frame.cell_m).ceil() as usize;
        let edges = frontiers(&map, least_cells.max(1));
        let here = Point2::from(pose.translation());
        let chart = Chart::new(&map, Unknown::Shut, self.room);
        let Some(routes) = chart.routes_from(here) else {
            return self.without_ways(pilot, edges.len());
        };
        let fresh = edges.iter().map(|f| self.fresh(&map, f));
        let goals = fresh.filter_map(|cells| goal(&cells, &map, &routes));
        let kept = self.target.filter(|target| {
            let near = |cell: &usize| (map.frame.centre(*cell) - target).norm() < TRIED_M;
            edges.iter().any(|f| f.cells.iter().any(near))
        });
        // The old one first: who turns back each time that something else is a
        // little nearer gets nowhere.
        let best = goals.min_by(|a, b| {
            let order = |g: &Goal| (kept.is_some_and(|t| (t - g.edge).norm() > TRIED_M), g.cost);
            let (a, b) = (order(a), order(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        match best {
            Some(goal) => {
                self.in_vain = 0;
                let corners = chart.corners(&routes, goal.cell);
                match self.target {
                    Some(_) => pilot.follow_on(corners),
                    None => pilot.follow(corners),
                }
                self.target = Some(goal.edge);
            }
            None => self.without_ways(pilot, edges.len()),
        }
    }

    /// The cells of a frontier that are away from all places that were tried.
    fn fresh(&self, map: &OccupancyMap, frontier: &Frontier) -> Vec<usize> {
        let fresh = |cell: &usize| {
            let at = map.frame.centre(*cell);
            self.tried.iter().all(|tried| (at - tried).norm() > TRIED_M)
        };
        frontier.cells.iter().copied().filter(fresh).collect()
    }

    fn without_ways(&mut self, pilot: &mut Pilot, left: usize) {
        pilot.follow(Vec::new());
        (self.target, self.left) = (None, left);
        self.in_vain += 1;
        if self.in_vain >= LAST_LOOKS {
            self.done_at = Some(pilot.around().tick_count());
        }
    }

    /// Takes the scan of a tick into the map, if there is one, and returns whether the map
    /// was drawn anew.
    fn take_in(&mut self, pilot: &Pilot, known: &Known<'_, Slam>) -> bool {
        let Some(ranges_m) = known.ranges_m else { return false };
        let ranges_m = believed(ranges_m, self.map.beams().range_max_m);
        let keys = known.filter.key_poses();
        let redrawn = self.map.follow(keys).and_then(|redrawn| {
            self.map.add(keys, &known.pose_in_world, ranges_m)?;
            Ok(redrawn)
        });
        redrawn.unwrap_or_else(|e| {
            self.refused(pilot, e);
            false
        })
    }

    /// The map stays as it was, and the end of the run reports why.
    fn refused(&mut self, pilot: &Pilot, why: GridError) {
        let time_s = pilot.around().tick_count() as f64 * self.dt_s;
        let text = format!("{time_s:.2} s: {why}");
        self.problem.get_or_insert(ClientError::Unusable(text));
    }

    /// The map as it is now.
    pub fn map(&self) -> OccupancyMap {
        self.map.grid().to_map()
    }

    /// In which tick no frontier was left, from 1.
    pub fn done_at(&self) -> Option<u64> {
        self.done_at
    }
}

/// Ranges without the beams that alone among their neighbours met nothing: a
/// beam that was lost would clear a way through walls that are not in the map yet,
/// and make frontiers out of doors.
fn believed(ranges_m: &[f64], range_max_m: f64) -> Vec<f64> {
    let count = ranges_m.len();
    let is_lost = |k: usize| ranges_m[k % count] >= range_max_m;
    let believed = |k: usize| match is_lost(k) && !(is_lost(k + 1) && is_lost(k + count - 1)) {
        true => f64::NAN,
        false => ranges_m[k],
    };
    (0..count).map(believed).collect()
}

/// A cell is unknown as long as all that readings said of it is nothing, and
/// otherwise what is more likely: Yamauchi's classes. The map that is written
/// asks for more certainty, and between it and the walls there would be a seam of
/// cells that never become certain.
fn by_the_prior(grid: &OccupancyGrid) -> OccupancyMap {
    let cell = |cell: usize| match grid.log_odds(cell) {
        odds if odds > 0.0 => Cell::Occupied,
        odds if odds < 0.0 => Cell::Free,
        _ => Cell::Unknown,
    };
    let frame = *grid.frame();
    OccupancyMap { frame, cells: (0..frame.cells()).map(cell).collect() }
}

/// A place from which a frontier is reached.
struct Goal {
    /// What the way there costs.
    cost: f64,
    /// The place.
    cell: usize,
    /// The point of the frontier nearest to it.
    edge: Point2<f64>,
}

/// The cheapest place near these cells of a frontier; `None` if there is none.
fn goal(edges: &[usize], map: &OccupancyMap, routes: &Routes) -> Option<Goal> {
    let frame = map.frame;
    let reach = (NEAR_M / frame.cell_m).ceil() as i64;
    let mut best: Option<Goal> = None;
    // Every cell of a large frontier, with all around it, would be many.
    for &edge in edges.iter().step_by(1 + edges.len() / 40) {
        let at = frame.centre(edge);
        for near in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            let Some(cell) = frame.beside(edge, near) else { continue };
            let off_m = (frame.centre(cell) - at).norm();
            if off_m > NEAR_M {
                continue;
            }
            // To be nearer is worth what it takes to get there.
            let cost = routes.cost(cell) + 2.0 * off_m;
            if best.as_ref().is_none_or(|b| cost < b.cost) && cost.is_finite() {
                best = Some(Goal { cost, cell, edge: at });
            }
        }
    }
    best
}

impl Task<Slam> for Explore {
    fn command(&mut self, pilot: &mut Pilot, known: &Known<'_, Slam>) -> Twist {
        let pose = &known.pose_in_world;
        let is_redrawn = self.take_in(pilot, known);
        if self.done_at.is_some() || self.map.grid().scans() < FIRST_SCANS {
            return Twist::default();
        }
        self.since_look += 1;
        let (command, progress) = pilot.command(pose, WITHIN_M);
        match (progress, self.target) {
            (Progress::Arrived | Progress::Stuck, Some(target)) => {
                self.tried.push(target);
                self.target = None;
            }
            (Progress::NoWay, _) => self.target = None,
            _ => {}
        }
        let look_ticks = (LOOK_S / self.dt_s).ceil() as u64;
        let is_due = is_redrawn || self.target.is_none() || self.since_look >= look_ticks;
        if known.ranges_m.is_some() && is_due {
            self.look(pilot, pose);
            self.since_look = 0;
        }
        command
    }

    fn is_done(&self) -> bool {
        self.options.end && self.done_at.is_some()
    }

    /// Writes the map, and prints a summary.
    fn finish(self, name: &str, pilot: &Pilot, filter: &Slam) -> Result<(), ClientError> {
        let map = self.map();
        let free = map.cells.iter().filter(|cell| **cell == Cell::Free).count();
        let area_m2 = free as f64 * map.frame.cell_m * map.frame.cell_m;
        let (when, remark) = (pilot.when(self.done_at), pilot.around().remark());
        let left = self.left;
        let loops = filter.loops();
        errln!(
            "{name}: {when}, {area_m2:.1} m² free, {loops} loops, {left} edges that cannot be \
             reached{remark}"
        );
        // An older map is better than none.
        if let Some(stem) = self.options.save.filter(|_| self.map.grid().known().is_some()) {
            map.save(&stem)?;
        }
        self.problem.map_or(Ok(()), Err)
    }
}
