//! Poses and how much each of them weighs, as a structure of arrays.

use nalgebra::{Matrix3, Vector2, Vector3};
use rusty_geometry::{SE2, trig, wrap_angle};

use super::even::{EvenErrors, even_normal, order};
use crate::{Motion, Random};

/// How far the metres of the robot's way per metre of its wheels may be from 1: one deviation,
const SCALE_STD: f64 = 0.02;
/// and by how much that changes on a metre.
const SCALE_DRIFT: f64 = 0.002;

/// Weighted poses of the body in the world frame.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// World frame, m.
    pub x_m: Vec<f64>,
    /// World frame, m.
    pub y_m: Vec<f64>,
    /// World frame, rad, in (−π, π].
    pub theta_rad: Vec<f64>,
    /// Metres of way per metre that the wheels say. A particle keeps its own, so that a
    /// robot whose wheels are worn leaves those behind that believe them.
    scales: Vec<f64>,
    /// They add up to 1.
    pub weights: Vec<f64>,
    /// Sine and cosine of each heading: a scan asks for them again and again.
    sin_cos: Vec<(f64, f64)>,
    errors: EvenErrors,
}

impl Particles {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.x_m.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.x_m.is_empty()
    }

    /// One of them.
    pub fn pose(&self, k: usize) -> SE2 {
        SE2::new(self.x_m[k], self.y_m[k], self.theta_rad[k])
    }

    /// All of them, in order.
    pub fn poses(&self) -> impl Iterator<Item = SE2> + '_ {
        (0..self.count()).map(|k| self.pose(k))
    }

    /// Where one of them is, m, and sine and cosine of its heading.
    pub fn place(&self, k: usize) -> (Vector2<f64>, f64, f64) {
        let (sin, cos) = self.sin_cos[k];
        (Vector2::new(self.x_m[k], self.y_m[k]), sin, cos)
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.x_m.clear();
        self.y_m.clear();
        self.theta_rad.clear();
        self.scales.clear();
        self.weights.clear();
        self.sin_cos.clear();
    }

    /// Adds one, which weighs nothing yet. Those of any few in a row have even scales.
    pub fn push(&mut self, pose: &SE2) {
        self.scales.push(1.0 + SCALE_STD * even_normal(self.scales.len()));
        self.x_m.push(pose.x());
        self.y_m.push(pose.y());
        self.theta_rad.push(pose.theta());
        self.sin_cos.push(trig::sin_cos(pose.theta()));
        self.weights.push(0.0);
    }

    /// Makes all of them equally heavy.
    pub fn level(&mut self) {
        let equal = 1.0 / self.count().max(1) as f64;
        self.weights.fill(equal);
    }

    /// Adds `count` draws from the normal law around `mean`.
    pub fn push_normal(
        &mut self,
        mean: &SE2,
        covariance: &Matrix3<f64>,
        count: usize,
        random: &mut Random,
    ) {
        let root = root(covariance);
        for _ in 0..count {
            let z = Vector3::new(random.normal(), random.normal(), random.normal());
            self.push(&mean.boxplus(&(root * z)));
        }
    }

    /// The heaviest one.
    pub fn heaviest(&self) -> Option<SE2> {
        let weights = self.weights.iter().enumerate();
        let (k, _) = weights.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        Some(self.pose(k))
    }

    /// Puts them in order along the longest axis of their positions.
    pub fn sort(&mut self) {
        fn permute<T: Copy>(values: &mut Vec<T>, order: &[u32]) {
            *values = order.iter().map(|k| values[*k as usize]).collect();
        }
        let order = order(&self.x_m, &self.y_m, &self.weights);
        let Self { x_m, y_m, theta_rad, scales, weights, .. } = self;
        for values in [x_m, y_m, theta_rad, scales, weights] {
            permute(values, &order);
        }
        permute(&mut self.sin_cos, &order);
    }

    /// Moves each by a separate motion, drawn from what is believed of the one and of the
    /// other in turn (Table 8.2, line 4), times its scale. The errors of neighbours lie evenly,
    /// and are heavy-tailed or normal (see the module `even`).
    pub fn move_by(&mut self, motions: &[Motion; 2], are_heavy: bool, random: &mut Random) {
        let motions = motions.map(|motion| (motion.now_in_then, by_heading(&motion.covariance)));
        let drift = SCALE_DRIFT * motions[0].0.translation().norm().sqrt();
        if drift > 0.0 {
            self.scales.iter_mut().for_each(|scale| *scale += drift * random.normal());
        }
        let of_each = self.errors.draw(self.x_m.len(), are_heavy, random);
        for (k, z) in of_each.iter().enumerate() {
            let (now_in_then, root) = &motions[k % 2];
            let moved = now_in_then.boxplus(&(root * Vector3::from(*z)));
            let (sin, cos) = self.sin_cos[k];
            let scale = self.scales[k];
            self.x_m[k] += scale * (cos * moved.x() - sin * moved.y());
            self.y_m[k] += scale * (sin * moved.x() + cos * moved.y());
            self.theta_rad[k] = wrap_angle(self.theta_rad[k] + moved.theta());
            self.sin_cos[k] = trig::sin_cos(self.theta_rad[k]);
        }
    }

    /// Makes `poses` the drawn ones, each moved by a normal error with these
    /// standard deviations (m, rad).
    pub fn draw(
        &self,
        drawn: &[u32],
        spread: (f64, f64),
        random: &mut Random,
        poses: &mut Vec<SE2>,
    ) {
        poses.clear();
        poses.extend(drawn.iter().map(|of| {
            let pose = self.pose(*of as usize);
            if spread.0 <= 0.0 {
                return pose;
            }
            let z = [random.normal(), random.normal(), random.normal()];
            pose.boxplus(&Vector3::new(spread.0 * z[0], spread.0 * z[1], spread.1 * z[2]))
        }));
    }

    /// Forgets all, and takes these instead, equally heavy; with the scales of those that
    /// they are `of`, if these are known.
    pub fn set(&mut self, poses: &[SE2], of: &[u32], are_known: bool) {
        let scales: Vec<f64> = of.iter().map(|k| self.scales[*k as usize]).collect();
        self.clear();
        poses.iter().for_each(|pose| self.push(pose));
        if are_known {
            self.scales = scales;
        }
        self.level();
    }

    /// The motion that the wheels say, as long as it is believed to be.
    pub fn scaled(&self, wheels: &Motion) -> Motion {
        let of_each = self.weights.iter().zip(&self.scales);
        // They add up to 1, and there may be none.
        let scale = 1.0 + of_each.map(|(weight, scale)| weight * (scale - 1.0)).sum::<f64>();
        let way = wheels.now_in_then;
        let now_in_then = SE2::new(scale * way.x(), scale * way.y(), way.theta());
        Motion { now_in_then, ..*wheels }
    }
}

