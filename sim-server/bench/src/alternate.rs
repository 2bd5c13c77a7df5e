//! Several ways to do something, timed in turns.
//!
//! A machine that becomes slower or faster while it measures does so to all of
//! them, and a ratio formed within each round does not notice.

use std::time::{Duration, Instant};

use super::quantiles::Spread;

/// The fewest rounds, however long one takes.
const ROUNDS_AT_LEAST: usize = 5;

/// One way to do it.
pub struct Rival<'a> {
    /// A batch of work.
    batch: Box<dyn FnMut() + 'a>,
    /// How many units of work a batch has.
    units: usize,
    /// ns per unit, a number for each round.
    rounds_ns: Vec<f64>,
}

impl<'a> Rival<'a> {
    /// A way that does `units` units of work at each call of `batch`. A batch
    /// should take some tens of microseconds or more: the clock is read twice.
    pub fn new(units: usize, batch: impl FnMut() + 'a) -> Self {
        Self { batch: Box::new(batch), units: units.max(1), rounds_ns: Vec::new() }
    }

    /// What a unit took, ns.
    #[must_use]
    pub fn ns(&self) -> Spread {
        Spread::of(self.rounds_ns.iter().copied())
    }

    /// How many times longer than `other` this took, round by round.
    #[must_use]
    pub fn over(&self, other: &Self) -> Spread {
        self.beside(other, |mine, its| mine / its)
    }

    /// How much longer than `other` a unit took, ns, round by round.
    #[must_use]
    pub fn beyond(&self, other: &Self) -> Spread {
        self.beside(other, |mine, its| mine - its)
    }

    fn beside(&self, other: &Self, compare: fn(f64, f64) -> f64) -> Spread {
        Spread::of(self.rounds_ns.iter().zip(&other.rounds_ns).map(|(a, b)| compare(*a, *b)))
    }

    fn round(&mut self) {
        let began = Instant::now();
        (self.batch)();
        let elapsed_ns = began.elapsed().as_nanos() as f64;
        self.rounds_ns.push(elapsed_ns / self.units as f64);
    }
}

/// Lets all of them work in turns for about `time`, after one round to warm up.
/// Each round begins with another, so that none is always behind the same one.
/// Returns the number of rounds.
pub fn alternate(rivals: &mut [Rival<'_>], time: Duration) -> usize {
    for rival in rivals.iter_mut() {
        (rival.batch)();
        rival.rounds_ns.clear();
    }
    let (began, count) = (Instant::now(), rivals.len());
    let mut rounds = 0;
    while rounds < ROUNDS_AT_LEAST || began.elapsed() < time {
        for place in 0..count {
            rivals[(place + rounds) % count].round();
        }
        rounds += 1;
    }
    rounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn each_has_its_turn_in_each_round_and_none_is_always_first() {
        let turns = RefCell::new(String::new());
        let turn = |name: char| {
            let turns = &turns;
            Rival::new(1, move || turns.borrow_mut().push(name))
        };
        let mut rivals = [turn('a'), turn('b'), turn('c')];
        assert_eq!(alternate(&mut rivals, Duration::ZERO), ROUNDS_AT_LEAST);
        assert!(rivals.iter().all(|r| r.rounds_ns.len() == ROUNDS_AT_LEAST));
        drop(rivals);
        // The first three are to warm up.
        assert_eq!(turns.into_inner(), "abcabcbcacababcbca");
    }

    #[test]
    fn ratios_are_formed_within_a_round() {
        let with = |rounds_ns: [f64; 3]| {
            let mut rival = Rival::new(1, || {});
            rival.rounds_ns = rounds_ns.to_vec();
            rival
        };
        // Twice as slow in the second round, and so was the other.
        let (a, b) = (with([4.0, 8.0, 6.0]), with([2.0, 4.0, 2.0]));
        assert_eq!(a.over(&b), Spread { median: 2.0, min: 2.0, max: 3.0 });
        assert_eq!(a.beyond(&b), Spread { median: 4.0, min: 2.0, max: 4.0 });
        assert_eq!(a.ns().median, 6.0);
    }
}
