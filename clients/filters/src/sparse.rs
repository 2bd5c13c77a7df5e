//! Sparse symmetric systems of 3×3 blocks, by Cholesky's factorisation.
//!
//! Source: T. Davis, *Direct Methods for Sparse Linear Systems* (2006), ch. 4
//! (left-looking Cholesky) and ch. 7 (minimum degree); for what it does in a pose
//! graph, F. Dellaert and M. Kaess, *Square Root SAM*, IJRR 2006.
//!
//! Why not a crate: what a library multiplies in blocks that it chooses it
//! multiplies with what the processor has, fused or not, and the last bits differ
//! between machines. Here every sum is written out in one order, on matrices of
//! fixed size. A graph of a thousand poses needs no more than this.
//!
//! The order of elimination is by least degree, ties by number; the last block is
//! always last, because its covariance then is (L Lᵀ)⁻¹ of that block alone.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

/// A symmetric matrix of 3×3 blocks, most of which are zero.
#[derive(Clone, Debug, Default)]
pub struct BlockMatrix {
    /// The blocks of the diagonal.
    diagonal: Vec<Matrix3<f64>>,
    /// Of each column the blocks below the diagonal, by row.
    below: Vec<BTreeMap<usize, Matrix3<f64>>>,
}

impl BlockMatrix {
    /// A matrix of zeros with N blocks in a row.
    pub fn zeros(blocks: usize) -> Self {
        Self { diagonal: vec![Matrix3::zeros(); blocks], below: vec![BTreeMap::new(); blocks] }
    }

    /// Adds to the block in row `i` and column `j`; the other half follows.
    pub fn add(&mut self, i: usize, j: usize, block: &Matrix3<f64>) {
        if i == j {
            self.diagonal[i] += block;
        } else if i > j {
            *self.below[j].entry(i).or_default() += block;
        } else {
            *self.below[i].entry(j).or_default() += block.transpose();
        }
    }

    /// How many blocks are in a row.
    pub fn blocks(&self) -> usize {
        self.diagonal.len()
    }
}

/// Where the blocks of L are: of all matrices with blocks at the same places.
#[derive(Debug, Default)]
pub struct Pattern {
    /// Which block of A comes `k`-th, and where each comes.
    order: Vec<usize>,
    place: Vec<usize>,
    /// The rows of each column of L below its diagonal, in that order.
    rows: Vec<Vec<usize>>,
}

impl Pattern {
    /// That of a matrix.
    pub fn of(matrix: &BlockMatrix) -> Self {
        let blocks = matrix.blocks();
        let mut adjacent = Neighbours::of(matrix);
        // By degree and number, so that the next is always the first. The last block is
        // not among them, and stays last.
        let mut remaining: BTreeSet<(usize, usize)> =
            (0..blocks.saturating_sub(1)).map(|k| (adjacent.degrees[k], k)).collect();
        let (mut order, mut rows) = (Vec::with_capacity(blocks), Vec::with_capacity(blocks));
        while let Some((_, block)) = remaining.pop_first() {
            let neighbours = adjacent.list(block);
            for one in &neighbours {
                let before = adjacent.degrees[*one];
                let degree = adjacent.eliminate(block, *one);
                if degree != before && remaining.remove(&(before, *one)) {
                    remaining.insert((degree, *one));
                }
            }
            order.push(block);
            rows.push(neighbours);
        }
        if blocks > 0 {
            order.push(blocks - 1);
            rows.push(Vec::new());
        }
        let mut place = vec![0; blocks];
        order.iter().enumerate().for_each(|(k, block)| place[*block] = k);
        for column in &mut rows {
            column.iter_mut().for_each(|row| *row = place[*row]);
            column.sort_unstable();
        }
        Self { order, place, rows }
    }
}

/// Which blocks a block meets, a bit each: eliminating a block joins those that it meets,
/// 64 at a time.
struct Neighbours {
    words: usize,
    bits: Vec<u64>,
    /// How many there are.
    degrees: Vec<usize>,
}

impl Neighbours {
    fn of(matrix: &BlockMatrix) -> Self {
        let blocks = matrix.blocks();
        let words = blocks.div_ceil(64);
        let (bits, degrees) = (vec![0; words * blocks], vec![0; blocks]);
        let mut adjacent = Self { words, bits, degrees };
        for (j, column) in matrix.below.iter().enumerate() {
            for i in column.keys() {
                for (one, other) in [(*i, j), (j, *i)] {
                    adjacent.bits[one * words + other / 64] |= 1 << (other % 64);
                    adjacent.degrees[one] += 1;
                }
            }
        }
        adjacent
    }

