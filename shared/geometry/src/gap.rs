//! Gaps: wall ends that stop just short of another wall.
//!
//! A floor plan drawn by hand has corners that almost meet. A beam that finds
//! such a slit reads metres too far, once in thousands of scans, and the cause
//! is nowhere in the sensor. So a slit narrower than any door is taken for a slip
//! of the pen and refused, with the numbers needed to mend it.

mod ends;

use core::fmt;

use crate::wall::Wall;
use ends::{End, EndTree};

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

/// Most comparisons of a wall with ends that a check for gaps makes: some
/// seconds. Plans of 100 000 walls in floors, grids and bundles take a hundredth.
pub(crate) const MAX_STEPS: u64 = 1 << 30;

/// Returns all ends of `walls` that touch no other wall and are closer than `reach_m`
/// to one, in order of wall and end (`a` before `b`), each named when asked for; of
/// several near walls the nearest is named, at equal distance the lowest index.
/// `None` if that takes more than `steps` comparisons.
pub(crate) fn find_gaps(
    walls: &[Wall],
    reach_m: f64,
    steps: u64,
) -> Option<impl Iterator<Item = Gap>> {
    let mut ends = EndTree::new(walls, steps);
    let _touching = ends.take_near(TOUCH_M)?;
    let mut free = ends.take_near(reach_m)?;
    free.sort_unstable();
    Some(free.into_iter().filter_map(|end| name(walls, end)))
}

/// Names the wall nearest to a free end.
fn name(walls: &[Wall], End { wall, end }: End) -> Option<Gap> {
    let point = End { wall, end }.point(walls);
    let others = walls.iter().enumerate().filter(|(other, _)| *other != wall);
    let distances = others.map(|(other, of)| (of.distance(&point), other));
    let (distance_m, other) = distances.min_by(|x, y| x.0.total_cmp(&y.0))?;
    Some(Gap { wall, end, point: [point.x, point.y], other, distance_m })
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
            assert_eq!(
                find_gaps(walls, GAP_M, MAX_STEPS).unwrap().collect::<Vec<_>>(),
                by_brute_force(walls)
            );
            // The same with slits of 1 mm to 6 mm, and some walls twice: ties.
            for (i, wall) in walls.iter_mut().enumerate().step_by(3) {
                wall.a.x += 0.001 * (1 + i % 6) as f64;
            }
            walls.extend_from_within(..walls.len() / 5);
            let gaps: Vec<Gap> = find_gaps(walls, GAP_M, MAX_STEPS).unwrap().collect();
            assert_eq!(gaps, by_brute_force(walls));
        }
    }

    /// Gaps, and how many comparisons the search for free ends takes for a wall.
    fn counted(walls: &[Wall]) -> (Vec<Gap>, u64) {
        let mut ends = EndTree::new(walls, MAX_STEPS);
        ends.take_near(TOUCH_M).unwrap();
        ends.take_near(GAP_M).unwrap();
        let steps = (MAX_STEPS - ends.steps()) / walls.len() as u64;
        (find_gaps(walls, GAP_M, MAX_STEPS).unwrap().take(2).collect(), steps)
    }

    /// Parallel diagonal walls, one `apart` metres above the other.
    fn diagonals(count: usize, apart: f64) -> Vec<Wall> {
        let at = |i: usize| apart * i as f64;
        (0..count).map(|i| wall([0.0, at(i)], [1e4, 1e4 + at(i)])).collect()
    }

    #[test]
    fn many_walls_in_one_place_take_no_more_than_a_few_comparisons_a_wall() {
        let count = 99_999;
        let equal = vec![wall([0.0, 0.0], [3.0, 4.0]); count];
        // Parallel walls 1e-7 m apart between two that all of them touch.
        let mut comb = vec![wall([0.0, 0.0], [1.0, 0.0]), wall([0.0, 2.0], [1.0, 2.0])];
        comb.extend((0..count - 2).map(|i| {
            let x = 1e-7 * i as f64;
            wall([x, 0.0], [x, 2.0])
        }));
        let star = |i: usize| wall([0.0, 0.0], place_on_circle(i as f64 / count as f64));
        let rays: Vec<Wall> = (0..count).map(star).collect();
        let far = diagonals(count, 0.1);
        for (walls, name) in [(equal, "equal"), (comb, "comb"), (far, "diagonals")] {
            let (gaps, steps) = counted(&walls);
            assert_eq!(gaps, [], "{name}");
            assert!(steps < 200, "{name}: {steps}");
        }
        // Their outer ends are close to each other.
        let (gaps, steps) = counted(&rays);
        assert_eq!(
            gaps.iter().map(|gap| (gap.wall, gap.end)).collect::<Vec<_>>(),
            [(0, 'b'), (1, 'b')]
        );
        assert!(steps < 200, "rays: {steps}");
        // Without what they touch, the first end is a gap already.
        let (gaps, steps) = counted(&diagonals(count, 0.01));
        assert_eq!((gaps[0].wall, gaps[0].end, gaps[0].other), (0, 'a', 1));
        assert!(steps < 200, "close diagonals: {steps}");
    }

    fn place_on_circle(turn: f64) -> [f64; 2] {
        let angle = core::f64::consts::TAU * turn;
        [100.0 * crate::trig::cos(angle), 100.0 * crate::trig::sin(angle)]
    }

    #[test]
    fn a_search_without_steps_left_finds_nothing_instead_of_part() {
        let walls = diagonals(1000, 0.01);
        assert!(find_gaps(&walls, GAP_M, 1000).is_none());
        assert!(find_gaps(&walls, GAP_M, 200 * 1000).is_some());
    }
}
