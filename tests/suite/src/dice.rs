//! Seeded chance for tests: what a case draws depends on its number alone, so
//! a case that fails can be repeated by itself.

use std::time::Duration;

/// A generator of random numbers (SplitMix64).
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// The generator of case `case` in the series `series`.
    pub fn of(series: &str, case: u64) -> Self {
        let seed = series.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        Self(seed ^ case.wrapping_mul(0xD134_2543_DE82_EF95))
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n.max(1)
    }

    /// One of these.
    pub fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len() as u64) as usize]
    }

    /// A time shorter than `limit`, to the microsecond.
    pub fn time(&mut self, limit: Duration) -> Duration {
        Duration::from_micros(self.below(limit.as_micros() as u64))
    }
}

/// The numbers of the cases of a series: as many as the environment variable
/// `how_many` says, else `usual`; or the one that `{how_many}_CASE` names.
pub fn cases(how_many: &str, usual: u64) -> std::ops::Range<u64> {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().unwrap());
    match number(&format!("{how_many}_CASE")) {
        Some(case) => case..case + 1,
        None => 0..number(how_many).unwrap_or(usual),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_draws_what_it_drew_and_no_other_does() {
        let draw = |series, case| Dice::of(series, case).bits();
        assert_eq!(draw("a", 1), draw("a", 1));
        assert_ne!(draw("a", 1), draw("a", 2));
        assert_ne!(draw("a", 1), draw("b", 1));
        let mut dice = Dice::of("a", 1);
        assert!((0..1000).all(|_| dice.below(7) < 7));
        let all: std::collections::BTreeSet<u64> = (0..100).map(|_| dice.below(7)).collect();
        assert_eq!(all.len(), 7);
    }
}
