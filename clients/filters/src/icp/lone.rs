//! Ends that no neighbour shares: beams that something small, or nothing, stopped short.
//!
//! Source: the short readings of S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics*, 2005,
//! §6.3.1, whose density a scan alone cannot tell; what neighbouring beams saw can.

use super::laser::{Laser, Ray};

/// An end that is nearer to the sensor than both of its neighbours by this, m, is lone.
const NEARER_M: f64 = 0.2;
/// Lone ends that are a smaller share of a scan stay: they may be legs of a table. In recorded
/// scans 1 to 3 % are usual, and 2 to 8 % or more in one scan of ten.
const WRONG_SHARE: f64 = 0.08;
/// Beams farther apart than two degrees or so, rad, meet much that their neighbours do not.
const APART_RAD: f64 = 0.036;

/// The rays of a scan, without those that end alone if too many do.
pub fn without_lone(laser: &Laser, mut rays: Vec<Ray>) -> Vec<Ray> {
    let range_m: Vec<f64> = rays.iter().map(|ray| laser.distance_m(&ray.point)).collect();
    let is_lone = |near: &[f64]| near[0].min(near[2]) > near[1] + NEARER_M;
    let lone: Vec<bool> = range_m.windows(3).map(is_lone).collect();
    let count = lone.iter().filter(|is_lone| **is_lone).count();
    if laser.view().step_rad <= APART_RAD && count as f64 >= WRONG_SHARE * rays.len() as f64 {
        // The first ray has one neighbour, as the last one has.
        let mut lone = std::iter::once(false).chain(lone).chain([false]);
        rays.retain(|_| lone.next() != Some(true));
    }
    rays
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::config::LidarConfig;

    /// The ranges that are left of a scan of `beams` all round that meet a wall at 3 m,
    /// but these at 1 m.
    fn left_m(beams: usize, short: &[usize]) -> Vec<f64> {
        let laser = Laser::new(&LidarConfig { beams: beams as u32, ..LidarConfig::default() });
        let range_m = |k| if short.contains(&k) { 1.0 } else { 3.0 };
        let ranges_m: Vec<f64> = (0..beams).map(range_m).collect();
        let rays = without_lone(&laser, laser.rays(&ranges_m));
        rays.iter().map(|ray| laser.distance_m(&ray.point)).collect()
    }

    fn short_of(left_m: &[f64]) -> usize {
        left_m.iter().filter(|range_m| **range_m < 2.0).count()
    }

    #[test]
    fn many_lone_ends_are_left_out() {
        // Not the first and the last, and none of two groups of three.
        let mut short: Vec<usize> = (5..180).step_by(6).collect();
        short.extend([0, 6, 7, 90, 91]);
        let left_m = left_m(180, &short);
        let lone = 180 - left_m.len();
        assert_eq!((short.len(), lone, short_of(&left_m)), (35, 27, 8));
    }

    #[test]
    fn few_lone_ends_stay() {
        let short: Vec<usize> = (5..180).step_by(20).collect();
        let left_m = left_m(180, &short);
        assert_eq!((left_m.len(), short_of(&left_m)), (180, 9));
    }

    #[test]
    fn lone_ends_of_sparse_beams_stay() {
        let short: Vec<usize> = (1..36).step_by(4).collect();
        let left_m = left_m(36, &short);
        assert_eq!((left_m.len(), short_of(&left_m)), (36, 9));
    }

    #[test]
    fn a_scan_without_ends_stays_empty() {
        let laser = Laser::new(&LidarConfig::default());
        assert!(without_lone(&laser, Vec::new()).is_empty());
    }
}
