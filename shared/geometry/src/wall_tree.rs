//! The tree of boxes around the walls, and what it promises.
//!
//! A bounding volume hierarchy from `parry2d` (its `Bvh`, built once). It only
//! ever *discards* walls; every wall it does not discard is put to the exact
//! formulas of [`Wall`]. The shape of the tree therefore cannot change a result,
//! only its cost, provided that no box is ever too small. To make that certain
//! despite rounding, every box is larger than its wall by [`MARGIN_M`], a
//! thousand times the rounding of anything computed from points within [`FAR_M`];
//! queries from farther out use no tree at all.

use core::cell::Cell;

use nalgebra::{Point2, Vector2};
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};

use crate::wall::Wall;

/// How much larger than its wall a box is on each side, metres.
const MARGIN_M: f64 = 1e-6;

/// Up to this many walls are looked at one by one within a wedge.
const FEW: usize = 64;

/// Query points with a coordinate beyond this, in metres, scan every wall.
const FAR_M: f64 = 1e7;

/// The boxes of a list of walls; leaves carry indices into that list.
#[derive(Clone, Debug)]
pub(crate) struct WallTree {
    bvh: Bvh,
}

impl WallTree {
    /// Builds the tree for `walls`; every query must be given the same list.
    pub(crate) fn new(walls: &[Wall]) -> Self {
        let boxes: Vec<Aabb> = walls.iter().map(box_around).collect();
        Self { bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes) }
    }

    /// The first wall along a ray within `max_m`: its distance and index, by the
    /// formula and the tie rule of [`crate::wall`].
    pub(crate) fn first_along(
        &self,
        walls: &[Wall],
        origin: &Point2<f64>,
        unit_dir: &Vector2<f64>,
        max_m: f64,
    ) -> Option<(f64, usize)> {
        self.first_of(walls, origin, unit_dir, max_m, |_| true)
    }

    /// [`first_along`](Self::first_along) among the hits that `counts` takes, each a
    /// distance and an index.
    #[inline(always)]
    pub(crate) fn first_of(
        &self,
        walls: &[Wall],
        origin: &Point2<f64>,
        unit_dir: &Vector2<f64>,
        max_m: f64,
        counts: impl Fn((f64, usize)) -> bool,
    ) -> Option<(f64, usize)> {
        let best: Cell<Option<(f64, usize)>> = Cell::new(None);
        let offer = |index: usize| {
            let t = walls[index].cast(origin, unit_dir);
            let t = t.filter(|t| *t <= max_m && counts((*t, index)))?;
            if best.get().is_none_or(|so_far| (t, index) < so_far) {
                best.set(Some((t, index)));
            }
            Some(t)
        };
        if is_far(origin) {
            for index in 0..walls.len() {
                offer(index);
            }
            return best.get();
        }
        let inverse = Vector2::new(1.0 / unit_dir.x, 1.0 / unit_dir.y);
        // The search drops a box whose entry is not below the best hit so far. A
        // box is entered at least a margin before its wall is met, so walls in a
        // tie are all offered; `best` decides between them.
        let _ = self.bvh.find_best(
            f64::INFINITY,
            |node, _| entry(node, origin, &inverse, max_m),
            |leaf, _| offer(leaf as usize),
        );
        best.get()
    }

    /// The least squared distance from `point` to any wall, square metres;
    /// infinite without walls.
    pub(crate) fn least_distance_squared(&self, walls: &[Wall], point: &Point2<f64>) -> f64 {
        self.least_by(walls, point, f64::INFINITY, |i| Some(walls[i].distance_squared(point)))
    }

    /// The least of `measure` over all walls and `most`, square metres. A wall's
    /// measure must not be below its squared distance from `point`; `None` leaves
    /// it out.
    pub(crate) fn least_by(
        &self,
        walls: &[Wall],
        point: &Point2<f64>,
        most: f64,
        measure: impl Fn(usize) -> Option<f64>,
    ) -> f64 {
        if is_far(point) {
            return (0..walls.len()).filter_map(measure).fold(most, f64::min);
        }
        let found = self.bvh.find_best(
            most,
            |node, _| box_distance_squared(node, point),
            |leaf, _| measure(leaf as usize),
        );
        found.map_or(most, |(_, distance_squared)| distance_squared)
    }

    /// The same where `measure` is `None` for every wall outside of a wedge, with its
    /// tip in the place of `point`.
    pub(crate) fn least_in_wedge_by(
        &self,
        walls: &[Wall],
        tip: &Point2<f64>,
        inward: &[Vector2<f64>; 2],
        most: f64,
        measure: impl Fn(usize) -> Option<f64>,
    ) -> f64 {
        if is_far(tip) {
            return (0..walls.len()).filter_map(measure).fold(most, f64::min);
        }
        let wedge = Wedge::new(tip, inward);
        if walls.len() <= FEW {
            let within = walls.iter().enumerate().filter(|(_, wall)| wedge.may_hold(wall));
            return within.filter_map(|(index, _)| measure(index)).fold(most, f64::min);
        }
        let found = self.bvh.find_best(
            most,
            |node, _| {
                if wedge.may_reach(node) { box_distance_squared(node, tip) } else { f64::MAX }
            },
            |leaf, _| measure(leaf as usize),
        );
        found.map_or(most, |(_, distance_squared)| distance_squared)
    }

    /// Whether `test` holds for a wall whose box comes within `reach_m` of
    /// `point` along both axes; calls it for every such wall until it does.
    pub(crate) fn any_near(
        &self,
        point: &Point2<f64>,
        reach_m: f64,
        mut test: impl FnMut(usize) -> bool,
    ) -> bool {
        let reach_m = reach_m + MARGIN_M;
        let mut found = false;
        self.bvh.traverse(|node| {
            let (lo, hi) = (node.mins(), node.maxs());
            let apart = lo.x - point.x > reach_m
                || point.x - hi.x > reach_m
                || lo.y - point.y > reach_m
                || point.y - hi.y > reach_m;
            if apart {
                return TraversalAction::Prune;
            }
            if let Some(leaf) = node.leaf_data() {
                found = test(leaf as usize);
                if found {
                    return TraversalAction::EarlyExit;
                }
            }
            TraversalAction::Continue
        });
        found
    }
}

