//! The ends of the walls, as a k-d tree from which ends near a wall are taken.
//!
//! The tree holds ends and not walls, because boxes around long diagonal walls
//! overlap and exclude nothing. An end that was found is taken out, so no pair
//! of one end and two walls is looked at twice; nodes without ends are skipped.
//! For n walls the search takes about n log n steps on plans with walls that run
//! side by side. No exact method stays below n^(4/3) on every plan (Hopcroft's
//! problem), so the number of steps is limited.

use nalgebra::Point2;

use crate::wall::Wall;

/// Ends in a leaf of the tree.
const LEAF: usize = 8;

/// How much wider than asked for the search is, metres: far more than the
/// rounding of anything computed from coordinates within 1e6 m.
const MARGIN_M: f64 = 1e-6;

/// One end of one wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct End {
    /// Index of the wall.
    pub wall: usize,
    /// Which end, 'a' or 'b'.
    pub end: char,
}

impl End {
    pub(super) fn point(self, walls: &[Wall]) -> Point2<f64> {
        let Wall { a, b, .. } = walls[self.wall];
        if self.end == 'a' { a } else { b }
    }
}

/// A box around ends. The children of node k are 2k + 1 and 2k + 2.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    mid: [f64; 2],
    half: [f64; 2],
    /// How many ends in it were not taken.
    left: usize,
}

/// The ends that were not taken.
pub(super) struct EndTree<'a> {
    walls: &'a [Wall],
    ends: Vec<End>,
    nodes: Vec<Node>,
    /// How many nodes and ends may still be compared with walls.
    steps: u64,
}

/// One search: what is near the wall `index`.
struct Search<'s> {
    index: usize,
    reach_m: f64,
    taken: &'s mut Vec<End>,
}

impl<'a> EndTree<'a> {
    /// The tree of all ends of `walls`, which are finite and within 1e6 m of the
    /// origin; at most `steps` comparisons will be made.
    pub(super) fn new(walls: &'a [Wall], steps: u64) -> Self {
        let ends: Vec<End> =
            (0..walls.len()).flat_map(|wall| ['a', 'b'].map(|end| End { wall, end })).collect();
        let leaves = ends.len().div_ceil(LEAF).next_power_of_two();
        let nodes = vec![Node::default(); 2 * leaves - 1];
        let mut tree = Self { walls, ends, nodes, steps };
        tree.build(0, 0, tree.ends.len());
        tree
    }

    /// The steps that are left.
    #[cfg(test)]
    pub(super) fn steps(&self) -> u64 {
        self.steps
    }

    fn is_leaf(&self, node: usize) -> bool {
        2 * node + 1 >= self.nodes.len()
    }

    fn build(&mut self, node: usize, from: usize, to: usize) {
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for end in &self.ends[from..to] {
            let point = end.point(self.walls);
            for axis in 0..2 {
                lo[axis] = lo[axis].min(point[axis]);
                hi[axis] = hi[axis].max(point[axis]);
            }
        }
        self.nodes[node] = Node {
            mid: [0, 1].map(|axis| 0.5 * (lo[axis] + hi[axis])),
            half: [0, 1].map(|axis| 0.5 * (hi[axis] - lo[axis])),
            left: to - from,
        };
        if self.is_leaf(node) {
            return;
        }
        let axis = usize::from(hi[1] - lo[1] > hi[0] - lo[0]);
        let (middle, walls) = (from.midpoint(to), self.walls);
        if to - from > 1 {
            self.ends[from..to].select_nth_unstable_by(middle - from, |x, y| {
                x.point(walls)[axis].total_cmp(&y.point(walls)[axis]).then(x.cmp(y))
            });
        }
        self.build(2 * node + 1, from, middle);
        self.build(2 * node + 2, middle, to);
    }

    /// Takes out all ends closer than `reach_m` to a wall that is not their own,
    /// in no order; `None` if that takes more steps than were left.
    pub(super) fn take_near(&mut self, reach_m: f64) -> Option<Vec<End>> {
        let mut taken = Vec::new();
        for index in 0..self.walls.len() {
            let mut search = Search { index, reach_m, taken: &mut taken };
            self.search(&mut search, 0, 0, self.ends.len())?;
        }
        Some(taken)
    }

    /// Takes from one node, whose ends are in places `from..to`.
    fn search(&mut self, of: &mut Search<'_>, node: usize, from: usize, to: usize) -> Option<()> {
        let Node { left, .. } = self.nodes[node];
        if left == 0 {
            return Some(());
        }
        self.steps = self.steps.checked_sub(1)?;
        let wall = &self.walls[of.index];
        if is_apart(&self.nodes[node], wall, of.reach_m + MARGIN_M) {
            return Some(());
        }
        if !self.is_leaf(node) {
            let middle = from.midpoint(to);
            self.search(of, 2 * node + 1, from, middle)?;
            self.search(of, 2 * node + 2, middle, to)?;
            self.nodes[node].left = self.nodes[2 * node + 1].left + self.nodes[2 * node + 2].left;
            return Some(());
        }
        self.steps = self.steps.checked_sub(left as u64)?;
        // Those that were not taken come first.
        let mut place = from;
        while place < from + self.nodes[node].left {
            let end = self.ends[place];
            if end.wall != of.index && wall.distance(&end.point(self.walls)) < of.reach_m {
                of.taken.push(end);
                self.nodes[node].left -= 1;
                self.ends.swap(place, from + self.nodes[node].left);
            } else {
                place += 1;
            }
        }
        Some(())
    }
}

/// Whether everything in a box is certainly farther than `reach_m` from a wall:
/// separated along an axis of the box, or across the wall.
fn is_apart(node: &Node, wall: &Wall, reach_m: f64) -> bool {
    let Node { mid: [x, y], half: [wide, high], .. } = *node;
    let (a, b) = (wall.a, wall.b);
    let (ex, ey) = (b.x - a.x, b.y - a.y);
    let across = (x - a.x) * ey - (y - a.y) * ex;
    let length = (ex * ex + ey * ey).sqrt();
    a.x.min(b.x) - x > wide + reach_m
        || x - a.x.max(b.x) > wide + reach_m
        || a.y.min(b.y) - y > high + reach_m
        || y - a.y.max(b.y) > high + reach_m
        || across.abs() > wide * ey.abs() + high * ex.abs() + reach_m * length
}
