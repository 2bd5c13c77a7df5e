//! The lockstep protocol as a state machine that does no I/O.
//!
//! Events go in through the methods, decisions come out of [`Lockstep::next`];
//! time is an argument. So it can be driven by a seed, without a process.
//!
//! ```text
//! gathering ── all awaited slots ready ──▶ publish t ──▶ awaiting t
//!     │                                        ▲             │ all awaited slots answered, or lost
//!     │ join timeout                           └── close t ◀─┘
//!     ▼                                               │ last tick, interrupt, or a loss that aborts
//!   ending ── all leave messages, deaths, or timeout ──▶ finished
//! ```
//!
//! A tick ends only when every awaited slot that is not lost has answered
//! *that* tick of *that* run with the digest of the frame it saw. Never
//! attached, slow, stalled and dead are four different things: a slot that is
//! merely slow gets a notice; the other three are losses, each with its name.
//!
//! Where losses are made good (`on_loss = "restart"`), time stands still while
//! a slot is away: its program is started again, joins, is fed every tick from
//! the first one on by a separate way, and answers each (`lockstep/catch_up.rs`).

mod catch_up;
mod receive;
mod rules;
mod slot;

pub use rules::{Rules, Step};
pub(crate) use slot::CatchingUp;
pub use slot::{Loss, LossKind, ParticipantState, ParticipantSummary, Slot};

use std::collections::VecDeque;

use rusty_contract::layout::layout_hash;
use rusty_contract::{JoinRequest, PROTOCOL_VERSION, Participant, Phase, Refusal, Reply, Role};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Gathering { since_ns: u64 },
    Publishing,
    Awaiting { since_ns: u64 },
    Closing,
    Ending { since_ns: Option<u64> },
    Finished,
}

/// The machine.
#[derive(Clone, Debug)]
pub struct Lockstep {
    rules: Rules,
    slots: Vec<Slot>,
    /// Places of the answering slots, in roster order.
    answering: Vec<usize>,
    state: State,
    /// The tick being worked on.
    tick: u64,
    /// Digest of the frame of that tick.
    digest: u64,
    phase: Phase,
    /// All present clients have been told how the run ends.
    end_of_run_is_sent: bool,
    /// What happened and was not reported yet.
    unsaid: VecDeque<Step>,
}

impl Lockstep {
    /// A machine that waits for `roster` to join from `now_ns` on.
    #[must_use]
    pub fn new(rules: Rules, roster: &[Participant], now_ns: u64) -> Self {
        let answering = |(i, p): (usize, &Participant)| p.answers().then_some(i);
        Self {
            rules,
            slots: roster.iter().map(Slot::new).collect(),
            answering: roster.iter().enumerate().filter_map(answering).collect(),
            state: State::Gathering { since_ns: now_ns },
            tick: 0,
            digest: 0,
            phase: Phase::Done,
            end_of_run_is_sent: false,
            unsaid: VecDeque::new(),
        }
    }

    /// The slots, in roster order.
    #[must_use]
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Places of those who are lost: a participant among them is told so by the
    /// next frame, should it still be there.
    pub(crate) fn lost(&self) -> impl Iterator<Item = usize> {
        self.slots.iter().enumerate().filter(|(_, s)| s.loss().is_some()).map(|(i, _)| i)
    }

    /// Slots of the participants that have joined, the lost included: each of
    /// them believes only a frame that is signed for it.
    pub(crate) fn joined(&self) -> impl Iterator<Item = usize> {
        self.slots.iter().enumerate().filter(|(_, s)| s.pid != 0).map(|(slot, _)| slot)
    }

    /// Whether the end of the run was published.
    pub(crate) fn has_ended(&self) -> bool {
        self.end_of_run_is_sent
    }

    /// How the run ends or ended.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Ticks that are closed.
    pub(crate) fn ticks_done(&self) -> u64 {
        self.tick
    }

    /// Whether all are still being waited for to join.
    pub(crate) fn is_gathering(&self) -> bool {
        matches!(self.state, State::Gathering { .. })
    }

