//! Beliefs are read as they were written; whatever else is in a file is named.

use super::*;

fn header() -> BeliefFileHeader {
    BeliefFileHeader {
        writer: "test".to_owned(),
        name: "mcl".to_owned(),
        scenario: "apartment".to_owned(),
    }
}

fn poses(n: usize) -> Vec<WeightedPose> {
    let pose = |k: usize| WeightedPose {
        x_m: k as f64,
        y_m: -1.5,
        theta_rad: 0.25,
        weight: 1.0 / n as f64,
    };
    (0..n).map(pose).collect()
}

fn written() -> Vec<u8> {
    let mut writer = BeliefWriter::new(Vec::new(), &header()).unwrap();
    writer.moment((4, 77), (BeliefKind::Particles, 3), &poses(3)).unwrap();
    writer.moment((9, 78), (BeliefKind::Histogram, 900), &poses(2)).unwrap();
    assert_eq!(writer.moments(), 2);
    writer.finish().unwrap()
}

/// Reads to the end: how many moments, and how it ended.
fn read(bytes: &[u8]) -> Result<(u64, bool), BeliefFileError> {
    let mut reader = BeliefReader::new(bytes)?;
    loop {
        match reader.next()? {
            Found::Moment { .. } => {}
            Found::End => return Ok((reader.moments, true)),
            Found::Cut => return Ok((reader.moments, false)),
        }
    }
}

#[test]
fn what_is_written_is_read() {
    let bytes = written();
    let mut reader = BeliefReader::new(&bytes[..]).unwrap();
    assert_eq!(reader.header(), &header());
    let (first, second) = (poses(3), poses(2));
    let (tick, observable, kind) = (4, 77, BeliefKind::Particles);
    let found = Found::Moment { tick, observable, kind, whole: 3, poses: &first };
    assert_eq!(reader.next().unwrap(), found);
    let (tick, observable, kind) = (9, 78, BeliefKind::Histogram);
    let found = Found::Moment { tick, observable, kind, whole: 900, poses: &second };
    assert_eq!(reader.next().unwrap(), found);
    assert_eq!(reader.next().unwrap(), Found::End);
}

#[test]
fn cut_anywhere_it_reads_up_to_its_last_whole_belief() {
    let bytes = written();
    let start = bytes.len() - 3 * FRONT_BYTES - 5 * 32;
    for length in start..bytes.len() {
        let whole = u64::from(length >= start + FRONT_BYTES + 3 * 32)
            + u64::from(length >= start + 2 * FRONT_BYTES + 5 * 32);
        assert_eq!(read(&bytes[..length]).unwrap(), (whole, false), "{length}");
    }
    assert_eq!(read(&bytes).unwrap(), (2, true));
    for length in 0..start {
        assert!(read(&bytes[..length]).is_err(), "{length}");
    }
}

#[test]
fn a_bit_that_flips_is_noticed() {
    let bytes = written();
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        // A count that grew may reach beyond the end.
        assert!(!matches!(read(&damaged), Ok((_, true))), "byte {at}");
    }
}

#[test]
fn others_are_told_what_to_give() {
    let error = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(error(b"RUSTYLOG and more").contains("--beliefs FILE"));
    assert!(error(b"").contains("no file of beliefs"));
    let mut later = written();
    later[8] = 9;
    assert!(error(&later).contains("format 9"));
    // Ticks must grow, and poses be made of numbers.
    let twice = |ticks: [u64; 2], x_m: f64| {
        let mut writer = BeliefWriter::new(Vec::new(), &header()).unwrap();
        let mut poses = poses(1);
        for tick in ticks {
            writer.moment((tick, 0), (BeliefKind::Particles, 1), &poses).unwrap();
            poses[0].x_m = x_m;
        }
        writer.finish().unwrap()
    };
    assert_eq!(read(&twice([0, 1], 2.0)).unwrap(), (2, true));
    assert!(error(&twice([5, 5], 2.0)).contains("tick 5: out of order"));
    assert!(error(&twice([5, 6], f64::NAN)).contains("poses that are none"));
}
