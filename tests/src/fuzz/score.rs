//! What a scorer makes of a log: figures and a picture.

use rusty_clients::scoring::{RunTrace, score as scores, svg};
use rusty_contract::log::{LogReader, Read};

/// Scores a log and draws it, as `score --log` does, but for the pixels.
pub fn score(bytes: &[u8]) -> bool {
    let Ok(mut reader) = LogReader::new(bytes, "fuzzed.log") else { return false };
    let mut trace = RunTrace::new(reader.header());
    let dt_s = reader.header().config.dt_s;
    while let Ok(Read::Tick(entry)) = reader.read() {
        let record = entry.record;
        let estimates = record.replies.iter().map(|r| r.estimate().map(|e| e.pose_in_world));
        let (time_s, truth) = (record.time_s(dt_s), record.pose_in_world());
        trace.push(time_s, truth, record.ranges_m.as_deref(), estimates);
    }
    let figures = scores(&trace);
    assert_eq!(figures.len(), trace.names.len());
    let drawing = svg(&trace, &figures).expect("whatever was said can be drawn");
    assert!(drawing.starts_with("<svg") && drawing.trim_end().ends_with("</svg>"));
    true
}
