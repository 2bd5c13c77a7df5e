//! A log is read as it was written, and up to its last complete tick when it
//! was cut; damaged anywhere, it never breaks the reader.

use std::path::Path;

use rusty_geometry::{EncoderCounts, SE2, Twist};

use super::*;
use crate::{Estimate, Frame, OwnedReadings, Reply, RunConfig, RunDigest, Scenario, TruthKey};

const DT_S: f64 = 0.02;
const TICKS: u64 = 8;

fn header() -> LogHeader {
    let (seed, ticks, start) = (u64::MAX, TICKS, SE2::new(0.1, 0.2, 0.3));
    let scenario =
        Scenario { seed, ticks, dt_s: DT_S, scan_every: 2, start, ..Scenario::default() };
    LogHeader::simulated("test", &scenario, rusty_geometry::places::apartment().spec().clone())
}

/// Readings in every third tick.
fn readings(tick: u64) -> OwnedReadings {
    let mut frame = Frame::boxed();
    if tick % 3 == 1 {
        frame.write_bumper(tick as u16);
        frame.write_sonars(&[0.5, 10.7]);
        frame.write_landmarks(&[crate::LandmarkReading::new(None, 2.0, -0.0)]);
    }
    frame.readings().into()
}

/// A tick with everything in it, or next to nothing.
fn record(tick: u64) -> TickRecord {
    let pose = SE2::new(tick as f64 + 0.1, -0.0, 1.0 / 3.0);
    let covariance = Some([0.1; 9]);
    let command = Twist { v_m_s: 0.5, omega_rad_s: -1e-300 };
    let replies = match tick % 4 {
        0 => vec![pose.into()],
        1 => vec![Reply::Both(Estimate { covariance, ..pose.into() }, command)],
        2 => vec![Reply::Missing],
        _ => vec![Reply::Abstain],
    };
    TickRecord {
        tick,
        stamp_s: (tick == 5).then_some(123.456),
        ticks: EncoderCounts { left: i64::MIN + tick as i64, right: i64::MAX },
        command,
        truth: (tick != 3).then_some([pose.x(), pose.y(), pose.theta()]),
        ranges_m: tick.is_multiple_of(2).then(|| vec![1.0, 8.0, 5e-324]),
        replies,
        readings: readings(tick),
    }
}

/// A complete log, and where each entry ends.
fn written() -> (Vec<u8>, Vec<usize>) {
    let mut log = LogWriter::new(Vec::new(), Path::new("test.log"), &header()).unwrap();
    let key = TruthKey::from_bytes([1; 32]);
    let (mut frame, mut digest, mut ends) = (Frame::boxed(), RunDigest::default(), Vec::new());
    for tick in 0..TICKS {
        let r = record(tick);
        r.write_frame(&mut frame, DT_S, &key);
        r.absorb(&frame, &mut digest);
        log.tick(TickRef::new(&frame, r.pose_in_world(), &r.replies, DT_S)).unwrap();
        ends.push(log.output().len());
    }
    let trailer = Trailer { ticks: TICKS, run_digest: digest.run(), world_digest: digest.world() };
    let bytes = log.finish(trailer).unwrap();
    ends.push(bytes.len());
    (bytes, ends)
}

fn read(bytes: &[u8]) -> Result<(Vec<ReadEntry>, Ending), LogError> {
    let mut reader = LogReader::new(bytes, "test.log")?;
    let mut entries = Vec::new();
    loop {
        match reader.read()? {
            Read::Tick(entry) => entries.push(entry),
            Read::End(ending) => return Ok((entries, ending)),
        }
    }
}

#[test]
fn what_was_written_is_read_bit_for_bit() {
    let (bytes, _) = written();
    let mut reader = LogReader::new(&bytes[..], "test.log").unwrap();
    assert_eq!(*reader.header(), header());
    let (entries, ending) = read(&bytes).unwrap();
    assert!(matches!(ending, Ending::Complete(Trailer { ticks: TICKS, .. })));
    for (entry, tick) in entries.iter().zip(0..) {
        assert!(entry.intact);
        assert_eq!(entry.record, record(tick));
        // `==` does not see the sign of zero.
        let y = entry.record.truth.map_or(-0.0, |t| t[1]);
        assert_eq!(y.to_bits(), (-0.0f64).to_bits());
    }
    assert!(matches!(reader.read().unwrap(), Read::Tick(_)));
}

