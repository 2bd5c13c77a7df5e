//! The bits a run is known by.
//!
//! Two chains of XXH3-128 run in parallel. For every tick, in order,
//! each absorbs little-endian bytes:
//!
//! * *world*: previous value (16), tick (8), digest of the frame's observable
//!   part (8), 1 and the true pose x, y, θ (24) or a single 0 where none is known;
//! * *run*: previous value (16), the world value of this tick (16), the number
//!   of answering participants (4), and in roster order every reply: its kind
//!   (1), then pose (24), one byte (1: with covariance, 2: with innovation, 3:
//!   both), covariance (72), innovation (8, 4), command (16), as far as there
//!   are any.
//!
//! The start values are the hashes of two fixed texts. Time, process ids,
//! compute times and the acknowledgements of scorers and loggers are never
//! absorbed: switching the logger off changes no digest.
//!
//! A third, the [`ObservableDigest`], knows frames by what can be seen of them,
//! with or without their truth.

mod observable;

pub use crate::hex::hex;
pub use observable::{ObservableDigest, observable_of};

use rusty_geometry::SE2;
use xxhash_rust::xxh3::xxh3_128;

use crate::frame::Frame;
use crate::reply::{Estimate, Reply};
use crate::tally::MAX_PARTICIPANTS;

/// Longest encoding of one reply: kind, estimate with covariance and innovation,
/// command.
const REPLY_BYTES: usize = 1 + 24 + 1 + 72 + 12 + 16;

/// Replies that fit into the short buffer.
const FEW: usize = 3;

/// The two chains of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunDigest {
    world: u128,
    run: u128,
}

impl Default for RunDigest {
    fn default() -> Self {
        Self { world: xxh3_128(b"rusty world digest 1"), run: xxh3_128(b"rusty run digest 1") }
    }
}

/// A buffer on the stack; a tick allocates nothing.
struct Bytes<const N: usize> {
    buffer: [u8; N],
    used: usize,
}

impl<const N: usize> Bytes<N> {
    fn new() -> Self {
        Self { buffer: [0; N], used: 0 }
    }

    fn put(&mut self, bytes: &[u8]) {
        self.buffer[self.used..self.used + bytes.len()].copy_from_slice(bytes);
        self.used += bytes.len();
    }

    fn put_f64(&mut self, values: &[f64]) {
        for value in values {
            self.put(&value.to_bits().to_le_bytes());
        }
    }

    fn put_estimate(&mut self, estimate: &Estimate) {
        let p = estimate.pose_in_world;
        self.put_f64(&[p.x(), p.y(), p.theta()]);
        let Estimate { covariance, innovation, .. } = estimate;
        self.put(&[u8::from(covariance.is_some()) + 2 * u8::from(innovation.is_some())]);
        if let Some(covariance) = covariance {
            self.put_f64(covariance);
        }
        if let Some(innovation) = innovation {
            self.put_f64(&[innovation.nis]);
            self.put(&innovation.degrees.to_le_bytes());
        }
    }

    fn put_reply(&mut self, reply: &Reply) {
        let kind = match reply {
            Reply::Missing => 0,
            Reply::Abstain => 1,
            Reply::Taken => 2,
            Reply::Estimate(_) => 3,
            Reply::Command(_) => 4,
            Reply::Both(..) => 5,
        };
        self.put(&[kind]);
        if let Some(estimate) = reply.estimate() {
            self.put_estimate(estimate);
        }
        if let Some(command) = reply.command() {
            self.put_f64(&[command.v_m_s, command.omega_rad_s]);
        }
    }

    fn hash(&self) -> u128 {
        xxh3_128(&self.buffer[..self.used])
    }
}

impl RunDigest {
    /// Absorbs a frame and its truth: the first half of a tick.
    pub fn absorb_frame(&mut self, frame: &Frame, pose_in_world: Option<SE2>) {
        let mut bytes = Bytes::<64>::new();
        bytes.put(&self.world.to_le_bytes());
        bytes.put(&frame.tick().to_le_bytes());
        bytes.put(&frame.digest().to_le_bytes());
        match pose_in_world {
            None => bytes.put(&[0]),
            Some(p) => {
                bytes.put(&[1]);
                bytes.put_f64(&[p.x(), p.y(), p.theta()]);
            }
        }
        self.world = bytes.hash();
    }

    /// Absorbs the replies to the frame just absorbed, in roster order.
    pub fn absorb_replies(&mut self, replies: impl ExactSizeIterator<Item = Reply>) {
        // Most runs have few who answer: a short buffer is soon emptied.
        if replies.len() <= FEW {
            self.absorb_within::<{ 36 + FEW * REPLY_BYTES }>(replies);
        } else {
            self.absorb_within::<{ 36 + MAX_PARTICIPANTS * REPLY_BYTES }>(replies);
        }
    }

