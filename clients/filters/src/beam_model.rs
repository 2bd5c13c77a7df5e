//! What a filter believes of a range: the beam model.
//!
//! Source: *Probabilistic Robotics*, §6.3, equations 6.4 to 6.12 and Table 6.1:
//! a reading is a mixture of four. It met what the map has there (*hit*, normal
//! around the range z* that the map promises), something nearer that the map
//! does not know (*short*, exponential), nothing (*max*), or it is inexplicable
//! (*rand*, uniform).
//!
//! Departures, and why:
//! * A reading of z_max is a separate event, with a probability; below z_max
//!   there is a density. The book calls that a point mass and then draws it as a
//!   narrow density. Particles are compared at one and the same reading, so the
//!   two never meet in one sum.
//! * Where the map has nothing within z_max, a reading of z_max is what *hit*
//!   promises. The book has half a normal density there, and calls the most
//!   ordinary reading of a corridor improbable.
//! * *Short* is cut off at z* as in the book, and has no density where z* is 0.

use core::f64::consts::{PI, SQRT_2};

use rusty_contract::config::LidarConfig;
use rusty_geometry::trig;

/// The six numbers of the mixture. The first four are its weights; they add up
/// to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamModel {
    /// Weight of readings of what the map has.
    pub z_hit: f64,
    /// Weight of readings of something in front of it.
    pub z_short: f64,
    /// Weight of readings of nothing.
    pub z_max: f64,
    /// Weight of readings of anything.
    pub z_rand: f64,
    /// Standard deviation σ of *hit*, m, greater than 0.
    pub sigma_hit_m: f64,
    /// Rate λ of *short*, 1/m, greater than 0.
    pub lambda_short_per_m: f64,
}

/// A number for each of the four parts of the mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Of what the map has.
    pub hit: f64,
    /// Of something in front of it.
    pub short: f64,
    /// Of nothing.
    pub max: f64,
    /// Of anything.
    pub rand: f64,
}

impl Parts {
    /// All four added up.
    pub fn sum(&self) -> f64 {
        self.hit + self.short + self.max + self.rand
    }
}

/// The least σ that is believed in, m: a normal density needs some.
const LEAST_SIGMA_M: f64 = 1e-3;

/// Beyond this many σ a normal law has nothing left that a sum would show.
#[cfg(feature = "link")]
const FAR: f64 = 9.0;

impl BeamModel {
    /// What the data sheet says: σ and dropout. That one reading in fifty is
    /// wrong in a way that no sheet speaks of is a belief of ours.
    pub fn of_lidar(lidar: &LidarConfig) -> Self {
        let (z_short, z_rand) = (0.01, 0.01);
        let z_max = lidar.dropout.clamp(1e-3, 1.0 - z_short - z_rand - 1e-3);
        Self {
            z_hit: 1.0 - z_short - z_max - z_rand,
            z_short,
            z_max,
            z_rand,
            sigma_hit_m: lidar.range_std_m.max(LEAST_SIGMA_M),
            lambda_short_per_m: 1.0,
        }
    }

    /// What each of the four parts by itself says of a reading `range_m` where
    /// the map promises `expected_m`: a density in 1/m below `range_max_m`, a
    /// probability from there on. Readings below 0 have none.
    pub fn parts(&self, range_m: f64, expected_m: f64, range_max_m: f64) -> Parts {
        let nothing_there = expected_m >= range_max_m;
        if range_m >= range_max_m {
            let hit = if nothing_there { 1.0 } else { 0.0 };
            return Parts { hit, short: 0.0, max: 1.0, rand: 0.0 };
        }
        if range_m.is_nan() || range_m < 0.0 {
            return Parts { hit: 0.0, short: 0.0, max: 0.0, rand: 0.0 };
        }
        let hit = if nothing_there { 0.0 } else { self.hit(range_m, expected_m, range_max_m) };
        let short = self.short(range_m, expected_m.min(range_max_m));
        Parts { hit, short, max: 0.0, rand: 1.0 / range_max_m }
    }

    /// p(z | x, m): the mixture's density of a reading, or the probability of
    /// one of z_max, see [`parts`](Self::parts).
    pub fn density(&self, range_m: f64, expected_m: f64, range_max_m: f64) -> f64 {
        self.weighted(range_m, expected_m, range_max_m).sum()
    }

