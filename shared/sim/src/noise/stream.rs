//! One stream of the generator, read at any place.

use std::convert::Infallible;

use chacha20::ChaCha8Rng;
use rand::rand_core::{Rng, SeedableRng, TryRng};

/// The part of the key that is not the seed: it keeps this program's numbers
/// apart from those of any other that hands the same seed to the same generator.
const DOMAIN: [u8; 24] = *b"rusty-sim noise, form 1.";

/// Number of the first stream of [`Source::Own`].
const FIRST_OWN: u64 = 1 << 63;

/// A source of noise, which has a separate stream. [`crate::noise`] has a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// Slip of the wheels.
    Slip,
    /// Dropout and range noise of the LiDAR.
    Lidar,
    /// Noise of the IMU.
    Imu,
    /// Biases of the IMU at the start.
    ImuStart,
    /// Dropout and range noise of the sonars.
    Sonars,
    /// Reports of doors.
    Doors,
    /// Dropout, range and bearing noise of landmarks.
    Landmarks,
    /// Passage of LiDAR beams through glass.
    Glass,
    /// Places and speeds of people.
    People,
    /// Which slips are outliers.
    SlipOutliers,
    /// A sensor that the simulator does not have, by a number of your choice; see
    /// [`OwnNoise`](super::OwnNoise).
    Own(u32),
}

impl Source {
    /// All sources of the simulator, in the order of their numbers.
    pub const BUILT_IN: [Self; 10] = [
        Self::Slip,
        Self::Lidar,
        Self::Imu,
        Self::ImuStart,
        Self::Sonars,
        Self::Doors,
        Self::Landmarks,
        Self::Glass,
        Self::People,
        Self::SlipOutliers,
    ];

    /// The number of its stream. It never changes.
    #[must_use]
    pub const fn number(self) -> u64 {
        match self {
            Self::Slip => 1,
            Self::Lidar => 2,
            Self::Imu => 3,
            Self::ImuStart => 4,
            Self::Sonars => 5,
            Self::Doors => 6,
            Self::Landmarks => 7,
            Self::Glass => 8,
            Self::People => 9,
            Self::SlipOutliers => 10,
            Self::Own(number) => FIRST_OWN + number as u64,
        }
    }

    /// Its name in the handbook.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slip => "slip",
            Self::Lidar => "lidar",
            Self::Imu => "imu",
            Self::ImuStart => "imu-start",
            Self::Sonars => "sonars",
            Self::Doors => "doors",
            Self::Landmarks => "landmarks",
            Self::Glass => "glass",
            Self::People => "people",
            Self::SlipOutliers => "slip-outliers",
            Self::Own(_) => "own",
        }
    }

    /// Words of 32 bits that a tick has room for: tick t begins at word t times this
    /// number. `None` for people, who draw when they need a number.
    #[must_use]
    pub const fn tick_words(self) -> Option<u64> {
        match self {
            Self::Slip | Self::SlipOutliers => Some(4),
            Self::Lidar => Some(8192),
            Self::Imu | Self::ImuStart => Some(16),
            Self::Sonars => Some(64),
            Self::Doors => Some(512),
            Self::Landmarks | Self::Glass => Some(32768),
            Self::People => None,
            Self::Own(_) => Some(1 << 24),
        }
    }
}

/// The words of one source: a [`rand::Rng`] that can be put at any place.
///
/// Two streams of the same seed and source give the same words.
#[derive(Debug)]
pub struct Stream {
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
    #[must_use]
    pub fn new(seed: u64, source: Source) -> Self {
        let mut key = [0; 32];
        let (seed_bytes, domain) = key.split_at_mut(8);
        seed_bytes.copy_from_slice(&seed.to_le_bytes());
        domain.copy_from_slice(&DOMAIN);
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(source.number());
        Self { rng }
    }

    /// Makes 32-bit word number `word`, below 2⁶⁸, the next one. Free when it already
    /// is: moving throws away up to 64 words that are already computed.
    pub fn seek(&mut self, word: u128) {
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
}

impl TryRng for Stream {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.rng.next_u32())
    }

    /// The next two words, the earlier one in the low half.
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.rng.next_u64())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.rng.fill_bytes(bytes);
        Ok(())
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
    fn every_source_has_another_number_and_they_are_in_order() {
        let ends = [Source::Own(0), Source::Own(u32::MAX)];
        let numbers: Vec<u64> =
            Source::BUILT_IN.into_iter().chain(ends).map(Source::number).collect();
        assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
        assert_eq!(numbers[..10], [1, 2, 3, 4, 5, 6, 7, 8, 9, 10], "recorded runs depend on them");
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
