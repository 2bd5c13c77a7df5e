//! New particles in the place of old ones, as often as these weigh.
//!
//! Source: *Probabilistic Robotics*, §4.3.4, Table 4.4, the low-variance
//! sampler: one random number for all, so that a particle of weight w is drawn
//! ⌊n w⌋ or ⌈n w⌉ times. When to do it: A. Kong, J. S. Liu, W. H. Wong,
//! *Sequential Imputations* (JASA 89, 1994), by the number of particles that the
//! weights are worth.

/// How many equally heavy particles these are worth: (Σ w)² / Σ w². 0 where
/// nothing weighs anything.
pub fn effective_size(weights: &[f64]) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for w in weights {
        sum += w;
        squares += w * w;
    }
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// Makes the weights add up to 1. Where their sum is no positive number, all
/// become equal: then they say nothing.
pub fn normalise(weights: &mut [f64]) {
    let sum: f64 = weights.iter().sum();
    let equal = 1.0 / weights.len().max(1) as f64;
    let usable = sum > 0.0 && sum < f64::INFINITY;
    for w in weights {
        *w = if usable { *w / sum } else { equal };
    }
}

/// Draws `count` particles: `drawn` becomes their numbers, in order. `weights`
/// add up to 1, and `start` is of [0, 1): the one random number.
pub fn low_variance(weights: &[f64], count: usize, start: f64, drawn: &mut Vec<u32>) {
    drawn.clear();
    let Some(last) = weights.iter().rposition(|w| *w > 0.0) else { return };
    let (mut of, mut up_to) = (0, weights[0]);
    for m in 0..count {
        let at = (start + m as f64) / count as f64;
        // Rounding may leave the sum a little below 1: the last one that weighs
        // anything takes what is left.
        while at >= up_to && of < last {
            of += 1;
            up_to += weights[of];
        }
        drawn.push(of as u32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn every_particle_is_drawn_as_often_as_it_weighs() {
        let mut random = Random::new(1, 1);
        let mut drawn = Vec::new();
        for (size, count) in [(50, 50), (50, 1000), (1000, 30), (1, 7)] {
            for _ in 0..50 {
                let mut weights: Vec<f64> = (0..size).map(|_| random.uniform()).collect();
                weights[size / 2] = if size > 1 { 0.0 } else { 1.0 };
                normalise(&mut weights);
                low_variance(&weights, count, random.uniform(), &mut drawn);
                assert_eq!(drawn.len(), count);
                for (particle, w) in weights.iter().enumerate() {
                    let times = drawn.iter().filter(|d| **d as usize == particle).count() as f64;
                    let due = w * count as f64;
                    assert!(times >= (due - 1e-9).floor() && times <= (due + 1e-9).ceil());
                }
            }
        }
    }

    #[test]
    fn on_average_it_is_drawn_exactly_that_often() {
        let weights = [0.07, 0.5, 0.03, 0.4];
        let (mut random, mut drawn, mut times) = (Random::new(2, 1), Vec::new(), [0.0; 4]);
        let rounds = 20_000;
        for _ in 0..rounds {
            low_variance(&weights, 9, random.uniform(), &mut drawn);
            drawn.iter().for_each(|d| times[*d as usize] += 1.0);
        }
        for (times, w) in times.iter().zip(weights) {
            assert!((times / f64::from(rounds) - 9.0 * w).abs() < 0.02, "{times} for {w}");
        }
    }

    #[test]
    fn weights_that_say_nothing_are_equal() {
        for useless in [[0.0; 3], [f64::NAN, 1.0, 1.0], [f64::INFINITY; 3]] {
            let mut weights = useless;
            normalise(&mut weights);
            assert_eq!(weights, [1.0 / 3.0; 3]);
        }
        let mut drawn = vec![1];
        low_variance(&[0.0, 0.0], 5, 0.5, &mut drawn);
        assert!(drawn.is_empty());
        normalise(&mut []);
    }

    #[test]
    fn effective_sizes_worked_by_hand() {
        assert_eq!(effective_size(&[1.0; 40]), 40.0);
        assert_eq!(effective_size(&[0.0, 3.0, 0.0]), 1.0);
        assert_eq!(effective_size(&[0.5, 0.25, 0.25]), 1.0 / 0.375);
        assert_eq!(effective_size(&[0.0]), 0.0);
    }
}
