//! What a frame shows, hides and covers.

use super::*;

fn sample() -> Box<Frame> {
    let mut frame = Frame::boxed();
    frame.begin(
        7,
        0.16,
        EncoderCounts { left: -3, right: 1 << 40 },
        Twist { v_m_s: 0.5, omega_rad_s: -0.25 },
    );
    frame.write_scan(3).copy_from_slice(&[1.0, 2.0, 8.0]);
    frame
}

#[test]
fn the_digest_covers_what_can_be_seen_and_nothing_else() {
    let key = TruthKey::from_bytes([3; 32]);
    let mut frame = sample();
    frame.seal(&key, Some(SE2::new(1.0, 2.0, 3.0)));
    let digest = frame.digest();
    frame.run_id = 99;
    frame.published_ns = 99;
    frame.numbers[3] = 5.0;
    assert_eq!(frame.observable_digest(), digest);
    frame.numbers[2] = f64::from_bits(frame.numbers[2].to_bits() ^ 1);
    assert_ne!(frame.observable_digest(), digest);
}

#[test]
fn who_is_lost_can_be_read_and_is_no_data() {
    let mut frame = sample();
    frame.seal(&TruthKey::from_bytes([3; 32]), None);
    let digest = frame.digest();
    frame.set_lost([0, 15, 31, 32, usize::MAX].into_iter());
    assert_eq!(frame.observable_digest(), digest);
    let lost: Vec<u32> = (0..100).filter(|place| frame.has_lost(*place)).collect();
    assert_eq!(lost, [0, 15, 31]);
    frame.end(Phase::Done, 8);
    assert!(!frame.has_lost(0));
}

#[test]
fn a_signature_is_for_one_slot_and_holds_for_run_tick_phase_losses_and_digest() {
    let (key, other) = (AuthKey::from_bytes([1; 16]), AuthKey::from_bytes([2; 16]));
    let mut frame = sample();
    frame.run_id = 5;
    frame.write_digest(false);
    let digest = frame.digest();
    frame.sign(3, &key);
    assert!(frame.is_signed_for(3, &key) && !frame.is_signed_for(3, &other));
    assert!(!frame.is_signed_for(2, &key) && !frame.is_signed_for(99, &key));
    frame.published_ns = 99;
    assert!(frame.is_signed_for(3, &key) && frame.observable_digest() == digest);
    let changes: [fn(&mut Frame); 5] = [
        |f| f.run_id ^= 1,
        |f| f.tick ^= 1,
        |f| f.phase = Phase::Done as u32,
        |f| f.set_lost(std::iter::once(0)),
        |f| f.digest ^= 1,
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut changed = frame.clone();
        change(&mut changed);
        assert!(!changed.is_signed_for(3, &key), "change {i}");
    }
}

#[test]
fn two_keys_give_the_same_digest() {
    let (mut a, mut b) = (sample(), sample());
    a.seal(&TruthKey::from_bytes([1; 32]), Some(SE2::identity()));
    b.seal(&TruthKey::from_bytes([2; 32]), Some(SE2::new(4.0, 5.0, 0.1)));
    assert_eq!(a.digest(), b.digest());
    assert_ne!(bytemuck::bytes_of(&a.sealed), bytemuck::bytes_of(&b.sealed));
}

#[test]
fn the_truth_opens_with_its_key_only() {
    let key = TruthKey::from_bytes([9; 32]);
    let mut frame = sample();
    let pose = SE2::new(4.25, -1.5, 0.75);
    frame.seal(&key, Some(pose));
    let truth = frame.open_truth(&key).unwrap().unwrap();
    assert_eq!(truth.pose_in_world(), pose);
    assert!(frame.open_truth(&TruthKey::from_bytes([8; 32])).is_err());
    let bytes = bytemuck::bytes_of(&*frame);
    for value in [4.25f64, -1.5, 0.75] {
        assert!(!bytes.windows(8).any(|w| w == value.to_le_bytes()));
    }
}

#[test]
fn a_frame_without_truth_says_so() {
    let key = TruthKey::from_bytes([9; 32]);
    let mut frame = sample();
    frame.seal(&key, None);
    assert!(frame.open_truth(&key).unwrap().is_none());
}

#[test]
fn beams_out_of_range_are_never_read() {
    let mut frame = sample();
    frame.beams = u16::MAX;
    assert_eq!(frame.ranges_m().map(<[f64]>::len), Some(MAX_BEAMS));
    (frame.sonars, frame.doors, frame.landmarks) = (u8::MAX, u8::MAX, u8::MAX);
    frame.flags = u16::MAX;
    assert_eq!(frame.observable().len(), size_of::<Frame>() - OBSERVABLE_FROM);
    assert_eq!(frame.readings().landmarks().map(<[_]>::len), Some(64));
}

#[test]
fn readings_lie_before_the_scan_and_are_covered_by_the_digest() {
    let mut frame = Frame::boxed();
    frame.begin(0, 0.02, EncoderCounts::default(), Twist::default());
    let plain = frame.observable().len();
    frame.write_bumper(3);
    frame.write_imu(crate::ImuReading { yaw_rate_rad_s: 0.5, ..Default::default() });
    frame.write_sonars(&[1.0, 2.0]);
    frame.write_doors(&[7.0]);
    frame.write_landmarks(&[crate::LandmarkReading::new(Some(9), 3.0, 0.1)]);
    frame.write_scan(2).copy_from_slice(&[4.0, 5.0]);
    frame.write_digest(true);
    assert_eq!(frame.observable().len(), plain + 8 * (1 + 3 + 2 + 1 + 3 + 2));
    assert_eq!(frame.ranges_m(), Some(&[4.0, 5.0][..]));
    let readings = frame.readings();
    assert_eq!((readings.bumper(), readings.doors()), (Some(3), Some(&[7.0][..])));
    assert_eq!(readings.landmarks().unwrap()[0].id(), Some(9));
    for place in 0..12 {
        let mut changed = frame.clone();
        changed.numbers[place] += 1.0;
        assert_ne!(changed.observable_digest(), frame.digest(), "number {place}");
    }
    // What a log keeps of them writes the same frame.
    let mut again = Frame::boxed();
    again.begin(0, 0.02, EncoderCounts::default(), Twist::default());
    again.write_readings(readings.present(), readings.numbers());
    again.write_scan(2).copy_from_slice(&[4.0, 5.0]);
    again.write_digest(true);
    assert_eq!(again.observable(), frame.observable());
}

#[test]
fn a_frame_without_readings_is_as_it_was_before_there_were_any() {
    // The bytes of flags and beams, once two numbers of 32 bits.
    let mut frame = sample();
    frame.write_digest(true);
    assert_eq!(frame.observable()[48..56], [3, 0, 0, 0, 3, 0, 0, 0]);
}
