//! Walls in blocks of eight that lie close together, in a tree of boxes.
//!
//! The order in which a scan takes walls cannot change its result, only its
//! cost; so all that matters here is that every wall is in exactly one block and
//! that every box holds all the walls in it.

use crate::wall::Wall;

/// How many walls, or boxes, go together.
pub(crate) const WALLS: usize = 8;

/// Eight walls, coordinate by coordinate; lanes without a wall are NaN, which no
/// comparison lets through.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Block {
    pub a_x: [f64; WALLS],
    pub a_y: [f64; WALLS],
    pub b_x: [f64; WALLS],
    pub b_y: [f64; WALLS],
    /// Index of the wall in the world's list; f64 holds every u32.
    pub index: [f64; WALLS],
}

/// Eight boxes with walls in them, coordinate by coordinate; lanes without a box
/// are NaN.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Octet {
    pub x_lo: [f64; WALLS],
    pub y_lo: [f64; WALLS],
    pub x_hi: [f64; WALLS],
    pub y_hi: [f64; WALLS],
    /// What is in each box.
    pub below: [Below; WALLS],
}

/// What a box holds: an octet or a block, by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Below(u32);

/// Set for a block.
const BLOCK: u32 = 1 << 31;

impl Below {
    /// Nothing: the box is NaN, and no ray meets it.
    const NOTHING: Self = Self(u32::MAX);

    /// The place of the block, if it is one.
    #[inline(always)]
    pub fn block(self) -> Option<usize> {
        (self.0 & BLOCK != 0).then_some((self.0 & !BLOCK) as usize)
    }

    /// The place of the octet, if it is one.
    #[inline(always)]
    pub fn octet(self) -> usize {
        self.0 as usize
    }
}

/// All walls of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    /// The first is the root; none where there are no walls.
    pub(crate) octets: Vec<Octet>,
    pub(crate) blocks: Vec<Block>,
}

impl Blocks {
    /// Arranges `walls`, in O(n log² n).
    pub(crate) fn new(walls: &[Wall]) -> Self {
        let mut all = Self::default();
        let mut order: Vec<u32> = (0..).take(walls.len()).collect();
        if !order.is_empty() {
            all.add_octet(walls, &mut order);
        }
        all
    }

    /// Makes the octet of the walls in `order` and all below it.
    fn add_octet(&mut self, walls: &[Wall], order: &mut [u32]) -> Below {
        let place = self.octets.len();
        let none = [f64::NAN; WALLS];
        let below = [Below::NOTHING; WALLS];
        self.octets.push(Octet { x_lo: none, y_lo: none, x_hi: none, y_hi: none, below });
        let mut parts = vec![order];
        for _ in 0..WALLS.ilog2() {
            parts = parts.into_iter().flat_map(|part| halves(walls, part)).collect();
        }
        parts.retain(|part| !part.is_empty());
        for (lane, part) in parts.into_iter().enumerate() {
            let [lo, hi] = box_of(walls, part);
            let below = self.add(walls, part);
            let octet = &mut self.octets[place];
            (octet.x_lo[lane], octet.y_lo[lane]) = (lo[0], lo[1]);
            (octet.x_hi[lane], octet.y_hi[lane]) = (hi[0], hi[1]);
            octet.below[lane] = below;
        }
        Below(narrow(place))
    }

    fn add(&mut self, walls: &[Wall], order: &mut [u32]) -> Below {
        if order.len() > WALLS {
            return self.add_octet(walls, order);
        }
        self.blocks.push(block_of(walls, order));
        Below(BLOCK | narrow(self.blocks.len() - 1))
    }
}

/// The walls of `order` in two halves along the longer side of their box. Halves
/// of whole blocks, because a lane without a wall is a lane wasted; the second
/// is empty where one block is enough.
fn halves<'a>(walls: &[Wall], order: &'a mut [u32]) -> [&'a mut [u32]; 2] {
    if order.len() <= WALLS {
        return [order, &mut []];
    }
    let [lo, hi] = box_of(walls, order);
    let axis = usize::from(hi[1] - lo[1] > hi[0] - lo[0]);
    let middle = |i: u32| walls[i as usize].a[axis] + walls[i as usize].b[axis];
    order.sort_unstable_by(|i, j| middle(*i).total_cmp(&middle(*j)).then(i.cmp(j)));
    order.split_at_mut(order.len().div_ceil(2).next_multiple_of(WALLS)).into()
}

/// `[lower, upper]` corner of the box around some walls.
fn box_of(walls: &[Wall], order: &[u32]) -> [[f64; 2]; 2] {
    let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for wall in order.iter().map(|i| &walls[*i as usize]) {
        for axis in 0..2 {
            for end in [wall.a[axis], wall.b[axis]] {
                lo[axis] = if end < lo[axis] { end } else { lo[axis] };
                hi[axis] = if end > hi[axis] { end } else { hi[axis] };
            }
        }
    }
    [lo, hi]
}

/// A world has at most 100,000 walls, and no more octets or blocks than walls.
fn narrow(place: usize) -> u32 {
    u32::try_from(place).unwrap_or(u32::MAX)
}

fn block_of(walls: &[Wall], order: &[u32]) -> Block {
    let none = [f64::NAN; WALLS];
    let mut block = Block { a_x: none, a_y: none, b_x: none, b_y: none, index: none };
    for (lane, i) in order.iter().enumerate() {
        let wall = &walls[*i as usize];
        (block.a_x[lane], block.a_y[lane]) = (wall.a.x, wall.a.y);
        (block.b_x[lane], block.b_y[lane]) = (wall.b.x, wall.b.y);
        block.index[lane] = f64::from(*i);
    }
    block
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use nalgebra::Point2;

    fn some_walls(n: u32) -> Vec<Wall> {
        let coordinate = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 1000.0;
        let point = |k| Point2::new(coordinate(k), coordinate(k + 7777));
        (0..n)
            .map(|k| Wall { a: point(3 * k), b: point(5 * k + 1), material: Material::Wall })
            .collect()
    }

    /// The walls in a box; checks that it holds them.
    fn inside(all: &Blocks, walls: &[Wall], below: Below) -> Vec<usize> {
        if let Some(place) = below.block() {
            let index = all.blocks[place].index;
            return index.iter().filter(|i| !i.is_nan()).map(|i| *i as usize).collect();
        }
        let octet = &all.octets[below.octet()];
        let mut found = Vec::new();
        for lane in (0..WALLS).filter(|lane| !octet.x_lo[*lane].is_nan()) {
            let within = inside(all, walls, octet.below[lane]);
            assert!(!within.is_empty());
            for end in within.iter().flat_map(|i| [walls[*i].a, walls[*i].b]) {
                assert!((octet.x_lo[lane]..=octet.x_hi[lane]).contains(&end.x));
                assert!((octet.y_lo[lane]..=octet.y_hi[lane]).contains(&end.y));
            }
            found.extend(within);
        }
        found
    }

    #[test]
    fn every_wall_is_in_one_block_and_every_box_holds_its_walls() {
        for n in [1, 2, 4, 5, 7, 8, 9, 16, 17, 63, 64, 65, 1000] {
            let walls = some_walls(n);
            let all = Blocks::new(&walls);
            let mut found = inside(&all, &walls, Below(0));
            found.sort_unstable();
            assert_eq!(found, (0..n as usize).collect::<Vec<_>>());
            assert_eq!(all.blocks.len(), (n as usize).div_ceil(WALLS), "no lane is wasted");
        }
    }

    #[test]
    fn no_walls_no_octets() {
        assert!(Blocks::new(&[]).octets.is_empty());
    }
}