    /// How likely it is that the reading came about in each of the four ways:
    /// the e of Table 6.2. They add up to 1, or are 0 where nothing explains it.
    pub fn responsibilities(&self, range_m: f64, expected_m: f64, range_max_m: f64) -> Parts {
        let Parts { hit, short, max, rand } = self.weighted(range_m, expected_m, range_max_m);
        let sum = hit + short + max + rand;
        let share = |part: f64| if sum > 0.0 { part / sum } else { 0.0 };
        Parts { hit: share(hit), short: share(short), max: share(max), rand: share(rand) }
    }

    fn weighted(&self, range_m: f64, expected_m: f64, range_max_m: f64) -> Parts {
        let Parts { hit, short, max, rand } = self.parts(range_m, expected_m, range_max_m);
        Parts {
            hit: self.z_hit * hit,
            short: self.z_short * short,
            max: self.z_max * max,
            rand: self.z_rand * rand,
        }
    }

    /// Equations 6.4 to 6.6: normal, and normalised to what lies between 0 and
    /// z_max.
    fn hit(&self, range_m: f64, expected_m: f64, range_max_m: f64) -> f64 {
        let sigma_m = self.sigma_hit_m;
        let z = (range_m - expected_m) / sigma_m;
        let below = |end_m: f64| normal_below((end_m - expected_m) / sigma_m);
        let mass = below(range_max_m) - below(0.0);
        trig::exp(-0.5 * z * z) / ((2.0 * PI).sqrt() * sigma_m * mass)
    }

    /// The second moment of a hit about z* in units of σ², below z_max and above 0: 1
    /// where both are far away. With η the mass of equation 6.6 it is
    /// 1 + (a φ(a) − b φ(b)) / η between a = −z*/σ and b = (z_max − z*)/σ, and
    /// ∂ ln η / ∂σ is what it has beyond 1, over σ.
    #[cfg(feature = "link")]
    pub(crate) fn hit_second_moment(sigma_m: f64, expected_m: f64, range_max_m: f64) -> f64 {
        let (a, b) = (-expected_m / sigma_m, (range_max_m - expected_m) / sigma_m);
        if a < -FAR && b > FAR {
            return 1.0;
        }
        let end = |z: f64| z * trig::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
        1.0 + (end(a) - end(b)) / (normal_below(b) - normal_below(a))
    }

    /// Equations 6.7 to 6.9: exponential up to z*, and normalised to that.
    fn short(&self, range_m: f64, expected_m: f64) -> f64 {
        let lambda = self.lambda_short_per_m;
        let mass = 1.0 - trig::exp(-lambda * expected_m);
        if range_m > expected_m || mass <= 0.0 {
            return 0.0;
        }
        lambda * trig::exp(-lambda * range_m) / mass
    }
}

