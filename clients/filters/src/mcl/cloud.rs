//! Particles that are moved, weighed and drawn: Table 8.2 with the number of
//! Table 8.4.

use super::sensor::Sensor;
use super::{Options, Particles};
use crate::kld::{Bins, sample_size};
use crate::resampling::{effective_size, low_variance};
use crate::{Motion, Random};

/// Side of the bins that particles are counted in, m, and their number in a turn.
const BINS: (f64, u32) = (0.1, 36);
/// ε of the KLD: how far the sample may be from the belief,
const EPSILON: f64 = 0.05;
/// and the quantile of the normal law for doing so in 99 of 100 cases.
const QUANTILE: f64 = 2.326_347_874;
/// Particles are drawn anew when their weights are worth less than this share.
const WORTH: f64 = 0.5;

/// A sample of a belief.
#[derive(Debug)]
pub(super) struct Cloud {
    pub particles: Particles,
    /// Likelihood of a beam of the last scan: the geometric mean over beams and
    /// particles, by their weights after it.
    pub beam_likelihood: f64,
    /// Whether the last scan was weighed as sharply as can be.
    pub settled: bool,
    /// How many scans it has taken.
    pub scans: u32,
    bins: Bins,
    /// By how much the survivors of the last scan are to be spread (m, rad).
    spread: (f64, f64),
    drawn: Vec<u32>,
    motions: Random,
    draws: Random,
}

impl Cloud {
    /// No particles yet. `purpose` and the next one are its streams of numbers.
    pub fn new(seed: u64, purpose: u64) -> Self {
        Self {
            particles: Particles::default(),
            beam_likelihood: 0.0,
            settled: false,
            scans: 0,
            bins: Bins::new(BINS.0, BINS.1),
            spread: (0.0, 0.0),
            drawn: Vec::new(),
            motions: Random::new(seed, purpose),
            draws: Random::new(seed, purpose + 1),
        }
    }

    /// Forgets all it has learned, for particles that are to come.
    pub fn clear(&mut self) {
        self.particles.clear();
        (self.beam_likelihood, self.settled, self.scans) = (0.0, false, 0);
    }

    /// Moves all particles, each by a motion of its own.
    pub fn move_by(&mut self, motion: &Motion) {
        self.particles.move_by(motion, &mut self.motions);
    }

    /// Weighs all particles. Says whether the scan had anything to say.
    pub fn weigh(&mut self, sensor: &mut Sensor, ranges_m: &[f64]) -> bool {
        let Some(weighed) = sensor.weigh(ranges_m, &mut self.particles) else { return false };
        self.beam_likelihood = weighed.beam_likelihood;
        self.spread = weighed.spread;
        self.settled = weighed.spread.0 == 0.0;
        self.scans += 1;
        true
    }

    /// Draws the next generation, if the weights call for one.
    pub fn draw(&mut self, options: &Options) {
        let (least, most) = (options.particles_min as usize, options.particles as usize);
        let weights = &self.particles.weights;
        if effective_size(weights) >= WORTH * weights.len() as f64 {
            return;
        }
        low_variance(weights, weights.len(), self.draws.uniform(), &mut self.drawn);
        let drawn = self.drawn.iter().map(|k| self.particles.pose(*k as usize));
        let needed = sample_size(self.bins.fill(drawn), EPSILON, QUANTILE);
        let count = needed.max(least).min(most);
        low_variance(weights, count, self.draws.uniform(), &mut self.drawn);
        self.particles.replace(&self.drawn, self.spread, &mut self.draws);
    }
}