    /// A process asks to join. Gives it its slot, and a ticket that its answers
    /// must carry.
    ///
    /// # Errors
    /// [`Refusal`], to be sent back.
    pub fn join(&mut self, request: &JoinRequest, ticket: u32) -> Result<usize, Refusal> {
        if request.protocol != PROTOCOL_VERSION {
            return Err(Refusal::Protocol { client: request.protocol, server: PROTOCOL_VERSION });
        }
        if request.layout != layout_hash() {
            return Err(Refusal::Layout { client: request.layout, server: layout_hash() });
        }
        if matches!(self.state, State::Ending { .. } | State::Finished) {
            return Err(Refusal::Ended);
        }
        let name = request.name.clone();
        let Some(slot) = self.slots.iter().position(|s| s.name == name) else {
            let roster = self.slots.iter().map(|s| s.name.clone()).collect();
            return Err(Refusal::Unknown { name, roster });
        };
        let published = self.published_ticks();
        let place = &mut self.slots[slot];
        match &place.state {
            ParticipantState::Absent => {}
            ParticipantState::Away { since_ns, called: true } => {
                let since_ns = *since_ns;
                place.catch_up =
                    Some(CatchingUp { ticks: published, next: 0, sent: None, since_ns });
                place.restarts += 1;
            }
            ParticipantState::Lost(loss) => {
                return Err(Refusal::Dropped { name, why: loss.kind.word().to_owned() });
            }
            // An observer may come, go and come again.
            ParticipantState::Left if !place.awaited => {}
            _ => return Err(Refusal::Taken { name, pid: place.pid }),
        }
        place.ticket = ticket;
        place.pid = request.pid;
        place.awake_ns = request.awake_ns;
        place.state = ParticipantState::Joined;
        Ok(slot)
    }

    /// The run is asked to stop.
    pub(crate) fn interrupt(&mut self) {
        self.end(Phase::Interrupted);
    }

    /// The server itself cannot go on.
    pub(crate) fn abort(&mut self) {
        self.end(Phase::Aborted);
    }

    fn end(&mut self, phase: Phase) {
        if !matches!(self.state, State::Ending { .. } | State::Finished) {
            self.phase = phase;
            self.state = State::Ending { since_ns: None };
        }
    }

    /// The frame of the current tick is out, with this digest.
    pub fn published(&mut self, digest: u64, now_ns: u64) {
        self.digest = digest;
        for slot in &mut self.slots {
            slot.reply = None;
            slot.slow_said = false;
        }
        self.state = match self.state {
            State::Ending { .. } => {
                self.end_of_run_is_sent = true;
                State::Ending { since_ns: Some(now_ns) }
            }
            _ => State::Awaiting { since_ns: now_ns },
        };
    }

    /// What to do next at `now_ns`. `describe` says what the kernel knows of a
    /// slot's process ("it is stopped by a signal"), for messages.
    pub fn next(&mut self, now_ns: u64, describe: impl Fn(usize) -> String) -> Step {
        if let Some(step) = self.unsaid.pop_front() {
            return self.said(step, now_ns);
        }
        if let Some(step) = self.next_catch_up(now_ns, &describe) {
            return step;
        }
        match self.state {
            State::Gathering { since_ns } => self.next_gathering(since_ns, now_ns, describe),
            State::Publishing => match self.back_by_ns() {
                Some(until_ns) => Step::Wait { until_ns },
                None => Step::Publish(self.tick),
            },
            State::Awaiting { since_ns } => self.next_awaiting(since_ns, now_ns, describe),
            State::Closing => {
                self.tick += 1;
                self.state = State::Publishing;
                let driver_is_done = |slot: &Slot| {
                    slot.role == Role::Driver && slot.reply.is_some() && slot.last.ends_run()
                };
                if self.tick == self.rules.ticks || self.slots.iter().any(driver_is_done) {
                    self.end(Phase::Done);
                }
                self.next(now_ns, describe)
            }
            State::Ending { since_ns: None } => Step::End(self.phase),
            State::Ending { since_ns: Some(since_ns) } => self.next_ending(since_ns, now_ns),
            State::Finished => Step::Finished,
        }
    }

