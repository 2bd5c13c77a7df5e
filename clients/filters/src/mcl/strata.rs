//! Places apart that the robot can be in, weighed and drawn each for itself.
//!
//! Two rooms that look the same explain every scan equally well, and yet a plain particle
//! filter ends in one of them by chance. At the width of the likelihood of 180 beams the
//! nearest particle decides, and errors that the beams have in common count 180 times.
//!
//! Source: A. Milstein, J. Sánchez, E. Williamson, *Robust global localization using
//! clustered particle filtering* (AAAI 2002): clusters of particles are separate
//! filters, each with a probability that the likelihoods of its particles change, and drawing
//! moves no particles from one cluster to another. The mixture of J. Vermaak, A. Doucet,
//! P. Pérez (*Maintaining multi-modality through mixture tracking*, ICCV 2003) is the same.
//!
//! Departures, and why:
//! * Clusters are found anew at every scan, as the modes of the answer are ([`Bins`]).
//! * Between clusters a scan counts as at most as many independent beams as in a blurred
//!   field ([`super::sensor`]), and with the mean logarithm of the particles that explain
//!   it, so that the one nearest particle does not decide. Small differences do not count: the
//!   cells of a field make them in every scan alike, and they would add up. Within a
//!   cluster a scan counts in full.
//! * A cluster of less than a hundredth of the belief is not kept by force.

use super::Particles;
use super::mode::{SIDE_M, TURNS};
use super::sensor::{BEAMS_WORTH, Rung};
use crate::kld::Bins;
use crate::resampling::{effective_size, low_variance, normalise};
use rusty_geometry::trig;

/// The share of the belief from which on a cluster is kept.
const LEAST_SHARE: f64 = 0.01;
/// A difference of ln p of a beam between clusters that the cells of a field can make, and
/// that few particles can make.
const OF_CELLS: f64 = 0.04;
/// The most clusters that are kept apart; the others are one more.
const MOST: usize = 16;
/// The fewest particles of a cluster that is kept, where half of all suffice for that.
const LEAST_PARTICLES: usize = 150;

/// Particles by the cluster that they are in.
#[derive(Debug)]
pub(super) struct Strata {
    bins: Bins,
    /// Members of each cluster, and its share of the belief. The last are all the rest.
    members: Vec<Vec<u32>>,
    shares: Vec<f64>,
}

impl Default for Strata {
    fn default() -> Self {
        Self { bins: Bins::new(SIDE_M, TURNS), members: Vec::new(), shares: Vec::new() }
    }
}

impl Strata {
    /// Finds the clusters. Returns whether there are two that are to be kept.
    pub fn find(&mut self, particles: &Particles) -> bool {
        self.bins.fill(particles.poses());
        let mode_of = self.bins.modes();
        let mut of_mode = vec![0.0; particles.count()];
        for (mode, weight) in mode_of.iter().zip(&particles.weights) {
            of_mode[*mode as usize] += weight;
        }
        let kept = |mode: &usize| of_mode[*mode] >= LEAST_SHARE;
        let mut modes: Vec<usize> = (0..of_mode.len()).filter(kept).collect();
        // The sort is stable: of equal ones the first in the order of the bins.
        modes.sort_by(|a, b| of_mode[*b].total_cmp(&of_mode[*a]));
        modes.truncate(MOST);
        let rest = modes.len();
        let mut stratum_of = vec![rest; of_mode.len()];
        modes.iter().enumerate().for_each(|(stratum, mode)| stratum_of[*mode] = stratum);
        self.members.iter_mut().for_each(Vec::clear);
        self.members.resize(rest + 1, Vec::new());
        self.shares.clear();
        self.shares.resize(rest + 1, 0.0);
        for (k, (mode, weight)) in mode_of.iter().zip(&particles.weights).enumerate() {
            let stratum = stratum_of[*mode as usize];
            self.members[stratum].push(k as u32);
            self.shares[stratum] += weight;
        }
        rest > 1
    }

    /// Weighs anew what a scan has weighed, from the weights `prior` before it.
    pub fn weigh(&mut self, prior: &[f64], rung: &Rung<'_>, weights: &mut [f64]) {
        let mut evidence = vec![f64::NEG_INFINITY; self.shares.len()];
        for (members, evidence) in self.members.iter().zip(&mut evidence) {
            let log = |k: &u32| rung.exponent * rung.logs[*k as usize];
            let best = members.iter().map(log).fold(f64::NEG_INFINITY, f64::max);
            let (mut sum, mut of_logs) = (0.0, 0.0);
            for k in members {
                let weight = prior[*k as usize] * trig::exp(log(k) - best);
                weights[*k as usize] = weight;
                (sum, of_logs) = (sum + weight, of_logs + weight * log(k));
            }
            if sum > 0.0 {
                *evidence = of_logs / sum / rung.worth;
                members.iter().for_each(|k| weights[*k as usize] /= sum);
            }
        }
        let best = evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (share, evidence) in self.shares.iter_mut().zip(&evidence) {
            let worse = (best - evidence - OF_CELLS).max(0.0);
            *share *= trig::exp(-worse * rung.worth.min(BEAMS_WORTH));
        }
        normalise(&mut self.shares);
        for (members, share) in self.members.iter().zip(&self.shares) {
            members.iter().for_each(|k| weights[*k as usize] *= share);
        }
    }

