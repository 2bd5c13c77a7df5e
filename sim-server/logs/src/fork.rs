//! A run that leaves another one in the middle.

use std::path::{Path, PathBuf};

use rusty_contract::log::{LogError, LogReader, Read, Source, TickRecord};
use rusty_contract::score::Score;
use rusty_contract::{Effects, Exit, Frame, LogHeader, Reply, RunConfig};
use rusty_engine::source::{FrameSource, SourceError};
use rusty_geometry::{SE2, Twist, trig};
use rusty_sim::SimError;
use serde::Serialize;
use thiserror::Error;

use super::compare::{self, Mismatch, record_of};
use super::comparison::Comparison;
use super::drivers::{Driven, DriversError};

fn remedy(ticks: u64) -> String {
    match ticks {
        0 => "nothing of it can be continued, fork another log".to_owned(),
        _ => format!("use a tick from 1 to {ticks}"),
    }
}

/// Why a run cannot be continued from the middle.
#[derive(Debug, Error)]
pub enum ForkError {
    /// No world made the frames, or two did.
    #[error("{log} cannot be forked: {why}")]
    Source {
        /// The log.
        log: String,
        /// What it is.
        why: &'static str,
    },
    /// The log ends before that.
    #[error("--at {at_tick}: {log} has {ticks} complete ticks; {}", remedy(*ticks))]
    NoSuchTick {
        /// The log.
        log: String,
        /// Asked for.
        at_tick: u64,
        /// Present.
        ticks: u64,
    },
    /// The log of another robot ends before that.
    #[error("--with: the log of robot {robot} has {ticks} ticks, and the branch begins at tick \
             {at_tick}; {}", remedy(*ticks))]
    OtherEnds {
        /// The robot.
        robot: String,
        /// Asked for.
        at_tick: u64,
        /// Present.
        ticks: u64,
    },
    /// The past is not what this build simulates.
    #[error(
        "{log} cannot be forked at tick {at_tick}, because its past does not come again: {found}; \
         `sim-server verify` says more"
    )]
    OtherPast {
        /// The log.
        log: String,
        /// Asked for.
        at_tick: u64,
        /// The first difference.
        found: Box<Mismatch>,
    },
    /// A record before that tick is damaged.
    #[error("{log}: tick {tick}: the checksum of its record fails; restore the log to fork it")]
    Damaged {
        /// The log.
        log: String,
        /// Where.
        tick: u64,
    },
    /// The commands of another robot's driver are missing.
    #[error(transparent)]
    Drivers(#[from] DriversError),
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The configuration cannot be used.
    #[error(transparent)]
    Sim(#[from] SimError),
}

impl ForkError {
    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::OtherPast { .. } => Exit::NotBitExact,
            Self::Source { .. }
            | Self::NoSuchTick { .. }
            | Self::OtherEnds { .. }
            | Self::Sim(_) => Exit::Usage,
            Self::Drivers(error) => error.exit(),
            Self::Damaged { .. } | Self::Log(_) => Exit::Failed,
        }
    }
}

/// A fork compared with its original.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Fork {
    /// The original's log.
    pub original: String,
    /// The first tick of the branch's own.
    pub at_tick: u64,
    /// Frames before it that are the original's, bit for bit.
    pub frames_equal: u64,
    /// The first of them that is not: a driver did not do the same again.
    pub first_frame_difference: Option<Mismatch>,
    /// The first tick at which the true poses differ in any bit.
    pub truths_differ_at: Option<u64>,
    /// Ticks from `at_tick` on that both have.
    pub ticks_compared: u64,
    /// Greatest distance between the true poses of a tick, m, and its tick.
    pub greatest: Option<(f64, u64)>,
    /// Distance between the true poses at the last tick that both have, m.
    pub final_m: Option<f64>,
    /// The original's scores, where a scorer takes part; over all its ticks.
    pub original_scores: Vec<Score>,
}

impl Fork {
    /// Takes in a tick that both runs have.
    fn compare(&mut self, tick: u64, original: [f64; 3], branch: SE2) {
        let same = [branch.x(), branch.y(), branch.theta()].map(f64::to_bits)
            == original.map(f64::to_bits);
        if !same {
            self.truths_differ_at.get_or_insert(tick);
        }
        let apart_m = trig::hypot(branch.x() - original[0], branch.y() - original[1]);
        self.ticks_compared += 1;
        self.final_m = Some(apart_m);
        if self.greatest.is_none_or(|(most_m, _)| apart_m > most_m) {
            self.greatest = Some((apart_m, tick));
        }
    }
}