    /// With a buffer of `N` bytes, which must be enough for these replies.
    fn absorb_within<const N: usize>(&mut self, replies: impl ExactSizeIterator<Item = Reply>) {
        let mut bytes = Bytes::<N>::new();
        bytes.put(&self.run.to_le_bytes());
        bytes.put(&self.world.to_le_bytes());
        bytes.put(&(replies.len() as u32).to_le_bytes());
        for reply in replies.take(MAX_PARTICIPANTS) {
            bytes.put_reply(&reply);
        }
        self.run = bytes.hash();
    }

    /// The digest of frames and replies.
    #[must_use]
    pub fn run(&self) -> [u8; 16] {
        self.run.to_be_bytes()
    }

    /// The digest of frames and truths alone: equal for all rosters.
    #[must_use]
    pub fn world(&self) -> [u8; 16] {
        self.world.to_be_bytes()
    }

    /// The run digest as 32 hexadecimal digits.
    #[must_use]
    pub fn run_hex(&self) -> String {
        hex(&self.run())
    }

    /// The world digest as 32 hexadecimal digits.
    #[must_use]
    pub fn world_hex(&self) -> String {
        hex(&self.world())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::TruthKey;
    use rusty_geometry::{EncoderCounts, Twist};

    fn digest_of(poses: &[SE2], replies: &[Reply]) -> RunDigest {
        let mut digest = RunDigest::default();
        let mut frame = Frame::boxed();
        for (tick, pose) in poses.iter().enumerate() {
            frame.begin(tick as u64, 0.0, EncoderCounts::default(), Twist::default());
            frame.seal(&TruthKey::from_bytes([0; 32]), Some(*pose));
            digest.absorb_frame(&frame, Some(*pose));
            digest.absorb_replies(replies.iter().copied());
        }
        digest
    }

    #[test]
    fn every_bit_of_truth_and_reply_counts() {
        let pose = SE2::new(1.0, 2.0, 3.0);
        let nearly = SE2::new(f64::from_bits(1.0f64.to_bits() + 1), 2.0, 3.0);
        let base = digest_of(&[pose], &[Reply::Abstain]);
        assert_ne!(base.run(), digest_of(&[nearly], &[Reply::Abstain]).run());
        assert_ne!(base.run(), digest_of(&[pose], &[Reply::Missing]).run());
        assert_ne!(base.run(), digest_of(&[pose], &[]).run());
        let estimate = |p: SE2| [Reply::Estimate(p.into())];
        assert_ne!(digest_of(&[pose], &estimate(pose)), digest_of(&[pose], &estimate(nearly)));
        let innovated = |nis, degrees| [Estimate::new(pose).with_innovation(nis, degrees).into()];
        let few = digest_of(&[pose], &innovated(1.0, 2));
        assert_ne!(few, digest_of(&[pose], &estimate(pose)));
        assert_ne!(few, digest_of(&[pose], &innovated(1.0, 3)));
        assert_ne!(few, digest_of(&[pose], &innovated(1.5, 2)));
    }

    #[test]
    fn a_short_buffer_gives_the_digest_of_a_long_one() {
        let estimate = Estimate::new(SE2::new(1.0, 2.0, 3.0))
            .with_covariance([0.5; 9])
            .with_innovation(2.0, 4);
        let command = Twist { v_m_s: 0.5, omega_rad_s: -0.25 };
        // As many as fit, each as long as it can be.
        let longest = [Reply::Both(estimate, command); FEW];
        let mut long = RunDigest::default();
        long.absorb_within::<{ 36 + MAX_PARTICIPANTS * REPLY_BYTES }>(longest.into_iter());
        let mut short = RunDigest::default();
        short.absorb_replies(longest.into_iter());
        assert_eq!(short, long);
        assert_ne!(short, RunDigest::default());
    }

    #[test]
    fn the_world_digest_does_not_hear_replies() {
        let pose = SE2::new(1.0, 2.0, 3.0);
        let a = digest_of(&[pose, pose], &[Reply::Abstain]);
        let b = digest_of(&[pose, pose], &[]);
        assert_eq!(a.world(), b.world());
        assert_ne!(a.run(), b.run());
    }

    #[test]
    fn sixteen_full_replies_fit() {
        let reply = Reply::Both(
            Estimate::new(SE2::identity()).with_covariance([1.0; 9]).with_innovation(1.0, 1),
            Twist::default(),
        );
        let _ = digest_of(&[SE2::identity()], &[reply; MAX_PARTICIPANTS]);
    }
}
