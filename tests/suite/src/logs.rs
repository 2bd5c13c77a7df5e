//! Contents of run logs, read for comparison.

use std::path::{Path, PathBuf};

use rusty_contract::log::{
    Ending, LogReader, LogWriter, Read, ReadEntry, Source, TickRecord, TickRef, Trailer,
};
use rusty_contract::{Frame, LogHeader, OnLoss, Participant, RunConfig, RunDigest, TruthKey};
use rusty_engine::scenario_file;
use rusty_geometry::SE2;
use serde_json::Value;

use crate::text;

/// A log, read to its end.
pub struct Log {
    pub header: LogHeader,
    pub entries: Vec<ReadEntry>,
    pub ending: Ending,
}

impl Log {
    /// Reads a log.
    #[track_caller]
    pub fn read(path: &Path) -> Self {
        Self::try_read(path).unwrap_or_else(|| panic!("{} is no log", path.display()))
    }

    /// Reads a log; `None` where not even a header was written.
    pub fn try_read(path: &Path) -> Option<Self> {
        let mut reader = LogReader::open(path).ok()?;
        let mut entries = Vec::new();
        loop {
            match reader.read().unwrap() {
                Read::Tick(entry) => entries.push(entry),
                Read::End(ending) => {
                    return Some(Self { header: reader.header().clone(), entries, ending });
                }
            }
        }
    }

    pub fn is_complete(&self) -> bool {
        matches!(self.ending, Ending::Complete(_))
    }

    /// The ticks, damaged ones included.
    pub fn records(self) -> Vec<TickRecord> {
        self.entries.into_iter().map(|entry| entry.record).collect()
    }

    /// The ticks; fails if one of them is damaged.
    #[track_caller]
    pub fn intact(self) -> Vec<TickRecord> {
        assert!(self.entries.iter().all(|entry| entry.intact), "a record is damaged");
        self.records()
    }
}

/// Header and ticks of a log.
#[track_caller]
pub fn load(log: &Path) -> (LogHeader, Vec<TickRecord>) {
    let log = Log::read(log);
    (log.header.clone(), log.records())
}

/// The log that a report names.
#[track_caller]
pub fn log_of(report: &Value) -> PathBuf {
    PathBuf::from(text(report, "log"))
}

/// The header of a simulated run.
pub fn header_of(config: RunConfig, roster: Vec<Participant>) -> LogHeader {
    let (writer, source, on_loss) = ("test".to_owned(), Source::Simulated, OnLoss::Abort);
    LogHeader { writer, source, config, roster, on_loss }
}

/// The configuration of a scenario with changes.
pub fn config_of(scenario: &str, changes: &[&str]) -> RunConfig {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    scenario_file::load(scenario, &changes).unwrap().config_with(rusty_floorplan::read).unwrap()
}

/// Writes a log whose checksums, digests and trailer are those of its content;
/// returns its run digest.
pub fn write_log(log: &Path, header: &LogHeader, records: &[TickRecord]) -> String {
    let mut writer = LogWriter::create(log, header).unwrap();
    let (mut frame, mut digest) = (Frame::boxed(), RunDigest::default());
    for record in records {
        record.write_frame(&mut frame, header.config.dt_s, &TruthKey::from_bytes([0; 32]));
        record.absorb(&frame, &mut digest);
        writer.tick(TickRef::from(record)).unwrap();
    }
    let (run_digest, world_digest) = (digest.run(), digest.world());
    writer.finish(Trailer { ticks: records.len() as u64, run_digest, world_digest }).unwrap();
    digest.run_hex()
}

/// Whether these bytes occur in others.
pub fn holds(bytes: &[u8], what: &[u8]) -> bool {
    bytes.windows(what.len()).any(|window| window == what)
}

/// The ticks of a log.
#[track_caller]
pub fn records(log: &Path) -> Vec<TickRecord> {
    Log::read(log).records()
}

/// The true poses of a log.
#[track_caller]
pub fn truths(log: &Path) -> Vec<SE2> {
    records(log).iter().filter_map(TickRecord::pose_in_world).collect()
}

/// How many ticks of a log that is being written have reached the disk.
pub fn written(log: &Path) -> usize {
    let Ok(mut reader) = LogReader::open(log) else { return 0 };
    std::iter::from_fn(|| reader.read().ok().filter(|r| matches!(r, Read::Tick(_)))).count()
}
