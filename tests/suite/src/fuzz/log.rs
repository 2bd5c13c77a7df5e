//! A run log, from its magic to wherever it ends.

use std::path::Path;

use rusty_contract::log::{Ending, LogReader, LogWriter, Read, TickRecord, TickRef};
use rusty_contract::{Frame, LogHeader, RunDigest, TruthKey};

/// Reads a log as every program here does, and writes again what was read.
pub fn log(bytes: &[u8]) -> bool {
    let Ok(mut reader) = LogReader::new(bytes, "fuzzed.log") else { return false };
    let header = reader.header().clone();
    // A reader of a header may build its world, index its roster, divide by
    // its beams.
    header.check().expect("a header that was read can be used");
    let (key, mut frame) = (TruthKey::from_bytes([7; 32]), Frame::boxed());
    let mut digest = RunDigest::default();
    let mut intact: Vec<TickRecord> = Vec::new();
    let (mut ticks, mut all_intact) = (0u64, true);
    let ending = loop {
        match reader.read().expect("bytes in memory are always read") {
            Read::Tick(entry) => {
                assert!((entry.at_byte as usize) < bytes.len());
                entry.record.write_frame(&mut frame, header.config.dt_s, &key);
                // What is marked as damaged may say anything.
                if entry.intact {
                    shown(&entry.record, &frame, &header, &key);
                }
                entry.record.absorb(&frame, &mut digest);
                ticks += 1;
                all_intact &= entry.intact;
                if entry.intact && all_intact {
                    intact.push(entry.record);
                }
            }
            Read::End(ending) => break ending,
        }
    };
    assert_eq!(reader.read().expect("the end again"), Read::End(ending.clone()));
    match &ending {
        Ending::Complete(trailer) => assert_eq!(trailer.ticks, ticks, "nothing is missing"),
        Ending::Cut { ticks: said, at_byte, .. } => {
            assert_eq!(*said, ticks);
            assert!(*at_byte as usize <= bytes.len());
        }
    }
    written_again(&header, &intact);
    matches!(ending, Ending::Complete(_))
}

/// The frame of a record shows what the record says and nothing else.
fn shown(record: &TickRecord, frame: &Frame, header: &LogHeader, key: &TruthKey) {
    assert_eq!(frame.tick(), record.tick);
    let ranges = frame.ranges_m().map(<[f64]>::len);
    assert_eq!(ranges, record.ranges_m.as_ref().map(Vec::len), "no beam is lost");
    let truth = frame.open_truth(key).expect("its own key");
    assert_eq!(truth.is_some(), record.truth.is_some());
    assert!(record.replies.len() <= header.answering().count());
    for reply in &record.replies {
        reply.check().expect("replies in a log were checked when they came");
    }
}

/// What was read, written and read again, is the same bit for bit.
fn written_again(header: &LogHeader, records: &[TickRecord]) {
    let write = |header: &LogHeader, records: &[TickRecord]| {
        let mut log = LogWriter::new(Vec::new(), Path::new("again"), header).expect("a header");
        for r in records {
            log.tick(TickRef::from(r)).expect("a record that was read fits");
        }
        let trailer = rusty_contract::log::Trailer {
            ticks: records.len() as u64,
            run_digest: [0; 16],
            world_digest: [0; 16],
        };
        log.finish(trailer).expect("memory")
    };
    let first = write(header, records);
    let mut reader = LogReader::new(&first[..], "again").expect("what was written is read");
    assert_eq!(reader.header(), header);
    let mut again = Vec::new();
    while let Read::Tick(entry) = reader.read().expect("memory") {
        assert!(entry.intact);
        again.push(entry.record);
    }
    assert!(first == write(header, &again), "written twice, other bytes");
}

/// Makes header length and all checksums right, as far as records can be told
/// apart.
pub fn mend(bytes: &mut [u8]) {
    let word = |bytes: &[u8], at: usize| {
        bytes.get(at..at + 4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]) as usize)
    };
    let Some(length) = word(bytes, 12) else { return };
    let Some(header_end) = 20usize.checked_add(length).filter(|end| *end <= bytes.len()) else {
        return;
    };
    let checksum = crc32fast::hash(&bytes[20..header_end]);
    bytes[16..20].copy_from_slice(&checksum.to_le_bytes());
    let mut at = header_end;
    while at < bytes.len() {
        let mut length = 0;
        for shift in [0, 7, 14] {
            let Some(&byte) = bytes.get(at) else { return };
            at += 1;
            length |= usize::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                break;
            }
        }
        let Some(body) = bytes.get(at + 4..at + 4 + length) else { return };
        let checksum = crc32fast::hash(body);
        bytes[at..at + 4].copy_from_slice(&checksum.to_le_bytes());
        at += 4 + length;
    }
}
