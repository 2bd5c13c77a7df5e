//! The shards that a merge has no whole part of.

use std::fmt;

/// The shards of a sweep that have no whole part.
#[derive(Debug)]
pub struct Incomplete {
    /// The number of shards.
    pub shards: u64,
    /// Index and fault of each that cannot be used, in order.
    pub faults: Vec<(u64, String)>,
    /// Command that makes one of them, with `I` for its index.
    pub command: String,
}

impl fmt::Display for Incomplete {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MOST_NAMED: usize = 5;
        let (count, all) = (self.faults.len(), self.shards);
        write!(f, "merging failed: {count} of {all} shards have no whole part: ")?;
        let named = self.faults.iter().take(MOST_NAMED).map(|(_, fault)| fault.as_str());
        f.write_str(&named.collect::<Vec<_>>().join(", "))?;
        if count > MOST_NAMED {
            write!(f, " and {} others", count - MOST_NAMED)?;
        }
        let shards = ranges(self.faults.iter().map(|(index, _)| *index));
        write!(f, "; make them with `{}` for I in {shards}", self.command)
    }
}

/// Indices that ascend, as ranges: `2,5-7`.
fn ranges(indices: impl Iterator<Item = u64>) -> String {
    let mut ranges: Vec<(u64, u64)> = Vec::new();
    for index in indices {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == index => *last = index,
            _ => ranges.push((index, index)),
        }
    }
    let text = |(first, last): &(u64, u64)| match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    };
    ranges.iter().map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named_in_short() {
        let fault = |index: u64| (index, format!("part-{index} is missing"));
        let faults = [0, 2, 3, 4, 7, 8, 10].map(fault).to_vec();
        let text = Incomplete { shards: 12, faults, command: "make I".to_owned() }.to_string();
        for words in ["7 of 12", "part-7 is missing", "2 others", "`make I` for I in 0,2-4,7-8,10"]
        {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert!(!text.contains("part-8"), "{text}");
    }
}
