//! One clock reading per round, and what the round took.

use std::ops::{Add, Sub};

use rusty_link::monotonic_ns;
use serde::{Deserialize, Serialize};

use crate::usage::Usage;

/// Stamps the beginning of every round. Rounds up to `warm_up` are left out.
pub struct Stamps {
    warm_up: usize,
    rounds: usize,
    stamps_ns: Vec<u64>,
    pids: Vec<u32>,
    before: Option<Used>,
    after: Option<Used>,
}

/// What was measured in one repetition.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Each round, from its beginning to that of the next, ns.
    pub durations_ns: Vec<u64>,
    /// What the rounds took of the machine.
    pub used: Used,
}

/// What the server and all its clients together used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Used {
    /// This process.
    pub server: Usage,
    /// The others, summed.
    pub clients: Usage,
}

/// The same for each round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UsePerRound {
    /// Processor time, ns.
    pub cpu_ns: f64,
    /// How often the core was given away to wait.
    pub voluntary_switches: f64,
    /// How often the core was lost, or left by `sched_yield`.
    pub involuntary_switches: f64,
}

impl UsePerRound {
    /// Of `used` in so many rounds.
    #[must_use]
    pub fn of(used: &Usage, rounds: usize) -> Self {
        let each = |count: u64| count as f64 / rounds.max(1) as f64;
        Self {
            cpu_ns: each(used.cpu_ns),
            voluntary_switches: each(used.voluntary_switches),
            involuntary_switches: each(used.involuntary_switches),
        }
    }
}

impl Stamps {
    /// For `rounds` rounds that count, after `warm_up` that do not, of this
    /// process with those of `pids`.
    #[must_use]
    pub fn new(warm_up: usize, rounds: usize, pids: Vec<u32>) -> Self {
        let stamps_ns = Vec::with_capacity(warm_up + rounds + 1);
        Self { warm_up, rounds, stamps_ns, pids, before: None, after: None }
    }

    /// Counts what these processes use, beside this one.
    pub fn watch(&mut self, pids: Vec<u32>) {
        self.pids = pids;
    }

    /// How many rounds there must be: one more begins than counts.
    #[must_use]
    pub fn rounds_in_all(&self) -> usize {
        self.warm_up + self.rounds + 1
    }

    /// A round begins.
    pub fn stamp(&mut self) {
        let round = self.stamps_ns.len();
        if round == self.warm_up {
            self.before = Used::now(&self.pids);
        }
        if round < self.rounds_in_all() {
            self.stamps_ns.push(monotonic_ns());
        }
        if round == self.warm_up + self.rounds {
            self.after = Used::now(&self.pids);
        }
    }

    /// What was measured; `None` if the rounds ended early.
    #[must_use]
    pub fn finish(self) -> Option<Sample> {
        let counted = self.stamps_ns.get(self.warm_up..=self.warm_up + self.rounds)?;
        let durations_ns = counted.windows(2).map(|pair| pair[1].saturating_sub(pair[0]));
        // Where the kernel does not say, zeros.
        let used = self.after.zip(self.before).map(|(after, before)| after - before);
        Some(Sample { durations_ns: durations_ns.collect(), used: used.unwrap_or_default() })
    }
}

impl Used {
    fn now(pids: &[u32]) -> Option<Self> {
        let clients: Option<Vec<Usage>> = pids.iter().map(|pid| Usage::of(*pid)).collect();
        let clients = clients?.into_iter().fold(Usage::default(), Usage::add);
        Some(Self { server: Usage::own()?, clients })
    }
}

impl Sub for Used {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        Self { server: self.server - earlier.server, clients: self.clients - earlier.clients }
    }
}

impl Add for Used {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { server: self.server + other.server, clients: self.clients + other.clients }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rounds_after_the_warm_up_count() {
        let mut stamps = Stamps::new(2, 3, vec![std::process::id()]);
        for _ in 0..stamps.rounds_in_all() {
            stamps.stamp();
        }
        let taken = stamps.stamps_ns.clone();
        let sample = stamps.finish().unwrap();
        let expected: Vec<u64> = (2..5).map(|i| taken[i + 1] - taken[i]).collect();
        assert_eq!(sample.durations_ns, expected);
    }

    #[test]
    fn what_ended_early_was_not_measured() {
        let mut stamps = Stamps::new(2, 3, Vec::new());
        (0..5).for_each(|_| stamps.stamp());
        assert!(stamps.finish().is_none());
    }

    #[test]
    fn use_is_divided_by_the_rounds() {
        let used = Usage { cpu_ns: 900, voluntary_switches: 3, ..Usage::default() };
        let each = UsePerRound::of(&used, 3);
        assert_eq!((each.cpu_ns, each.voluntary_switches), (300.0, 1.0));
    }
}
