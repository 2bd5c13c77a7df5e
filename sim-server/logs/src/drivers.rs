//! The commands of other robots' drivers, from the logs of these robots.
//!
//! A log has all that its robot's run depends on but one thing: where another robot of the
//! world was driven by a participant, that robot's log has the commands.

use std::path::PathBuf;

use rusty_contract::log::{LogError, LogReader, Read};
use rusty_contract::{Exit, FieldError, LogHeader};
use rusty_engine::source::Course;
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
}

impl DriversError {
    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Field(_) => Exit::Usage,
            Self::Log(_) => Exit::Failed,
        }
    }
}

/// The logs of robots with drivers, by place, read tick by tick.
#[derive(Default)]
pub struct Drivers(Vec<(usize, LogReader)>);

impl Drivers {
    /// Finds, among `logs`, one for each robot with a driver that shares the world of
    /// `header`.
    ///
    /// # Errors
    /// [`DriversError`] names the robot whose log is missing, or the log that is of no
    /// such robot.
    pub fn of(header: &LogHeader, logs: &[PathBuf]) -> Result<Self, DriversError> {
        let others = header.config.fleet.iter().flat_map(|fleet| fleet.others());
        let mut missing: Vec<(usize, &str)> = others
            .filter(|(_, other)| other.is_driven())
            .map(|(place, other)| (place, other.name.as_str()))
            .collect();
        let mut found = Vec::new();
        for path in logs {
            let log = LogReader::open(path)?;
            let its = &log.header().config;
            let name = its.fleet.as_ref().map(|fleet| fleet.name.as_str());
            let same_run = its.seed == header.told().seed && its.scenario == header.config.scenario;
            let wanted = |(_, robot): &(usize, &str)| same_run && name == Some(*robot);
            let Some(index) = missing.iter().position(wanted) else {
                let value = path.display().to_string();
                let problem = "is the log of no other robot with a driver in this run";
                let remedy = match missing.first() {
                    Some((_, robot)) => format!("give the log of robot {robot}"),
                    None => "leave it out".to_owned(),
                };
                return Err(FieldError::new("--with", value, problem, remedy).into());
            };
            found.push((missing.swap_remove(index).0, log));
        }
        match missing.first() {
            None => Ok(Self(found)),
            Some((place, robot)) => {
                let problem = "has a driver, whose commands are in that robot's log";
                let remedy = format!("add --with LOG, the log of robot {robot} of the same run");
                Err(FieldError::new(format!("robot[{place}]"), robot, problem, remedy).into())
            }
        }
    }

    /// Gives `course` the commands of its next tick; behind the end of a log its robot
    /// stands.
    ///
    /// # Errors
    /// [`LogError`] if a log cannot be read.
    pub fn drive(&mut self, course: &mut Course) -> Result<(), LogError> {
        for (place, log) in &mut self.0 {
            if let Read::Tick(entry) = log.read()? {
                course.drive_other(*place, entry.record.command);
            }
        }
        Ok(())
    }
}
