//! Where a robot can be: for beginning anywhere, and for beginning again.

use core::f64::consts::PI;

use nalgebra::Point2;
use rusty_geometry::{SE2, World};

use super::Particles;
use crate::occupancy::Cell;
use crate::{DistanceField, GridFrame, OccupancyMap, Random};

/// Side of the cells in which a floor plan is looked at, m.
const CELL_M: f64 = 0.05;
/// The most of them.
const MOST_CELLS: usize = 1 << 20;

/// The places at which a body touches nothing.
#[derive(Clone, Debug)]
pub struct FreeSpace {
    frame: GridFrame,
    /// Cells whose centres are clear of everything.
    cells: Vec<u32>,
}

impl FreeSpace {
    /// What lies within the bounds of a plan, and no nearer to a wall than the
    /// body is large.
    pub fn of_world(world: &World, body_radius_m: f64) -> Self {
        let mut frame = GridFrame::covering(world.bounds(), 0.0, CELL_M);
        while frame.cells() > MOST_CELLS {
            frame = GridFrame::covering(world.bounds(), 0.0, 2.0 * frame.cell_m);
        }
        let clear = |cell: &usize| {
            let centre = frame.centre(*cell);
            let [x0, y0, x1, y1] = world.bounds();
            let inside = (x0..=x1).contains(&centre.x) && (y0..=y1).contains(&centre.y);
            inside && world.distance_to_nearest(centre) >= body_radius_m
        };
        Self { frame, cells: (0..frame.cells()).filter(clear).map(|cell| cell as u32).collect() }
    }

    /// The free cells of a map that are no nearer to an occupied one than the
    /// body is large.
    pub fn of_map(map: &OccupancyMap, distances: &DistanceField, body_radius_m: f64) -> Self {
        let clear = |cell: &usize| {
            map.cells[*cell] == Cell::Free
                && f64::from(distances.distances_m[*cell]) >= body_radius_m
        };
        let cells = (0..map.cells.len()).filter(clear).map(|cell| cell as u32).collect();
        Self { frame: map.frame, cells }
    }

    /// Whether there is no such place.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The middle of each of these cells, world frame, m.
    pub fn centres(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.cells.iter().map(|cell| self.frame.centre(*cell as usize))
    }

    /// A pose, all of these places and all headings being equally likely;
    /// `None` where there is no such place.
    pub fn pose(&self, random: &mut Random) -> Option<SE2> {
        let which = (random.uniform() * self.cells.len() as f64) as usize;
        let centre: Point2<f64> = self.frame.centre(*self.cells.get(which)? as usize);
        let mut within = || (random.uniform() - 0.5) * self.frame.cell_m;
        let (x, y) = (centre.x + within(), centre.y + within());
        Some(SE2::new(x, y, PI - 2.0 * PI * random.uniform()))
    }

    /// Adds this many of them to the particles.
    pub fn fill(&self, particles: &mut Particles, count: usize, random: &mut Random) {
        let poses = (0..count).filter_map(|_| self.pose(random));
        poses.for_each(|pose| particles.push(&pose));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_spread_evenly_over_what_is_free() {
        let world = rusty_geometry::apartment();
        let (space, mut random) = (FreeSpace::of_world(&world, 0.11), Random::new(1, 1));
        let (mut quadrants, count) = ([0.0; 4], 20_000);
        for _ in 0..count {
            let pose = space.pose(&mut random).unwrap();
            let at = Point2::from(pose.translation());
            // The corner of a cell is nearer than its centre.
            assert!(world.distance_to_nearest(at) > 0.11 - 0.036, "{pose:?}");
            assert!((0.0..12.0).contains(&at.x) && (0.0..9.0).contains(&at.y));
            quadrants[((pose.theta() + PI) / (0.5 * PI)).min(3.0) as usize] += 1.0;
        }
        assert!(quadrants.iter().all(|q| (q / f64::from(count) - 0.25).abs() < 0.015));
    }

    #[test]
    fn of_a_map_only_what_is_known_to_be_free_counts() {
        let world = rusty_geometry::apartment();
        let mut map = OccupancyMap::of_world(&world, 0.0, 0.1);
        for (cell, known) in map.cells.iter_mut().enumerate() {
            if map.frame.centre(cell).x > 6.0 {
                *known = Cell::Unknown;
            }
        }
        let space = FreeSpace::of_map(&map, &DistanceField::of_map(&map), 0.11);
        let mut random = Random::new(1, 1);
        for _ in 0..1000 {
            let pose = space.pose(&mut random).unwrap();
            assert!(pose.x() < 6.0, "{pose:?}");
        }
        map.cells.fill(Cell::Unknown);
        let none = FreeSpace::of_map(&map, &DistanceField::of_map(&map), 0.11);
        assert!(none.is_empty() && none.pose(&mut random).is_none());
    }
}
