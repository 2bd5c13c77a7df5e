//! `Answer`: what a participant says to a frame. The answer is the acknowledgement.
//!
//! | offset | size | field         | type     | meaning                                            |
//! |-------:|-----:|---------------|----------|----------------------------------------------------|
//! |      0 |    8 | `run_id`      | u64      | the run of the frame                               |
//! |      8 |    8 | `tick`        | u64      | the tick of the frame                              |
//! |     16 |    8 | `digest_seen` | u64      | the digest of the frame as it was read             |
//! |     24 |    8 | `sent_ns`     | u64      | monotonic clock at send: a hint for waiting        |
//! |     32 |    8 | `compute_ns`  | u64      | time between frame and answer, as reported         |
//! |     40 |    4 | `participant` | u32      | slot in the roster                                 |
//! |     44 |    4 | `kind`        | u32      | 0 abstain, 1 taken, 2 estimate, 3 command, 4 both, 5 leave message, 6 failed, 7 ready |
//! |     48 |    4 | `flags`       | u32      | bit 0: a covariance is present; bit 1: an innovation is; bit 2: last tick |
//! |     52 |    4 | `ticket`      | u32      | the ticket of the sender's `Start`                 |
//! |     56 |   24 | `pose`        | `[f64; 3]` | estimate: x m, y m, theta rad in the world frame   |
//! |     80 |    8 | `v_m_s`       | f64      | command for the next tick, body frame              |
//! |     88 |    8 | `omega_rad_s` | f64      | command for the next tick, body frame              |
//! |     96 |    8 | `nis`         | f64      | normalised innovation squared of this tick         |
//! |    104 |    4 | `nis_degrees` | u32      | its degrees of freedom                             |
//! |    108 |    4 | `reserved`    | u32      | zero                                               |
//! |    112 |   72 | `covariance`  | `[f64; 9]` | row-major, of the error τ (m, m, rad) with truth = estimate ⊞ τ |
//! |    184 |    8 | `tag`         | u64      | SipHash-2-4 of the bytes before it that mean something, with the participant's key |
//!
//! The tag covers bytes 0 to 80, 96, 112 or 184: up to the last field that the
//! answer's kind and flags say is present. What lies behind is not read.
//!
//! An `Answer` is what travels; a [`Reply`] is what it means. Whatever arrives
//! from another process becomes a `Reply` only through [`Answer::message`],
//! which refuses numbers that are not numbers.

use bytemuck::{Pod, Zeroable};
use rusty_geometry::{SE2, Twist};

use crate::auth::AuthKey;
use crate::field_table::{Field, field_table};
use crate::reply::{AnswerError, Estimate, Innovation, Reply};

/// Bit of `flags`: a covariance is present.
const COVARIANCE_GIVEN: u32 = 1;
/// Bit of `flags`: an innovation is present.
const INNOVATION_GIVEN: u32 = 2;
/// Bit of `flags`: the driver is done, and this tick is to be the last.
const LAST_TICK: u32 = 4;

/// What travels. See the module for the layout.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Answer {
    /// The run of the frame that is answered.
    pub run_id: u64,
    /// The tick of the frame that is answered.
    pub tick: u64,
    /// The digest of the frame as it was read.
    pub digest_seen: u64,
    /// Monotonic clock at send, ns: a hint for waiting.
    pub sent_ns: u64,
    /// Time between frame and answer, ns, as reported.
    pub compute_ns: u64,
    /// Place in the roster.
    pub participant: u32,
    kind: u32,
    flags: u32,
    /// The ticket that the sender was given when it joined. An answer with
    /// another one comes from a process that does not have the slot (any more).
    pub ticket: u32,
    pose: [f64; 3],
    v_m_s: f64,
    omega_rad_s: f64,
    nis: f64,
    nis_degrees: u32,
    reserved: u32,
    covariance: [f64; 9],
    tag: u64,
}

