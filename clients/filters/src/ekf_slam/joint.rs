//! The joint covariance of a pose and of landmarks.
//!
//! Source: *Probabilistic Robotics*, §10.2, Table 10.1. Only the lower half of the
//! symmetric matrix is kept, row by row. So it is symmetric whatever is rounded.
//!
//! * A motion changes the rows and columns of the pose only: O(n) for n landmarks.
//! * A reading depends on the pose and one landmark, so P Hᵀ is O(n), and P − W Wᵀ is
//!   O(n²), with W = P Hᵀ L⁻ᵀ and the Cholesky factor L of S. That is (I − K H) P of the
//!   book, where K is never formed.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix3x2, Vector2, Vector3};

use crate::Motion;
use crate::landmarks::Placed;
use crate::tangent::symmetric;

/// Covariance of the error τ of a pose (m, m, rad, its own tangent space) and of the
/// landmarks (m, m, frame of the map), in this order.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    landmarks: usize,
    /// Row i has the columns 0 to i.
    lower: Vec<f64>,
}

/// A correction of the state, by [`Joint::correct`].
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// Error of the pose.
    pub tau: Vector3<f64>,
    /// Changes of all landmarks, m.
    pub landmarks_m: Vec<Vector2<f64>>,
    /// νᵀ S⁻¹ ν.
    pub nis: f64,
}

/// Index of an element, `row ≥ column`.
fn place(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// Row of the first coordinate of landmark `k`.
fn first(k: usize) -> usize {
    3 + 2 * k
}

impl Joint {
    /// Begins with a pose and no landmark.
    pub fn new(pose: &Matrix3<f64>) -> Self {
        let mut joint = Self { landmarks: 0, lower: vec![0.0; place(3, 0)] };
        joint.set_pose(pose);
        joint
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.lower[place(i.max(j), i.min(j))]
    }

    /// Covariance of the pose.
    pub fn pose(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.at(i, j))
    }

    fn set_pose(&mut self, pose: &Matrix3<f64>) {
        for i in 0..3 {
            for j in 0..=i {
                self.lower[place(i, j)] = pose[(i, j)];
            }
        }
    }

    /// Covariance of landmark `k`, m².
    pub fn landmark(&self, k: usize) -> Matrix2<f64> {
        self.between(k, k)
    }

    /// Covariance of landmarks `k` (rows) and `l` (columns), m².
    pub fn between(&self, k: usize, l: usize) -> Matrix2<f64> {
        Matrix2::from_fn(|i, j| self.at(first(k) + i, first(l) + j))
    }

    /// Covariance of the pose (rows) and landmark `k` (columns).
    pub fn cross(&self, k: usize) -> Matrix3x2<f64> {
        Matrix3x2::from_fn(|i, j| self.at(i, first(k) + j))
    }

    /// Number of landmarks.
    pub fn len(&self) -> usize {
        self.landmarks
    }

    /// Whether there is no landmark.
    pub fn is_empty(&self) -> bool {
        self.landmarks == 0
    }

    /// Predicts over a motion (Table 10.1, line 5).
    pub fn predict(&mut self, motion: &Motion) {
        let pose = symmetric(&motion.propagate(&self.pose()));
        self.carry(&motion.now_in_then.inverse().adjoint());
        self.set_pose(&pose);
    }

    /// Multiplies the error of the pose by a matrix: it is seen from another pose.
    pub fn carry(&mut self, by: &Matrix3<f64>) {
        let pose = symmetric(&(by * self.pose() * by.transpose()));
        for row in 3..first(self.landmarks) {
            let start = place(row, 0);
            let with_pose = by * Vector3::from_fn(|j, _| self.lower[start + j]);
            self.lower[start..start + 3].copy_from_slice(with_pose.as_slice());
        }
        self.set_pose(&pose);
    }

    /// S = H P Hᵀ + R of a reading of landmark `k`.
    pub fn innovation_covariance(
        &self,
        k: usize,
        (by_pose, by_landmark): (&Matrix2x3<f64>, &Matrix2<f64>),
        r: &Matrix2<f64>,
    ) -> Matrix2<f64> {
        let both = by_pose * self.cross(k) * by_landmark.transpose();
        let of_pose = by_pose * self.pose() * by_pose.transpose();
        let of_landmark = by_landmark * self.landmark(k) * by_landmark.transpose();
        of_pose + both + both.transpose() + of_landmark + r
    }

    /// Corrects by a reading of landmark `k` with the residual ν (Table 10.1, lines 15 to
    /// 19). Changes nothing, and returns `None`, where S is not positive definite.
    pub fn correct(
        &mut self,
        k: usize,
        (by_pose, by_landmark): (&Matrix2x3<f64>, &Matrix2<f64>),
        r: &Matrix2<f64>,
        nu: &Vector2<f64>,
    ) -> Option<Correction> {
        let s = self.innovation_covariance(k, (by_pose, by_landmark), r);
        let l = s.cholesky()?.l();
        let whiten = |v: &Vector2<f64>| {
            let x = v.x / l[(0, 0)];
            Vector2::new(x, (v.y - l[(1, 0)] * x) / l[(1, 1)])
        };
        let y = whiten(nu);
        let size = first(self.landmarks);
        let w: Vec<Vector2<f64>> = (0..size)
            .map(|i| {
                let with_pose = Vector3::from_fn(|j, _| self.at(i, j));
                let with_landmark = Vector2::from_fn(|j, _| self.at(i, first(k) + j));
                whiten(&(by_pose * with_pose + by_landmark * with_landmark))
            })
            .collect();
        if !w.iter().chain([&y]).all(|v| v.x.is_finite() && v.y.is_finite()) {
            return None;
        }
        for (i, of_row) in w.iter().enumerate() {
            let start = place(i, 0);
            for (p, of_column) in self.lower[start..=start + i].iter_mut().zip(&w) {
                *p -= of_row.x * of_column.x + of_row.y * of_column.y;
            }
        }
        let change = |i: usize| w[i].dot(&y);
        let of_landmark = |k: usize| Vector2::new(change(first(k)), change(first(k) + 1));
        Some(Correction {
            tau: Vector3::new(change(0), change(1), change(2)),
            landmarks_m: (0..self.landmarks).map(of_landmark).collect(),
            nis: y.dot(&y),
        })
    }

    /// Adds a landmark that was seen from the pose.
    pub fn add(&mut self, placed: &Placed) {
        let g = &placed.by_pose;
        // Its rows: G times the rows of the pose, for all columns before it.
        let columns = first(self.landmarks);
        let rows: Vec<Vector2<f64>> =
            (0..columns).map(|j| g * Vector3::from_fn(|i, _| self.at(i, j))).collect();
        let own = g * self.pose() * g.transpose() + placed.covariance;
        self.lower.extend(rows.iter().map(|v| v.x).chain([own[(0, 0)]]));
        let cross = 0.5 * (own[(0, 1)] + own[(1, 0)]);
        self.lower.extend(rows.iter().map(|v| v.y).chain([cross, own[(1, 1)]]));
        self.landmarks += 1;
    }
}
