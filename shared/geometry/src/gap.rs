//! Gaps: wall ends that stop just short of another wall.
//!
//! A floor plan drawn by hand has corners that almost meet. A beam that finds
//! such a slit reads metres too far, once in thousands of scans, and the cause
//! is nowhere in the sensor. So a slit narrower than any door is taken for a slip
//! of the pen and refused, with the numbers needed to mend it.

use core::fmt;

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

/// All gaps among `walls`, in order of wall and end (`a` before `b`), each found
/// when asked for; of several near walls the nearest is named, at equal distance
/// the lowest index.
pub(crate) fn find_gaps(walls: &[Wall]) -> impl Iterator<Item = Gap> {
    let tree = WallTree::new(walls);
    let ends = walls.iter().enumerate().flat_map(|(i, w)| [(i, 'a', w.a), (i, 'b', w.b)]);
    ends.filter_map(move |(wall, end, point)| {
        let (distance_m, other) = tree.nearest_other(walls, wall, &point, TOUCH_M, GAP_M)?;
        let is_gap = (TOUCH_M..GAP_M).contains(&distance_m);
        is_gap.then_some(Gap { wall, end, point: [point.x, point.y], other, distance_m })
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::generated::{Density, Pattern, Recipe};
    use crate::material::Material;
    use crate::places::{PLACES, place};

    /// Compares every end with every wall.
    fn by_brute_force(walls: &[Wall]) -> Vec<Gap> {
        let mut gaps = Vec::new();
        for (wall, of) in walls.iter().enumerate() {
            for (end, point) in [('a', of.a), ('b', of.b)] {
                let others = (0..walls.len()).filter(|other| *other != wall);
                let found = others.map(|other| (walls[other].distance(&point), other));
                let nearest = found.min_by(|x, y| x.partial_cmp(y).unwrap());
                if let Some((distance_m, other)) = nearest
                    && (TOUCH_M..GAP_M).contains(&distance_m)
                {
                    gaps.push(Gap { wall, end, point: [point.x, point.y], other, distance_m });
                }
            }
        }
        gaps
    }

    fn wall(a: [f64; 2], b: [f64; 2]) -> Wall {
        Wall { a: Point2::from(a), b: Point2::from(b), material: Material::Wall }
    }

    #[test]
    fn the_gaps_are_those_of_every_end_compared_with_every_wall() {
        let built_in = PLACES.iter().map(|(name, _)| place(name).unwrap().walls().to_vec());
        let mut plans: Vec<Vec<Wall>> = built_in.collect();
        for pattern in [Pattern::Rooms, Pattern::Segments] {
            for density in [Density::Constant, Density::Area] {
                let recipe = Recipe { pattern, density, walls: 600, seed: 7 };
                plans.push(recipe.spec().to_walls());
            }
        }
        for walls in &mut plans {
            assert_eq!(find_gaps(walls).collect::<Vec<_>>(), by_brute_force(walls));
            // The same with slits of 1 mm to 6 mm, and some walls twice: ties.
            for (i, wall) in walls.iter_mut().enumerate().step_by(3) {
                wall.a.x += 0.001 * (1 + i % 6) as f64;
            }
            walls.extend_from_within(..walls.len() / 5);
            let gaps: Vec<Gap> = find_gaps(walls).collect();
            assert_eq!(gaps, by_brute_force(walls));
        }
    }

    #[test]
    fn many_walls_in_one_place_take_no_more_than_a_few_comparisons_an_end() {
        let count = 99_999;
        let equal = vec![wall([0.0, 0.0], [3.0, 4.0]); count];
        assert_eq!(find_gaps(&equal).next(), None);
        // Parallel walls 1e-7 m apart between two that all of them touch.
        let mut comb = vec![wall([0.0, 0.0], [1.0, 0.0]), wall([0.0, 2.0], [1.0, 2.0])];
        comb.extend((0..count - 2).map(|i| {
            let x = 1e-7 * i as f64;
            wall([x, 0.0], [x, 2.0])
        }));
        assert_eq!(find_gaps(&comb).next(), None);
        // Without those two, the first end is a gap already.
        assert_eq!(find_gaps(&comb[2..]).next().map(|gap| (gap.wall, gap.other)), Some((0, 1)));
    }
}
