//! Readings of a laser, compared with what a map predicts.

use nalgebra::Point2;
use rusty_geometry::{SE2, Scan, World};

use crate::ray_walk::RayWalk;
use crate::{Beams, Cell, OccupancyMap};

/// A range, and what the map promises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// What was read, m; z_max where nothing came back.
    pub range_m: f64,
    /// z*: how far the map's first wall is in that direction, m; z_max where it
    /// has none.
    pub expected_m: f64,
}

/// Many of them, of one laser.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// z_max, m.
    pub range_max_m: f64,
    /// All of them.
    pub all: Vec<Reading>,
}

/// Says what a map promises.
pub enum Expected {
    /// A floor plan, exactly.
    Plan {
        /// The walls.
        world: Box<World>,
        /// The beams.
        scan: Box<Scan>,
        /// What they would read, m.
        distances_m: Vec<f64>,
    },
    /// A map of cells, as exactly as these are large.
    Cells(OccupancyMap),
}

impl Expected {
    /// Adds to `readings` the ranges (m, one a beam) read from the pose `robot`.
    /// Left out are ranges that are no numbers or below 0, and beams about which
    /// the map says nothing: they go through cells that are unknown.
    pub fn add(&mut self, readings: &mut Readings, robot: &SE2, ranges_m: &[f64], beams: &Beams) {
        if !robot.is_finite() {
            return;
        }
        let sensor = robot.compose(&beams.sensor_in_body);
        if let Self::Plan { world, scan, distances_m } = self {
            scan.take(world, &sensor, beams.range_max_m);
            scan.write_distances_m(distances_m);
        }
        for (k, &range_m) in ranges_m.iter().take(beams.count()).enumerate() {
            if range_m.is_nan() || range_m < 0.0 {
                continue;
            }
            let expected_m = match self {
                Self::Plan { distances_m, .. } => Some(distances_m[k]),
                Self::Cells(map) => first_wall_m(map, &sensor, k, beams),
            };
            if let Some(expected_m) = expected_m {
                let range_m = range_m.min(beams.range_max_m);
                readings.all.push(Reading { range_m, expected_m });
            }
        }
    }
}

/// How far it is to the middle of what beam `k` sees of the first occupied cell,
/// m; z_max if there is none, `None` if there may be.
fn first_wall_m(map: &OccupancyMap, sensor: &SE2, k: usize, beams: &Beams) -> Option<f64> {
    let eye = Point2::from(sensor.translation());
    let end = sensor.transform_point(&Point2::from(beams.direction(k) * beams.range_max_m));
    for crossing in RayWalk::new(&map.frame, eye, end) {
        match map.cells[map.frame.index(crossing.column, crossing.row)?] {
            Cell::Free => {}
            Cell::Unknown => return None,
            Cell::Occupied => {
                return Some(0.5 * (crossing.enters + crossing.leaves) * beams.range_max_m);
            }
        }
    }
    Some(beams.range_max_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::LidarConfig;
    use rusty_geometry::apartment;

    #[test]
    fn a_plan_and_its_cells_promise_the_same() {
        let (lidar, world) = (LidarConfig::default(), apartment());
        let beams = Beams::new(&lidar);
        let map = OccupancyMap::of_world(&world, 0.2, 0.02);
        let scan = Box::new(Scan::new(lidar.fan()));
        let mut plan =
            Expected::Plan { world: Box::new(world), scan, distances_m: vec![0.0; beams.count()] };
        let robot = SE2::new(6.0, 4.5, 0.3);
        let ranges_m = vec![1.0; 180];
        let read = |expected: &mut Expected| {
            let mut readings = Readings { range_max_m: 8.0, all: Vec::new() };
            expected.add(&mut readings, &robot, &ranges_m, &beams);
            readings.all
        };
        let (exact, coarse) = (read(&mut plan), read(&mut Expected::Cells(map)));
        assert_eq!((exact.len(), coarse.len()), (180, 180));
        let near =
            exact.iter().zip(&coarse).filter(|(a, b)| (a.expected_m - b.expected_m).abs() < 0.05);
        // Along a wall, or past a corner, a cell makes more of a difference.
        assert!(near.count() > 160);
    }

    #[test]
    fn nothing_is_said_of_what_nobody_knows() {
        let lidar = LidarConfig { beams: 4, ..LidarConfig::default() };
        let beams = Beams::new(&lidar);
        let map = OccupancyMap::unknown(crate::GridFrame::covering([0.0, 0.0, 1.0, 1.0], 0.0, 0.1));
        let mut readings = Readings { range_max_m: 8.0, all: Vec::new() };
        let mut expected = Expected::Cells(map);
        expected.add(&mut readings, &SE2::new(0.5, 0.5, 0.0), &[1.0; 4], &beams);
        expected.add(&mut readings, &SE2::new(f64::NAN, 0.5, 0.0), &[1.0; 4], &beams);
        assert!(readings.all.is_empty());
    }
}
