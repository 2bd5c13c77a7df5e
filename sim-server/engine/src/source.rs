//! Where frames come from: the world, or a log.

use std::path::{Path, PathBuf};

use rusty_contract::digest::hex;
use rusty_contract::log::{Ending, LogError, LogReader, Read, TickRecord};
use rusty_contract::{Frame, LogHeader, Reply};
use rusty_geometry::{SE2, Twist};
use rusty_sim::SimError;
use thiserror::Error;

mod comparison;
mod course;
mod fork;

pub use comparison::{Compared, Comparison, Difference};
pub use course::{Course, record_of};
pub use fork::{Branch, Fork, ForkError};

/// Something that makes one frame after the other.
pub trait FrameSource {
    /// What the run's log will say of it.
    fn header(&self) -> &LogHeader;

    /// How many ticks it has.
    fn ticks(&self) -> u64;

    /// Writes the next tick into `frame`, unsealed, and says where the robot
    /// really is, if that is known. `driver` is the driver's latest command.
    ///
    /// # Errors
    /// [`SourceError`] if there is no next tick.
    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError>;

    /// The same frames again, from the first one on.
    ///
    /// # Errors
    /// [`SourceError`] if they are not to be had any more.
    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError>;

    /// The tick last made has these replies, by name.
    fn closed(&mut self, _replies: &mut dyn Iterator<Item = (&str, Reply)>) {}

    /// What a replay found, if this is one.
    fn comparison(&self) -> Option<&Comparison> {
        None
    }

    /// What became of a fork, if this is one.
    fn fork(&self) -> Option<&Fork> {
        None
    }
}

/// Why there is no next tick.
#[derive(Debug, Error)]
pub enum SourceError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The world cannot go on.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The log ends before its run does.
    #[error("the log ends after {ticks} ticks (byte {at_byte}): {problem}")]
    Cut {
        /// Complete ticks.
        ticks: u64,
        /// Where.
        at_byte: u64,
        /// What was found there.
        problem: String,
    },
}

/// The world itself.
pub struct Simulated {
    header: LogHeader,
    course: Course,
}

impl Simulated {
    /// The world of the configuration in this header, which its log will have;
    /// that of a fork's header changes where the fork does.
    ///
    /// # Errors
    /// [`SimError`] if the configuration cannot be used.
    pub fn new(header: LogHeader) -> Result<Self, SimError> {
        let course = match Course::of(&header)? {
            Some(course) => course,
            None => Course::unchanging(&header.config)?,
        };
        Ok(Self { header, course })
    }
}

impl FrameSource for Simulated {
    fn header(&self) -> &LogHeader {
        &self.header
    }

    fn ticks(&self) -> u64 {
        self.header.config.ticks
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        Ok(Some(self.course.step(driver, frame)?))
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(Self::new(self.header.clone())?))
    }
}

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
    comparison: Comparison,
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
        let path = path.to_owned();
        let recording =
            Self { path, reader, header, ticks, made: 0, record: None, names, comparison };
        Ok((recording, ending))
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

    fn ticks(&self) -> u64 {
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

    fn comparison(&self) -> Option<&Comparison> {
        Some(&self.comparison)
    }
}
