//! Answers: one by itself, and any sequence of them put to the lockstep.

use rusty_contract::answer::Message;
use rusty_contract::{Answer, JoinRequest, OnLoss, Participant, Phase, Reply, Role};
use rusty_engine::lockstep::{Lockstep, ParticipantState, Rules, Step};

const RUN: u64 = 77;
const TICKS: u64 = 4;
const ANSWER_BYTES: usize = size_of::<Answer>();
/// What to do with it, then the answer.
const OP_BYTES: usize = 1 + ANSWER_BYTES;
/// Those who keep to the protocol.
const HONEST: [u32; 2] = [0, 2];
/// Those who do not: an estimator and an observer.
const HOSTILE: [u32; 2] = [1, 3];

/// Rules with short times, so that a sequence reaches all of them.
pub fn rules(ticks: u64, on_loss: OnLoss) -> Rules {
    Rules {
        run_id: RUN,
        ticks,
        on_loss,
        join_timeout_ns: 1_000,
        answer_timeout_ns: 1_000,
        leave_timeout_ns: 5_000,
        early_leave_timeout_ns: 2_000,
        slow_after_ns: 100,
    }
}

/// An answer from these bytes, the missing ones zero.
fn pod(bytes: &[u8]) -> Answer {
    let mut all = [0; ANSWER_BYTES];
    let n = bytes.len().min(ANSWER_BYTES);
    all[..n].copy_from_slice(&bytes[..n]);
    bytemuck::pod_read_unaligned(&all)
}

/// One answer: what it means is made of numbers, and survives the wire.
pub fn answer(bytes: &[u8]) -> bool {
    let Ok(message) = pod(bytes).message() else { return false };
    if let Message::Reply(reply) = message {
        reply.check().expect("a reply is checked where it is read");
        assert!(reply.estimate().is_none_or(|e| e.pose_in_world.is_finite()));
    }
    let again = Answer::carrying(&message).message().expect("what was carried is read");
    match (message, again) {
        (Message::Reply(a), Message::Reply(b)) => assert!(a.same_bits(&b), "{a:?} {b:?}"),
        (a, b) => assert_eq!(a, b),
    }
    true
}

/// A run in which two keep to the protocol and two send what the bytes say.
struct Game {
    machine: Lockstep,
    now_ns: u64,
    closed: u64,
    digest: u64,
    ended: bool,
}

/// A sequence of answers to a run: it comes to its end, and those who kept to
/// the protocol are not lost, whatever the others send.
pub fn answers(bytes: &[u8]) -> bool {
    let mut game = Game::new();
    for op in bytes.chunks(OP_BYTES) {
        game.hostile(op);
        game.go_on();
    }
    // The last of it again and again, while time goes by.
    let last = bytes.chunks(OP_BYTES).next_back().unwrap_or_default();
    for _ in 0..2_000 {
        if game.machine.phase() != Phase::Done || matches!(game.go_on(), Step::Finished) {
            break;
        }
        game.hostile(last);
        game.now_ns = game.now_ns.saturating_add(20);
    }
    assert_eq!(game.go_on(), Step::Finished, "a flood keeps the run from ending");
    assert_eq!((game.closed, game.machine.phase()), (TICKS, Phase::Done));
    for slot in HONEST {
        let slot = &game.machine.slots()[slot as usize];
        assert_eq!(slot.state, ParticipantState::Left, "{} was no part of it", slot.name);
    }
    for slot in game.machine.slots() {
        let s = slot.summary();
        let figures = [s.compute_mean_us, s.latency_mean_us, s.latency_max_us];
        assert!(figures.iter().all(|x| x.is_finite()), "{figures:?}");
    }
    game.machine.slots()[1].loss().is_none()
}

impl Game {
    fn new() -> Self {
        let roster = [
            Participant::new("a", Role::Estimator),
            Participant::new("b", Role::Estimator),
            Participant::new("log", Role::Logger),
            Participant::new("eye", Role::Observer),
        ];
        let machine = Lockstep::new(rules(TICKS, OnLoss::Continue), &roster, 0);
        let mut game = Self { machine, now_ns: 1, closed: 0, digest: 0, ended: false };
        for name in ["a", "b", "log"] {
            let request = JoinRequest::new(name, 100, 0, "fuzz");
            game.machine.join(&request, 0).expect("a slot");
        }
        for slot in HONEST {
            game.say(slot, &Message::Ready);
        }
        game
    }

    fn say(&mut self, slot: u32, message: &Message) {
        let mut answer = Answer::carrying(message);
        answer.run_id = RUN;
        answer.participant = slot;
        answer.tick = self.closed;
        answer.digest_seen = self.digest;
        self.machine.answer(&answer, self.now_ns);
    }

    /// What a hostile participant does: bits of the first byte say how much of
    /// its answer is made to fit.
    fn hostile(&mut self, op: &[u8]) {
        let Some((&how, payload)) = op.split_first() else { return };
        let mut answer = pod(payload);
        let slot = HOSTILE[usize::from(how >> 4 & 1)];
        answer.participant = slot;
        match how >> 5 {
            0..=3 => {
                if how & 1 != 0 {
                    answer.run_id = RUN;
                }
                if how & 3 != 0 {
                    answer.ticket = 0;
                }
                if how & 2 != 0 {
                    answer.tick = self.closed;
                }
                if how & 4 != 0 {
                    answer.digest_seen = self.digest;
                }
                if how & 8 != 0 {
                    let kind = bytemuck::bytes_of(&answer)[44] % 8;
                    bytemuck::bytes_of_mut(&mut answer)[44..48].copy_from_slice(&[kind, 0, 0, 0]);
                }
                self.machine.answer(&answer, self.now_ns);
            }
            4 => self.now_ns = self.now_ns.saturating_add(answer.tick % 3_000),
            5 => self.machine.died(slot as usize, "it ended"),
            _ => {
                let name = self.machine.slots()[slot as usize].name.clone();
                let request =
                    JoinRequest::new(&name, answer.compute_ns as u32, answer.sent_ns, "fuzz");
                let _ = self.machine.join(&request, 0);
            }
        }
    }

    /// Does what the machine says until it waits or has finished.
    fn go_on(&mut self) -> Step {
        for _ in 0..100 {
            match self.machine.next(self.now_ns, |_| String::new()) {
                Step::Publish(tick) => {
                    assert_eq!(tick, self.closed, "ticks come in order");
                    self.digest = tick.wrapping_mul(31) + 5;
                    self.machine.published(self.digest, self.now_ns);
                    for slot in HONEST {
                        self.say(slot, &Message::Reply(Reply::Taken));
                    }
                }
                Step::Close(tick) => {
                    assert_eq!(tick, self.closed);
                    for (_, reply) in self.machine.replies() {
                        reply.check().expect("only checked replies are closed over");
                    }
                    self.closed += 1;
                }
                Step::End(phase) => {
                    self.machine.published(0, self.now_ns);
                    assert_eq!(phase, Phase::Done);
                    if !std::mem::replace(&mut self.ended, true) {
                        for slot in HONEST {
                            self.say(slot, &Message::Leave);
                        }
                    }
                }
                Step::Slow { .. } | Step::Lost(_) => {}
                Step::Restart(_) | Step::Feed { .. } | Step::Echo { .. } => {
                    panic!("nobody comes back where the rules do not say so");
                }
                step @ (Step::Wait { .. } | Step::Finished) => return step,
            }
        }
        panic!("the machine never waits");
    }
}
