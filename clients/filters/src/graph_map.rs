//! An occupancy grid under a pose graph: scans hang on key poses, and where the graph
//! moves those, the grid is drawn anew.
//!
//! Source: W. Hess, D. Kohler, H. Rapp, D. Andor, *Real-time loop closure in 2D LIDAR
//! SLAM* (ICRA 2016), §V: a map is the scans at the poses that the optimisation gives
//! them.
//!
//! Departures: there are no submaps that are drawn once and moved as a whole, because a
//! grid of whole cells has one orientation; all scans are drawn again, as soon as a key
//! pose has moved by more than half a cell, or turned by more than 0.005 rad. The
//! scans before the first key pose hang on the world.
//!
//! How much it holds: every scan, 8 bytes for each beam: with 180 beams ten times per
//! second 52 MB an hour, of which each drawing takes about two seconds.

use rusty_geometry::{SE2, wrap_angle};

use crate::Beams;
use crate::occupancy_grid::{GridError, InverseModel, OccupancyGrid};

/// A key pose that turned by more moves the end of a beam of 5 m by half a cell of 5 cm.
const TURNED_RAD: f64 = 0.005;

/// A scan, and where it was taken.
#[derive(Clone, Debug)]
struct Hung {
    /// Number of its key pose; without one, its pose is in the world frame.
    key: Option<usize>,
    key_from_robot: SE2,
    ranges_m: Vec<f64>,
}

/// A grid that follows the key poses of a graph.
#[derive(Clone, Debug)]
pub struct GraphMap {
    model: InverseModel,
    beams: Beams,
    grid: OccupancyGrid,
    scans: Vec<Hung>,
    /// The key poses with which the grid was drawn, world frame.
    drawn: Vec<SE2>,
}

impl GraphMap {
    /// Before the first scan.
    pub fn new(model: InverseModel, beams: Beams) -> Self {
        let grid = OccupancyGrid::new(model);
        Self { model, beams, grid, scans: Vec::new(), drawn: Vec::new() }
    }

    /// The grid.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// The laser.
    pub fn beams(&self) -> &Beams {
        &self.beams
    }

    /// Takes in a scan (m, one a beam) from a pose in the world frame, which belongs to
    /// the newest of the key poses.
    ///
    /// # Errors
    /// [`GridError`]; the map is then what it was before.
    pub fn add(&mut self, keys: &[SE2], pose: &SE2, ranges_m: Vec<f64>) -> Result<(), GridError> {
        self.grid.add(pose, &ranges_m, &self.beams)?;
        let key = keys.len().checked_sub(1);
        let key_from_robot = key.map_or(*pose, |key| keys[key].inverse() * *pose);
        self.scans.push(Hung { key, key_from_robot, ranges_m });
        self.drawn.extend_from_slice(keys.get(self.drawn.len()..).unwrap_or_default());
        Ok(())
    }

    /// Draws all scans anew where the key poses have moved, and returns whether they
    /// have.
    ///
    /// # Errors
    /// [`GridError`]; the map is then what it was before.
    pub fn follow(&mut self, keys: &[SE2]) -> Result<bool, GridError> {
        if !self.drawn.iter().zip(keys).any(|(drawn, key)| self.has_moved(drawn, key)) {
            return Ok(false);
        }
        let mut grid = OccupancyGrid::new(self.model);
        for scan in &self.scans {
            let world_from_key = scan.key.map_or(SE2::identity(), |key| keys[key]);
            grid.add(&(world_from_key * scan.key_from_robot), &scan.ranges_m, &self.beams)?;
        }
        (self.grid, self.drawn) = (grid, keys.to_vec());
        Ok(true)
    }

    fn has_moved(&self, drawn: &SE2, key: &SE2) -> bool {
        let moved_m = (drawn.translation() - key.translation()).norm();
        let turned_rad = wrap_angle(drawn.theta() - key.theta()).abs();
        moved_m > 0.5 * self.model.cell_m || turned_rad > TURNED_RAD
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beams::believed_lidar;
    use crate::surroundings::tests::{ranges_from, start};
    use rusty_geometry::apartment;

    /// Scans from these poses, without noise, on two key poses: where the graph has
    /// them, and where they are.
    fn map_of(poses: &[SE2], keys: [SE2; 2], first_of_second: usize) -> GraphMap {
        let told = start(&apartment(), poses[0]);
        let beams = Beams::new(&believed_lidar(&told));
        let mut map = GraphMap::new(InverseModel::default(), beams);
        for (k, pose) in poses.iter().enumerate() {
            let is_second = k >= first_of_second;
            let keys = &keys[..1 + usize::from(is_second)];
            // What the graph believes: the motion since the key pose is right.
            let true_key = poses[if is_second { first_of_second } else { 0 }];
            let believed = keys[keys.len() - 1] * (true_key.inverse() * *pose);
            map.add(keys, &believed, ranges_from(&told, pose)).unwrap();
        }
        map
    }

    /// How many of the cells of two maps are not the same.
    fn different(a: &GraphMap, b: &GraphMap) -> usize {
        let (a, b) = (a.grid().to_map(), b.grid().to_map());
        let cells =
            (0..a.frame.cells()).filter(|cell| a.cells[*cell] != b.at(a.frame.centre(*cell)));
        cells.count()
    }

    #[test]
    fn a_map_whose_keys_are_put_right_is_the_map_of_right_keys() {
        let poses: Vec<SE2> =
            (0..8).map(|k| SE2::new(4.0 + 0.3 * f64::from(k), 4.5, 0.1 * f64::from(k))).collect();
        // Walls on the edges of cells would fall to either side by a rounding.
        let turned = SE2::new(0.013, 0.021, 0.1);
        let right = [turned * poses[0], turned * poses[4]];
        let wrong = [right[0], right[1] * SE2::new(0.2, 0.1, 0.05)];
        let (mut map, of_right) = (map_of(&poses, wrong, 4), map_of(&poses, right, 4));
        assert!(different(&map, &of_right) > 300, "{}", different(&map, &of_right));
        assert_eq!(map.follow(&wrong), Ok(false));
        assert_eq!(map.follow(&right), Ok(true));
        // The same poses but for roundings.
        assert!(different(&map, &of_right) < 5, "{}", different(&map, &of_right));
        assert_eq!(map.follow(&right), Ok(false));
    }

    #[test]
    fn little_moves_are_not_drawn_and_all_together_are() {
        let poses = [SE2::new(4.0, 4.5, 0.0), SE2::new(4.5, 4.5, 0.0)];
        let mut map = map_of(&poses, poses, 1);
        let moved = |by_m: f64| [poses[0], poses[1] * SE2::new(by_m, 0.0, 0.0)];
        assert_eq!(map.follow(&moved(0.02)), Ok(false));
        assert_eq!(map.follow(&moved(0.04)), Ok(true));
        assert_eq!(map.follow(&moved(0.05)), Ok(false));
    }

    #[test]
    fn scans_before_the_first_key_pose_stay_where_they_are() {
        let pose = SE2::new(4.0, 4.5, 0.0);
        let mut map = map_of(&[pose; 5], [pose, pose], 5);
        let before = map.clone();
        let mut early = GraphMap::new(InverseModel::default(), map.beams().clone());
        for scan in &map.scans {
            early.add(&[], &pose, scan.ranges_m.clone()).unwrap();
        }
        assert_eq!(different(&early, &before), 0);
        let far = SE2::new(9.0, 4.5, 0.0);
        map.follow(&[far]).unwrap();
        assert!(different(&map, &before) > 300);
        assert_eq!(early.follow(&[far]), Ok(false));
    }
}
