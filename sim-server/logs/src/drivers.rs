//! The commands of other robots' drivers, from the logs of these robots.
//!
//! A log has all that its robot's run depends on but one thing: where another robot of the
//! world was driven by a participant, that robot's log has the commands.

use std::path::PathBuf;

use rusty_contract::config::OtherRobot;
use rusty_contract::log::{LogError, LogReader, Read};
use rusty_contract::{Exit, FieldError, Frame, LogHeader, RunConfig};
use rusty_engine::source::{Course, FrameSource, SourceError};
use rusty_geometry::{SE2, Twist};
use rusty_sim::SimError;
use thiserror::Error;

/// Why there are no such commands.
#[derive(Debug, Error)]
pub enum DriversError {
    /// A log is missing, or is another one's.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The world cannot be made.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A record is damaged.
    #[error("{log}: tick {tick}: the checksum of its record fails; restore the log to use it")]
    Damaged {
        /// The log.
        log: String,
        /// Where.
        tick: u64,
    },
}

impl DriversError {
    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Field(_) | Self::Sim(_) => Exit::Usage,
            Self::Log(_) | Self::Damaged { .. } => Exit::Failed,
        }
    }
}

/// The log of a robot with a driver.
struct Driver {
    place: usize,
    name: String,
    path: PathBuf,
    log: LogReader,
}

/// The logs of robots with drivers, read tick by tick.
struct Drivers(Vec<Driver>);

/// Whether a robot's configuration is what another one's log says of it.
fn is_of(its: &RunConfig, other: &OtherRobot, config: &RunConfig) -> bool {
    its.fleet.as_ref().is_some_and(|fleet| fleet.name == other.name)
        && (its.start, its.robot, &its.script) == (other.start, other.robot, &other.script)
        && its.kidnappings == other.kidnappings
        && (its.seed, its.dt_s, &its.scenario) == (config.seed, config.dt_s, &config.scenario)
        && its.world == config.world
}

impl Drivers {
    /// Finds, among `logs`, one for each robot with a driver that shares the world of
    /// `header`.
    fn of(header: &LogHeader, logs: &[PathBuf]) -> Result<Self, DriversError> {
        let config = header.told();
        let others = config.fleet.iter().flat_map(|fleet| fleet.others());
        let mut missing: Vec<(usize, &OtherRobot)> =
            others.filter(|(_, other)| other.is_driven()).collect();
        let mut found = Vec::new();
        for path in logs {
            let log = LogReader::open(path)?;
            let wanted =
                |(_, other): &(usize, &OtherRobot)| is_of(log.header().told(), other, config);
            let Some(index) = missing.iter().position(wanted) else {
                let value = path.display().to_string();
                let problem = "is the log of no other robot with a driver in this run";
                let remedy = match missing.first() {
                    Some((_, other)) => format!("give the log of robot {} of this run", other.name),
                    None => "leave it out".to_owned(),
                };
                return Err(FieldError::new("--with", value, problem, remedy).into());
            };
            let (place, other) = missing.swap_remove(index);
            found.push(Driver { place, name: other.name.clone(), path: path.clone(), log });
        }
        match missing.first() {
            None => Ok(Self(found)),
            Some((place, other)) => {
                let robot = &other.name;
                let problem = "has a driver, whose commands are in that robot's log";
                let remedy = format!("add --with LOG, the log of robot {robot} of the same run");
                Err(FieldError::new(format!("robot[{place}]"), robot, problem, remedy).into())
            }
        }
    }

    /// Gives `course` the commands of its next tick. A robot whose log has ended stands;
    /// the first such is returned by its name.
    fn drive(&mut self, course: &mut Course) -> Result<Option<&str>, DriversError> {
        let mut ended = None;
        for Driver { place, name, path, log } in &mut self.0 {
            match log.read()? {
                Read::Tick(entry) if entry.intact => {
                    course.drive_other(*place, entry.record.command);
                }
                Read::Tick(entry) => {
                    let (log, tick) = (path.display().to_string(), entry.record.tick);
                    return Err(DriversError::Damaged { log, tick });
                }
                Read::End(_) => ended = ended.or(Some(name.as_str())),
            }
        }
        Ok(ended)
    }
}

/// The world of a log again, in which other robots with drivers do as their logs say.
pub struct Driven {
    pub(crate) header: LogHeader,
    course: Course,
    drivers: Drivers,
    others: Vec<PathBuf>,
    ended: Option<String>,
}

impl Driven {
    /// The world of `header` with these logs of other robots; `None` if no world made it.
    ///
    /// # Errors
    /// [`DriversError`] if a log is missing, or the configuration cannot be used.
    pub fn new(header: LogHeader, others: &[PathBuf]) -> Result<Option<Self>, DriversError> {
        let Some(course) = Course::of_driven(&header)? else { return Ok(None) };
        let drivers = Drivers::of(&header, others)?;
        Ok(Some(Self { header, course, drivers, others: others.to_vec(), ended: None }))
    }

    /// The next tick, written into `frame`, unsealed; the true pose after it.
    ///
    /// # Errors
    /// [`DriversError`] if a log cannot be read.
    pub fn step(&mut self, driver: Option<Twist>, frame: &mut Frame) -> Result<SE2, DriversError> {
        let ended = self.drivers.drive(&mut self.course)?;
        if self.ended.is_none() {
            self.ended = ended.map(str::to_owned);
        }
        Ok(self.course.step(driver, frame)?)
    }

    /// A robot whose log ends before the last tick, in which it does not move.
    #[must_use]
    pub fn ended(&self) -> Option<&str> {
        self.ended.as_deref()
    }
}

impl From<DriversError> for SourceError {
    fn from(error: DriversError) -> Self {
        match error {
            DriversError::Field(error) => SimError::from(error).into(),
            DriversError::Sim(error) => error.into(),
            DriversError::Log(error) => error.into(),
            DriversError::Damaged { ref log, .. } => {
                let remedy = "restore the log to use it";
                SimError::from(FieldError::new("--with", log, error.to_string(), remedy)).into()
            }
        }
    }
}

impl FrameSource for Driven {
    fn header(&self) -> &LogHeader {
        &self.header
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        Ok(Some(self.step(driver, frame)?))
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        let problem = || FieldError::new("source", "", "no world made it", "use a simulated log");
        let again = Self::new(self.header.clone(), &self.others)?;
        Ok(Box::new(again.ok_or_else(|| SimError::from(problem()))?))
    }
}
