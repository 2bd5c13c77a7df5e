//! The draws of people: each has a separate row of numbers, one after the other.

use nalgebra::Point2;
use rand::Rng as _;
use rusty_geometry::normal::{standard_normal, uniform};

use super::stream::{Source, Stream};

/// Binary logarithm of the words that a person has room for.
const PERSON_BITS: u32 = 56;

/// Draws of people.
#[derive(Clone, Debug)]
pub struct PeopleNoise {
    stream: Stream,
}

impl PeopleNoise {
    /// The noise of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { stream: Stream::new(seed, Source::People) }
    }

    /// The next number of a person who has drawn `drawn` so far.
    fn next(&mut self, person: usize, drawn: &mut u64) -> u64 {
        self.stream.seek(((person as u128) << PERSON_BITS) + 2 * u128::from(*drawn));
        *drawn += 1;
        self.stream.next_u64()
    }

    /// A standard normal deviate.
    #[must_use]
    pub fn normal(&mut self, person: usize, drawn: &mut u64) -> f64 {
        standard_normal(self.next(person, drawn))
    }

    /// A point in a box `[x_min, y_min, x_max, y_max]`, uniformly.
    #[must_use]
    pub fn place(&mut self, person: usize, drawn: &mut u64, bounds: [f64; 4]) -> Point2<f64> {
        let [x_min, y_min, x_max, y_max] = bounds;
        let x = x_min + uniform(self.next(person, drawn)) * (x_max - x_min);
        let y = y_min + uniform(self.next(person, drawn)) * (y_max - y_min);
        Point2::new(x, y)
    }
}