/// The box of a wall, larger by the margin.
fn box_around(wall: &Wall) -> Aabb {
    let (a, b) = (wall.a, wall.b);
    Aabb::new(
        Vector::new(a.x.min(b.x) - MARGIN_M, a.y.min(b.y) - MARGIN_M),
        Vector::new(a.x.max(b.x) + MARGIN_M, a.y.max(b.y) + MARGIN_M),
    )
}

/// Whether the margin no longer covers rounding at this point.
fn is_far(point: &Point2<f64>) -> bool {
    !(point.x.abs() <= FAR_M && point.y.abs() <= FAR_M)
}

/// Where a ray enters a box, in metres along it (negative from inside), or
/// `f64::MAX`, which the search drops, if it misses the box or meets it too late.
///
/// A direction along an axis makes an infinite inverse and possibly 0 · ∞ = NaN,
/// which `min` and `max` skip; that happens only to a ray exactly on the border
/// of a box, a margin away from the wall.
#[inline]
fn entry(node: &BvhNode, origin: &Point2<f64>, inverse: &Vector2<f64>, max_m: f64) -> f64 {
    let (lo, hi) = (node.mins(), node.maxs());
    let x1 = (lo.x - origin.x) * inverse.x;
    let x2 = (hi.x - origin.x) * inverse.x;
    let y1 = (lo.y - origin.y) * inverse.y;
    let y2 = (hi.y - origin.y) * inverse.y;
    let t_in = x1.min(x2).max(y1.min(y2));
    let t_out = x1.max(x2).min(y1.max(y2));
    if t_out >= t_in && t_out >= 0.0 && t_in <= max_m { t_in } else { f64::MAX }
}

/// The part of the plane between two lines.
struct Wedge {
    /// x and y of the inward normals of both sides.
    x: [f64; 2],
    y: [f64; 2],
    /// How far along them the tip is, less the margin.
    tip: [f64; 2],
}

impl Wedge {
    fn new(tip: &Point2<f64>, inward: &[Vector2<f64>; 2]) -> Self {
        let along = |side: Vector2<f64>| side.dot(&tip.coords) - MARGIN_M;
        Self { x: inward.map(|side| side.x), y: inward.map(|side| side.y), tip: inward.map(along) }
    }

    /// Whether an end of a wall is inside of each of the two sides; a wall that the wedge
    /// holds a point of has one. Both sides are one vector of the processor.
    #[inline(always)]
    fn may_hold(&self, wall: &Wall) -> bool {
        let along = |k: usize, end: &Point2<f64>| self.x[k] * end.x + self.y[k] * end.y;
        let far: [f64; 2] = core::array::from_fn(|k| {
            let (a, b) = (along(k, &wall.a), along(k, &wall.b));
            if a > b { a } else { b }
        });
        (far[0] >= self.tip[0]) & (far[1] >= self.tip[1])
    }

    /// Whether a corner of a box is inside of each of the two sides.
    #[inline]
    fn may_reach(&self, node: &BvhNode) -> bool {
        let (lo, hi) = (node.mins(), node.maxs());
        (0..2).all(|k| {
            let x = self.x[k] * if self.x[k] > 0.0 { hi.x } else { lo.x };
            let y = self.y[k] * if self.y[k] > 0.0 { hi.y } else { lo.y };
            x + y >= self.tip[k]
        })
    }
}

/// Squared distance from a point to a box, zero inside.
#[inline]
fn box_distance_squared(node: &BvhNode, point: &Point2<f64>) -> f64 {
    let (lo, hi) = (node.mins(), node.maxs());
    let dx = (lo.x - point.x).max(point.x - hi.x).max(0.0);
    let dy = (lo.y - point.y).max(point.y - hi.y).max(0.0);
    dx * dx + dy * dy
}
