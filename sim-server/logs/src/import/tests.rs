//! Small logs for every rule, and the real ones.

mod counts;
mod echoes;
mod errors;
mod findings;
mod ranges;
mod real;
mod rules;

use std::fmt::Write as _;
use std::path::Path;

use rusty_contract::log::{Ending, LogHeader, LogReader, Read, Source, TickRecord};
use rusty_contract::{Frame, RunDigest, TruthKey};
use rusty_engine::source::FrameSource as _;

use super::{ImportError, ImportOptions, ImportReport, import_carmen};
use crate::replay::Recording;

/// An import and what its log reads back as.
struct Imported {
    report: ImportReport,
    header: LogHeader,
    ticks: Vec<TickRecord>,
}

/// Imports `bytes` as a file called `name`.
fn import_bytes(name: &str, bytes: &[u8]) -> Result<Imported, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join(name);
    std::fs::write(&input, bytes).unwrap();
    let output = folder.path().join("out.runlog");
    let imported = import_file(&input, &output);
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    let expected = if imported.is_ok() { 2 } else { 1 };
    assert_eq!(left, expected, "an import leaves its log, or nothing at all");
    imported
}

fn import_text(text: &str) -> Result<Imported, ImportError> {
    import_bytes("some robot.log", text.as_bytes())
}

fn import_file(input: &Path, output: &Path) -> Result<Imported, ImportError> {
    let mut told = Vec::new();
    let options = ImportOptions { writer: "test 1.0", strict: false };
    let report = import_carmen(input, output, options, &mut |n| told.push(n))?;
    assert!(told.is_sorted(), "{told:?}");
    assert_eq!(told.last(), Some(&report.lines));
    let (header, ticks) = read_back(output);
    assert_eq!(report.ticks, ticks.len() as u64);
    assert_eq!(header.config.ticks, report.ticks);
    Ok(Imported { report, header, ticks })
}

/// Reads a log to its end, which must be complete, with digests that hold.
fn read_back(path: &Path) -> (LogHeader, Vec<TickRecord>) {
    let mut log = LogReader::open(path).unwrap();
    let header = log.header().clone();
    header.config.check().unwrap();
    let (mut frame, key) = (Frame::boxed(), TruthKey::from_bytes([7; 32]));
    let mut digest = RunDigest::default();
    let mut ticks = Vec::new();
    loop {
        match log.read().unwrap() {
            Read::Tick(entry) => {
                assert!(entry.intact);
                entry.record.write_frame(&mut frame, header.config.dt_s, &key);
                entry.record.absorb(&frame, &mut digest);
                ticks.push(entry.record);
            }
            Read::End(Ending::Complete(trailer)) => {
                assert_eq!(trailer.ticks, ticks.len() as u64);
                assert_eq!(trailer.run_digest, digest.run());
                assert_eq!(trailer.world_digest, digest.world());
                return (header, ticks);
            }
            Read::End(cut) => panic!("{cut:?}"),
        }
    }
}

/// An `ODOM` line.
fn odom([x, y, theta]: [f64; 3], stamp_s: f64) -> String {
    format!("ODOM {x} {y} {theta} 0 0 0 {stamp_s} host {stamp_s}\n")
}

/// A `FLASER` line with `beams` ranges of 1 m, 2 m, …
fn flaser(beams: usize, pose: [f64; 3], odometry: [f64; 3], stamp_s: f64) -> String {
    let mut line = format!("FLASER {beams}");
    for beam in 1..=beams {
        write!(line, " {beam}").unwrap();
    }
    for number in pose.iter().chain(&odometry) {
        write!(line, " {number}").unwrap();
    }
    line + &format!(" {stamp_s} host {stamp_s}\n")
}

/// Nothing can make a recording again and compare, so a replay of it has to say what it lacks.
#[test]
fn a_replay_of_a_cut_or_damaged_recording_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let [text, whole, other] = ["a.txt", "whole", "other"].map(|name| folder.path().join(name));
    let lines = (0..40).map(|k| {
        let pose = [0.1 * f64::from(k), 0.0, 0.0];
        odom(pose, f64::from(k)) + &flaser(180, pose, pose, f64::from(k))
    });
    std::fs::write(&text, lines.collect::<String>()).unwrap();
    import_file(&text, &whole).unwrap();
    let bytes = std::fs::read(&whole).unwrap();
    let replayed = |bytes: &[u8]| {
        std::fs::write(&other, bytes).unwrap();
        let (mut recording, _) = Recording::open(&other).unwrap();
        let ticks = recording.tick_count();
        match &recording.header_mut().source {
            Source::Recorded { remarks, .. } => (ticks, remarks.clone()),
            source => panic!("{source:?}"),
        }
    };
    let (ticks, before) = replayed(&bytes);
    let (fewer, cut) = replayed(&bytes[..bytes.len() / 2]);
    assert!(fewer < ticks);
    let text = format!("the log was cut off: only its first {fewer} ticks");
    assert_eq!(cut, [&before[..], &[text]].concat());
    let mut damaged = bytes.clone();
    damaged[bytes.len() * 3 / 4] ^= 1;
    let (same, damaged) = replayed(&damaged);
    assert_eq!(same, ticks);
    let text = "the checksums of 1 records failed in the log".to_owned();
    assert_eq!(damaged, [&before[..], &[text]].concat());
}
