//! The digest of what could be seen, also of a log whose truth is sealed.

use xxhash_rust::xxh3::{Xxh3, xxh3_128};

use super::hex;
use crate::frame::Frame;

/// A chain of XXH3-128 over the observable bytes of frames, tick by tick: the
/// previous value (16 bytes, little-endian), then the frame's
/// [observable part](crate::frame), in which the flag that a truth is known
/// counts as 0. So a log and what [sealing](crate::blind) makes of it have the
/// same observable digest, and so has every log of a replay of either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObservableDigest(u128);

impl Default for ObservableDigest {
    fn default() -> Self {
        Self(xxh3_128(b"rusty observable digest 1"))
    }
}

impl ObservableDigest {
    /// Absorbs the frame of the next tick.
    pub fn absorb(&mut self, frame: &Frame) {
        let (front, ranges) = frame.observable_without_truth();
        let mut state = Xxh3::new();
        state.update(&self.0.to_le_bytes());
        state.update(&front);
        state.update(ranges);
        self.0 = state.digest128();
    }

    /// The digest up to here.
    #[must_use]
    pub fn value(&self) -> [u8; 16] {
        self.0.to_be_bytes()
    }

    /// The digest up to here as 32 hexadecimal digits.
    #[must_use]
    pub fn hex(&self) -> String {
        hex(&self.value())
    }
}

/// The observable part of one frame, hashed by itself (XXH3-64); the flag that
/// a truth is known counts as 0.
#[must_use]
pub fn observable_of(frame: &Frame) -> u64 {
    let (front, ranges) = frame.observable_without_truth();
    let mut state = Xxh3::new();
    state.update(&front);
    state.update(ranges);
    state.digest()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::TruthKey;
    use rusty_geometry::{EncoderCounts, SE2, Twist};

    fn frame(tick: u64, range_m: f64, truth: Option<SE2>) -> Box<Frame> {
        let mut frame = Frame::boxed();
        frame.begin(tick, 0.02, EncoderCounts { left: 1, right: 2 }, Twist::default());
        frame.write_scan(2).copy_from_slice(&[1.0, range_m]);
        frame.seal(&TruthKey::from_bytes([7; 32]), truth);
        frame
    }

    fn digest(frames: &[Box<Frame>]) -> ObservableDigest {
        let mut digest = ObservableDigest::default();
        frames.iter().for_each(|f| digest.absorb(f));
        digest
    }

    #[test]
    fn it_receives_frames_and_their_order_but_no_truth() {
        let truth = Some(SE2::new(1.0, 2.0, 3.0));
        let base = digest(&[frame(0, 2.0, truth), frame(1, 3.0, truth)]);
        assert_eq!(base, digest(&[frame(0, 2.0, None), frame(1, 3.0, None)]));
        assert_eq!(observable_of(&frame(0, 2.0, truth)), observable_of(&frame(0, 2.0, None)));
        let nearly = f64::from_bits(3.0f64.to_bits() ^ 1);
        for other in [
            [frame(0, 2.0, truth), frame(1, nearly, truth)],
            [frame(1, 3.0, truth), frame(0, 2.0, truth)],
            [frame(0, 2.0, truth), frame(2, 3.0, truth)],
        ] {
            assert_ne!(base, digest(&other));
        }
        assert_ne!(base, digest(&[frame(0, 2.0, truth)]));
        assert_ne!(observable_of(&frame(1, 3.0, None)), observable_of(&frame(1, nearly, None)));
    }
}
