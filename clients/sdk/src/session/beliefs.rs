//! Beliefs that a participant of a run shows, or sees.

use rusty_contract::belief::tidy;
use rusty_contract::scenario::Role;
use rusty_contract::{BeliefHeader, BeliefKind, Start, WeightedPose};
use rusty_link::Beliefs;

use super::{Session, Source};

impl Session {
    /// The way by which beliefs are shown in a run; none on a log.
    fn beliefs(&mut self) -> Option<&mut Beliefs> {
        match &mut self.source {
            Source::Live(link) => Some(link.beliefs()),
            Source::Log(_) => None,
        }
    }

    /// Whether any process observes beliefs of this run now; never on a log.
    pub fn is_watched(&mut self) -> bool {
        self.beliefs().is_some_and(|beliefs| beliefs.is_watched())
    }

    /// Shows the belief that is held after a tick to the processes that observe the
    /// run. What is no pose is taken out of `poses`, and of more than
    /// [`MAX_POSES`](rusty_contract::belief::MAX_POSES) a part is shown. Whether
    /// anybody observes, or gets it, changes nothing else.
    pub fn show_belief(
        &mut self,
        (tick, time_s): (u64, f64),
        kind: BeliefKind,
        poses: &mut Vec<WeightedPose>,
    ) {
        let whole = tidy(poses);
        let Start { run_id, participant, name, .. } = &self.start;
        let (run_id, participant) = (*run_id, *participant);
        let (name, kind) = (BeliefHeader::padded(name), kind.number());
        let count = poses.len() as u32;
        let header = BeliefHeader { run_id, tick, time_s, name, participant, kind, count, whole };
        if let Some(beliefs) = self.beliefs().filter(|_| whole > 0) {
            // Whether it went out is of no consequence.
            let _ = beliefs.show(header, poses);
        }
    }

    /// The next belief of this run that came, for scorers.
    pub(crate) fn next_belief(&mut self, poses: &mut Vec<WeightedPose>) -> Option<BeliefHeader> {
        let run_id = self.start.run_id;
        if self.start.role != Role::Scorer {
            return None;
        }
        let beliefs = self.beliefs()?;
        std::iter::from_fn(|| beliefs.next(poses)).find(|header| header.run_id == run_id)
    }
}
