//! Frames that are not what they should be.

use rusty_contract::{Frame, TruthKey};
use rusty_geometry::{EncoderCounts, SE2};

/// A frame of the same tick of another run, in which the wheels have turned
/// much further.
pub(super) fn foreign(frame: &Frame, key: &TruthKey) -> Box<Frame> {
    let mut other = Box::new(*frame);
    let EncoderCounts { left, right } = frame.encoders();
    let ticks = EncoderCounts { left: left + 5000, right: right + 3000 };
    other.begin(frame.tick(), frame.time_s(), ticks, frame.command());
    other.run_id ^= 1;
    other.seal(key, Some(SE2::identity()));
    other
}

/// A frame with another first range than its digest was made for; without a
/// scan, with another word on whether its truth is known.
pub(super) fn damaged(frame: &Frame) -> Box<Frame> {
    let mut damaged = Box::new(*frame);
    match frame.ranges_m().map(<[f64]>::len) {
        Some(beams) if beams > 0 => damaged.write_scan(beams)[0] += 1.0,
        _ => damaged.set_truth_known(!frame.truth_known()),
    }
    damaged
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::Twist;

    #[test]
    fn a_foreign_frame_is_sound_and_a_damaged_one_is_not() {
        let key = TruthKey::from_bytes([5; 32]);
        let mut frame = Frame::boxed();
        frame.begin(3, 0.08, EncoderCounts { left: 1, right: 2 }, Twist::default());
        frame.seal(&key, Some(SE2::identity()));
        let other = foreign(&frame, &key);
        assert_eq!(other.observable_digest(), other.digest());
        assert!(other.digest() != frame.digest() && other.run_id != frame.run_id);
        let bare = damaged(&frame);
        assert!(bare.digest() == frame.digest() && bare.observable_digest() != bare.digest());
        frame.write_scan(4);
        frame.seal(&key, Some(SE2::identity()));
        let scan = damaged(&frame);
        assert!(scan.digest() == frame.digest() && scan.observable_digest() != scan.digest());
    }
}
