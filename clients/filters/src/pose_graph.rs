//! A graph of poses and of motions measured between them.
//!
//! Source: F. Lu and E. Milios, *Globally consistent range scan alignment for
//! environment mapping*, Autonomous Robots 4 (1997); G. Grisetti, R. Kümmerle,
//! C. Stachniss, W. Burgard, *A tutorial on graph-based SLAM*, IEEE ITS Magazine
//! (2010), alg. 1; *Probabilistic Robotics*, ch. 11. The poses minimise
//! Σ eᵀ Λ e with e = (xᵢ⁻¹ xⱼ) ⊟ z, by Gauss–Newton on the group.
//!
//! Departures, and why:
//! * The Jacobians are those of SE(2) itself, with J_r⁻¹ ([`crate::tangent`]);
//!   the tutorial subtracts angles and positions.
//! * The first pose is fixed by leaving it out; the book adds infinite
//!   information to it.
//! * Loops have a weight each, by their residual: dynamic covariance scaling
//!   (P. Agarwal et al., *Robust map optimization using dynamic covariance
//!   scaling*, ICRA 2013, eq. 15), so that one wrong loop does not bend the map.
//! * The scaling begins with Φ at the χ² of the worst loop and ends at its own, so that
//!   right loops that find the poses far off are not taken for wrong ones. This is
//!   graduated non-convexity (H. Yang, P. Antonante, V. Tzoumas, L. Carlone,
//!   *Graduated non-convexity for robust spatial perception*, RA-L 5 (2020)), with this
//!   scaling in place of their loss.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use rusty_geometry::SE2;

use crate::sparse::{BlockMatrix, Cholesky, Pattern};
use crate::tangent::{right_jacobian_inverse, symmetric};

/// Steps at most.
const MOST_STEPS: u32 = 30;
/// A step that moves no pose by more (m, rad) is the last.
const SMALL_STEP: f64 = 1e-5;
/// Φ of dynamic covariance scaling: a loop with χ² beyond it (99 % of three
/// numbers) begins to count less.
const SUSPECT_CHI2: f64 = 11.3;
/// From one step to the next Φ shrinks to this part, down to that.
const GRADUATION: f64 = 0.2;
/// χ² for each degree of freedom of a graph whose motions are as sure as they say: 0.13 to
/// 0.26 in simulated runs, since loops count for half and share scans with the chain.
const EXPECTED_CHI2: f64 = 0.3;
/// Degrees of freedom that such a graph is taken to have had before.
const PRIOR_DEGREES: f64 = 30.0;

/// Where a motion comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One pose to the next: it is what it is.
    Chain,
    /// Two poses that seem to have seen the same: it may be wrong.
    Loop,
}

/// A motion measured between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint {
    /// The pose it is measured from.
    pub from: usize,
    /// The pose it leads to.
    pub to: usize,
    /// The motion.
    pub motion: SE2,
    /// Information Λ (inverse covariance) of its error τ, truth = motion ⊞ τ.
    pub information: Matrix3<f64>,
    /// Where it comes from.
    pub kind: Kind,
}

/// A constraint at two poses: its residual, and how that changes with them.
struct Linear {
    residual: Vector3<f64>,
    of_from: Matrix3<f64>,
    of_to: Matrix3<f64>,
}

impl Constraint {
    fn residual(&self, poses: &[SE2]) -> Vector3<f64> {
        (poses[self.from].inverse() * poses[self.to]).boxminus(&self.motion)
    }

    fn linear(&self, poses: &[SE2]) -> Linear {
        let relative = poses[self.from].inverse() * poses[self.to];
        let residual = relative.boxminus(&self.motion);
        let of_to = right_jacobian_inverse(&residual);
        let of_from = -(of_to * relative.inverse().adjoint());
        Linear { residual, of_from, of_to }
    }

    /// χ² of its residual at these poses.
    pub fn chi2(&self, poses: &[SE2]) -> f64 {
        let e = self.residual(poses);
        (e.transpose() * self.information * e).x
    }

    /// Returns the weight of a loop with this χ², 0 to 1, where `suspect_chi2` is Φ.
    fn weight(&self, chi2: f64, suspect_chi2: f64) -> f64 {
        if self.kind == Kind::Chain || chi2 <= suspect_chi2 {
            return 1.0;
        }
        let scale = 2.0 * suspect_chi2 / (suspect_chi2 + chi2);
        scale * scale
    }
}

/// Poses, and motions measured between them. The first pose is certain.
#[derive(Clone, Debug)]
pub struct PoseGraph {
    poses: Vec<SE2>,
    constraints: Vec<Constraint>,
    /// The factorised information of all poses but the first, and where its blocks are.
    factor: Option<Cholesky>,
    pattern: Option<Arc<Pattern>>,
}

impl PoseGraph {
    /// A graph of one pose.
    pub fn new(first: SE2) -> Self {
        Self { poses: vec![first], constraints: Vec::new(), factor: None, pattern: None }
    }

    /// The poses, world frame.
    pub fn poses(&self) -> &[SE2] {
        &self.poses
    }

    /// What was measured.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// A new pose, at the end of a motion from the last one.
    pub fn extend(&mut self, motion: &SE2, information: &Matrix3<f64>) {
        let from = self.poses.len() - 1;
        self.poses.push(self.poses[from] * *motion);
        self.constrain(Constraint {
            from,
            to: from + 1,
            motion: *motion,
            information: *information,
            kind: Kind::Chain,
        });
    }

    /// One motion more between poses that are there.
    ///
    /// # Panics
    /// If one of them is not, or they are the same.
    pub fn constrain(&mut self, constraint: Constraint) {
        let Constraint { from, to, .. } = constraint;
        assert!(from != to && from.max(to) < self.poses.len(), "{from} to {to}");
        self.constraints.push(constraint);
        (self.factor, self.pattern) = (None, None);
    }

