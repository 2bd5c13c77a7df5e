//! The frames of a log, once more.

use std::path::{Path, PathBuf};

use rusty_contract::digest::hex;
use rusty_contract::log::{Ending, LogError, LogReader, Read, Source, TickRecord};
use rusty_contract::{Frame, LogHeader, Reply};
use rusty_engine::source::{FrameSource, SourceError};
use rusty_geometry::{SE2, Twist};

use super::comparison::Comparison;

/// A log, frame by frame.
pub struct Recording {
    path: PathBuf,
    reader: LogReader,
    header: LogHeader,
    ticks: u64,
    /// Ticks that were made.
    made: u64,
    record: Option<TickRecord>,
    names: Vec<String>,
    pub(crate) comparison: Comparison,
}

impl Recording {
    /// Opens a log and counts its ticks (one pass over the file).
    ///
    /// # Errors
    /// [`LogError`] if it is no log.
    pub fn open(path: &Path) -> Result<(Self, Ending), LogError> {
        let mut counter = LogReader::open(path)?;
        let mut ticks = 0;
        let ending = loop {
            match counter.read()? {
                Read::Tick(_) => ticks += 1,
                Read::End(ending) => break ending,
            }
        };
        let reader = LogReader::open(path)?;
        let mut header = reader.header().clone();
        let names = header.answering().map(|p| p.name.clone()).collect();
        let damaged = counter.damaged();
        let mut comparison = Comparison { cut: true, damaged, ..Comparison::default() };
        if let Ending::Complete(trailer) = &ending {
            comparison.cut = false;
            comparison.recorded_digest = Some(hex(&trailer.run_digest));
            comparison.recorded_world_digest = Some(hex(&trailer.world_digest));
        }
        header.config.ticks = ticks.max(1);
        // A replay of a recording looks whole: nothing can make it again and compare.
        if let Source::Recorded { remarks, .. } = &mut header.source {
            if comparison.cut {
                remarks.push(format!("the log was cut off: only its first {ticks} ticks"));
            }
            if damaged > 0 {
                remarks.push(format!("the checksums of {damaged} records failed in the log"));
            }
        }
        let path = path.to_owned();
        let recording =
            Self { path, reader, header, ticks, made: 0, record: None, names, comparison };
        Ok((recording, ending))
    }

    /// Returns the number of records whose checksums fail.
    #[must_use]
    pub fn damaged(&self) -> u64 {
        self.comparison.damaged
    }

    /// Changes who takes part in the replay.
    pub fn header_mut(&mut self) -> &mut LogHeader {
        &mut self.header
    }
}

impl FrameSource for Recording {
    fn header(&self) -> &LogHeader {
        &self.header
    }

    fn tick_count(&self) -> u64 {
        self.ticks
    }

    fn make(&mut self, _: Option<Twist>, frame: &mut Frame) -> Result<Option<SE2>, SourceError> {
        match self.reader.read()? {
            Read::Tick(entry) => {
                let mut record = entry.record;
                // The number of a damaged record may be the damage. Its place
                // in the log says which tick it is.
                record.tick = self.made;
                self.made += 1;
                record.write_unsealed(frame, self.header.config.dt_s);
                let truth = record.pose_in_world();
                self.record = Some(record);
                Ok(truth)
            }
            Read::End(ending) => {
                let (at_byte, problem) = match ending {
                    Ending::Cut { at_byte, problem, .. } => (at_byte, problem),
                    Ending::Complete(_) => (0, "the file changed while it was read".to_owned()),
                };
                Err(SourceError::Cut { ticks: self.ticks, at_byte, problem })
            }
        }
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(Self::open(&self.path)?.0))
    }

    fn closed(&mut self, replies: &mut dyn Iterator<Item = (&str, Reply)>) {
        let Some(record) = &self.record else { return };
        self.comparison.take(record, &self.names, replies);
    }
}
