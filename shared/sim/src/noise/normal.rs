//! The portable normal law for `rand`.

use rand::Rng;
use rand::distr::Distribution;
use rusty_geometry::normal::standard_normal;

/// The standard normal distribution: one number of 64 bits is one deviate, with the
/// same bits on every machine; see [`rusty_geometry::normal`].
///
/// `rand_distr::StandardNormal` is not portable and draws a varying number of words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StandardNormal;

impl Distribution<f64> for StandardNormal {
    fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        standard_normal(rng.next_u64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Source, Stream, TickNoise};

    fn drawn(law: impl Distribution<f64>, rng: &mut impl Rng) -> [f64; 2] {
        [law.sample(rng), law.sample(rng)]
    }

    #[test]
    fn the_trait_is_that_of_rand_distr() {
        // A law of that crate goes where this one does.
        let mut stream = Stream::new(42, Source::Slip);
        let law = rand_distr::Uniform::new(1.0, 2.0).unwrap();
        assert!(drawn(law, &mut stream).iter().all(|x| (1.0..2.0).contains(x)));
    }

    #[test]
    fn a_distribution_on_a_named_stream_gives_the_numbers_of_the_simulator() {
        let mut stream = Stream::new(42, Source::Slip);
        let mut slip = TickNoise::slip(42);
        for tick in 0..50 {
            let (ours, theirs) = (drawn(StandardNormal, &mut stream), slip.normals::<2>(tick));
            assert_eq!(ours.map(f64::to_bits), theirs.map(f64::to_bits), "tick {tick}");
        }
    }
}