field_table! {
    /// The layout of [`Answer`], field by field.
    pub const ANSWER_FIELDS for Answer, size 192 {
        run_id: "u64" at 0, 8;
        tick: "u64" at 8, 8;
        digest_seen: "u64" at 16, 8;
        sent_ns: "u64" at 24, 8;
        compute_ns: "u64" at 32, 8;
        participant: "u32" at 40, 4;
        kind: "u32" at 44, 4;
        flags: "u32" at 48, 4;
        ticket: "u32" at 52, 4;
        pose: "[f64; 3]" at 56, 24;
        v_m_s: "f64" at 80, 8;
        omega_rad_s: "f64" at 88, 8;
        nis: "f64" at 96, 8;
        nis_degrees: "u32" at 104, 4;
        reserved: "u32" at 108, 4;
        covariance: "[f64; 9]" at 112, 72;
        tag: "u64" at 184, 8;
    }
}

/// What a participant may say at all: a reply, or that it comes or leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// An answer to a tick.
    Reply(Reply),
    /// The participant has finished its work after the last frame.
    Leave,
    /// The participant gave up by itself (it panicked, or could not write).
    Failed,
    /// The participant's ports are open: frames will reach it from now on.
    Ready,
}

impl Answer {
    /// An answer that carries `message`. Ids, tick, digest and clocks are the
    /// sender's to fill in.
    #[must_use]
    pub fn carrying(message: &Message) -> Self {
        let mut answer = Self::default();
        answer.kind = match message {
            Message::Reply(reply) => {
                answer.put(reply);
                match reply {
                    Reply::Missing | Reply::Abstain => 0,
                    Reply::Taken => 1,
                    Reply::Estimate(_) => 2,
                    Reply::Command(_) => 3,
                    Reply::Both(..) => 4,
                }
            }
            Message::Leave => 5,
            Message::Failed => 6,
            Message::Ready => 7,
        };
        answer
    }

    /// Asks for this tick to be the last one. Counts where the sender is the driver.
    pub fn end_run(&mut self) {
        self.flags |= LAST_TICK;
    }

    /// Whether the sender asks for this tick to be the last one.
    #[must_use]
    pub fn ends_run(&self) -> bool {
        self.flags & LAST_TICK != 0
    }

    /// Signs the answer with the sender's key. Nothing may be changed after it.
    pub fn sign(&mut self, key: &AuthKey) {
        self.tag = key.tag(self.signed());
    }

    /// Whether the answer was signed with this key, as it is.
    #[must_use]
    pub fn is_signed_by(&self, key: &AuthKey) -> bool {
        self.tag == key.tag(self.signed())
    }

    /// The bytes that the tag covers: all that [`message`](Self::message) reads.
    fn signed(&self) -> &[u8] {
        let to = if self.flags & COVARIANCE_GIVEN != 0 {
            std::mem::offset_of!(Self, tag)
        } else if self.flags & INNOVATION_GIVEN != 0 {
            std::mem::offset_of!(Self, covariance)
        } else if matches!(self.kind, 3 | 4) {
            std::mem::offset_of!(Self, nis)
        } else {
            std::mem::offset_of!(Self, v_m_s)
        };
        &bytemuck::bytes_of(self)[..to]
    }

    fn put(&mut self, reply: &Reply) {
        if let Some(e) = reply.estimate() {
            let p = e.pose_in_world;
            self.pose = [p.x(), p.y(), p.theta()];
            if let Some(covariance) = e.covariance {
                self.flags |= COVARIANCE_GIVEN;
                self.covariance = covariance;
            }
            if let Some(innovation) = e.innovation {
                self.flags |= INNOVATION_GIVEN;
                self.nis = innovation.nis;
                self.nis_degrees = innovation.degrees;
            }
        }
        if let Some(c) = reply.command() {
            self.v_m_s = c.v_m_s;
            self.omega_rad_s = c.omega_rad_s;
        }
    }

