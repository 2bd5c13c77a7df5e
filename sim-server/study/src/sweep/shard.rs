//! `--shard i/n`: one machine's part of a sweep.

use std::ops::Range;
use std::str::FromStr;

/// Part `index` of `count`, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// All of it.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Which of `runs` are this part's: a block, so that the parts one after the
    /// other are the whole. Blocks differ in length by one run at most.
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

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const REMEDY: &str = "write i/n with i from 0 to n - 1: 0/8 is the first of eight parts";
        let (index, count) = text.split_once('/').ok_or(format!("has no `/`; {REMEDY}"))?;
        let number = |word: &str| {
            word.trim().parse::<u64>().map_err(|_| format!("{word:?} is no number; {REMEDY}"))
        };
        let (index, count) = (number(index)?, number(count)?);
        if index >= count {
            return Err(format!("there is no part {index} of {count}; {REMEDY}"));
        }
        Ok(Self { index, count })
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
                let part: Shard = format!("{index}/{count}").parse().unwrap();
                let block = part.of(runs);
                assert_eq!(block.start, end);
                assert!(block.end - block.start <= runs / count + 1);
                end = block.end;
            }
            assert_eq!(end, runs);
        }
        for text in ["3/3", "1/0", "0", "a/2", "-1/2"] {
            assert!(text.parse::<Shard>().unwrap_err().contains("i/n"), "{text}");
        }
    }
}
