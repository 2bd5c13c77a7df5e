//! The noise of sources that draw a few numbers in a tick.

use rand::Rng as _;
use rusty_geometry::normal::{standard_normal, uniform};

use super::stream::{Source, Stream};

/// 32-bit words that one reading of a landmark has room for: a uniform number and
/// two normal ones, two words each, and two that are free.
const LANDMARK_WORDS: u128 = 8;

/// Draws of one source, by tick and slot. Any tick may be asked for, in any order.
#[derive(Clone, Debug)]
pub struct TickNoise {
    stream: Stream,
    /// Words that a tick has room for.
    tick_words: u64,
}

impl TickNoise {
    fn of(seed: u64, source: Source) -> Self {
        let tick_words = source.tick_words().unwrap_or_default();
        Self { stream: Stream::new(seed, source), tick_words }
    }

    /// Slip of the wheels, `[left, right]`.
    #[must_use]
    pub fn slip(seed: u64) -> Self {
        Self::of(seed, Source::Slip)
    }

    /// Choice of the outliers of the slip, `[left, right]`.
    #[must_use]
    pub fn slip_outliers(seed: u64) -> Self {
        Self::of(seed, Source::SlipOutliers)
    }

    /// Walk and white noise of each axis of the IMU.
    #[must_use]
    pub fn imu(seed: u64) -> Self {
        Self::of(seed, Source::Imu)
    }

    /// Biases of the IMU at the start, all in tick 0.
    #[must_use]
    pub fn imu_start(seed: u64) -> Self {
        Self::of(seed, Source::ImuStart)
    }

    /// Dropout and range noise of up to 16 sonars.
    #[must_use]
    pub fn sonars(seed: u64) -> Self {
        Self::of(seed, Source::Sonars)
    }

    /// Reports of 256 doors.
    #[must_use]
    pub fn doors(seed: u64) -> Self {
        Self::of(seed, Source::Doors)
    }

    /// Readings of up to 4096 landmarks.
    #[must_use]
    pub fn landmarks(seed: u64) -> Self {
        Self::of(seed, Source::Landmarks)
    }

    /// Passages of LiDAR beams through panes of glass.
    pub(super) fn glass(seed: u64) -> Self {
        Self::of(seed, Source::Glass)
    }

    fn seek(&mut self, tick: u64, word: u128) {
        self.stream.seek(u128::from(tick) * u128::from(self.tick_words) + word);
    }

    /// The first `N` standard normal deviates of a tick.
    #[must_use]
    pub fn normals<const N: usize>(&mut self, tick: u64) -> [f64; N] {
        self.seek(tick, 0);
        std::array::from_fn(|_| standard_normal(self.stream.next_u64()))
    }

    /// The uniform number in [0, 1) of a slot of two words.
    #[must_use]
    pub fn uniform_at(&mut self, tick: u64, slot: u64) -> f64 {
        self.seek(tick, 2 * u128::from(slot));
        uniform(self.stream.next_u64())
    }

    /// A uniform number in [0, 1) and a standard normal deviate for each of `N`
    /// slots of four words.
    #[must_use]
    pub fn pairs<const N: usize>(&mut self, tick: u64) -> [(f64, f64); N] {
        self.seek(tick, 0);
        std::array::from_fn(|_| {
            (uniform(self.stream.next_u64()), standard_normal(self.stream.next_u64()))
        })
    }

    /// A uniform number in [0, 1) and two standard normal deviates of the landmark
    /// with this index.
    #[must_use]
    pub fn uniform_and_normals_at(&mut self, tick: u64, landmark: usize) -> (f64, [f64; 2]) {
        self.seek(tick, LANDMARK_WORDS * landmark as u128);
        let u = uniform(self.stream.next_u64());
        (u, std::array::from_fn(|_| standard_normal(self.stream.next_u64())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_the_same_alone_and_in_a_row() {
        let mut row = TickNoise::slip(11);
        for tick in 0..100 {
            assert_eq!(row.normals::<2>(tick), TickNoise::slip(11).normals::<2>(tick));
        }
        assert_eq!(row.normals::<2>(3), TickNoise::slip(11).normals::<2>(3), "and backwards");
    }

    #[test]
    fn slots_ticks_seeds_and_sources_differ() {
        let [left, right] = TickNoise::slip(11).normals(0);
        assert_ne!(left, right);
        assert_ne!([left, right], TickNoise::slip(11).normals(1));
        assert_ne!([left, right], TickNoise::slip(12).normals(0));
        let sources = [TickNoise::imu, TickNoise::imu_start, TickNoise::sonars, TickNoise::doors];
        let mut first: Vec<u64> =
            sources.iter().map(|source| source(11).normals::<1>(0)[0].to_bits()).collect();
        first.push(left.to_bits());
        first.push(TickNoise::landmarks(11).normals::<1>(0)[0].to_bits());
        first.push(TickNoise::glass(11).normals::<1>(0)[0].to_bits());
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), 7);
    }

    #[test]
    fn the_room_of_a_tick_ends_where_the_next_begins() {
        let next = |noise: fn(u64) -> TickNoise| noise(4).stream_at(1);
        // One past the last slot of tick 0 is the first of tick 1.
        assert_eq!(TickNoise::doors(4).uniform_at(0, 256), uniform(next(TickNoise::doors)));
        let (u, _) = TickNoise::landmarks(4).uniform_and_normals_at(0, 4096);
        assert_eq!(u, uniform(next(TickNoise::landmarks)));
        let mut sonars = TickNoise::sonars(4);
        let _ = sonars.pairs::<16>(0);
        assert_eq!(sonars.stream.next_u64(), next(TickNoise::sonars));
    }

    impl TickNoise {
        fn stream_at(mut self, tick: u64) -> u64 {
            self.seek(tick, 0);
            self.stream.next_u64()
        }
    }
}
