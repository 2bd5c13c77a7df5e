//! Ends that other scans looked through: people who walked on, beams that ended in the air.
//!
//! Source: D. Hähnel, R. Triebel, W. Burgard, S. Thrun, *Map building with mobile robots in
//! dynamic environments*, ICRA 2003: beams that ended where others passed are left out of
//! the map.
//!
//! Departure: they count in the cells of a grid, and iterate; here each end asks once the
//! beams of the other scans that look at it.

use nalgebra::Point2;
use rusty_geometry::SE2;

use crate::icp::{Laser, Ray};

/// A beam that ends this much farther looked through an end, m.
const BEYOND_M: f64 = 0.3;
/// Ends no farther apart are on the same wall, m.
const SAME_M: f64 = 0.15;
/// An end counts if no more scans looked through it than saw a wall there, and this many.
const DOUBTED: usize = 1;

/// The scans with those of their rays whose ends the other scans do not refute.
pub(super) fn unrefuted(laser: &Laser, scans: &[(SE2, &[Ray])]) -> Vec<(SE2, Vec<Ray>)> {
    let all: Vec<ByBeam<'_>> = scans.iter().map(|scan| ByBeam::new(laser, scan)).collect();
    let counts = |k: usize, end: &Point2<f64>| {
        let others = all.iter().enumerate().filter(|(other, _)| *other != k);
        let (mut through, mut walls) = (0, 0);
        for (_, other) in others {
            match other.says(laser, end) {
                Says::Through => through += 1,
                Says::Wall => walls += 1,
                Says::Nothing => {}
            }
        }
        through <= walls + DOUBTED
    };
    let kept = |(k, (pose, rays)): (usize, &(SE2, &[Ray]))| {
        let rays = rays.iter().filter(|ray| counts(k, &pose.transform_point(&ray.point)));
        (*pose, rays.copied().collect())
    };
    scans.iter().enumerate().map(kept).collect()
}

/// What a scan says of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Says {
    Wall,
    /// No wall, but one behind it.
    Through,
    Nothing,
}

/// A scan in the order of all beams of its laser.
struct ByBeam<'a> {
    body_from_map: SE2,
    rays: Vec<Option<&'a Ray>>,
}

impl<'a> ByBeam<'a> {
    fn new(laser: &Laser, (pose, met): &(SE2, &'a [Ray])) -> Self {
        let mut rays = vec![None; laser.beams()];
        met.iter().for_each(|ray| rays[ray.beam] = Some(ray));
        Self { body_from_map: pose.inverse(), rays }
    }

    /// What it says of a place in the frame of the map.
    fn says(&self, laser: &Laser, place: &Point2<f64>) -> Says {
        let here = self.body_from_map.transform_point(place);
        let through_m = laser.distance_m(&here) + BEYOND_M;
        let mut says = Says::Nothing;
        let mut all_beyond = true;
        for ray in laser.beams_towards(&here).filter_map(|beam| self.rays[beam]) {
            if (ray.point - here).norm() < SAME_M {
                return Says::Wall;
            }
            all_beyond &= laser.distance_m(&ray.point) > through_m;
            says = if all_beyond { Says::Through } else { Says::Nothing };
        }
        says
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::config::LidarConfig;

    /// How many rays of each scan are kept, of a round wall at 3 m that these beams of each scan
    /// do not reach.
    fn kept(scans: usize, short: impl Fn(usize) -> Vec<usize>) -> Vec<usize> {
        let lidar = LidarConfig { beams: 90, ..LidarConfig::default() };
        let laser = Laser::new(&lidar);
        let rays = |k: usize| {
            let mut ranges = [3.0; 90];
            short(k).into_iter().for_each(|beam| ranges[beam] = 1.5);
            laser.rays(&ranges)
        };
        let met: Vec<Vec<Ray>> = (0..scans).map(rays).collect();
        let scans: Vec<_> = met.iter().map(|rays| (SE2::identity(), rays.as_slice())).collect();
        unrefuted(&laser, &scans).iter().map(|(_, rays)| rays.len()).collect()
    }

    #[test]
    fn an_end_that_two_scans_looked_through_is_left_out() {
        let one = |k: usize| if k == 0 { vec![7] } else { vec![] };
        assert_eq!(kept(1, one), [90]);
        assert_eq!(kept(2, one), [90, 90]);
        assert_eq!(kept(3, one), [89, 90, 90]);
    }

    #[test]
    fn an_end_that_another_scan_has_as_well_needs_more_against_it() {
        let two = |k: usize| if k < 2 { vec![7] } else { vec![] };
        assert_eq!(kept(4, two), [90, 90, 90, 90]);
        assert_eq!(kept(5, two), [89, 89, 90, 90, 90]);
    }

    #[test]
    fn a_wall_in_front_hides_what_is_behind() {
        // Beam 7 and its neighbours of all but the first end before its wall.
        let hidden = |k: usize| if k == 0 { vec![] } else { vec![6, 7, 8] };
        assert_eq!(kept(4, hidden), [90, 90, 90, 90]);
    }
}
