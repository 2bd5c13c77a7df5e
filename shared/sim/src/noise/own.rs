//! The noise of a sensor that the simulator does not have.

use super::stream::{Source, Stream};

/// Binary logarithm of the words that a tick has room for.
const TICK_BITS: u32 = 24;
/// Binary logarithm of the words that a slot has room for.
const SLOT_BITS: u32 = TICK_BITS - u16::BITS;

const _: () =
    assert!(matches!(Source::Own(0).tick_words(), Some(words) if words == 1 << TICK_BITS));

/// Draws of your own sensor, by tick and slot, under the rule of [`crate::noise`].
///
/// A tick has 65 536 slots, and a slot has room for 128 numbers of 64 bits; further
/// numbers are those of the next slot. A method that draws a varying number of words,
/// such as rejection, therefore changes nothing outside its slot.
///
/// A compass that fails in one of ten ticks:
///
/// ```
/// use rand::{RngExt, distr::Distribution};
/// use rusty_sim::noise::{OwnNoise, StandardNormal};
///
/// struct Compass {
///     noise: OwnNoise,
/// }
///
/// impl Compass {
///     fn read(&mut self, tick: u64, heading_rad: f64) -> Option<f64> {
///         let draws = self.noise.at(tick, 0);
///         let is_lost = draws.random_bool(0.1);
///         // Drawn whether it is used or not.
///         let z = StandardNormal.sample(draws);
///         (!is_lost).then_some(heading_rad + 0.05 * z)
///     }
/// }
///
/// let compass = || Compass { noise: OwnNoise::new(42, 1) };
/// let (mut whole, mut late) = (compass(), compass());
/// let readings: Vec<_> = (0..100).map(|tick| whole.read(tick, 0.3)).collect();
/// assert_eq!(late.read(99, 0.3), readings[99], "tick 99 without the ticks before it");
/// assert!(readings.iter().flatten().count() < 100);
/// ```
#[derive(Clone, Debug)]
pub struct OwnNoise {
    stream: Stream,
}

impl OwnNoise {
    /// The noise of your sensor with this number in a run with this seed. Sensors with
    /// different numbers have independent noise.
    #[must_use]
    pub fn new(seed: u64, number: u32) -> Self {
        Self { stream: Stream::new(seed, Source::Own(number)) }
    }

    /// The numbers of a slot, from its first. `tick` is below 2⁴⁰, as in every run.
    /// Any tick and slot may be asked for, in any order.
    pub fn at(&mut self, tick: u64, slot: u16) -> &mut Stream {
        let first = (u128::from(tick) << TICK_BITS) + (u128::from(slot) << SLOT_BITS);
        self.stream.seek(first);
        &mut self.stream
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng as _;

    #[test]
    fn the_room_of_a_slot_ends_where_the_next_begins() {
        let mut noise = OwnNoise::new(4, 7);
        let draws = |noise: &mut OwnNoise, tick, slot, n| -> Vec<u64> {
            let stream = noise.at(tick, slot);
            (0..n).map(|_| stream.next_u64()).collect()
        };
        let one = draws(&mut noise, 0, 0, 129);
        assert_eq!(draws(&mut noise, 0, 1, 1), one[128..]);
        let last = draws(&mut noise, 0, u16::MAX, 129);
        assert_eq!(draws(&mut noise, 1, 0, 1), last[128..]);
        let far = (1 << 40) - 1;
        assert_ne!(draws(&mut noise, far, 0, 1), draws(&mut noise, far - 1, 0, 1));
    }

    #[test]
    fn a_sensor_of_your_own_shares_no_numbers_with_others() {
        let first = |source| Stream::new(4, source).next_u64();
        let own = [Source::Own(0), Source::Own(1), Source::Own(u32::MAX)];
        let mut all: Vec<u64> = Source::BUILT_IN.into_iter().chain(own).map(first).collect();
        assert_eq!(all[Source::BUILT_IN.len()], OwnNoise::new(4, 0).at(0, 0).next_u64());
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
    }
}
