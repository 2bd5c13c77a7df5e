//! What the machine receives: answers and deaths, and what it makes of them.

use rusty_contract::answer::Message;
use rusty_contract::{Answer, OnLoss, Phase, Reply};

use super::{Lockstep, Loss, LossKind, ParticipantState, State, Step};

impl Lockstep {
    /// An answer arrived. Whatever is in it, nothing breaks: what does not
    /// belong to this run or this tick is counted and left.
    pub fn answer(&mut self, answer: &Answer, now_ns: u64) {
        let place = answer.participant as usize;
        if answer.run_id != self.rules.run_id || place >= self.slots.len() {
            return;
        }
        let ending = self.end_of_run_is_sent;
        let slot = &mut self.slots[place];
        if answer.ticket != slot.ticket || matches!(slot.state, ParticipantState::Away { .. }) {
            // A process that no longer has the slot, or never had it.
            slot.strays += 1;
            return;
        }
        slot.waiting_since_ns = answer.sent_ns;
        let message = match answer.message() {
            Ok(message) => message,
            Err(e) => return self.lose(place, LossKind::Invalid, e.to_string()),
        };
        let reply = match message {
            Message::Ready => {
                if self.ready(place) && ending {
                    // It came too late for the last frame: once more for it.
                    // Only once, or saying so again and again would keep the
                    // run from ending.
                    self.state = State::Ending { since_ns: None };
                }
                return;
            }
            Message::Leave if ending || !slot.awaited => return slot.leave(),
            Message::Leave => {
                return self.lose(place, LossKind::Left, "it left before the end".into());
            }
            Message::Failed => {
                return self.lose(
                    place,
                    LossKind::Failed,
                    "it reported a failure of its own".into(),
                );
            }
            Message::Reply(reply) => reply,
        };
        self.reply(place, answer, reply, now_ns);
    }

    /// A reply arrived from the one who has this slot.
    fn reply(&mut self, place: usize, answer: &Answer, reply: Reply, now_ns: u64) {
        let (tick, digest) = (self.tick, self.digest);
        let awaiting = match self.state {
            State::Awaiting { since_ns } => Some(since_ns),
            _ => None,
        };
        let slot = &mut self.slots[place];
        if slot.catch_up.is_some() {
            return self.answer_again(place, answer, reply, now_ns);
        }
        let Some(since_ns) =
            awaiting.filter(|_| slot.state == ParticipantState::Ready && slot.awaited)
        else {
            slot.strays += 1;
            return;
        };
        if answer.tick > tick {
            let detail = format!("it answered tick {}, asked was tick {tick}", answer.tick);
            return self.lose(place, LossKind::Invalid, detail);
        }
        if answer.tick < tick || slot.reply.is_some() {
            // A second answer to a tick that has one. When it arrives is a
            // matter of chance, so it must not matter.
            slot.strays += 1;
            return;
        }
        if answer.digest_seen != digest {
            let detail = format!(
                "it saw another frame at tick {tick}: digest {:016x}, published was {digest:016x}",
                answer.digest_seen
            );
            return self.lose(place, LossKind::Invalid, detail);
        }
        slot.accept(*answer, reply, now_ns.saturating_sub(since_ns));
    }

    /// The kernel says that this slot's process has ended.
    pub fn died(&mut self, slot: usize, how: &str) {
        let ending = matches!(self.state, State::Ending { .. } | State::Finished);
        match self.slots[slot].state {
            // The run ended before it had begun to take part.
            ParticipantState::Joined | ParticipantState::Absent if ending => {
                self.slots[slot].leave()
            }
            ParticipantState::Joined | ParticipantState::Ready | ParticipantState::Absent => {
                self.lose(slot, LossKind::Dead, how.to_owned());
            }
            // The program that was started again has ended as well.
            ParticipantState::Away { called: true, .. } if !ending => {
                self.lose(slot, LossKind::Dead, how.to_owned());
            }
            ParticipantState::Away { .. } | ParticipantState::Lost(_) | ParticipantState::Left => {}
        }
    }

    pub(super) fn lose(&mut self, slot: usize, kind: LossKind, detail: String) {
        let may_restart = self.may_restart(slot, kind);
        let place = &mut self.slots[slot];
        if matches!(place.state, ParticipantState::Lost(_) | ParticipantState::Left) {
            return;
        }
        if !place.awaited {
            // No process waits for it, so nothing is lost.
            place.state = ParticipantState::Left;
            return;
        }
        let tick = (!matches!(self.state, State::Gathering { .. })).then_some(self.tick);
        let loss = Loss { slot, name: place.name.clone(), kind, tick, detail };
        place.catch_up = None;
        if may_restart {
            place.fruitless += 1;
            // No process has the slot now.
            place.pid = 0;
            place.state = ParticipantState::Away { since_ns: 0, called: false };
            self.unsaid.push_back(Step::Restart(loss));
            return;
        }
        place.state = ParticipantState::Lost(loss.clone());
        self.unsaid.push_back(Step::Lost(loss));
        if self.rules.on_loss != OnLoss::Continue {
            self.end(Phase::Aborted);
        }
    }
}
