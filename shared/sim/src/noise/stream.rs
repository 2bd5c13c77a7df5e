//! One stream of the generator, read at any place.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

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
    /// Noise of the IMU.
    Imu = 3,
    /// Biases of the IMU at the start.
    ImuStart = 4,
    /// Dropout and range noise of the sonars.
    Sonar = 5,
    /// Reports of doors.
    Doors = 6,
    /// Dropout, range and bearing noise of landmarks.
    Landmarks = 7,
    /// Passage of LiDAR beams through glass.
    Glass = 8,
    /// Places and speeds of people.
    People = 9,
}

/// The words of one source.
#[derive(Debug)]
pub(super) struct Stream {
    rng: ChaCha8Rng,
}

/// The generator cannot be copied, so that no code uses a key twice by accident;
/// here the same words are wanted.
impl Clone for Stream {
    fn clone(&self) -> Self {
        let mut rng = ChaCha8Rng::from_seed(self.rng.get_seed());
        rng.set_stream(self.rng.get_stream());
        rng.set_word_pos(self.rng.get_word_pos());
        Self { rng }
    }
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

    /// The next words, two to a number, the earlier one in the low half.
    pub(super) fn fill(&mut self, numbers: &mut [u64]) {
        self.rng.fill_bytes(bytemuck::cast_slice_mut(numbers));
        for number in numbers {
            // The bytes are those of a little-endian machine, on any.
            *number = u64::from_le(*number);
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
    fn many_at_once_are_the_same() {
        let mut one_by_one = Stream::new(5, Source::Lidar);
        for (first, length) in [(0, 1), (3, 200), (64, 64), (7, 0), (1000, 33)] {
            let mut numbers = vec![0; length];
            let mut stream = Stream::new(5, Source::Lidar);
            stream.seek(2 * first as u128);
            stream.fill(&mut numbers);
            one_by_one.seek(2 * first as u128);
            assert!(numbers.iter().all(|number| *number == one_by_one.next_u64()));
            assert_eq!(stream.next_u64(), one_by_one.next_u64(), "and go on alike");
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
