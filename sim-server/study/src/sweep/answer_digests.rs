//! The digests of all answers of a run, to compare it with its repetition.

use rusty_contract::{Frame, LogHeader, Reply, RunDigest};
use rusty_engine::source::{FrameSource, Simulated, SourceError};
use rusty_geometry::{SE2, Twist};

/// The world, and a digest of every answer where they are kept.
pub(super) struct DigestingSource<'s> {
    source: Simulated<'s>,
    is_kept: bool,
    digests: AnswerDigests,
}

/// The answers of a run: for each tick their digests, in the order of the names.
#[derive(Default)]
pub(super) struct AnswerDigests {
    names: Vec<String>,
    ticks: Vec<Vec<[u8; 16]>>,
}

impl<'s> DigestingSource<'s> {
    pub(super) fn new(source: Simulated<'s>, is_kept: bool) -> Self {
        Self { source, is_kept, digests: AnswerDigests::default() }
    }

    pub(super) fn digests(self) -> AnswerDigests {
        self.digests
    }
}

impl FrameSource for DigestingSource<'_> {
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

    fn needs_no_answer(&self) -> bool {
        self.source.needs_no_answer()
    }

    fn prepare(&mut self) {
        self.source.prepare();
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        self.source.again()
    }

    fn closed(&mut self, replies: &mut dyn Iterator<Item = (&str, Reply)>) {
        if !self.is_kept {
            return;
        }
        let (names, digests): (Vec<&str>, Vec<[u8; 16]>) = replies
            .map(|(name, reply)| {
                let mut digest = RunDigest::default();
                digest.absorb_replies(std::iter::once(reply));
                (name, digest.run())
            })
            .unzip();
        if self.digests.names.is_empty() {
            self.digests.names = names.into_iter().map(str::to_owned).collect();
        }
        self.digests.ticks.push(digests);
    }
}

impl AnswerDigests {
    /// The first tick at which answers differ, and whose they are. What differs later may
    /// follow from these.
    pub(super) fn first_difference(&self, other: &Self) -> Option<(usize, Vec<&str>)> {
        let differ = |(a, b): (&Vec<[u8; 16]>, &Vec<[u8; 16]>)| a != b;
        let tick = self.ticks.iter().zip(&other.ticks).position(differ).or_else(|| {
            let lengths = [self.ticks.len(), other.ticks.len()];
            (lengths[0] != lengths[1]).then(|| lengths[0].min(lengths[1]))
        })?;
        let at = |run: &Self, i: usize| run.ticks.get(tick).map(|digests| digests[i]);
        let names = self.names.iter().enumerate().filter(|(i, _)| at(self, *i) != at(other, *i));
        Some((tick, names.map(|(_, name)| name.as_str()).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_to_differ_is_named() {
        let digests = |ticks: &[[u8; 2]]| AnswerDigests {
            names: ["a", "b"].map(str::to_owned).to_vec(),
            ticks: ticks.iter().map(|tick| tick.map(|n| [n; 16]).to_vec()).collect(),
        };
        let first = digests(&[[1, 2], [3, 4], [5, 6]]);
        assert_eq!(first.first_difference(&digests(&[[1, 2], [3, 4], [5, 6]])), None);
        let other = digests(&[[1, 2], [3, 9], [9, 9]]);
        assert_eq!(first.first_difference(&other), Some((1, vec!["b"])));
        assert_eq!(first.first_difference(&digests(&[[1, 2]])), Some((1, vec!["a", "b"])));
    }
}
