//! The replies of a run so far, kept where a participant may have to be given the
//! run again.

use rusty_contract::Reply;

/// Replies of the answering slots, tick by tick. They are kept in memory for as
/// long as the run lasts, in the log's encoding: a tick takes 8 bytes and an
/// estimate in it 26, 72 more with its covariance, 9 or more with its innovation.
/// It is the one thing of a run that grows with its ticks: with one estimator, 34
/// MB for a million of them.
#[derive(Debug, Default)]
pub(super) struct History {
    bytes: Vec<u8>,
    /// Where each tick's replies end.
    ends: Vec<usize>,
}

impl History {
    /// Adds a tick that is closed.
    pub(super) fn push(&mut self, replies: impl Iterator<Item = Reply>) {
        for reply in replies {
            // Writing to memory cannot fail.
            if let Ok(bytes) = postcard::to_extend(&reply, std::mem::take(&mut self.bytes)) {
                self.bytes = bytes;
            }
        }
        self.ends.push(self.bytes.len());
    }

    /// The replies to `tick`, in roster order; `None` if it is not closed.
    pub(super) fn replies(&self, tick: u64) -> Option<Vec<Reply>> {
        let &end = self.ends.get(usize::try_from(tick).ok()?)?;
        let begin = (tick as usize).checked_sub(1).map_or(0, |t| self.ends[t]);
        let mut rest = &self.bytes[begin..end];
        let mut replies = Vec::new();
        while let Ok((reply, after)) = postcard::take_from_bytes(rest) {
            replies.push(reply);
            rest = after;
        }
        Some(replies)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{SE2, Twist};

    #[test]
    fn a_tick_takes_as_many_bytes_as_it_says() {
        let pose = SE2::new(1.0, 2.0, 3.0);
        let sure = rusty_contract::Estimate::new(pose).with_covariance([0.1; 9]);
        for (reply, bytes) in [(pose.into(), 26), (Reply::from(sure), 98)] {
            let mut history = History::default();
            (0..1000).for_each(|_| history.push([reply].into_iter()));
            assert_eq!((history.bytes.len(), history.ends.len()), (1000 * bytes, 1000));
        }
    }

    #[test]
    fn what_was_said_comes_back_tick_by_tick() {
        let estimate = Reply::from(SE2::new(1.0, -0.0, 0.5));
        let command = Reply::from(Twist { v_m_s: 0.25, omega_rad_s: -1.0 });
        let said = [vec![estimate, Reply::Missing], vec![Reply::Abstain, command], vec![]];
        let mut history = History::default();
        for replies in &said {
            history.push(replies.iter().copied());
        }
        for (tick, replies) in said.iter().enumerate() {
            let again = history.replies(tick as u64).unwrap();
            assert_eq!(again.len(), replies.len());
            assert!(again.iter().zip(replies).all(|(a, b)| a.same_bits(b)));
        }
        assert_eq!(history.replies(3), None);
        assert_eq!(history.replies(u64::MAX), None);
    }
}