#[test]
fn a_record_has_the_bytes_that_are_derived_for_it() {
    let scans = [0, 1, 180, 1080].map(|n| (0..n).map(|k| f64::from(k) * 0.1).collect::<Vec<_>>());
    let mut records: Vec<TickRecord> = (0..TICKS).map(record).collect();
    records.extend(scans.map(|scan| TickRecord { ranges_m: Some(scan), ..record(300) }));
    for r in records {
        let borrowed = TickRef::from(&r);
        let entry = match r.readings.get().present().is_empty() {
            true => Entry::Tick(r.clone()),
            false => Entry::Sensed(r.readings.clone(), r.clone()),
        };
        let derived = postcard::to_stdvec(&entry).unwrap();
        if matches!(entry, Entry::Tick(_)) {
            assert_eq!(postcard::to_stdvec(&EntryRef::Tick(borrowed)).unwrap(), derived);
        }
        assert_eq!(borrowed.encode(vec![7; 3]).unwrap(), [&[7; 3], &derived[..]].concat());
    }
}

#[test]
fn a_log_cut_anywhere_reads_up_to_its_last_complete_tick() {
    let (bytes, ends) = written();
    for length in 0..bytes.len() {
        match read(&bytes[..length]) {
            Err(e) => {
                // Inside magic, version or header: said with its place.
                let text = e.to_string();
                assert!(text.contains("header, byte") || text.contains("no run log"), "{text}");
            }
            Ok((entries, Ending::Cut { ticks, at_byte, .. })) => {
                let complete = ends.iter().filter(|end| **end <= length).count();
                assert_eq!(entries.len(), complete, "cut at {length}");
                assert_eq!(ticks, complete as u64);
                assert!(at_byte <= length as u64);
            }
            Ok((_, ending)) => panic!("cut at {length} reads as {ending:?}"),
        }
    }
}

#[test]
fn a_flipped_bit_is_noticed_wherever_it_is() {
    let (bytes, _) = written();
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        if let Ok((entries, Ending::Complete(_))) = read(&damaged) {
            assert!(entries.iter().any(|e| !e.intact), "byte {at} goes unnoticed");
        }
    }
}

#[test]
fn a_foreign_file_is_named_for_what_it_is() {
    let (mut bytes, _) = written();
    for foreign in [&b""[..], b"\x89PNG\r\n", b"ODOM 0 0 0 0 0 0 0 nohost 0\n"] {
        let text = read(foreign).unwrap_err().to_string();
        assert!(text.contains("test.log: this is no run log"), "{text}");
    }
    bytes[8] = 9;
    let text = read(&bytes).unwrap_err().to_string();
    assert!(text.contains("log format 9, this build reads 1"), "{text}");
}

#[test]
fn memory_follows_the_file_and_not_what_it_claims() {
    let (mut bytes, _) = written();
    bytes[12..16].copy_from_slice(&(MAX_HEADER_BYTES).to_le_bytes());
    assert!(read(&bytes).unwrap_err().to_string().contains("the file ends here"));
    bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(read(&bytes).unwrap_err().to_string().contains("is not credible"));
}

/// A log with good checksums that no program of ours has written.
fn forged(header: &LogHeader, records: &[TickRecord], ticks: u64) -> Vec<u8> {
    let mut log = LogWriter::new(Vec::new(), Path::new("test.log"), header).unwrap();
    for r in records {
        log.tick(TickRef::from(r)).unwrap();
    }
    log.finish(Trailer { ticks, run_digest: [0; 16], world_digest: [0; 16] }).unwrap()
}

#[test]
fn a_header_that_no_run_can_have_is_refused() {
    type Break = fn(&mut LogHeader);
    let broken: [(Break, &str); 5] = [
        (|h| h.config.scenario = "a\u{1b}[2J".to_owned(), "name = \"a\\u{1b}[2J\""),
        (|h| h.config.lidar.beams = 0, "lidar.beams = 0"),
        (|h| h.config.robot.track_m = 0.0, "robot.track_m = 0"),
        (|h| h.roster = vec![h.roster[0].clone(); 2], "is there twice"),
        (|h| h.config.world.bounds = [1.0; 4], "bounds"),
    ];
    for (break_it, said) in broken {
        let mut header = header();
        break_it(&mut header);
        let text = read(&forged(&header, &[], 0)).unwrap_err().to_string();
        assert!(text.contains("header, byte 20") && text.contains(said), "{text}");
    }
}

