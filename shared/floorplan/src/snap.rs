//! Ends that stop just short of a wall, joined to it.

use std::collections::BTreeMap;

use nalgebra::Point2;
use rusty_geometry::{WallSpec, WorldSpec};

/// Most times that the ends are looked at again: what is joined may leave another end.
const ROUNDS: usize = 8;
/// Most comparisons of an end with a wall in a round.
const MAX_COMPARISONS: usize = 1 << 28;

/// Joins each end that stops at most `reach_m` short of another wall to it: to its end,
/// if that is as near, or by splitting it there. Ends that cannot be joined are left to
/// the check of the world.
pub fn join_ends(spec: &mut WorldSpec, reach_m: f64) {
    for _ in 0..ROUNDS {
        let most = MAX_COMPARISONS / spec.walls.len().max(1);
        let Ok(near) = spec.ends_near(reach_m, most) else { return };
        if near.is_empty() {
            return;
        }
        let mut splits: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
        for gap in near {
            let WallSpec { a, b, .. } = spec.walls[gap.other];
            let distance = |end: [f64; 2]| (Point2::from(end) - Point2::from(gap.point)).norm();
            let end = if distance(a) <= distance(b) { a } else { b };
            if distance(end) > reach_m {
                splits.entry(gap.other).or_default().push(gap.point);
                continue;
            }
            let wall = &mut spec.walls[gap.wall];
            match gap.end {
                'a' if wall.b != end => wall.a = end,
                'b' if wall.a != end => wall.b = end,
                _ => {}
            }
        }
        for (index, mut points) in splits {
            let WallSpec { a, b, material } = spec.walls[index];
            let from_a = |point: &[f64; 2]| (Point2::from(*point) - Point2::from(a)).norm();
            points.sort_by(|p, q| from_a(p).total_cmp(&from_a(q)));
            points.dedup();
            spec.walls[index].b = points[0];
            points.push(b);
            let pieces =
                points.windows(2).map(|ends| WallSpec { a: ends[0], b: ends[1], material });
            spec.walls.extend(pieces);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::Material;

    fn spec(walls: &[([f64; 2], [f64; 2])]) -> WorldSpec {
        let wall = |&(a, b): &_| WallSpec { a, b, material: Material::Wall };
        let walls = walls.iter().map(wall).collect();
        WorldSpec {
            name: "s".to_owned(),
            bounds: [-1.0, -1.0, 11.0, 11.0],
            walls,
            landmarks: Vec::new(),
        }
    }

    #[test]
    fn ends_are_joined_to_ends_and_walls_are_split() {
        let mut plan = spec(&[
            ([0.0, 0.0], [10.0, 3.0]),
            ([5.0, 1.5004], [5.0, 9.0]),
            ([2.0, 0.5996], [2.0, -1.0]),
            ([10.0003, 3.0004], [10.0, 9.0]),
            ([7.0, 2.2], [7.0, 9.0]),
        ]);
        let before = plan.clone();
        assert!(plan.check().is_err());
        join_ends(&mut plan, 1e-3);
        // The end at (7, 2.2) is 9 cm short, and stays.
        assert_eq!(plan.check(), Ok(()));
        assert_eq!(plan.walls.len(), 7);
        assert_eq!((plan.walls[0].a, plan.walls[0].b), ([0.0, 0.0], [2.0, 0.5996]));
        // The two ends of the corner are one now.
        assert!(plan.walls.iter().any(|wall| wall.b == plan.walls[3].a));
        assert_eq!(plan.walls[4], before.walls[4]);
        let joined = plan.clone();
        join_ends(&mut plan, 1e-3);
        assert_eq!(plan, joined);
    }
}