    /// How many equally heavy particles these are worth, if each cluster needs its own.
    pub fn effective_size(&self, weights: &[f64]) -> f64 {
        let of = |members: &Vec<u32>| {
            let own: Vec<f64> = members.iter().map(|k| weights[*k as usize]).collect();
            effective_size(&own)
        };
        self.members.iter().map(of).sum()
    }

    /// Draws at most `count` particles, from each cluster a least number, and the others by
    /// its share of the belief. `drawn` becomes their numbers, `heavy` their weights. `start` is of
    /// [0, 1).
    pub fn draw(
        &self,
        weights: &[f64],
        count: usize,
        start: f64,
        drawn: &mut Vec<u32>,
        heavy: &mut Vec<f64>,
    ) {
        drawn.clear();
        heavy.clear();
        let (mut own, mut of_own) = (Vec::new(), Vec::new());
        let rest = self.members.len() - 1;
        let least = LEAST_PARTICLES.min(count / (2 * rest.max(1)));
        for (stratum, members) in self.members.iter().enumerate() {
            own.clear();
            own.extend(members.iter().map(|k| weights[*k as usize]));
            let share: f64 = own.iter().sum();
            let by_share = (share * (count - rest * least) as f64 + 1e-9) as usize;
            let number = if stratum < rest { least + by_share } else { by_share };
            if number == 0 || share <= 0.0 {
                continue;
            }
            normalise(&mut own);
            low_variance(&own, number, start, &mut of_own);
            drawn.extend(of_own.iter().map(|k| members[*k as usize]));
            heavy.resize(drawn.len(), share / number as f64);
        }
        normalise(heavy);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use nalgebra::{Matrix3, Vector3};
    use rusty_geometry::SE2;

    /// Two clusters of these numbers of particles with 0.9 and 0.1 of the belief.
    fn two(first: usize, second: usize) -> Particles {
        let (mut particles, mut random) = (Particles::default(), Random::new(1, 1));
        let narrow = Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-4, 1e-4));
        particles.push_normal(&SE2::new(1.0, 1.0, 0.0), &narrow, first, &mut random);
        particles.push_normal(&SE2::new(9.0, 1.0, 0.0), &narrow, second, &mut random);
        particles.weights[..first].fill(0.9 / first as f64);
        particles.weights[first..].fill(0.1 / second as f64);
        particles
    }

    fn second(particles: &Particles, weights: &[f64]) -> f64 {
        let of = |(k, weight): (usize, &f64)| if particles.x_m[k] > 5.0 { *weight } else { 0.0 };
        weights.iter().enumerate().map(of).sum()
    }

    #[test]
    fn one_nearest_particle_does_not_decide_between_clusters() {
        let particles = two(500, 500);
        let mut strata = Strata::default();
        assert!(strata.find(&particles));
        // The scan fits both equally, but one particle of the first by 12 better.
        let mut logs = vec![-100.0; 1000];
        (logs[3], logs[700]) = (-88.0, -90.0);
        let rung = Rung { logs: &logs, exponent: 1.0, worth: 160.0 };
        let mut weights = particles.weights.clone();
        strata.weigh(&particles.weights, &rung, &mut weights);
        let sum: f64 = weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        let share = second(&particles, &weights);
        assert!((share - 0.1).abs() < 1e-9, "{share}");
        // Within a cluster the scan counts in full.
        assert!(weights[3] > 100.0 * weights[4]);
        // By what most of its beams say, it does decide.
        logs[500..].fill(-300.0);
        let rung = Rung { logs: &logs, exponent: 1.0, worth: 160.0 };
        strata.find(&particles);
        strata.weigh(&particles.weights, &rung, &mut weights);
        assert!(second(&particles, &weights) < 1e-4);
    }

    #[test]
    fn a_light_cluster_keeps_particles_and_its_share() {
        let particles = two(5000, 3);
        let mut strata = Strata::default();
        assert!(strata.find(&particles));
        let (mut drawn, mut heavy) = (Vec::new(), Vec::new());
        strata.draw(&particles.weights, 200, 0.3, &mut drawn, &mut heavy);
        let of_second = drawn.iter().filter(|k| **k >= 5000).count();
        assert_eq!((of_second, drawn.len()), (50 + 10, 200));
        let share: f64 =
            drawn.iter().zip(&heavy).filter(|(k, _)| **k >= 5000).map(|(_, w)| w).sum();
        assert!((share - 0.1).abs() < 1e-9, "{share}");
        // Unequal clusters of equal particles are worth all of them.
        assert!((strata.effective_size(&particles.weights) - 5003.0).abs() < 1e-6);
    }

    #[test]
    fn one_cluster_is_left_to_the_plain_filter() {
        let mut particles = two(500, 500);
        particles.weights[500..].fill(1e-6);
        normalise(&mut particles.weights);
        assert!(!Strata::default().find(&particles));
        assert!(!Strata::default().find(&Particles::default()));
    }
}
