//! Particles that are moved, weighed and drawn: Table 8.2 with the number of
//! Table 8.4.
//!
//! Scans of a robot that stands still err in the same way, as far as they err
//! because of the map and the model, and its particles do not move apart: counted
//! one after the other, a minute of them would leave copies of one particle and
//! a covariance of nothing (§4.3.4 warns of it). So of every place one scan counts,
//! as in ROS's amcl, whose `update_min_d` says what a place is. There are two
//! exceptions. As long as the particles are too far apart for a scan to be taken
//! as sharply as it is, each counts: on its way up the ladder of [`super::sensor`]
//! a cloud is spread again at every step, and a robot that wakes up standing is to
//! find itself. And how well the belief explains a scan is asked of every one: so a
//! robot that is carried away with its wheels still is missed.

use super::sensor::Sensor;
use super::strata::Strata;
use super::{Options, Particles};
use crate::kld::{Bins, sample_size};
use crate::resampling::{effective_size, low_variance};
use crate::{Motion, Random};
use rusty_geometry::SE2;

/// Side of the bins that particles are counted in, m, and their number in a turn.
const BINS: (f64, u32) = (0.1, 36);
/// ε of the KLD: how far the sample may be from the belief,
const EPSILON: f64 = 0.05;
/// and the quantile of the normal law for doing so in 99 of 100 cases.
const QUANTILE: f64 = 2.326_347_874;
/// Particles are drawn anew when their weights are worth less than this share.
const WORTH: f64 = 0.5;
/// Nearer to where the last scan counted than this, m,
const SAME_PLACE_M: f64 = 0.01;
/// and turned by less, rad, the robot is at the same place.
const SAME_PLACE_RAD: f64 = 0.01;

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
    /// Way of the robot since the last scan that counted.
    since: SE2,
    bins: Bins,
    /// By how much the survivors of the last scan are to be spread (m, rad).
    spread: (f64, f64),
    strata: Strata,
    drawn: Vec<u32>,
    heavy: Vec<f64>,
    trial: Vec<SE2>,
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
            since: SE2::identity(),
            bins: Bins::new(BINS.0, BINS.1),
            spread: (0.0, 0.0),
            strata: Strata::default(),
            drawn: Vec::new(),
            heavy: Vec::new(),
            trial: Vec::new(),
            motions: Random::new(seed, purpose),
            draws: Random::new(seed, purpose + 1),
        }
    }

    /// Forgets all it has learned, for particles that are to come.
    pub fn clear(&mut self) {
        self.particles.clear();
        (self.beam_likelihood, self.settled, self.scans) = (0.0, false, 0);
        self.since = SE2::identity();
    }

    /// Moves all particles, by one or the other motion. The first is that of the wheels,
    /// and says whether the next scan is of another place. If it is not, no scan will choose
    /// between the particles, and their errors are normal.
    pub fn move_by(&mut self, motions: &[Motion; 2], are_heavy: bool) {
        self.since = self.since.compose(&motions[0].now_in_then);
        let are_heavy = are_heavy && !self.is_same_place();
        self.particles.move_by(motions, are_heavy, &mut self.motions);
    }

    /// Weighs all particles, if the scan counts. Says whether it had anything to
    /// say.
    pub fn weigh(&mut self, sensor: &mut Sensor, ranges_m: &[f64]) -> bool {
        if self.settled && self.is_same_place() {
            let Some(likelihood) = sensor.beam_likelihood(ranges_m, &self.particles) else {
                return false;
            };
            self.beam_likelihood = likelihood;
            self.scans += 1;
            return true;
        }
        let is_apart = self.strata.find(&self.particles);
        let Some(weighed) = sensor.weigh(ranges_m, &mut self.particles) else { return false };
        let (rung, prior) = sensor.rung();
        if is_apart {
            self.strata.weigh(prior, &rung, &mut self.particles.weights);
        }
        self.beam_likelihood = weighed.beam_likelihood;
        self.spread = weighed.spread;
        self.settled = weighed.spread.0 == 0.0;
        self.scans += 1;
        self.since = SE2::identity();
        true
    }

    /// Likelihood of a beam of the last scan, which it was weighed by, without those of something
    /// in front of the walls; 0 of no particles.
    pub fn seen_likelihood(&self, sensor: &Sensor, ranges_m: &[f64]) -> f64 {
        let heaviest = self.particles.heaviest();
        heaviest.map_or(0.0, |pose| sensor.without_hidden(ranges_m, &pose, self.beam_likelihood))
    }

    /// Whether the robot is where it was when the last scan counted.
    fn is_same_place(&self) -> bool {
        self.since.translation().norm() < SAME_PLACE_M && self.since.theta().abs() < SAME_PLACE_RAD
    }

    /// Draws the next generation, if the weights call for one. While it is not known where
    /// the robot is, those that survive tell nothing of its wheels.
    pub fn draw(&mut self, options: &Options, is_known: bool) {
        let (least, most) = (options.least() as usize, options.particles as usize);
        let weights = &self.particles.weights;
        if effective_size(weights) >= WORTH * weights.len() as f64 {
            return;
        }
        if self.strata.find(&self.particles) {
            self.draw_apart(least, most, is_known);
            return;
        }
        self.particles.sort();
        let weights = &self.particles.weights;
        low_variance(weights, weights.len(), self.draws.uniform(), &mut self.drawn);
        // Spread as those that are kept will be: that is what their bins are of.
        self.particles.draw(&self.drawn, self.spread, &mut self.draws, &mut self.trial);
        let needed = sample_size(self.bins.fill(self.trial.iter().copied()), EPSILON, QUANTILE);
        let count = needed.max(least).min(most);
        low_variance(weights, count, self.draws.uniform(), &mut self.drawn);
        self.particles.draw(&self.drawn, self.spread, &mut self.draws, &mut self.trial);
        self.particles.set(&self.trial, &self.drawn, is_known);
    }

    /// The same where the belief has several places: from each for itself.
    fn draw_apart(&mut self, least: usize, most: usize, is_known: bool) {
        let Self { particles, strata, bins, drawn, heavy, trial, draws, spread, .. } = self;
        let weights = &particles.weights;
        if strata.effective_size(weights) >= WORTH * weights.len() as f64 {
            return;
        }
        let start = draws.uniform();
        strata.draw(weights, weights.len().min(most), start, drawn, heavy);
        particles.draw(drawn, *spread, draws, trial);
        let needed = sample_size(bins.fill(trial.iter().copied()), EPSILON, QUANTILE);
        strata.draw(weights, needed.max(least).min(most), draws.uniform(), drawn, heavy);
        particles.draw(drawn, *spread, draws, trial);
        particles.set(trial, drawn, is_known);
        particles.weights.clone_from(heavy);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};
    use rusty_geometry::trig;

    #[test]
    fn bins_are_counted_where_those_that_are_kept_come_to_lie() {
        let mut cloud = Cloud::new(1, 2);
        (0..2000).for_each(|k| cloud.particles.push(&SE2::new(f64::from(k % 3), 0.0, 0.0)));
        // Two of three places have weight.
        cloud.particles.level();
        cloud.particles.weights.iter_mut().skip(2).step_by(3).for_each(|w| *w = 0.0);
        cloud.particles.weights.iter_mut().take(300).for_each(|w| *w *= 20.0);
        crate::resampling::normalise(&mut cloud.particles.weights);
        let options = Options { particles: 50_000, particles_min: Some(10), ..Options::default() };
        let (mut few, mut many) = (cloud, Cloud::new(1, 2));
        many.particles = few.particles.clone();
        few.draw(&options, true);
        // Two bins: 1 degree of freedom, χ² of 99 % is 6.6, over 2ε.
        assert_eq!(few.particles.count(), sample_size(2, EPSILON, QUANTILE));
        many.spread = (0.1, 0.1);
        many.draw(&options, true);
        // As many as the occupied bins ask for, or a little less: a larger
        // sample reaches a few bins more.
        let bins = many.bins.fill(many.particles.poses());
        let needed = sample_size(bins, EPSILON, QUANTILE) as f64;
        let ratio = many.particles.count() as f64 / needed;
        assert!(bins > 50 && (0.6..1.7).contains(&ratio), "{bins} bins, {ratio}");
    }

    #[test]
    fn a_place_is_left_by_going_or_by_turning() {
        let mut cloud = Cloud::new(1, 2);
        let by = |x_m, theta_rad| {
            let now_in_then = SE2::new(x_m, 0.0, theta_rad);
            [Motion { now_in_then, ..Motion::default() }, Motion::default()]
        };
        assert!(cloud.is_same_place());
        cloud.move_by(&by(0.006, 0.0), false);
        cloud.move_by(&by(-0.006, 0.009), true);
        assert!(cloud.is_same_place());
        cloud.move_by(&by(0.0, 0.002), false);
        assert!(!cloud.is_same_place());
        cloud.clear();
        assert!(cloud.is_same_place());
        (0..3).for_each(|_| cloud.move_by(&by(0.004, 0.0), false));
        assert!(!cloud.is_same_place());
    }

    #[test]
    fn errors_are_heavy_on_the_way_to_another_place_only() {
        let of = |x_m| Motion {
            now_in_then: SE2::new(x_m, 0.0, 0.0),
            covariance: Matrix3::identity() * 1e-6,
        };
        let deviations = |x_m, are_heavy| {
            let mut cloud = Cloud::new(1, 2);
            (0..1000).for_each(|_| cloud.particles.push(&SE2::identity()));
            cloud.move_by(&[of(x_m); 2], are_heavy);
            cloud.particles.theta_rad.iter().map(|theta| theta.abs() / 1e-3).fold(0.0, f64::max)
        };
        assert!(deviations(0.02, true) > 6.0, "{}", deviations(0.02, true));
        for (x_m, are_heavy) in [(0.002, true), (0.002, false), (0.02, false)] {
            assert!(deviations(x_m, are_heavy) < 5.0, "{x_m}: {}", deviations(x_m, are_heavy));
        }
    }

    #[test]
    fn a_direction_that_no_scan_sees_keeps_its_spread() {
        let motion = Motion {
            now_in_then: SE2::identity(),
            covariance: Matrix3::from_diagonal(&Vector3::new(1e-10, 1e-6, 1e-4)),
        };
        for (seed, are_heavy) in (0..10).map(|k| (k / 2, k % 2 == 1)) {
            let mut cloud = Cloud::new(seed, 2);
            let far = Matrix3::from_diagonal(&Vector3::new(0.0025, 1e-6, 1e-6));
            let start = SE2::new(3.0, 1.0, 0.7);
            cloud.particles.push_normal(&start, &far, 1000, &mut Random::new(seed, 9));
            cloud.particles.level();
            for _ in 0..200 {
                cloud.move_by(&[motion; 2], are_heavy);
                // A tenth of them have a heading that fits.
                for k in 0..cloud.particles.count() {
                    let off = (cloud.particles.theta_rad[k] - 0.7) / 0.001;
                    cloud.particles.weights[k] *= trig::exp(-0.5 * off * off);
                }
                crate::resampling::normalise(&mut cloud.particles.weights);
                cloud.draw(&Options::default(), true);
            }
            let along_m: Vec<f64> =
                cloud.particles.poses().map(|pose| pose.boxminus(&start).x).collect();
            let mean = |of: &dyn Fn(f64) -> f64| {
                along_m.iter().map(|x_m| of(*x_m)).sum::<f64>() / along_m.len() as f64
            };
            let mean_m = mean(&|x_m| x_m);
            let deviation_m = mean(&|x_m| (x_m - mean_m) * (x_m - mean_m)).sqrt();
            // Drawn by chance, they are all in one place.
            let (most_m, least_m) = if are_heavy { (0.09, 0.008) } else { (0.06, 0.015) };
            assert!(mean_m.abs() < most_m, "{seed}, {are_heavy}: {mean_m}");
            assert!((least_m..0.09).contains(&deviation_m), "{seed}, {are_heavy}: {deviation_m}");
        }
    }

    #[test]
    fn wheels_that_say_too_much_are_found_out() {
        for seed in 0..5 {
            let mut cloud = Cloud::new(seed, 2);
            let near = Matrix3::from_diagonal(&Vector3::new(0.0025, 1e-6, 1e-6));
            cloud.particles.push_normal(&SE2::identity(), &near, 1000, &mut Random::new(seed, 9));
            cloud.particles.level();
            let wheels = Motion {
                now_in_then: SE2::new(0.52, 0.0, 0.0),
                covariance: Matrix3::from_diagonal(&Vector3::new(1e-6, 1e-10, 1e-6)),
            };
            for scan in 1..=100 {
                cloud.move_by(&[wheels; 2], false);
                // Half a metre more, seen with a deviation of 0.1 m.
                for k in 0..cloud.particles.count() {
                    let off = (cloud.particles.x_m[k] - 0.5 * f64::from(scan)) / 0.1;
                    cloud.particles.weights[k] *= trig::exp(-0.5 * off * off);
                }
                crate::resampling::normalise(&mut cloud.particles.weights);
                cloud.draw(&Options::default(), true);
            }
            let found_m = cloud.particles.scaled(&wheels).now_in_then.x();
            assert!((found_m - 0.5).abs() < 0.005, "{seed}: {found_m}");
            // While the robot is not found, nothing is kept of that.
            cloud.particles.weights[..500].fill(0.0);
            crate::resampling::normalise(&mut cloud.particles.weights);
            cloud.draw(&Options { particles: 400, ..Options::default() }, false);
            let found_m = cloud.particles.scaled(&wheels).now_in_then.x();
            assert!((found_m - 0.52).abs() < 0.001, "{seed}: {found_m}");
        }
    }
}
