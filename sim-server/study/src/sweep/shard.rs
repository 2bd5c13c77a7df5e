//! One of the shards of a sweep.

use std::ops::Range;

/// Shard `index` of `count`, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its index, below `count`.
    pub index: u64,
    /// The number of shards.
    pub count: u64,
}

impl Shard {
    /// Returns the runs of this shard among `runs`: a block, so that the shards one
    /// after the other are the whole. Blocks differ in length by one run at most.
    #[must_use]
    pub fn of(&self, runs: u64) -> Range<u64> {
        let begin = |index: u64| {
            let place = u128::from(runs) * u128::from(index) / u128::from(self.count);
            // Never above `runs`, since the index is not above the count.
            place as u64
        };
        begin(self.index)..begin(self.index + 1)
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_one_after_the_other_are_the_whole() {
        for (runs, count) in [(10, 3), (2, 5), (0, 2), (u64::MAX, 7), (12, 1)] {
            let mut end = 0;
            for index in 0..count {
                let block = Shard { index, count }.of(runs);
                assert_eq!(block.start, end);
                assert!(block.end - block.start <= runs / count + 1);
                end = block.end;
            }
            assert_eq!(end, runs);
        }
    }
}
