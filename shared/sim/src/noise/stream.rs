//! One stream of the generator, read at any place.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The part of the key that is not the seed: it keeps this program's numbers
/// apart from those of any other that hands the same seed to the same generator.
const DOMAIN: [u8; 24] = *b"rusty-sim noise, form 1.";

/// The streams in use; see the table in [`crate::noise`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub(super) enum Source {
    /// Slip of the wheels.
    Slip = 1,
    /// Dropout and range noise of the LiDAR.
    Lidar = 2,
}

/// The words of one source.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    rng: ChaCha8Rng,
}

impl Stream {
    /// The words of `source` under `seed`, from word 0.
    pub(super) fn new(seed: u64, source: Source) -> Self {
        let mut key = [0; 32];
        let (seed_bytes, domain) = key.split_at_mut(8);
        seed_bytes.copy_from_slice(&seed.to_le_bytes());
        domain.copy_from_slice(&DOMAIN);
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(source as u64);
        Self { rng }
    }

    /// Makes 32-bit word number `word` the next one. Free when it already is:
    /// moving throws away up to 64 words that are already computed.
    pub(super) fn seek(&mut self, word: u128) {
        if self.rng.get_word_pos() != word {
            self.rng.set_word_pos(word);
        }
    }

    /// The next two words, the earlier one in the low half.
    pub(super) fn next_u64(&mut self) -> u64 {
        self.rng.next_u64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_place_can_be_read_first() {
        let mut in_order = Stream::new(5, Source::Lidar);
        let words: Vec<u64> = (0..300).map(|_| in_order.next_u64()).collect();
        // Unaligned places, places across a buffer's edge, and backwards.
        for k in (0..300).rev() {
            let mut alone = Stream::new(5, Source::Lidar);
            alone.seek(2 * k as u128);
            assert_eq!(alone.next_u64(), words[k], "word {k}");
            in_order.seek(2 * k as u128);
            assert_eq!(in_order.next_u64(), words[k], "word {k}, same stream");
        }
    }

    #[test]
    fn seeking_where_it_stands_changes_nothing() {
        let mut plain = Stream::new(9, Source::Slip);
        let mut sought = plain.clone();
        for k in 0..200 {
            sought.seek(2 * k);
            assert_eq!(plain.next_u64(), sought.next_u64());
        }
    }

    #[test]
    fn seeds_and_sources_differ() {
        let first = |seed, source| Stream::new(seed, source).next_u64();
        let base = first(1, Source::Slip);
        assert_ne!(base, first(2, Source::Slip));
        assert_ne!(base, first(1 << 63, Source::Slip));
        assert_ne!(base, first(1, Source::Lidar));
    }

    #[test]
    fn far_places_can_be_read() {
        let mut stream = Stream::new(1, Source::Lidar);
        stream.seek(u128::from(u64::MAX >> 9) << 13);
        let far = stream.next_u64();
        stream.seek(0);
        assert_ne!(far, stream.next_u64());
    }
}
