//! Noticing that the robot is where the map knows few of the walls.
//!
//! A likelihood compares poses, and [`super::recovery`] compares scans with those before: in a
//! room that is not on the map, all are equally unlikely after a while. The share of the beams
//! that end on a wall of the map does not depend on what came before. A few beams do so by
//! chance, and these few then pull the particles along with them.

use crate::Motion;

/// How fast the mean share follows, per scan.
const ALPHA: f64 = 0.5;
/// While less than this share of the beams end on known walls, the filter abstains.
const FEW: f64 = 0.2;
/// The place where a robot is found has this share at least,
const MOST: f64 = 0.5;
/// and, where the particles are elsewhere, so much more than they have.
const MORE: f64 = 0.05;
/// After this way without known walls the robot may be elsewhere, m.
const STRAYED_M: f64 = 1.0;

/// How much of what the laser sees is on the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KnownWalls {
    /// Running mean of the share of the beams that end on known walls.
    share: f64,
    /// Way since the last scan with enough of them, m.
    way_m: f64,
}

/// Whether the robot is at the likeliest place, on whose walls this share of the beams ends.
/// `share_here` is the share where the particles are, if that is elsewhere.
pub(super) fn is_found(share: f64, share_here: Option<f64>) -> bool {
    share >= MOST && share_here.is_none_or(|here| share >= here + MORE)
}

impl Default for KnownWalls {
    fn default() -> Self {
        Self { share: 1.0, way_m: 0.0 }
    }
}

impl KnownWalls {
    /// Moves with the robot.
    pub fn move_by(&mut self, motion: &Motion) {
        self.way_m += motion.now_in_then.translation().norm();
    }

    /// Takes the share of the beams of one more scan that end on known walls.
    pub fn update(&mut self, share: f64) {
        self.share += ALPHA * (share - self.share);
        if !self.are_few() {
            self.way_m = 0.0;
        }
    }

    /// Whether they are too few for an answer.
    pub fn are_few(&self) -> bool {
        self.share < FEW
    }

    /// Whether the robot has gone so far without them that it may be elsewhere.
    pub fn is_strayed(&self) -> bool {
        self.way_m >= STRAYED_M
    }
}

#[cfg(test)]
mod tests {
    use rusty_geometry::SE2;

    use super::*;

    #[test]
    fn a_robot_strays_on_a_way_without_known_walls_and_not_where_it_stands() {
        let mut walls = KnownWalls::default();
        let mut scan = |way_m, share| {
            let now_in_then = SE2::new(way_m, 0.0, 0.5);
            walls.move_by(&Motion { now_in_then, ..Motion::default() });
            walls.update(share);
            (walls.are_few(), walls.is_strayed())
        };
        // The mean is 0.5, 0.25 and 0.125.
        assert_eq!(scan(9.0, 0.0), (false, false));
        assert_eq!(scan(0.4, 0.0), (false, false));
        assert_eq!(scan(0.4, 0.0), (true, false));
        for _ in 0..9 {
            assert_eq!(scan(0.0, 0.0), (true, false));
        }
        assert_eq!(scan(0.4, 0.1), (true, false));
        assert_eq!(scan(0.4, 0.1), (true, true));
        // One scan of known walls is enough.
        assert_eq!(scan(0.4, 0.5), (false, false));
    }

    #[test]
    fn a_place_elsewhere_has_to_explain_more_of_the_scan() {
        assert!(is_found(0.5, None) && !is_found(0.49, None));
        assert!(is_found(0.6, Some(0.5)) && !is_found(0.54, Some(0.5)));
        assert!(!is_found(0.45, Some(0.1)));
    }
}