/// Φ: how much of a standard normal law lies below `z`. Source: M. Abramowitz,
/// I. Stegun, *Handbook of Mathematical Functions*, 7.1.26, whose error is below
/// 1.5·10⁻⁷: enough for a normaliser.
fn normal_below(z: f64) -> f64 {
    const A: [f64; 5] =
        [0.254_829_592, -0.284_496_736, 1.421_413_741, -1.453_152_027, 1.061_405_429];
    let x = z.abs() / SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let series = t * (A[0] + t * (A[1] + t * (A[2] + t * (A[3] + t * A[4]))));
    let beyond = 0.5 * series * trig::exp(-x * x);
    if z < 0.0 { beyond } else { 1.0 - beyond }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    const RANGE_MAX_M: f64 = 8.0;

    fn model() -> BeamModel {
        BeamModel {
            z_hit: 0.6,
            z_short: 0.2,
            z_max: 0.05,
            z_rand: 0.15,
            sigma_hit_m: 0.3,
            lambda_short_per_m: 0.8,
        }
    }

    /// The density's integral from `a` to `b`, by Simpson's rule.
    fn integral(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
        let (n, mut sum) = (2000, 0.0);
        let h = (b - a) / f64::from(n);
        for k in 0..n {
            let x = a + h * f64::from(k);
            sum += f(x) + 4.0 * f(x + 0.5 * h) + f(x + h);
        }
        sum * h / 6.0
    }

    #[test]
    fn every_part_is_a_law_of_its_own() {
        let model = model();
        // In the middle, so near that half of a hit lies below 0, at the far end.
        for expected_m in [3.0, 0.05, 7.9] {
            let below = |part: fn(&Parts) -> f64| {
                let f = |z: f64| part(&model.parts(z, expected_m, RANGE_MAX_M));
                integral(f, 0.0, expected_m) + integral(f, expected_m + 1e-9, RANGE_MAX_M - 1e-9)
            };
            let last = model.parts(RANGE_MAX_M, expected_m, RANGE_MAX_M);
            for (name, part) in [
                ("hit", (|p| p.hit) as fn(&Parts) -> f64),
                ("short", |p| p.short),
                ("max", |p| p.max),
                ("rand", |p| p.rand),
            ] {
                let sum = below(part) + part(&last);
                assert!((sum - 1.0).abs() < 1e-5, "{name} at {expected_m} m: {sum}");
            }
        }
    }

    /// One reading as §6.3.1 tells the story of it.
    fn drawn(model: &BeamModel, expected_m: f64, random: &mut Random) -> f64 {
        let u = random.uniform();
        if u < model.z_hit {
            loop {
                let range_m = expected_m + model.sigma_hit_m * random.normal();
                if (0.0..RANGE_MAX_M).contains(&range_m) {
                    return range_m;
                }
            }
        } else if u < model.z_hit + model.z_short {
            loop {
                let range_m = -trig::ln(1.0 - random.uniform()) / model.lambda_short_per_m;
                if range_m <= expected_m {
                    return range_m;
                }
            }
        } else if u < model.z_hit + model.z_short + model.z_max {
            RANGE_MAX_M
        } else {
            random.uniform() * RANGE_MAX_M
        }
    }

    #[test]
    fn readings_fall_into_bins_as_the_density_says() {
        let (model, mut random) = (model(), Random::new(1, 1));
        for expected_m in [3.0, 0.2] {
            let (bins, count) = (80, 200_000);
            let mut found = vec![0.0; bins + 1];
            for _ in 0..count {
                let range_m = drawn(&model, expected_m, &mut random);
                found[(range_m / RANGE_MAX_M * bins as f64) as usize] += 1.0;
            }
            for (bin, found) in found.iter().enumerate() {
                let edge = |bin: usize| bin as f64 * RANGE_MAX_M / bins as f64;
                let density = |z: f64| model.density(z, expected_m, RANGE_MAX_M);
                let said = match bin {
                    bin if bin == bins => density(RANGE_MAX_M),
                    _ => integral(density, edge(bin), edge(bin + 1) - 1e-9),
                };
                let expected = said * f64::from(count);
                let off = (found - expected) / expected.max(1.0).sqrt();
                assert!(off.abs() < 4.5, "bin {bin} at {expected_m} m: {found} for {expected}");
            }
        }
    }

    #[test]
    fn responsibilities_are_shares_of_the_density() {
        let model = model();
        for (range_m, expected_m) in [(3.1, 3.0), (1.0, 3.0), (7.0, 3.0), (8.0, 3.0), (8.0, 8.0)] {
            let e = model.responsibilities(range_m, expected_m, RANGE_MAX_M);
            assert!((e.sum() - 1.0).abs() < 1e-15, "{e:?}");
        }
        let e = model.responsibilities(8.0, 3.0, RANGE_MAX_M);
        assert_eq!((e.max, e.hit), (1.0, 0.0));
        let e = model.responsibilities(3.0, 3.0, RANGE_MAX_M);
        // 0.6 · 1.3298, 0.2 · 0.0798, 0.15 / 8, by hand.
        assert!((e.hit - 0.797_885 / (0.797_885 + 0.015_963 + 0.018_75)).abs() < 1e-4, "{e:?}");
        // Nothing explains these, and nothing panics.
        for range_m in [-1.0, f64::NAN] {
            assert_eq!(model.responsibilities(range_m, 3.0, RANGE_MAX_M).sum(), 0.0);
        }
    }

    #[test]
    fn nothing_within_range_reads_the_longest_range() {
        let model = model();
        let said = model.density(RANGE_MAX_M, RANGE_MAX_M, RANGE_MAX_M);
        assert!((said - 0.65).abs() < 1e-15, "{said}");
        let below = integral(|z| model.density(z, f64::INFINITY, RANGE_MAX_M), 0.0, 7.999_999);
        assert!((below - 0.35).abs() < 1e-5, "{below}");
    }

    #[test]
    fn the_data_sheet_is_believed() {
        let lidar = LidarConfig { dropout: 0.02, ..LidarConfig::default() };
        let model = BeamModel::of_lidar(&lidar);
        assert_eq!((model.sigma_hit_m, model.z_max), (0.02, 0.02));
        let dead = LidarConfig { dropout: 1.0, range_std_m: 0.0, ..lidar };
        for model in [model, BeamModel::of_lidar(&dead)] {
            let BeamModel { z_hit, z_short, z_max, z_rand, .. } = model;
            assert!((z_hit + z_short + z_max + z_rand - 1.0).abs() < 1e-15);
            assert!(z_hit > 0.0 && model.sigma_hit_m > 0.0);
        }
    }
}
