//! The results of a run so far: digests, replies, effects, losses.

use rusty_contract::tally::{Tally, TallyEntry};
use rusty_contract::{Effects, Frame, LogHeader, OnLoss, Reply, RunDigest};
use rusty_geometry::SE2;

use super::history::History;
use crate::lockstep::{Lockstep, Loss};
use crate::source::SourceError;

/// The digests of a run, and the answers in effect.
pub(super) struct Chain {
    run_id: u64,
    /// Over all that was published or answered.
    pub(super) digest: RunDigest,
    pub(super) effects: Effects,
    /// Whether the frame of the current tick has a scan.
    has_scan: bool,
}

impl Chain {
    pub(super) fn new(run_id: u64, header: &LogHeader) -> Self {
        let effects = Effects::of(header);
        Self { run_id, digest: RunDigest::default(), effects, has_scan: false }
    }

    /// Takes in a sealed frame.
    pub(super) fn frame(&mut self, frame: &Frame, truth: Option<SE2>) {
        self.has_scan = frame.ranges_m().is_some();
        self.digest.absorb_frame(frame, truth);
    }

    /// Takes in the replies to a tick.
    pub(super) fn close(
        &mut self,
        tick: u64,
        replies: impl ExactSizeIterator<Item = Reply> + Clone,
    ) {
        self.digest.absorb_replies(replies.clone());
        self.effects.close(tick, self.has_scan, replies);
    }

    /// Begins the tally of the tick closed last.
    pub(super) fn begin_tally(&self, tally: &mut Tally, tick: u64) {
        tally.begin(self.run_id, tick);
        tally.run_digest = self.digest.run();
        tally.world_digest = self.digest.world();
    }
}

/// The results of a run so far.
pub(super) struct Ledger {
    pub(super) chain: Chain,
    /// The digests up to the last complete tick.
    pub(super) closed: RunDigest,
    /// Whether a participant holds the key, so that tallies are sent.
    has_key_holders: bool,
    /// Replies so far, where a participant may come back.
    history: Option<History>,
    pub(super) losses: Vec<Loss>,
    pub(super) restarts: Vec<Loss>,
    pub(super) remarks: Vec<String>,
    pub(super) source_error: Option<SourceError>,
}

impl Ledger {
    pub(super) fn new(run_id: u64, header: &LogHeader) -> Self {
        Self {
            chain: Chain::new(run_id, header),
            closed: RunDigest::default(),
            has_key_holders: header.roster.iter().any(|p| p.role.holds_key()),
            history: (header.on_loss == OnLoss::Restart).then(History::default),
            losses: Vec::new(),
            restarts: Vec::new(),
            remarks: Vec::new(),
            source_error: None,
        }
    }

    /// Takes in the replies to a tick.
    pub(super) fn close(&mut self, tick: u64, lockstep: &Lockstep) {
        let replies = lockstep.replies().map(|(_, reply)| reply);
        self.chain.close(tick, replies.clone());
        self.closed = self.chain.digest;
        if let Some(history) = &mut self.history {
            history.push(replies);
        }
    }

    /// The replies to a complete tick, where they are kept.
    pub(super) fn replies(&self, tick: u64) -> Option<Vec<Reply>> {
        self.history.as_ref()?.replies(tick)
    }

    /// Returns what writes the tally of the tick closed last, if a participant
    /// reads it.
    pub(super) fn tally(&self, tick: u64, lockstep: &Lockstep) -> Option<impl FnOnce(&mut Tally)> {
        self.has_key_holders.then_some(move |tally: &mut Tally| {
            self.chain.begin_tally(tally, tick);
            for (slot, _) in lockstep.replies() {
                let state = &lockstep.slots()[slot];
                tally.push(match state.reply {
                    Some(_) => TallyEntry::answered(state.last, state.latency_ns),
                    None => TallyEntry::missing(slot as u32),
                });
            }
        })
    }
}
