//! What a scorer makes of a log: figures, a picture and a report.

use rusty_contract::log::{LogReader, Read};
use rusty_scorer::report::html;
use rusty_scorer::scoring::stops::Stops;
use rusty_scorer::scoring::{RunTrace, score as scores, svg};

/// Scores a log and draws it, as `score --log` does, but for the pixels.
pub fn score(bytes: &[u8]) -> bool {
    let Ok(mut reader) = LogReader::new(bytes, "fuzzed.log") else { return false };
    let mut trace = RunTrace::new(reader.header());
    let dt_s = reader.header().config.dt_s;
    // Room for none: of a log that was made up, the length is unknown.
    let mut stops = Stops::new(trace.names.len(), trace.lidar.beams as usize, 0);
    while let Ok(Read::Tick(entry)) = reader.read() {
        let record = entry.record;
        let estimates = record.replies.iter().map(|r| r.estimate().map(|e| e.pose_in_world));
        let (time_s, truth) = (record.time_s(dt_s), record.pose_in_world());
        trace.push(time_s, truth, record.ranges_m.as_deref(), estimates);
        let estimates = record.replies.iter().map(|r| r.estimate().copied());
        stops.push(time_s, truth, record.ranges_m.as_deref(), estimates);
    }
    trace.stops = stops.finish();
    let figures = scores(&trace);
    assert_eq!(figures.len(), trace.names.len());
    let drawing = svg(&trace, &figures);
    assert!(drawing.starts_with("<svg") && drawing.trim_end().ends_with("</svg>"));
    let report = trace.report(figures);
    let page = html(reader.header(), &trace, &report);
    assert!(!page.contains("NaN") && page.trim_end().ends_with("</html>"));
    true
}
