//! The answer: mean and covariance of the mode that most of the belief is in.
//!
//! The mean of two rooms is the wall between them. So poses that belong together
//! ([`Bins`]) are one mode, the heaviest mode is the answer, and the others are
//! for the belief to show.

use nalgebra::{Matrix3, Vector3};
use rusty_geometry::SE2;

use super::Particles;
use super::everywhere::is_within;
use crate::kld::Bins;

/// Side of the bins that touch within a mode, m.
pub(crate) const SIDE_M: f64 = 0.25;
/// How many of them to a full turn.
pub(crate) const TURNS: u32 = 24;

/// Modes of two beliefs farther apart than this are not the same place, m, nor are those that
/// head so much elsewhere, rad: a corridor looks the same both ways.
const APART_M: f64 = 0.5;
const APART_RAD: f64 = 1.0;

/// The largest σ of the position of an answer, m.
const NOWHERE_M: f64 = 1.0;

/// Whether a covariance (m, m, rad) is small enough for an answer.
pub(crate) fn is_somewhere(covariance: &Matrix3<f64>) -> bool {
    covariance[(0, 0)].max(covariance[(1, 1)]) <= NOWHERE_M * NOWHERE_M
}

/// A part of the belief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Mean on the group, world frame.
    pub pose_in_world: SE2,
    /// Covariance (m, m, rad) in the tangent space there.
    pub covariance: Matrix3<f64>,
    /// How much of the belief is in it.
    pub share: f64,
    /// How much of it is in the second heaviest.
    pub second_share: f64,
}

impl Mode {
    /// Whether its mean is no more than half a metre and a radian from a pose.
    pub fn is_at(&self, pose_in_world: &SE2) -> bool {
        is_within(&self.pose_in_world, pose_in_world, APART_M, APART_RAD)
    }
}

/// Finds the heaviest mode.
#[derive(Clone, Debug)]
pub struct Modes {
    bins: Bins,
    shares: Vec<f64>,
}

impl Default for Modes {
    fn default() -> Self {
        Self::of_bins(Bins::new(SIDE_M, TURNS))
    }
}

impl Modes {
    /// Finds modes as sets of such bins.
    pub(crate) fn of_bins(bins: Bins) -> Self {
        Self { bins, shares: Vec::new() }
    }

    /// Whether the heaviest modes of two beliefs are not the same place.
    pub fn are_apart(&mut self, one: &Particles, other: &Particles) -> bool {
        let [one, other] = [one, other].map(|particles| self.heaviest(particles));
        one.zip(other).is_some_and(|(one, other)| !one.is_at(&other.pose_in_world))
    }

    /// The heaviest mode; `None` of no particles.
    pub fn heaviest(&mut self, particles: &Particles) -> Option<Mode> {
        self.bins.fill(particles.poses());
        let mode_of = self.bins.modes();
        self.shares.clear();
        self.shares.resize(particles.count(), 0.0);
        for (mode, weight) in mode_of.iter().zip(&particles.weights) {
            self.shares[*mode as usize] += weight;
        }
        let mut best = 0;
        for (mode, share) in self.shares.iter().enumerate() {
            if *share > self.shares[best] {
                best = mode;
            }
        }
        let share = *self.shares.get(best)?;
        let others = self.shares.iter().enumerate().filter(|(mode, _)| *mode != best);
        let second_share = others.map(|(_, share)| *share).fold(0.0, f64::max);
        let members = |k: &usize| mode_of[*k] as usize == best && particles.weights[*k] > 0.0;
        let members: Vec<usize> = (0..particles.count()).filter(members).collect();
        let heaviest =
            |a: &&usize, b: &&usize| particles.weights[**a].total_cmp(&particles.weights[**b]);
        let mut mean = particles.pose(*members.iter().max_by(heaviest)?);
        // The mean on the group is where the errors add up to nothing; two or
        // three steps come as near as numbers go.
        for _ in 0..4 {
            let mut sum = Vector3::zeros();
            for &k in &members {
                sum += particles.pose(k).boxminus(&mean) * (particles.weights[k] / share);
            }
            mean = mean.boxplus(&sum);
        }
        let mut covariance = Matrix3::zeros();
        for &k in &members {
            let tau = particles.pose(k).boxminus(&mean);
            covariance += tau * tau.transpose() * (particles.weights[k] / share);
        }
        Some(Mode { pose_in_world: mean, covariance, share, second_share })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn the_answer_is_the_heavier_of_two_peaks_and_not_their_mean() {
        let (mut particles, mut random) = (Particles::default(), Random::new(1, 1));
        let covariance = Matrix3::from_diagonal(&Vector3::new(4e-4, 1e-4, 9e-4));
        // One of them heads along the cut at half a turn.
        let (light, heavy) = (SE2::new(1.0, 1.0, 0.0), SE2::new(5.0, 1.0, 3.1413));
        particles.push_normal(&light, &covariance, 6000, &mut random);
        particles.push_normal(&heavy, &covariance, 4000, &mut random);
        particles.weights[..6000].fill(0.3 / 6000.0);
        particles.weights[6000..].fill(0.7 / 4000.0);
        let mode = Modes::default().heaviest(&particles).unwrap();
        assert!((mode.share - 0.7).abs() < 1e-9, "{mode:?}");
        assert!((mode.second_share - 0.3).abs() < 1e-9, "{mode:?}");
        let error = mode.pose_in_world.boxminus(&heavy);
        assert!(error.norm() < 2e-3, "{error}");
        for i in 0..3 {
            let ratio = mode.covariance[(i, i)] / covariance[(i, i)];
            assert!((ratio - 1.0).abs() < 0.1, "{i}: {ratio}");
        }
        assert!((mode.covariance - mode.covariance.transpose()).norm() == 0.0);
    }

    #[test]
    fn a_place_is_another_one_the_other_way_round() {
        let mode = Mode {
            pose_in_world: SE2::new(1.0, 2.0, 3.0),
            covariance: Matrix3::identity(),
            share: 1.0,
            second_share: 0.0,
        };
        for (x_m, rad, is_at) in
            [(1.4, 3.0, true), (1.6, 3.0, false), (1.0, -2.9, true), (1.0, 0.1, false)]
        {
            assert_eq!(mode.is_at(&SE2::new(x_m, 2.0, rad)), is_at, "{x_m} {rad}");
        }
    }

    #[test]
    fn of_one_particle_the_answer_is_that_and_of_none_nothing() {
        let mut particles = Particles::default();
        assert_eq!(Modes::default().heaviest(&particles), None);
        particles.push(&SE2::new(1.0, 2.0, 3.0));
        particles.level();
        let mode = Modes::default().heaviest(&particles).unwrap();
        assert_eq!((mode.pose_in_world, mode.covariance), (particles.pose(0), Matrix3::zeros()));
    }
}
