//! The processes of the participants, as far as the server knows them.

use std::path::PathBuf;

use rusty_contract::Phase;
use rusty_link::{Peer, PeerState};

use super::catch_up::Feeding;
use super::children::{Children, Leaving};
use super::has_content;
use crate::lockstep::{Lockstep, LossKind, ParticipantSummary};

/// The processes of the participants, by slot.
pub(super) struct Participants {
    /// Those that the server started.
    pub(super) children: Children,
    /// Those that have joined.
    pub(super) peers: Vec<Option<Peer>>,
    /// The run again, for those who came back.
    pub(super) feedings: Vec<Option<Feeding>>,
    /// Time to join, s.
    pub(super) join_timeout_s: f64,
    /// A forged answer was reported.
    pub(super) forged: bool,
    /// Requests to join that were refused.
    pub(super) refused: u32,
}

impl Participants {
    pub(super) fn new(children: Children, slots: usize, join_timeout_s: f64) -> Self {
        Self {
            children,
            peers: (0..slots).map(|_| None).collect(),
            feedings: (0..slots).map(|_| None).collect(),
            join_timeout_s,
            forged: false,
            refused: 0,
        }
    }

    /// Returns the processes whose end is worth waiting for: one whose end is known would
    /// end every wait at once.
    pub(super) fn present<'a>(&'a self, lockstep: &'a Lockstep) -> impl Iterator<Item = &'a Peer> {
        let present = self.peers.iter().zip(lockstep.slots()).filter(|(_, s)| s.is_present());
        present.filter_map(|(peer, _)| peer.as_ref())
    }

    /// Returns what the kernel knows of a participant, as the end of a sentence.
    pub(super) fn describe(&self, slot: usize) -> String {
        match self.peers[slot].as_ref().map(|p| (p.pid(), p.state())) {
            None => String::new(),
            Some((pid, PeerState::Running)) => format!(" (process {pid} is running)"),
            Some((pid, PeerState::Stopped)) => {
                format!(" (process {pid} is stopped by a signal; `kill -CONT {pid}` lets it go on)")
            }
            Some((pid, PeerState::Dead)) => format!(" (process {pid} has ended)"),
        }
    }

    /// Returns where all that a participant printed can be read, on a line.
    pub(super) fn output(&self, slot: usize) -> String {
        let path = self.children.output(slot).filter(|path| has_content(path));
        path.map(|path| format!("\n    full output: {}", path.display())).unwrap_or_default()
    }

    /// Returns the files for what they print, of those that the server started.
    pub(super) fn outputs(&self) -> Vec<(usize, PathBuf)> {
        let output = |slot| Some((slot, self.children.output(slot)?.to_owned()));
        (0..self.peers.len()).filter_map(output).collect()
    }

    /// Waits for the processes to end. Returns those that ended badly: slot and how.
    pub(super) fn finish(self, phase: Phase, slots: &[ParticipantSummary]) -> Vec<(usize, String)> {
        self.children.finish(|slot| how_left(phase, &slots[slot]))
    }
}

pub(super) fn how_left(phase: Phase, slot: &ParticipantSummary) -> Leaving {
    match &slot.lost {
        Some(loss) if loss.kind == LossKind::Failed => Leaving::Failed,
        Some(loss) if loss.kind == LossKind::Dead => Leaving::Dead,
        None if phase == Phase::Aborted => match slot.pid {
            Some(_) => Leaving::Aborted,
            None => Leaving::TooLate,
        },
        None if slot.pid.is_some() => Leaving::AtTheEnd,
        _ => Leaving::Lost,
    }
}
