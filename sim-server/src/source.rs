//! Where frames come from: the world, or a log.

use std::path::{Path, PathBuf};

use rusty_contract::digest::hex;
use rusty_contract::log::{Ending, LogError, LogReader, Read, TickRecord};
use rusty_contract::{Frame, LogHeader, Reply};
use rusty_geometry::{SE2, Twist};
use rusty_sim::{Sim, SimError};
use serde::Serialize;
use thiserror::Error;

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
}

/// Why there is no next tick.
#[derive(Debug, Error)]
pub enum SourceError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The world cannot be made again.
    #[error(transparent)]
    World(#[from] SimError),
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
    sim: Sim,
}

impl Simulated {
    /// A world whose log will have this header.
    #[must_use]
    pub fn new(header: LogHeader, sim: Sim) -> Self {
        Self { header, sim }
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
        // Whether the robot was blocked shows in the truth.
        let _ = self.sim.step(driver, frame);
        Ok(Some(self.sim.truth()))
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        let sim = Sim::new(self.header.config.clone())?;
        Ok(Box::new(Self::new(self.header.clone(), sim)))
    }
}

/// How the replies of a replay compare with the recorded ones.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Comparison {
    /// Run digest in the log's trailer; null if it was cut.
    pub recorded_digest: Option<String>,
    /// World digest in the log's trailer; null if it was cut.
    pub recorded_world_digest: Option<String>,
    /// Replies that a participant of the same name gave in the log.
    pub compared: u64,
    /// Those equal to the recorded one, bit for bit.
    pub equal: u64,
    /// The first that is not.
    pub first_difference: Option<Difference>,
    /// The log has no trailer.
    pub cut: bool,
    /// Records of the log whose checksums fail.
    pub damaged: u64,
    /// Others answer than in the log, so that the run digest cannot be its own.
    pub other_roster: bool,
}

/// A reply that is not the recorded one.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// Where.
    pub tick: u64,
    /// Whose.
    pub name: String,
    /// What the log has.
    pub recorded: String,
    /// What came.
    pub replayed: String,
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
        let mut answering = 0;
        for (i, (name, reply)) in replies.enumerate() {
            let place = self.names.iter().position(|n| n == name);
            self.comparison.other_roster |= place != Some(i);
            answering += 1;
            let Some(recorded) = place.and_then(|i| record.replies.get(i)) else { continue };
            self.comparison.compared += 1;
            if recorded.same_bits(&reply) {
                self.comparison.equal += 1;
            } else if self.comparison.first_difference.is_none() {
                self.comparison.first_difference = Some(Difference {
                    tick: record.tick,
                    name: name.to_owned(),
                    recorded: format!("{recorded:?}"),
                    replayed: format!("{reply:?}"),
                });
            }
        }
        self.comparison.other_roster |= answering != self.names.len();
    }

    fn comparison(&self) -> Option<&Comparison> {
        Some(&self.comparison)
    }
}