/// An upper triangular root of a covariance (m, m, rad): the heading depends on the last
/// number alone, the most even one.
fn by_heading(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let swap = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0);
    swap * root(&(swap * covariance * swap)) * swap
}

/// A lower triangular root of a covariance. One that is not of full rank (the
/// robot stood still) has zeros there.
pub(crate) fn root(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let mut l = Matrix3::<f64>::zeros();
    for j in 0..3 {
        let square = covariance[(j, j)] - (0..j).map(|k| l[(j, k)] * l[(j, k)]).sum::<f64>();
        if square.is_nan() || square <= 1e-12 * covariance[(j, j)] {
            continue;
        }
        l[(j, j)] = square.sqrt();
        for i in j + 1..3 {
            let rest = covariance[(i, j)] - (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            l[(i, j)] = rest / l[(j, j)];
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_squared_is_the_covariance_of_whatever_rank() {
        let a = Matrix3::new(0.3, 0.0, 0.0, 0.1, 0.2, 0.0, -0.4, 0.5, 0.1);
        let flat = Matrix3::new(0.3, 0.0, 0.0, 0.6, 0.0, 0.0, -0.4, 0.5, 0.0);
        for l in [a, flat, Matrix3::zeros()] {
            let covariance = l * l.transpose();
            let root = root(&covariance);
            assert!((root * root.transpose() - covariance).norm() < 1e-12, "{covariance}");
            let root = by_heading(&covariance);
            assert!((root * root.transpose() - covariance).norm() < 1e-12, "{covariance}");
            assert_eq!((root[(2, 0)], root[(2, 1)]), (0.0, 0.0));
        }
    }

    #[test]
    fn particles_move_as_the_motion_is_believed() {
        let motion = Motion {
            now_in_then: SE2::new(0.3, 0.1, 0.4),
            covariance: Matrix3::from_diagonal(&Vector3::new(1e-4, 4e-4, 9e-4)),
        };
        let start = SE2::new(2.0, 1.0, 3.0);
        let (mut particles, mut random) = (Particles::default(), Random::new(1, 1));
        (0..20_000).for_each(|_| particles.push(&start));
        let half =
            Motion { now_in_then: SE2::new(0.15, 0.05, 0.2), covariance: motion.covariance * 0.25 };
        particles.move_by(&[motion, half], false, &mut random);
        let mut sums = [Matrix3::zeros(); 2];
        for k in 0..particles.count() {
            let end = start.compose(&[motion, half][k % 2].now_in_then);
            let tau = particles.pose(k).boxminus(&end);
            sums[k % 2] += tau * tau.transpose();
            let (_, sin, cos) = particles.place(k);
            assert_eq!((sin, cos), trig::sin_cos(particles.pose(k).theta()));
        }
        for (sum, of) in sums.iter().zip([motion, half]) {
            let found = sum / (0.5 * particles.count() as f64);
            let (way, mut expected) = (of.now_in_then, of.covariance);
            // The scales: a tangent vector ends where the motion ends.
            let of_scale = SE2::new(way.x() * 1.001, way.y() * 1.001, way.theta());
            let by_scale = of_scale.boxminus(&way) * (1e3 * SCALE_STD);
            expected += by_scale * by_scale.transpose();
            for i in 0..3 {
                let ratio = found[(i, i)] / expected[(i, i)];
                assert!((ratio - 1.0).abs() < 0.05, "{i}: {ratio}");
            }
        }
    }

    #[test]
    fn heavy_errors_of_a_motion_are_more_often_large() {
        let covariance = Matrix3::from_diagonal(&Vector3::new(1e-4, 4e-4, 9e-4));
        let turn = Motion { now_in_then: SE2::new(0.0, 0.0, 0.4), covariance };
        let start = SE2::new(2.0, 1.0, 3.0);
        let (mut particles, mut random) = (Particles::default(), Random::new(1, 1));
        (0..20_000).for_each(|_| particles.push(&start));
        particles.move_by(&[turn; 2], true, &mut random);
        let end = start.compose(&turn.now_in_then);
        for i in 0..3 {
            let std = covariance[(i, i)].sqrt();
            let off = |pose: SE2| pose.boxminus(&end)[i].abs() / std;
            // Tables of Student's t with two degrees of freedom, times √π/2.
            for (bound, share) in [(0.7236, 0.5), (2.5878, 0.1), (5.6171, 0.024)] {
                let beyond = particles.poses().filter(|pose| off(*pose) > bound).count();
                let ratio = beyond as f64 / particles.count() as f64 / share;
                assert!((ratio - 1.0).abs() < 0.05, "{i}, {bound}: {ratio}");
            }
        }
    }
}