    /// Moves the poses to where they fit best. Returns the number of steps, 30 where
    /// they have not come to rest by then and stay where the last one led (loops whose
    /// weights change from step to step), or `None` if the motions do not determine the
    /// poses (they then stay).
    pub fn optimise(&mut self) -> Option<u32> {
        let before = self.poses.clone();
        let loops = self.constraints.iter().filter(|c| c.kind == Kind::Loop);
        let worst = loops.map(|c| c.chi2(&self.poses)).fold(0.0, f64::max);
        let mut suspect_chi2 = SUSPECT_CHI2.max(worst);
        for step in 1..=MOST_STEPS {
            let (matrix, mut tau) = self.system(suspect_chi2);
            let Some(factor) = self.factorise(&matrix) else {
                self.poses = before;
                return None;
            };
            factor.solve(&mut tau);
            let largest = tau.iter().fold(0.0f64, |most, t| most.max(t.amax()));
            if !largest.is_finite() {
                self.poses = before;
                return None;
            }
            let moved = self.poses[1..].iter_mut().zip(&tau);
            moved.for_each(|(pose, tau)| *pose = pose.boxplus(tau));
            self.factor = Some(factor);
            if largest < SMALL_STEP && suspect_chi2 <= SUSPECT_CHI2 {
                return Some(step);
            }
            suspect_chi2 = (suspect_chi2 * GRADUATION).max(SUSPECT_CHI2);
        }
        Some(MOST_STEPS)
    }

    /// H and −g of the cost at these poses, without the first one, where `suspect_chi2` is Φ.
    fn system(&self, suspect_chi2: f64) -> (BlockMatrix, Vec<Vector3<f64>>) {
        let free = self.poses.len() - 1;
        let (mut matrix, mut right) = (BlockMatrix::zeros(free), vec![Vector3::zeros(); free]);
        for constraint in &self.constraints {
            let Linear { residual, of_from, of_to } = constraint.linear(&self.poses);
            let chi2 = (residual.transpose() * constraint.information * residual).x;
            let information = constraint.information * constraint.weight(chi2, suspect_chi2);
            let sides = [(constraint.from, of_from), (constraint.to, of_to)];
            for (i, of_i) in sides.iter().filter(|(i, _)| *i > 0) {
                let weighted = of_i.transpose() * information;
                right[i - 1] -= weighted * residual;
                matrix.add(i - 1, i - 1, &(weighted * of_i));
            }
            if constraint.from.min(constraint.to) > 0 {
                let block = of_from.transpose() * information * of_to;
                matrix.add(constraint.from - 1, constraint.to - 1, &block);
            }
        }
        (matrix, right)
    }

    /// The covariance of the last pose, in its own tangent space.
    pub fn last_covariance(&mut self) -> Option<Matrix3<f64>> {
        if self.poses.len() == 1 {
            return Some(Matrix3::zeros());
        }
        self.factored()?.last_of_inverse().map(|covariance| symmetric(&covariance))
    }

    /// The motion from each of these poses to the last one, with its covariance.
    /// `None` where there is but one pose, or the motions do not determine them.
    pub fn to_last(&mut self, from: &[usize]) -> Option<Vec<crate::Motion>> {
        let last = self.poses.len() - 1;
        if last == 0 {
            return None;
        }
        let to_last: Vec<SE2> =
            from.iter().map(|k| self.poses[*k].inverse() * self.poses[last]).collect();
        let factor = self.factored()?;
        let of_last = factor.inverse_column(last - 1);
        let motion = |(k, relative): (&usize, &SE2)| {
            // x_k⁻¹ x_last moves by τ_last − Ad τ_k.
            let ad = relative.inverse().adjoint();
            let mut covariance = of_last[last - 1];
            if *k > 0 {
                let (own, both) = (factor.inverse_column(k - 1)[k - 1], of_last[k - 1]);
                covariance += ad * own * ad.transpose();
                covariance -= ad * both + (ad * both).transpose();
            }
            crate::Motion { now_in_then: *relative, covariance: symmetric(&covariance) }
        };
        Some(from.iter().zip(&to_last).map(motion).collect())
    }

    /// By how much the variances of the motions are too small, at least 1, as the residuals
    /// tell: the variance factor (K.-R. Koch, *Parameter Estimation and Hypothesis Testing
    /// in Linear Models*, Springer 1999, §3.2), relative to that of a graph where they are
    /// right. It moves no pose. Loops count by their weight.
    pub fn variance_factor(&self) -> f64 {
        let mut sum = PRIOR_DEGREES * EXPECTED_CHI2;
        let mut degrees = PRIOR_DEGREES - 3.0 * (self.poses.len() - 1) as f64;
        for constraint in &self.constraints {
            let chi2 = constraint.chi2(&self.poses);
            let weight = constraint.weight(chi2, SUSPECT_CHI2);
            sum += weight * chi2;
            degrees += 3.0 * weight;
        }
        (sum / (EXPECTED_CHI2 * degrees.max(PRIOR_DEGREES))).max(1.0)
    }

    /// Factorises, where the blocks are as in the matrix before.
    fn factorise(&mut self, matrix: &BlockMatrix) -> Option<Cholesky> {
        let pattern = self.pattern.get_or_insert_with(|| Arc::new(Pattern::of(matrix)));
        Cholesky::with(Arc::clone(pattern), matrix)
    }

    /// The factorised information at these poses.
    fn factored(&mut self) -> Option<&Cholesky> {
        if self.factor.is_none() {
            self.factor = self.factorise(&self.system(SUSPECT_CHI2).0);
        }
        self.factor.as_ref()
    }
}

#[cfg(test)]
mod tests;