    fn next_gathering(&mut self, since: u64, now: u64, describe: impl Fn(usize) -> String) -> Step {
        let missing = |s: &Slot| {
            s.awaited
                && s.catch_up.is_none()
                && matches!(s.state, ParticipantState::Absent | ParticipantState::Joined)
        };
        if !self.slots.iter().any(|s| missing(s) || s.is_coming_back()) {
            self.state = State::Publishing;
            return Step::Publish(self.tick);
        }
        let until_ns = since.saturating_add(self.rules.join_timeout_ns);
        if now < until_ns || !self.slots.iter().any(missing) {
            let until_ns = if now < until_ns { until_ns } else { u64::MAX };
            return Step::Wait { until_ns: until_ns.min(self.back_by_ns().unwrap_or(u64::MAX)) };
        }
        for slot in 0..self.slots.len() {
            if missing(&self.slots[slot]) {
                let what = match self.slots[slot].state {
                    ParticipantState::Absent => "it never asked to join",
                    _ => "it asked to join but never opened its ports",
                };
                self.lose(slot, LossKind::NeverAttached, format!("{what}{}", describe(slot)));
            }
        }
        self.next(now, describe)
    }

    fn next_awaiting(&mut self, since: u64, now: u64, describe: impl Fn(usize) -> String) -> Step {
        let open = |s: &Slot| s.awaited && s.is_up_to_date() && s.reply.is_none();
        let back_by_ns = self.back_by_ns();
        if !self.slots.iter().any(open) {
            if let Some(until_ns) = back_by_ns {
                return Step::Wait { until_ns };
            }
            self.state = State::Closing;
            return Step::Close(self.tick);
        }
        let wait = |for_ns: u64| {
            let until_ns = since.saturating_add(for_ns);
            Step::Wait { until_ns: until_ns.min(back_by_ns.unwrap_or(u64::MAX)) }
        };
        let waited_ns = now.saturating_sub(since);
        if waited_ns < self.rules.slow_after_ns {
            return wait(self.rules.slow_after_ns);
        }
        if waited_ns < self.rules.answer_timeout_ns {
            let wait = wait(self.rules.answer_timeout_ns);
            return self.slow(open, waited_ns).unwrap_or(wait);
        }
        for slot in 0..self.slots.len() {
            if open(&self.slots[slot]) {
                let seconds = self.rules.answer_timeout_ns as f64 * 1e-9;
                let tick = self.tick;
                let detail =
                    format!("no answer to tick {tick} within {seconds} s{}", describe(slot));
                self.lose(slot, LossKind::Stalled, detail);
            }
        }
        self.next(now, describe)
    }

    /// A notice about the first open slot that has had none in this wait.
    fn slow(&mut self, open: impl Fn(&Slot) -> bool, waited_ns: u64) -> Option<Step> {
        let slow = self.slots.iter_mut().enumerate().find(|(_, s)| open(s) && !s.slow_said);
        let (slot, place) = slow?;
        place.slow_said = true;
        place.slow += 1;
        Some(Step::Slow { slot, waited_ns })
    }

    fn next_ending(&mut self, since: u64, now: u64) -> Step {
        let open = |s: &Slot| s.awaited && s.is_present();
        if !self.slots.iter().any(open) {
            self.state = State::Finished;
            return Step::Finished;
        }
        let timeout_ns = match self.phase {
            Phase::Done => self.rules.leave_timeout_ns,
            _ => self.rules.leave_timeout_ns.min(self.rules.early_leave_timeout_ns),
        };
        let until_ns = since.saturating_add(timeout_ns);
        let waited_ns = now.saturating_sub(since);
        if waited_ns < timeout_ns {
            if waited_ns < self.rules.slow_after_ns {
                return Step::Wait { until_ns: since.saturating_add(self.rules.slow_after_ns) };
            }
            return self.slow(open, waited_ns).unwrap_or(Step::Wait { until_ns });
        }
        for slot in 0..self.slots.len() {
            if open(&self.slots[slot]) {
                let seconds = timeout_ns as f64 * 1e-9;
                let detail = format!("no leave message within {seconds:.1} s after the last frame");
                self.lose(slot, LossKind::Stalled, detail);
            }
        }
        self.next(now, |_| String::new())
    }

    /// Places of the answering slots, in roster order.
    pub(crate) fn answering(&self) -> &[usize] {
        &self.answering
    }

    /// The replies to the current tick: answering slots only, roster order.
    pub fn replies(&self) -> impl ExactSizeIterator<Item = (usize, Reply)> + Clone {
        self.answering.iter().map(|&i| (i, self.slots[i].reply.unwrap_or(Reply::Missing)))
    }
}

#[cfg(test)]
mod schedules;
#[cfg(test)]
mod tests;
