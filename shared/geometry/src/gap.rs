//! Gaps: wall ends that stop just short of another wall.
//!
//! A floor plan drawn by hand has corners that almost meet. A beam that finds
//! such a slit reads metres too far, once in thousands of scans, and the cause
//! is nowhere in the sensor. So a slit narrower than any door is taken for a slip
//! of the pen and refused, with the numbers needed to mend it.

use core::fmt;

use nalgebra::Point2;

use crate::wall::Wall;
use crate::wall_tree::WallTree;

/// Closer than this, in metres, an end touches the other wall.
pub const TOUCH_M: f64 = 1e-9;

/// Closer than this, in metres, but not touching, is a gap. A free end farther
/// from every other wall is a door or a niche, meant as drawn.
pub const GAP_M: f64 = 0.05;

/// One end of one wall that touches nothing, with the wall it nearly touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Index of the wall whose end is free.
    pub wall: usize,
    /// Which end, 'a' or 'b'.
    pub end: char,
    /// Where the end is, metres.
    pub point: [f64; 2],
    /// Index of the nearest other wall.
    pub other: usize,
    /// Distance to it, metres: at least [`TOUCH_M`], less than [`GAP_M`].
    pub distance_m: f64,
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "wall {}, end `{}` at {:?} touches no wall but stops {:.3e} m from wall {}; snap it \
             onto that wall, or move it farther than {GAP_M} m away",
            self.wall, self.end, self.point, self.distance_m, self.other
        )
    }
}

/// All gaps among `walls`, in order of wall and end (`a` before `b`); of several
/// near walls the nearest is named, at equal distance the lowest index.
pub(crate) fn find_gaps(walls: &[Wall]) -> Vec<Gap> {
    let tree = WallTree::new(walls);
    let mut gaps = Vec::new();
    for (index, wall) in walls.iter().enumerate() {
        for (end, point) in [('a', wall.a), ('b', wall.b)] {
            if let Some((distance_m, other)) = nearest_other(walls, &tree, index, &point)
                && (TOUCH_M..GAP_M).contains(&distance_m)
            {
                gaps.push(Gap { wall: index, end, point: [point.x, point.y], other, distance_m });
            }
        }
    }
    gaps
}

/// The wall other than `index` nearest to `point`, if any is about that near.
fn nearest_other(
    walls: &[Wall],
    tree: &WallTree,
    index: usize,
    point: &Point2<f64>,
) -> Option<(f64, usize)> {
    let mut nearest: Option<(f64, usize)> = None;
    tree.any_near(point, GAP_M, |other| {
        if other != index {
            let found = (walls[other].distance(point), other);
            if nearest.is_none_or(|best| found < best) {
                nearest = Some(found);
            }
        }
        false
    });
    nearest
}