#[test]
fn a_record_that_no_run_can_have_ends_the_log_whatever_its_checksum_says() {
    type Break = fn(&mut TickRecord, Reply);
    let nan: Reply = SE2::new(f64::NAN, 0.0, 0.0).into();
    let broken: [(Break, &str); 6] = [
        (|r, _| r.stamp_s = Some(f64::INFINITY), "holds inf where"),
        (|r, _| r.truth = Some([0.0, f64::NAN, 0.0]), "holds NaN where"),
        (|r, _| r.ranges_m = Some(vec![1.0; 1081]), "1081 beams"),
        (|r, _| r.ranges_m = Some(vec![1.0, -0.1]), "the range -0.1"),
        (|r, _| r.replies = vec![Reply::Abstain; 2], "2 replies of 1"),
        (|r, nan| r.replies = vec![nan], "x_m is NaN"),
    ];
    for (break_it, said) in broken {
        let mut records = [record(0), record(1)];
        break_it(&mut records[1], nan);
        match read(&forged(&header(), &records, 2)).unwrap() {
            (entries, Ending::Cut { ticks: 1, problem, .. }) => {
                assert!(entries.len() == 1 && problem.contains(said), "{problem}");
            }
            other => panic!("{said}: {other:?}"),
        }
    }
    // Nothing came back: a real robot's log may say so by an infinite range.
    let mut open = record(0);
    open.ranges_m = Some(vec![f64::INFINITY]);
    assert!(matches!(read(&forged(&header(), &[open], 1)).unwrap().1, Ending::Complete(_)));
}

#[test]
fn a_log_whose_last_ticks_were_taken_out_is_not_complete() {
    let (_, ending) = read(&forged(&header(), &[record(0)], 2)).unwrap();
    assert!(matches!(&ending, Ending::Cut { ticks: 1, .. }), "{ending:?}");
}

#[test]
fn a_seed_below_two_to_the_forty_is_guessable_where_there_is_one() {
    let of = |seed: u64, source: Source| {
        let config = RunConfig { seed, ..header().config };
        LogHeader { source, config, ..header() }.guessable_seed()
    };
    let forked = |before: u64| {
        let before = Box::new(RunConfig { seed: before, ..header().config });
        Source::Forked { at_tick: 3, before }
    };
    let recorded = Source::Recorded {
        format: "a".into(),
        file: "b".into(),
        remarks: Vec::new(),
        findings: Vec::new(),
    };
    assert_eq!(of(42, Source::Simulated), Some(42));
    assert_eq!(of((1 << 40) - 1, Source::Simulated), Some((1 << 40) - 1));
    assert_eq!(of(1 << 40, Source::Simulated), None);
    assert_eq!(of(u64::MAX, forked(7)), Some(7));
    assert_eq!(of(9, forked(u64::MAX)), Some(9));
    assert_eq!(of(u64::MAX, forked(1 << 40)), None);
    assert_eq!(of(42, recorded), None);
}

#[test]
fn a_whole_log_is_written_as_it_was_read() {
    let (bytes, ends) = written();
    let log = Log::read(&bytes[..], "test.log").unwrap();
    assert_eq!(log.records.len() as u64, TICKS);
    assert_eq!(log.write(Vec::new()).unwrap(), bytes);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.log");
    log.save(&path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
    assert_eq!(Log::load(&path).unwrap(), log);
    // Cut, or damaged: an error that names the place.
    let cut = Log::read(&bytes[..ends[3] + 5], "test.log").unwrap_err();
    let at = ends[3] as u64;
    assert!(matches!(cut, LogError::Incomplete { at_byte, .. } if at_byte == at), "{cut}");
    let mut damaged = bytes;
    damaged[ends[3] - 1] ^= 1;
    let error = Log::read(&damaged[..], "test.log").unwrap_err();
    let at = ends[2] as u64;
    assert!(matches!(error, LogError::Incomplete { at_byte, .. } if at_byte == at), "{error}");
}
