//! A source of frames that keeps note of who answered what.

use rusty_contract::{Frame, LogHeader, Reply, RunDigest};
use rusty_engine::source::{FrameSource, Simulated, SourceError};
use rusty_geometry::{SE2, Twist};

/// The world, and a digest of every answer.
pub(super) struct Witness<'s> {
    source: Simulated<'s>,
    heard: Heard,
}

/// The answers of a run: for each tick their digests, in the order of the names.
#[derive(Default)]
pub(super) struct Heard {
    names: Vec<String>,
    ticks: Vec<Vec<[u8; 16]>>,
}

impl<'s> Witness<'s> {
    pub(super) fn new(source: Simulated<'s>) -> Self {
        Self { source, heard: Heard::default() }
    }

    pub(super) fn heard(self) -> Heard {
        self.heard
    }
}

impl FrameSource for Witness<'_> {
    fn header(&self) -> &LogHeader {
        self.source.header()
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        self.source.make(driver, frame)
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        self.source.again()
    }

    fn closed(&mut self, replies: &mut dyn Iterator<Item = (&str, Reply)>) {
        let (names, digests): (Vec<&str>, Vec<[u8; 16]>) = replies
            .map(|(name, reply)| {
                let mut digest = RunDigest::default();
                digest.absorb_replies(std::iter::once(reply));
                (name, digest.run())
            })
            .unzip();
        if self.heard.names.is_empty() {
            self.heard.names = names.into_iter().map(str::to_owned).collect();
        }
        self.heard.ticks.push(digests);
    }
}

impl Heard {
    /// The first tick at which answers differ, and whose they are. What differs later may
    /// follow from these.
    pub(super) fn first_difference(&self, other: &Self) -> Option<(usize, Vec<&str>)> {
        let differ = |(a, b): (&Vec<[u8; 16]>, &Vec<[u8; 16]>)| a != b;
        let tick = self.ticks.iter().zip(&other.ticks).position(differ).or_else(|| {
            let lengths = [self.ticks.len(), other.ticks.len()];
            (lengths[0] != lengths[1]).then(|| lengths[0].min(lengths[1]))
        })?;
        let at = |heard: &Self, i: usize| heard.ticks.get(tick).map(|digests| digests[i]);
        let names = self.names.iter().enumerate().filter(|(i, _)| at(self, *i) != at(other, *i));
        Some((tick, names.map(|(_, name)| name.as_str()).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_to_differ_is_named() {
        let heard = |ticks: &[[u8; 2]]| Heard {
            names: ["a", "b"].map(str::to_owned).to_vec(),
            ticks: ticks.iter().map(|tick| tick.map(|n| [n; 16]).to_vec()).collect(),
        };
        let first = heard(&[[1, 2], [3, 4], [5, 6]]);
        assert_eq!(first.first_difference(&heard(&[[1, 2], [3, 4], [5, 6]])), None);
        let other = heard(&[[1, 2], [3, 9], [9, 9]]);
        assert_eq!(first.first_difference(&other), Some((1, vec!["b"])));
        assert_eq!(first.first_difference(&heard(&[[1, 2]])), Some((1, vec!["a", "b"])));
    }
}
