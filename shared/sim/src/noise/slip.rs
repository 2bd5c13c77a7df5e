//! The noise of the wheels.

use super::stream::{Source, Stream};
use rusty_geometry::normal::standard_normal;

/// Standard normal deviates for the slip of the two wheels.
#[derive(Clone, Debug)]
pub struct SlipNoise {
    stream: Stream,
}

impl SlipNoise {
    /// The slip noise of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { stream: Stream::new(seed, Source::Slip) }
    }

    /// The deviates z of tick `tick`, `[left, right]`, without a unit; the
    /// slip is ε = σ·z. Any tick may be asked for, in any order, at any time.
    #[must_use]
    pub fn at(&mut self, tick: u64) -> [f64; 2] {
        self.stream.seek(u128::from(tick) << 2);
        let left = standard_normal(self.stream.next_u64());
        let right = standard_normal(self.stream.next_u64());
        [left, right]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_the_same_alone_and_in_a_row() {
        let mut row = SlipNoise::new(11);
        for tick in 0..100 {
            assert_eq!(row.at(tick), SlipNoise::new(11).at(tick));
        }
        assert_eq!(row.at(3), SlipNoise::new(11).at(3), "and backwards");
    }

    #[test]
    fn wheels_ticks_and_seeds_differ() {
        let [left, right] = SlipNoise::new(11).at(0);
        assert_ne!(left, right);
        assert_ne!([left, right], SlipNoise::new(11).at(1));
        assert_ne!([left, right], SlipNoise::new(12).at(0));
    }
}
