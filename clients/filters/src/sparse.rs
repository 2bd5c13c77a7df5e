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

/// The factorisation P A Pᵀ = L Lᵀ.
#[derive(Clone, Debug)]
pub struct Cholesky {
    /// Which block of A comes `k`-th.
    order: Vec<usize>,
    /// Blocks of L on the diagonal, in that order.
    diagonal: Vec<Matrix3<f64>>,
    /// Of each column of L the blocks below the diagonal, by row.
    columns: Vec<Vec<(usize, Matrix3<f64>)>>,
}

impl Cholesky {
    /// Factorises; `None` where the matrix is not positive definite.
    pub fn of(matrix: &BlockMatrix) -> Option<Self> {
        let (order, mut columns) = eliminated(matrix);
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, block)| place[*block] = k);
        let mut diagonal = vec![Matrix3::zeros(); order.len()];
        // The column at work, and of each row the columns to its left that meet it.
        let mut work = vec![Matrix3::zeros(); order.len()];
        let mut left: Vec<Vec<(usize, usize)>> = vec![Vec::new(); order.len()];
        for j in 0..order.len() {
            for (row, block) in &matrix.below[j] {
                let (a, b) = (place[*row], place[j]);
                let block = if a > b { *block } else { block.transpose() };
                let column = &mut columns[a.min(b)];
                let at = column.binary_search_by_key(&a.max(b), |(row, _)| *row).ok()?;
                column[at].1 = block;
            }
        }
        for k in 0..order.len() {
            work[k] = matrix.diagonal[order[k]];
            columns[k].iter().for_each(|(row, block)| work[*row] = *block);
            for (column, at) in std::mem::take(&mut left[k]) {
                let column = &columns[column];
                let of_k = column[at].1.transpose();
                column[at..].iter().for_each(|(row, block)| work[*row] -= block * of_k);
            }
            diagonal[k] = work[k].cholesky()?.unpack();
            for (at, (row, block)) in columns[k].iter_mut().enumerate() {
                *block = diagonal[k].solve_lower_triangular(&work[*row].transpose())?.transpose();
                left[*row].push((k, at));
            }
        }
        Some(Self { order, diagonal, columns })
    }

    /// Solves A x = b, in place.
    pub fn solve(&self, b: &mut [Vector3<f64>]) {
        let mut x: Vec<Vector3<f64>> = self.order.iter().map(|block| b[*block]).collect();
        for (k, column) in self.columns.iter().enumerate() {
            let found = self.diagonal[k].solve_lower_triangular_unchecked(&x[k]);
            x[k] = found;
            column.iter().for_each(|(row, block)| x[*row] -= block * found);
        }
        for (k, column) in self.columns.iter().enumerate().rev() {
            let mut rest = x[k];
            column.iter().for_each(|(row, block)| rest -= block.transpose() * x[*row]);
            x[k] = self.diagonal[k].tr_solve_lower_triangular_unchecked(&rest);
        }
        self.order.iter().zip(&x).for_each(|(block, x)| b[*block] = *x);
    }

    /// A column of blocks of A⁻¹.
    pub fn inverse_column(&self, block: usize) -> Vec<Matrix3<f64>> {
        let mut column = vec![Matrix3::zeros(); self.order.len()];
        for axis in 0..3 {
            let mut unit = vec![Vector3::zeros(); self.order.len()];
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

/// A column of L before it is computed: the rows that it will have.
type Column = Vec<(usize, Matrix3<f64>)>;

/// The order of elimination, and the rows that each column of L will have.
fn eliminated(matrix: &BlockMatrix) -> (Vec<usize>, Vec<Column>) {
    let blocks = matrix.blocks();
    let mut beside: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); blocks];
    for (j, column) in matrix.below.iter().enumerate() {
        for i in column.keys() {
            beside[*i].insert(j);
            beside[j].insert(*i);
        }
    }
    // By degree and number, so that the next is always the first.
    let mut remaining: BTreeSet<(usize, usize)> =
        (0..blocks.saturating_sub(1)).map(|k| (beside[k].len(), k)).collect();
    let mut order = Vec::with_capacity(blocks);
    let mut rows: Vec<BTreeSet<usize>> = Vec::with_capacity(blocks);
    while let Some((_, block)) = remaining.pop_first() {
        let neighbours = std::mem::take(&mut beside[block]);
        for one in &neighbours {
            let before = beside[*one].len();
            beside[*one].remove(&block);
            beside[*one].extend(neighbours.iter().filter(|other| *other != one));
            // The last block is not among them, and stays last.
            if remaining.remove(&(before, *one)) {
                remaining.insert((beside[*one].len(), *one));
            }
        }
        order.push(block);
        rows.push(neighbours);
    }
    if blocks > 0 {
        order.push(blocks - 1);
        rows.push(BTreeSet::new());
    }
    let mut place = vec![0; blocks];
    order.iter().enumerate().for_each(|(k, block)| place[*block] = k);
    let columns = rows.iter().map(|rows| {
        let mut column: Column = rows.iter().map(|row| (place[*row], Matrix3::zeros())).collect();
        column.sort_unstable_by_key(|(row, _)| *row);
        column
    });
    (order, columns.collect())
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
        let mut beside = vec![BTreeSet::new(); 30];
        for (j, column) in matrix.below.iter().enumerate() {
            for i in column.keys() {
                beside[*i].insert(j);
                beside[j].insert(*i);
            }
        }
        let mut left: Vec<usize> = (0..29).collect();
        let mut expected = Vec::new();
        while let Some(block) = left.iter().copied().min_by_key(|k| beside[*k].len()) {
            left.retain(|k| *k != block);
            let neighbours = std::mem::take(&mut beside[block]);
            for one in &neighbours {
                beside[*one].extend(neighbours.iter().filter(|other| *other != one));
                beside[*one].remove(&block);
            }
            expected.push(block);
        }
        expected.push(29);
        assert_eq!(Cholesky::of(&matrix).unwrap().order, expected);
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
