//! What is measured in a server's process: when each tick began, and the
//! processor time of everyone who takes part.

use std::collections::BTreeMap;

use rusty_bench::usage::Usage;
use rusty_link::monotonic_ns;
use serde::{Deserialize, Serialize};

/// What one process measured; it travels to the parent as JSON.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Measured {
    /// From the beginning of each tick to that of the next, ns, in order.
    pub ticks_ns: Vec<u64>,
    /// Processor time of the server and all clients in these ticks, ns; `None`
    /// where the kernel does not say.
    pub cpu_ns: Option<u64>,
    /// Digest of the whole run.
    pub digest: String,
}

/// Stamps the beginning of every tick. Ticks up to `warm_up` count for nothing.
pub struct Meter {
    warm_up: u64,
    stamps_ns: Vec<u64>,
    pids: Vec<u32>,
    before: BTreeMap<u32, u64>,
    after: BTreeMap<u32, u64>,
}

/// How many ticks a run has that measures `ticks`: the last one only ends the
/// one before.
pub fn run_ticks(warm_up: u64, ticks: u64) -> u64 {
    warm_up + ticks + 1
}

impl Meter {
    /// Measures `ticks` ticks after `warm_up`, and the processor time of this
    /// process and of `clients`.
    pub fn new(warm_up: u64, ticks: u64, clients: &[u32]) -> Self {
        let pids = [&[std::process::id()], clients].concat();
        let stamps_ns = Vec::with_capacity(ticks as usize + 1);
        Self { warm_up, stamps_ns, pids, before: BTreeMap::new(), after: BTreeMap::new() }
    }

    /// Call it first in every tick.
    pub fn begin(&mut self, tick: u64) {
        if tick < self.warm_up || self.stamps_ns.len() == self.stamps_ns.capacity() {
            return;
        }
        if tick == self.warm_up {
            self.before = self.cpu_ns();
        }
        self.stamps_ns.push(monotonic_ns());
        if self.stamps_ns.len() == self.stamps_ns.capacity() {
            self.after = self.cpu_ns();
        }
    }

    fn cpu_ns(&self) -> BTreeMap<u32, u64> {
        self.pids.iter().filter_map(|&pid| Some((pid, Usage::of(pid)?.cpu_ns))).collect()
    }

    pub fn finish(self, digest: String) -> Measured {
        let difference =
            |pid: &u32| Some(self.after.get(pid)?.saturating_sub(*self.before.get(pid)?));
        let cpu_ns = self.pids.iter().map(difference).sum();
        let ticks_ns = self.stamps_ns.windows(2).map(|pair| pair[1] - pair[0]).collect();
        Measured { ticks_ns, cpu_ns, digest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_ticks_are_measured_as_were_asked_for() {
        let mut meter = Meter::new(10, 5, &[]);
        (0..run_ticks(10, 5)).for_each(|tick| meter.begin(tick));
        let measured = meter.finish("d".to_owned());
        assert_eq!(measured.ticks_ns.len(), 5);
        assert!(measured.cpu_ns.is_some());
    }

    #[test]
    fn a_client_that_is_not_there_makes_processor_time_unknown() {
        let mut meter = Meter::new(0, 2, &[0]);
        (0..run_ticks(0, 2)).for_each(|tick| meter.begin(tick));
        assert_eq!(meter.finish(String::new()).cpu_ns, None);
    }
}
