//! `--seeds A..B`: which seeds, in order.

use std::str::FromStr;

/// Seeds in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seeds {
    first: u64,
    last: u64,
}

impl Seeds {
    /// A single one.
    #[must_use]
    pub fn one(seed: u64) -> Self {
        Self { first: seed, last: seed }
    }

    /// How many; at most `u64::MAX`.
    #[must_use]
    pub fn count(&self) -> u64 {
        (self.last - self.first).saturating_add(1)
    }

    /// The seed at `place`, from 0, below [`count`](Self::count).
    #[must_use]
    pub fn at(&self, place: u64) -> u64 {
        self.first + place
    }
}

impl std::fmt::Display for Seeds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.last.checked_add(1) {
            Some(end) => write!(f, "{}..{end}", self.first),
            None => write!(f, "{}..={}", self.first, self.last),
        }
    }
}

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const REMEDY: &str = "write A..B (B left out), A..=B, or one seed: 0..500";
        let number = |word: &str| {
            word.trim().parse::<u64>().map_err(|_| format!("{word:?} is no seed; {REMEDY}"))
        };
        let (first, last) = match text.split_once("..") {
            None => (number(text)?, Some(number(text)?)),
            Some((first, last)) => match last.strip_prefix('=') {
                Some(last) => (number(first)?, Some(number(last)?)),
                None => (number(first)?, number(last)?.checked_sub(1)),
            },
        };
        match last {
            Some(last) if last >= first => Ok(Self { first, last }),
            _ => Err(format!("there is no seed in it; {REMEDY}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_read_and_written() {
        for (text, first, count, again) in [
            ("0..500", 0, 500, "0..500"),
            ("3..=5", 3, 3, "3..6"),
            ("7", 7, 1, "7..8"),
            ("18446744073709551615", u64::MAX, 1, "18446744073709551615..=18446744073709551615"),
        ] {
            let seeds: Seeds = text.parse().unwrap();
            assert_eq!((seeds.at(0), seeds.count()), (first, count), "{text}");
            assert_eq!(seeds.to_string(), again);
            assert_eq!(again.parse(), Ok(seeds));
        }
        for text in ["5..5", "5..4", "0..0", "a..b", "", "1..", "-1..3", "5..=4"] {
            let error = text.parse::<Seeds>().unwrap_err();
            assert!(error.contains("0..500"), "{text}: {error}");
        }
    }
}
