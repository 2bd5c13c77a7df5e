//! One clock reading per round, and what the round took.

use std::ops::Add as _;

use rusty_link::monotonic_ns;

use crate::usage::Usage;

/// Stamps the beginning of every round. Rounds up to `warm_up` are left out.
pub struct Stamps {
    warm_up: usize,
    rounds: usize,
    stamps_ns: Vec<u64>,
    pids: Vec<u32>,
    before: Option<[Usage; 2]>,
    after: Option<[Usage; 2]>,
}

/// What was measured in one repetition.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Each round, from its beginning to that of the next, ns.
    pub durations_ns: Vec<u64>,
    /// What the rounds took of the machine: the server, and its clients together.
    pub used: [Usage; 2],
}

impl Stamps {
    /// For `rounds` rounds that count, after `warm_up` that do not, of this
    /// process with those of `pids`.
    #[must_use]
    pub fn new(warm_up: usize, rounds: usize, pids: Vec<u32>) -> Self {
        let stamps_ns = Vec::with_capacity(warm_up + rounds + 1);
        Self { warm_up, rounds, stamps_ns, pids, before: None, after: None }
    }

    /// Counts what these processes use, in addition to this one.
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
            self.before = used_now(&self.pids);
        }
        if round < self.rounds_in_all() {
            self.stamps_ns.push(monotonic_ns());
        }
        if round == self.warm_up + self.rounds {
            self.after = used_now(&self.pids);
        }
    }

    /// What was measured; `None` if the rounds ended early.
    #[must_use]
    pub fn finish(self) -> Option<Sample> {
        let counted = self.stamps_ns.get(self.warm_up..=self.warm_up + self.rounds)?;
        let durations_ns = counted.windows(2).map(|pair| pair[1].saturating_sub(pair[0]));
        // Where the kernel does not say, zeros.
        let used = self.after.zip(self.before).map(|(a, b)| [a[0] - b[0], a[1] - b[1]]);
        Some(Sample { durations_ns: durations_ns.collect(), used: used.unwrap_or_default() })
    }
}

/// What the server and all its clients together have used, as the kernel counts.
fn used_now(pids: &[u32]) -> Option<[Usage; 2]> {
    let clients: Option<Vec<Usage>> = pids.iter().map(|pid| Usage::of(*pid)).collect();
    Some([Usage::own()?, clients?.into_iter().fold(Usage::default(), Usage::add)])
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
}
