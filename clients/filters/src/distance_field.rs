//! How far it is to the nearest obstacle, from every cell of a grid.
//!
//! From an [`OccupancyMap`] the distances are those between centres of cells, by
//! the exact Euclidean distance transform of P. Felzenszwalb and D. Huttenlocher,
//! *Distance Transforms of Sampled Functions* (Theory of Computing 8, 2012): the
//! lower envelope of parabolas along every column, and then along every row, in
//! time proportional to the number of cells.
//!
//! From a [`World`] each centre is put to the walls themselves. Drawing the
//! walls into cells first would move every one of them by up to half a cell, to
//! the same side all along it, and a scan matched to that is wrong by as much.
//! It costs a walk down the tree of walls per cell, once.

use rusty_geometry::World;

use crate::occupancy::Cell;
use crate::{GridFrame, OccupancyMap};

/// Distances to the nearest obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    /// Where the cells lie.
    pub frame: GridFrame,
    /// From the centre of each to the nearest obstacle, m; infinite where there
    /// is none at all.
    pub distances_m: Vec<f32>,
}

impl DistanceField {
    /// The distances to the walls of a floor plan.
    pub fn of_world(world: &World, frame: GridFrame) -> Self {
        let distance = |cell| world.distance_to_nearest(frame.centre(cell)) as f32;
        Self { frame, distances_m: (0..frame.cells()).map(distance).collect() }
    }

    /// The distances to the occupied cells of a map.
    pub fn of_map(map: &OccupancyMap) -> Self {
        let squares = squares_to(map, |cell| *cell == Cell::Occupied);
        let cell_m = map.frame.cell_m;
        let distances_m = squares.iter().map(|s| (s.sqrt() * cell_m) as f32).collect();
        Self { frame: map.frame, distances_m }
    }
}

/// The squared distance from each cell to the nearest obstacle, from centre to
/// centre, in cells; infinite where there is none at all.
pub(crate) fn squares_to(map: &OccupancyMap, is_obstacle: impl Fn(&Cell) -> bool) -> Vec<f64> {
    let frame = map.frame;
    let of = |cell: &Cell| if is_obstacle(cell) { 0.0 } else { f64::INFINITY };
    let mut squares: Vec<f64> = map.cells.iter().map(of).collect();
    let mut envelope = Envelope::default();
    let mut line = Vec::with_capacity(frame.width.max(frame.height));
    for column in 0..frame.width {
        line.clear();
        line.extend((0..frame.height).map(|row| squares[row * frame.width + column]));
        envelope.transform(&mut line);
        for (row, square) in line.iter().enumerate() {
            squares[row * frame.width + column] = *square;
        }
    }
    for row in squares.chunks_mut(frame.width) {
        envelope.transform(row);
    }
    squares
}

/// The lower envelope of parabolas of equal width, one over each finite sample.
#[derive(Debug, Default)]
struct Envelope {
    /// Where the parabolas that are part of it stand, and how high.
    parabolas: Vec<(f64, f64)>,
    /// From where on each of them is the lowest.
    from: Vec<f64>,
}

impl Envelope {
    /// Puts min over q of (p − q)² + f(q) in the place of every f(p).
    fn transform(&mut self, line: &mut [f64]) {
        self.parabolas.clear();
        self.from.clear();
        for (q, &height) in line.iter().enumerate() {
            if height < f64::INFINITY {
                self.push(q as f64, height);
            }
        }
        let mut k = 0;
        for (p, value) in line.iter_mut().enumerate() {
            let p = p as f64;
            while k + 1 < self.from.len() && self.from[k + 1] <= p {
                k += 1;
            }
            if let Some((q, height)) = self.parabolas.get(k) {
                *value = (p - q) * (p - q) + height;
            }
        }
    }

    /// Adds a parabola to the right of all others.
    fn push(&mut self, q: f64, height: f64) {
        while let Some(&(r, other)) = self.parabolas.last() {
            let crossing = ((height + q * q) - (other + r * r)) / (2.0 * (q - r));
            if crossing > self.from[self.from.len() - 1] {
                self.from.push(crossing);
                self.parabolas.push((q, height));
                return;
            }
            self.parabolas.pop();
            self.from.pop();
        }
        self.from.push(f64::NEG_INFINITY);
        self.parabolas.push((q, height));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use nalgebra::Point2;

    fn map(width: usize, height: usize, share: f64, seed: u64) -> OccupancyMap {
        let origin_m = Point2::new(-1.0, 2.0);
        let mut map = OccupancyMap::unknown(GridFrame { origin_m, cell_m: 0.05, width, height });
        let mut random = Random::new(seed, 1);
        for cell in &mut map.cells {
            let u = random.uniform();
            *cell = match u {
                u if u < share => Cell::Occupied,
                u if u < 0.5 => Cell::Unknown,
                _ => Cell::Free,
            };
        }
        map
    }

    #[test]
    fn distances_are_those_of_asking_every_cell() {
        for (seed, (width, height, share)) in
            [(40, 30, 0.01), (40, 30, 0.2), (1, 50, 0.1), (50, 1, 0.1), (7, 7, 1.0)]
                .into_iter()
                .enumerate()
        {
            let map = map(width, height, share, seed as u64);
            let field = DistanceField::of_map(&map);
            let place = |cell: usize| ((cell % width) as f64, (cell / width) as f64);
            for (cell, found) in field.distances_m.iter().enumerate() {
                let (x, y) = place(cell);
                let occupied = (0..map.cells.len()).filter(|k| map.cells[*k] == Cell::Occupied);
                let square = |k| {
                    let (u, v) = place(k);
                    (u - x) * (u - x) + (v - y) * (v - y)
                };
                let nearest = occupied.map(square).fold(f64::INFINITY, f64::min);
                assert_eq!(*found, (nearest.sqrt() * 0.05) as f32, "cell {cell}, seed {seed}");
            }
        }
    }

    #[test]
    fn a_map_without_obstacles_is_far_from_all() {
        let field = DistanceField::of_map(&map(5, 4, 0.0, 1));
        assert!(field.distances_m.iter().all(|d| *d == f32::INFINITY));
        let open = rusty_geometry::open();
        let frame = GridFrame::covering([0.0, 0.0, 1.0, 1.0], 0.0, 0.1);
        let field = DistanceField::of_world(&open, frame);
        assert!(field.distances_m.iter().all(|d| *d == f32::INFINITY));
    }

    #[test]
    fn a_plan_and_its_drawing_agree_within_a_cell() {
        let world = rusty_geometry::apartment();
        let map = OccupancyMap::of_world(&world, 0.2, 0.1);
        let drawn = DistanceField::of_map(&map);
        let exact = DistanceField::of_world(&world, map.frame);
        for (a, b) in drawn.distances_m.iter().zip(&exact.distances_m) {
            assert!((a - b).abs() <= 0.1 * 0.75, "{a} m, {b} m");
        }
    }
}
