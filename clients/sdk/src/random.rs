//! Random numbers of a filter: the same on every machine and in every run.
//!
//! The seed is the filter's, and not related to the seed of the world. Each purpose
//! (motion, resampling, …) has a separate stream, so that the count of numbers drawn
//! for one does not change another.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use rusty_geometry::normal;

/// The part of the key that is not the seed: the same seed in a filter and in
/// the world gives numbers that have nothing to do with each other.
const DOMAIN: [u8; 24] = *b"rusty-filters, form one.";

/// The numbers of one purpose.
#[derive(Debug)]
pub struct Random {
    rng: ChaCha8Rng,
}

impl Random {
    /// The numbers of `purpose` under `seed`, from the first.
    #[must_use]
    pub fn new(seed: u64, purpose: u64) -> Self {
        let mut key = [0; 32];
        let (seed_bytes, domain) = key.split_at_mut(8);
        seed_bytes.copy_from_slice(&seed.to_le_bytes());
        domain.copy_from_slice(&DOMAIN);
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(purpose);
        Self { rng }
    }

    /// A number of [0, 1), all multiples of 2⁻⁵³ equally likely.
    pub fn uniform(&mut self) -> f64 {
        normal::uniform(self.rng.next_u64())
    }

    /// A standard normal number.
    pub fn normal(&mut self) -> f64 {
        normal::standard_normal(self.rng.next_u64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_and_purposes_are_apart() {
        let first = |seed, purpose| Random::new(seed, purpose).uniform();
        let all = [first(1, 1), first(1, 2), first(2, 1)];
        assert!(all[0] != all[1] && all[0] != all[2] && all[1] != all[2], "{all:?}");
    }

    #[test]
    fn the_bits_are_pinned() {
        let mut random = Random::new(42, 1);
        let drawn = [random.uniform(), random.normal()].map(f64::to_bits);
        assert_eq!(drawn, [0x3fe5_d043_32db_f32c, 0xbfe3_33e8_dc1b_9563], "{drawn:#x?}");
    }
}
