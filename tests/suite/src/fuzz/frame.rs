//! The structs in shared memory as a reader finds them: any bytes at all.

use std::path::Path;

use bytemuck::Zeroable;
use rusty_contract::frame::OBSERVABLE_FROM;
use rusty_contract::log::{LogReader, LogWriter, Read, TickRef};
use rusty_contract::{Frame, LogHeader, MAX_BEAMS, MAX_PARTICIPANTS, RunDigest, Tally, TruthKey};

use super::seeds;

fn fill(place: &mut [u8], bytes: &[u8]) {
    let n = bytes.len().min(place.len());
    place[..n].copy_from_slice(&bytes[..n]);
}

/// A frame as a client borrows it.
pub fn frame(bytes: &[u8]) -> bool {
    thread_local! {
        static HEADER: LogHeader = seeds::header();
    }
    let mut frame = Frame::boxed();
    fill(bytemuck::bytes_of_mut(&mut *frame), bytes);
    let beams = frame.ranges_m().map_or(0, <[f64]>::len);
    assert!(beams <= MAX_BEAMS);
    let observable = frame.observable().len();
    let readings = frame.readings().numbers().len();
    assert_eq!(observable, 56 + 8 * (readings + beams));
    assert!(observable <= size_of::<Frame>() - OBSERVABLE_FROM);
    assert_eq!(frame.readings().named().count(), readings);
    let phase = frame.phase();
    assert_eq!(phase, frame.phase());

    // What a logger writes of it is what a reader finds.
    let sealed = frame.digest() == frame.observable_digest();
    let opened = frame.open_truth(&TruthKey::from_bytes([7; 32]));
    if frame.tick() == 0 {
        HEADER.with(|header| logged(&frame, header));
    }
    sealed && opened.is_ok()
}

fn logged(frame: &Frame, header: &LogHeader) {
    let mut log = LogWriter::new(Vec::new(), Path::new("frame"), header).expect("a header");
    log.tick(TickRef::new(frame, None, &[], header.config.dt_s)).expect("a frame fits");
    log.flush().expect("memory");
    let trailer =
        rusty_contract::log::Trailer { ticks: 1, run_digest: [0; 16], world_digest: [0; 16] };
    let written = log.finish(trailer).expect("memory");
    let mut reader = LogReader::new(&written[..], "frame").expect("a log");
    // A frame that a server of ours cannot have made is refused, not changed.
    let Ok(Read::Tick(entry)) = reader.read() else { return };
    let mut again = Frame::boxed();
    entry.record.write_unsealed(&mut again, header.config.dt_s);
    let bits = |frame: &Frame| -> Vec<u64> {
        frame.ranges_m().unwrap_or_default().iter().map(|r| r.to_bits()).collect()
    };
    assert_eq!(bits(frame), bits(&again));
    assert_eq!(frame.readings().present(), again.readings().present());
    assert_eq!(frame.readings().numbers(), again.readings().numbers());
    assert_eq!(frame.time_s().to_bits(), again.time_s().to_bits());
    assert_eq!(frame.encoders(), again.encoders());
}

/// A tally as a recorder borrows it.
pub fn tally(bytes: &[u8]) -> bool {
    let mut tally = Box::new(Tally::zeroed());
    fill(bytemuck::bytes_of_mut(&mut *tally), bytes);
    let entries = tally.entries();
    assert!(entries.len() <= MAX_PARTICIPANTS);
    let replies: Vec<_> = entries.iter().map(|e| e.reply()).collect();
    for reply in &replies {
        reply.check().expect("a reply is checked where it is read");
    }
    let mut digest = RunDigest::default();
    digest.absorb_replies(replies.iter().copied());
    digest.run() == tally.run_digest
}