/// A world that is a log's up to a tick, and another from there on.
pub struct Branch {
    world: Driven,
    original: LogReader,
    record: Option<TickRecord>,
    names: Vec<String>,
    pub(crate) comparison: Comparison,
    pub(crate) fork: Fork,
}

impl Branch {
    /// A branch of `log` whose configuration is `after` from `at_tick` on.
    /// The ticks before it are simulated once here, with the recorded commands
    /// of a driver, to see that they come again. `others` are the logs of other robots
    /// with drivers, which drive as they did.
    ///
    /// # Errors
    /// [`ForkError`] names what stands against it.
    pub fn new(
        log: &Path,
        at_tick: u64,
        after: RunConfig,
        others: &[PathBuf],
    ) -> Result<Self, ForkError> {
        let original = LogReader::open(log)?;
        let before = original.header().clone();
        let name = log.display().to_string();
        let why = match before.source {
            Source::Simulated => None,
            Source::Recorded { .. } => Some("a robot recorded it, and no world can go on with it"),
            Source::Blind { .. } => Some("it is blind; fork the log that it was made from"),
            Source::Forked { .. } => {
                Some("it is a fork itself; fork the log that it was made from, with all changes")
            }
        };
        if let Some(why) = why {
            return Err(ForkError::Source { log: name, why });
        }
        check_past(log, &before, at_tick, others)?;
        let source = Source::Forked { at_tick, before: Box::new(before.config.clone()) };
        let names = before.answering().map(|p| p.name.clone()).collect();
        let header = LogHeader { source, config: after, ..before };
        let none = ForkError::Source { log: name.clone(), why: "no world made it" };
        let world = Driven::new(header, others)?.ok_or(none)?;
        let fork = Fork { original: name, at_tick, ..Fork::default() };
        let comparison = Comparison::default();
        Ok(Self { world, original, record: None, names, comparison, fork })
    }

    /// Changes who takes part.
    pub fn header_mut(&mut self) -> &mut LogHeader {
        &mut self.world.header
    }

    /// What became of it; for the scores of the original.
    pub fn fork_mut(&mut self) -> &mut Fork {
        &mut self.fork
    }
}

/// Simulates the ticks before `at_tick` and compares them with the log's.
fn check_past(
    log: &Path,
    header: &LogHeader,
    at_tick: u64,
    others: &[PathBuf],
) -> Result<(), ForkError> {
    let name = log.display().to_string();
    let mut reader = LogReader::open(log)?;
    let Some(mut world) = Driven::new(header.clone(), others)? else { return Ok(()) };
    let (mut frame, mut effects) = (Frame::boxed(), Effects::of(header));
    for tick in 0..at_tick {
        let record = match reader.read()? {
            Read::Tick(entry) if entry.intact => entry.record,
            Read::Tick(_) => return Err(ForkError::Damaged { log: name, tick }),
            Read::End(_) => return Err(ForkError::NoSuchTick { log: name, at_tick, ticks: tick }),
        };
        let truth = world.step(effects.command(), &mut frame)?;
        if let Some(robot) = world.ended() {
            return Err(ForkError::OtherEnds { robot: robot.to_owned(), at_tick, ticks: tick });
        }
        let again = record_of(&frame, truth);
        if let Some(found) = compare::frames(&record, &again, header.config.dt_s) {
            return Err(ForkError::OtherPast { log: name, at_tick, found: Box::new(found) });
        }
        effects.close(tick, frame.ranges_m().is_some(), record.replies.iter().copied());
    }
    Ok(())
}

impl FrameSource for Branch {
    fn header(&self) -> &LogHeader {
        &self.world.header
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        let truth = self.world.step(driver, frame)?;
        self.record = match self.original.read()? {
            Read::Tick(entry) => Some(entry.record),
            Read::End(_) => None,
        };
        let (tick, fork) = (frame.tick(), &mut self.fork);
        let Some(record) = &self.record else { return Ok(Some(truth)) };
        if tick >= fork.at_tick {
            if let Some(original) = record.truth {
                fork.compare(tick, original, truth);
            }
        } else if fork.first_frame_difference.is_none() {
            let dt_s = self.world.header.config.dt_s;
            fork.first_frame_difference = compare::frames(record, &record_of(frame, truth), dt_s);
            fork.frames_equal += u64::from(fork.first_frame_difference.is_none());
        }
        Ok(Some(truth))
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        // What is given again is compared with nothing.
        self.world.again()
    }

    fn closed(&mut self, replies: &mut dyn Iterator<Item = (&str, Reply)>) {
        let before = |record: &&TickRecord| record.tick < self.fork.at_tick;
        if let Some(record) = self.record.as_ref().filter(before) {
            self.comparison.take(record, &self.names, replies);
        }
    }
}