    fn list(&self, block: usize) -> Vec<usize> {
        let mut list = Vec::with_capacity(self.degrees[block]);
        let row = &self.bits[block * self.words..][..self.words];
        for (word, mut bits) in row.iter().copied().enumerate() {
            while bits != 0 {
                list.push(64 * word + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
        list
    }

    /// Takes `block` from those that `one` meets and joins the rest that `block` meets.
    /// Returns how many they are.
    fn eliminate(&mut self, block: usize, one: usize) -> usize {
        let words = self.words;
        for word in 0..words {
            self.bits[one * words + word] |= self.bits[block * words + word];
        }
        let row = &mut self.bits[one * words..][..words];
        for gone in [block, one] {
            row[gone / 64] &= !(1 << (gone % 64));
        }
        self.degrees[one] = row.iter().map(|bits| bits.count_ones() as usize).sum();
        self.degrees[one]
    }
}

/// The factorisation P A Pᵀ = L Lᵀ.
#[derive(Clone, Debug)]
pub struct Cholesky {
    pattern: Arc<Pattern>,
    /// Blocks of L on the diagonal, in the order of the pattern.
    diagonal: Vec<Matrix3<f64>>,
    /// Of each column of L the blocks below the diagonal, as in the pattern.
    columns: Vec<Vec<Matrix3<f64>>>,
}

impl Cholesky {
    /// Factorises; `None` where the matrix is not positive definite.
    #[cfg(test)]
    pub(crate) fn of(matrix: &BlockMatrix) -> Option<Self> {
        Self::with(Arc::new(Pattern::of(matrix)), matrix)
    }

    /// Factorises a matrix of this pattern; `None` where it has another one, or is not
    /// positive definite.
    pub fn with(pattern: Arc<Pattern>, matrix: &BlockMatrix) -> Option<Self> {
        let Pattern { order, place, rows } = &*pattern;
        let mut columns: Vec<Vec<Matrix3<f64>>> =
            rows.iter().map(|rows| vec![Matrix3::zeros(); rows.len()]).collect();
        let mut diagonal = vec![Matrix3::zeros(); order.len()];
        // The column at work, and of each row the columns to its left that meet it.
        let mut work = vec![Matrix3::zeros(); order.len()];
        let mut left: Vec<Vec<(usize, usize)>> = vec![Vec::new(); order.len()];
        for j in 0..order.len() {
            for (row, block) in &matrix.below[j] {
                let (a, b) = (place[*row], place[j]);
                let block = if a > b { *block } else { block.transpose() };
                let at = rows[a.min(b)].binary_search(&a.max(b)).ok()?;
                columns[a.min(b)][at] = block;
            }
        }
        for k in 0..order.len() {
            work[k] = matrix.diagonal[order[k]];
            rows[k].iter().zip(&columns[k]).for_each(|(row, block)| work[*row] = *block);
            for (column, at) in std::mem::take(&mut left[k]) {
                let blocks = &columns[column][at..];
                let of_k = blocks[0].transpose();
                let met = rows[column][at..].iter().zip(blocks);
                met.for_each(|(row, block)| work[*row] -= block * of_k);
            }
            diagonal[k] = work[k].cholesky()?.unpack();
            for (at, (row, block)) in rows[k].iter().zip(&mut columns[k]).enumerate() {
                *block = diagonal[k].solve_lower_triangular(&work[*row].transpose())?.transpose();
                left[*row].push((k, at));
            }
        }
        Some(Self { pattern, diagonal, columns })
    }

    /// Solves A x = b, in place.
    pub fn solve(&self, b: &mut [Vector3<f64>]) {
        let Pattern { order, rows, .. } = &*self.pattern;
        let mut x: Vec<Vector3<f64>> = order.iter().map(|block| b[*block]).collect();
        for (k, column) in self.columns.iter().enumerate() {
            let found = self.diagonal[k].solve_lower_triangular_unchecked(&x[k]);
            x[k] = found;
            rows[k].iter().zip(column).for_each(|(row, block)| x[*row] -= block * found);
        }
        for (k, column) in self.columns.iter().enumerate().rev() {
            let mut rest = x[k];
            let met = rows[k].iter().zip(column);
            met.for_each(|(row, block)| rest -= block.transpose() * x[*row]);
            x[k] = self.diagonal[k].tr_solve_lower_triangular_unchecked(&rest);
        }
        order.iter().zip(&x).for_each(|(block, x)| b[*block] = *x);
    }

    /// A column of blocks of A⁻¹.
    pub fn inverse_column(&self, block: usize) -> Vec<Matrix3<f64>> {
        let mut column = vec![Matrix3::zeros(); self.pattern.order.len()];
        for axis in 0..3 {
            let mut unit = vec![Vector3::zeros(); self.pattern.order.len()];
            unit[block][axis] = 1.0;
            self.solve(&mut unit);
            column.iter_mut().zip(&unit).for_each(|(c, x)| c.set_column(axis, x));
        }
        column
    }

    /// The last block of A⁻¹ on the diagonal; `None` for a matrix without blocks.
    pub fn last_of_inverse(&self) -> Option<Matrix3<f64>> {
        let inverse = self.diagonal.last()?.try_inverse()?;
        Some(inverse.transpose() * inverse)
    }

    /// How many blocks L has below its diagonal.
    pub fn filled(&self) -> usize {
        self.columns.iter().map(Vec::len).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use nalgebra::{DMatrix, DVector};

    /// A random positive definite matrix with a chain and some loops.
    fn matrix(blocks: usize, loops: &[(usize, usize)]) -> (BlockMatrix, DMatrix<f64>) {
        let mut random = Random::new(blocks as u64, 1);
        let (mut sparse, mut dense) =
            (BlockMatrix::zeros(blocks), DMatrix::zeros(3 * blocks, 3 * blocks));
        let chain = (1..blocks).map(|k| (k - 1, k));
        for (i, j) in chain.chain(loops.iter().copied()).chain([(0, 0)]) {
            let mut draw = || Matrix3::from_fn(|_, _| random.normal());
            let jacobians = if i == j { vec![(i, draw())] } else { vec![(i, draw()), (j, draw())] };
            for (a, of_a) in &jacobians {
                for (b, of_b) in &jacobians {
                    let block = of_a.transpose() * of_b;
                    let mut view = dense.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                    view += block;
                    if a <= b {
                        sparse.add(*a, *b, &block);
                    }
                }
            }
        }
        (sparse, dense)
    }

    #[test]
    fn solutions_and_inverses_are_those_of_the_dense_matrix() {
        for (blocks, loops) in [(1, vec![]), (2, vec![]), (9, vec![(0, 8), (2, 6), (6, 1)])] {
            let (sparse, dense) = matrix(blocks, &loops);
            let factor = Cholesky::of(&sparse).unwrap();
            let b = DVector::from_fn(3 * blocks, |k, _| 1.0 + k as f64);
            let expected = dense.clone().lu().solve(&b).unwrap();
            let mut x: Vec<_> =
                (0..blocks).map(|k| b.fixed_rows::<3>(3 * k).into_owned()).collect();
            factor.solve(&mut x);
            let scale = expected.norm();
            for (k, x) in x.iter().enumerate() {
                assert!((x - expected.fixed_rows::<3>(3 * k)).norm() < 1e-9 * scale, "{k}");
            }
            let inverse = dense.try_inverse().unwrap();
            let last = blocks - 1;
            let column = factor.inverse_column(last);
            let scale = inverse.norm();
            for (k, block) in column.iter().enumerate() {
                let expected = inverse.fixed_view::<3, 3>(3 * k, 3 * last);
                assert!((block - expected).norm() < 1e-9 * scale, "{k}");
            }
            assert!((factor.last_of_inverse().unwrap() - column[last]).norm() < 1e-9 * scale);
        }
    }

    #[test]
    fn a_chain_fills_nothing_and_a_loop_little() {
        let filled =
            |loops: &[(usize, usize)]| Cholesky::of(&matrix(60, loops).0).unwrap().filled();
        assert_eq!(filled(&[]), 59);
        assert_eq!(filled(&[(0, 59)]), 59 + 58);
        assert!(filled(&[(0, 59), (10, 50), (30, 59)]) < 59 + 3 * 58);
    }

    #[test]
    fn the_least_degree_comes_first_and_of_equals_the_first() {
        // Of every block that is left, asked anew each time.
        let loops = [(0, 29), (3, 17), (17, 25), (4, 28), (9, 21), (3, 28)];
        let (matrix, _) = matrix(30, &loops);
        let mut adjacent = vec![BTreeSet::new(); 30];
        for (j, column) in matrix.below.iter().enumerate() {
            for i in column.keys() {
                adjacent[*i].insert(j);
                adjacent[j].insert(*i);
            }
        }
        let mut left: Vec<usize> = (0..29).collect();
        let mut expected = Vec::new();
        while let Some(block) = left.iter().copied().min_by_key(|k| adjacent[*k].len()) {
            left.retain(|k| *k != block);
            let neighbours = std::mem::take(&mut adjacent[block]);
            for one in &neighbours {
                adjacent[*one].extend(neighbours.iter().filter(|other| *other != one));
                adjacent[*one].remove(&block);
            }
            expected.push(block);
        }
        expected.push(29);
        assert_eq!(Pattern::of(&matrix).order, expected);
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        let mut matrix = BlockMatrix::zeros(2);
        matrix.add(0, 0, &Matrix3::identity());
        assert!(Cholesky::of(&matrix).is_none());
        matrix.add(1, 1, &Matrix3::from_diagonal(&Vector3::new(1.0, f64::NAN, 1.0)));
        assert!(Cholesky::of(&matrix).is_none());
        assert!(Cholesky::of(&BlockMatrix::zeros(0)).unwrap().last_of_inverse().is_none());
    }
}
