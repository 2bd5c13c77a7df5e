//! What the machine hears: answers and deaths, and what it makes of them.

use rusty_contract::answer::Message;
use rusty_contract::{Answer, OnLoss, Phase, Reply};

use super::{Lockstep, Loss, LossKind, SeatState, State, Step};

impl Lockstep {
    /// An answer arrived. Whatever is in it, nothing breaks: what does not
    /// belong to this run or this tick is counted and left.
    pub fn answer(&mut self, answer: &Answer, now_ns: u64) {
        let place = answer.participant as usize;
        if answer.run_id != self.rules.run_id || place >= self.seats.len() {
            return;
        }
        let ending = self.last_word_is_out;
        let seat = &mut self.seats[place];
        if answer.ticket != seat.ticket || matches!(seat.state, SeatState::Away { .. }) {
            // Somebody who has the seat no more, or never had it.
            seat.strays += 1;
            return;
        }
        seat.waiting_since_ns = answer.sent_ns;
        let message = match answer.message() {
            Ok(message) => message,
            Err(e) => return self.lose(place, LossKind::Invalid, e.to_string()),
        };
        let reply = match message {
            Message::Ready => {
                if self.ready(place) && ending {
                    // It came too late for the last word: once more for it.
                    // Only once, or saying so again and again would keep the
                    // run from ending.
                    self.state = State::Ending { since_ns: None };
                }
                return;
            }
            Message::Goodbye if ending || !seat.awaited => return seat.leave(),
            Message::Goodbye => {
                return self.lose(place, LossKind::Left, "it said goodbye before the end".into());
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

    /// A reply arrived from the one who has this seat.
    fn reply(&mut self, place: usize, answer: &Answer, reply: Reply, now_ns: u64) {
        let (tick, digest) = (self.tick, self.digest);
        let awaiting = match self.state {
            State::Awaiting { since_ns } => Some(since_ns),
            _ => None,
        };
        let seat = &mut self.seats[place];
        if seat.catch_up.is_some() {
            return self.answer_again(place, answer, reply, now_ns);
        }
        let Some(since_ns) = awaiting.filter(|_| seat.state == SeatState::Ready && seat.awaited)
        else {
            seat.strays += 1;
            return;
        };
        if answer.tick > tick {
            let detail = format!("it answered tick {}, asked was tick {tick}", answer.tick);
            return self.lose(place, LossKind::Invalid, detail);
        }
        if answer.tick < tick || seat.reply.is_some() {
            // A second answer to a tick that has one. When it arrives is a
            // matter of chance, so it must not matter.
            seat.strays += 1;
            return;
        }
        if answer.digest_seen != digest {
            let detail = format!(
                "it saw another frame at tick {tick}: digest {:016x}, published was {digest:016x}",
                answer.digest_seen
            );
            return self.lose(place, LossKind::Invalid, detail);
        }
        seat.accept(*answer, reply, now_ns.saturating_sub(since_ns));
    }

    /// The kernel says that this seat's process has ended.
    pub fn died(&mut self, seat: usize, how: &str) {
        let ending = matches!(self.state, State::Ending { .. } | State::Finished);
        match self.seats[seat].state {
            // The run ended before it had begun to take part.
            SeatState::Joined | SeatState::Absent if ending => self.seats[seat].leave(),
            SeatState::Joined | SeatState::Ready | SeatState::Absent => {
                self.lose(seat, LossKind::Dead, how.to_owned());
            }
            // The program that was started again has ended as well.
            SeatState::Away { called: true, .. } if !ending => {
                self.lose(seat, LossKind::Dead, how.to_owned());
            }
            SeatState::Away { .. } | SeatState::Lost(_) | SeatState::Left => {}
        }
    }

    pub(super) fn lose(&mut self, seat: usize, kind: LossKind, detail: String) {
        let may_restart = self.may_restart(seat, kind);
        let place = &mut self.seats[seat];
        if matches!(place.state, SeatState::Lost(_) | SeatState::Left) {
            return;
        }
        if !place.awaited {
            // Nobody waits for it, so nothing is lost.
            place.state = SeatState::Left;
            return;
        }
        let tick = (!matches!(self.state, State::Gathering { .. })).then_some(self.tick);
        let loss = Loss { seat, name: place.name.clone(), kind, tick, detail };
        place.catch_up = None;
        if may_restart {
            place.fruitless += 1;
            // Nobody has the seat now.
            place.pid = 0;
            place.state = SeatState::Away { since_ns: 0, called: false };
            self.unsaid.push_back(Step::Restart(loss));
            return;
        }
        place.state = SeatState::Lost(loss.clone());
        self.unsaid.push_back(Step::Lost(loss));
        if self.rules.on_loss != OnLoss::Continue {
            self.end(Phase::Aborted);
        }
    }
}
