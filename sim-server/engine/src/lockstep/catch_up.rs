//! How a participant that was lost comes back (`on_loss = "restart"`).
//!
//! ```text
//! lost ──▶ away ── joins ──▶ joined ── ready ──▶ fed 0, 1, … up to the tick of the others ──▶ as before
//!            │ join timeout        │ lost again: away, unless it never gets anywhere
//!            ▼                     ▼
//!          lost for good, the run is aborted
//! ```
//!
//! No tick is released meanwhile. What it answers to a tick that had its answer
//! before it was lost is an echo: it changes nothing, and is handed out so that
//! a reader can compare. A participant that is deterministic gives the same
//! again, so the run has the digest it would have had.

use rusty_contract::{Answer, OnLoss, Reply};

use super::{CatchingUp, Lockstep, LossKind, ParticipantState, State, Step};

/// So often in a row a participant is started again without having answered
/// anything new in between: once is chance, three times is its own fault.
const FRUITLESS: u32 = 3;

impl Lockstep {
    /// How many ticks have been published so far.
    pub(super) fn published_ticks(&self) -> u64 {
        match self.state {
            State::Awaiting { .. } | State::Closing => self.tick + 1,
            _ => self.tick,
        }
    }

    pub(super) fn may_restart(&self, slot: usize, kind: LossKind) -> bool {
        self.rules.on_loss == OnLoss::Restart
            && kind.may_come_back()
            && self.slots[slot].fruitless < FRUITLESS
            && !matches!(self.state, State::Ending { .. } | State::Finished)
    }

    /// Starting the program on this slot again cannot help: should it be lost, it
    /// is lost for good.
    pub(crate) fn give_up(&mut self, slot: usize) {
        self.slots[slot].fruitless = FRUITLESS;
    }

    /// A participant is being told this.
    pub(super) fn said(&mut self, step: Step, now_ns: u64) -> Step {
        if let Step::Restart(loss) = &step {
            if matches!(self.state, State::Ending { .. } | State::Finished) {
                // There is nothing left to come back to.
                self.slots[loss.slot].state = ParticipantState::Lost(loss.clone());
                return Step::Lost(loss.clone());
            }
            let state = &mut self.slots[loss.slot].state;
            if let ParticipantState::Away { since_ns, called } = state {
                (*since_ns, *called) = (now_ns, true);
            }
        }
        step
    }

    /// By when those who are coming back must have done their next step, if
    /// a participant is.
    pub(super) fn back_by_ns(&self) -> Option<u64> {
        (0..self.slots.len()).filter_map(|slot| self.deadline_ns(slot)).min()
    }

    fn deadline_ns(&self, slot: usize) -> Option<u64> {
        let (since_ns, timeout_ns) = match (&self.slots[slot].state, self.slots[slot].catch_up) {
            (ParticipantState::Away { since_ns, .. }, _) => (*since_ns, self.rules.join_timeout_ns),
            (ParticipantState::Joined, Some(c)) => (c.since_ns, self.rules.join_timeout_ns),
            (ParticipantState::Ready, Some(CatchingUp { sent: Some((_, sent_ns)), .. })) => {
                (sent_ns, self.rules.answer_timeout_ns)
            }
            // It is fed at once.
            (ParticipantState::Ready, Some(_)) => return Some(0),
            _ => return None,
        };
        Some(since_ns.saturating_add(timeout_ns))
    }

    /// What is to be done for those who are coming back.
    pub(super) fn next_catch_up(
        &mut self,
        now_ns: u64,
        describe: impl Fn(usize) -> String,
    ) -> Option<Step> {
        if matches!(self.state, State::Ending { .. } | State::Finished) {
            return None;
        }
        for slot in 0..self.slots.len() {
            let Some(deadline_ns) = self.deadline_ns(slot) else { continue };
            match (&self.slots[slot].state, self.slots[slot].catch_up) {
                (ParticipantState::Ready, Some(CatchingUp { next, sent: None, .. })) => {
                    return Some(Step::Feed { slot, tick: next });
                }
                _ if now_ns < deadline_ns => {}
                (ParticipantState::Ready, Some(CatchingUp { next, .. })) => {
                    let seconds = self.rules.answer_timeout_ns as f64 * 1e-9;
                    let detail = format!(
                        "no answer to tick {next}, given to it again, within {seconds} s{}",
                        describe(slot)
                    );
                    self.lose(slot, LossKind::Stalled, detail);
                }
                _ => {
                    let seconds = self.rules.join_timeout_ns as f64 * 1e-9;
                    let detail =
                        format!("it did not come back within {seconds} s{}", describe(slot));
                    self.lose(slot, LossKind::NeverAttached, detail);
                }
            }
        }
        let step = self.unsaid.pop_front()?;
        Some(self.said(step, now_ns))
    }

    /// The tick that [`Step::Feed`] asked for is out, with this digest.
    pub(crate) fn fed(&mut self, slot: usize, digest: u64, now_ns: u64) {
        if let Some(catch_up) = &mut self.slots[slot].catch_up {
            catch_up.sent = Some((digest, now_ns));
        }
    }

    /// Its ports are open: it takes part, once it has caught up. Says whether
    /// that is news.
    pub(super) fn ready(&mut self, slot: usize) -> bool {
        let place = &mut self.slots[slot];
        let joined = place.state == ParticipantState::Joined;
        if joined {
            place.state = ParticipantState::Ready;
            if place.catch_up.is_some_and(|c| c.ticks == 0) {
                place.catch_up = None;
            }
        }
        joined
    }

    /// One who is catching up answers.
    pub(super) fn answer_again(&mut self, slot: usize, answer: &Answer, reply: Reply, now_ns: u64) {
        let place = &mut self.slots[slot];
        let Some(catch_up) = &mut place.catch_up else { return };
        let at = catch_up.next;
        let Some((digest, sent_ns)) = catch_up.sent.filter(|_| answer.tick >= at) else {
            place.strays += 1;
            return;
        };
        if answer.tick > at || answer.digest_seen != digest {
            let detail = format!(
                "given tick {at} again, digest {digest:016x}, it answered tick {}, digest {:016x}",
                answer.tick, answer.digest_seen
            );
            return self.lose(slot, LossKind::Invalid, detail);
        }
        catch_up.next += 1;
        catch_up.sent = None;
        if catch_up.next == catch_up.ticks {
            place.catch_up = None;
        }
        let is_current = matches!(self.state, State::Awaiting { .. }) && at == self.tick;
        if is_current && place.reply.is_none() {
            place.accept(*answer, reply, now_ns.saturating_sub(sent_ns));
        } else {
            self.unsaid.push_back(Step::Echo { slot, tick: at, reply });
        }
    }
}