    /// What the answer means, checked.
    ///
    /// # Errors
    /// [`AnswerError`] names the invalid number, or the invalid
    /// kind.
    pub fn message(&self) -> Result<Message, AnswerError> {
        let [x, y, theta] = self.pose;
        let estimate = Estimate {
            pose_in_world: SE2::new(x, y, theta),
            covariance: (self.flags & COVARIANCE_GIVEN != 0).then_some(self.covariance),
            innovation: (self.flags & INNOVATION_GIVEN != 0)
                .then_some(Innovation { nis: self.nis, degrees: self.nis_degrees }),
        };
        let command = Twist { v_m_s: self.v_m_s, omega_rad_s: self.omega_rad_s };
        let reply = match self.kind {
            0 => Reply::Abstain,
            1 => Reply::Taken,
            2 => Reply::Estimate(estimate),
            3 => Reply::Command(command),
            4 => Reply::Both(estimate, command),
            5 => return Ok(Message::Leave),
            6 => return Ok(Message::Failed),
            7 => return Ok(Message::Ready),
            kind => return Err(AnswerError::UnknownKind(kind)),
        };
        reply.check()?;
        Ok(Message::Reply(reply))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate() -> Estimate {
        Estimate {
            pose_in_world: SE2::new(1.0, -2.0, 0.5),
            covariance: Some([1.0, 0.1, 0.0, 0.1, 2.0, 0.0, 0.0, 0.0, 3.0]),
            innovation: None,
        }
    }

    #[test]
    fn every_message_survives_the_wire() {
        let twist = Twist { v_m_s: 0.5, omega_rad_s: -1.0 };
        for message in [
            Message::Reply(Reply::Abstain),
            Message::Reply(Reply::Taken),
            Message::Reply(Reply::Estimate(estimate())),
            Message::Reply(Reply::Estimate(SE2::new(1.0, 2.0, 3.0).into())),
            Message::Reply(Reply::Command(twist)),
            Message::Reply(Reply::Both(estimate(), twist)),
            Message::Reply(Reply::Both(estimate().with_innovation(7.5, 3), twist)),
            Message::Leave,
            Message::Failed,
            Message::Ready,
        ] {
            assert_eq!(Answer::carrying(&message).message(), Ok(message));
        }
    }

    #[test]
    fn numbers_that_are_none_are_named() {
        let mut bad = estimate();
        bad.pose_in_world = SE2::new(0.0, f64::NAN, 0.0);
        let error = Answer::carrying(&Message::Reply(Reply::Estimate(bad))).message().unwrap_err();
        assert!(error.to_string().starts_with("estimate y_m is NaN"), "{error}");

        let mut bad = estimate();
        bad.covariance = Some([1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0]);
        let error = Answer::carrying(&Message::Reply(Reply::Estimate(bad))).message().unwrap_err();
        assert!(error.to_string().starts_with("covariance[1][1] is -1"), "{error}");

        let twist = Twist { v_m_s: f64::INFINITY, omega_rad_s: 0.0 };
        let error = Answer::carrying(&Message::Reply(Reply::Command(twist))).message().unwrap_err();
        assert!(error.to_string().contains("command v_m_s is inf"), "{error}");
    }

    #[test]
    fn a_signature_holds_for_every_byte_that_is_read() {
        let (key, other) = (AuthKey::from_bytes([1; 16]), AuthKey::from_bytes([2; 16]));
        let twist = Twist { v_m_s: 0.5, omega_rad_s: -1.0 };
        let plain = Estimate { covariance: None, ..estimate() };
        for message in [
            Message::Reply(Reply::Abstain),
            Message::Reply(Reply::Estimate(plain)),
            Message::Reply(Reply::Estimate(plain.with_innovation(7.5, 3))),
            Message::Reply(Reply::Command(twist)),
            Message::Reply(Reply::Both(plain, twist)),
            Message::Reply(Reply::Both(estimate().with_innovation(7.5, 3), twist)),
            Message::Leave,
        ] {
            let mut answer = Answer::carrying(&message);
            answer.tick = 5;
            answer.sign(&key);
            assert!(answer.is_signed_by(&key) && !answer.is_signed_by(&other));
            for byte in 0..size_of::<Answer>() {
                let mut changed = answer;
                bytemuck::bytes_of_mut(&mut changed)[byte] ^= 1;
                let is_read = byte < 56 || changed.message() != answer.message() || byte >= 184;
                assert!(!(is_read && changed.is_signed_by(&key)), "{message:?}, byte {byte}");
            }
        }
    }

    #[test]
    fn the_end_of_a_run_changes_no_reply() {
        let message = Message::Reply(Reply::Command(Twist::default()));
        let mut answer = Answer::carrying(&message);
        assert!(!answer.ends_run());
        answer.end_run();
        assert!(answer.ends_run());
        assert_eq!(answer.message(), Ok(message));
    }

    #[test]
    fn any_bytes_are_an_answer_or_an_error() {
        for fill in 0..=255u8 {
            let answer: Answer = bytemuck::pod_read_unaligned(&[fill; 192]);
            let _ = answer.message();
        }
    }
}
