//! Where frames come from: the world, or a log.

use rusty_contract::log::{LogError, Source};
use rusty_contract::{Frame, LogHeader, OnLoss, Participant, Reply, RunConfig};
use rusty_geometry::{SE2, Twist};
use rusty_sim::{Sim, SimError};
use thiserror::Error;

mod board;
mod course;

use board::Seat;
pub use course::Course;

/// Something that makes one frame after the other.
pub trait FrameSource {
    /// What the run's log will say of it.
    fn header(&self) -> &LogHeader;

    /// The number of its ticks.
    fn tick_count(&self) -> u64 {
        self.header().config.ticks
    }

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

    /// Whether the next tick is the same whatever the participants answer, so that it may
    /// be made before they do.
    fn needs_no_answer(&self) -> bool {
        false
    }

    /// Does what of the next tick depends on no answer, where the whole does.
    fn prepare(&mut self) {}

    /// Whether the next tick may happen: where robots share a world, once all are ready
    /// for it. `driver` is as for [`make`](Self::make).
    ///
    /// # Errors
    /// [`SourceError`] if it never will.
    fn is_ready(&mut self, _driver: Option<Twist>) -> Result<bool, SourceError> {
        Ok(true)
    }

    /// The run ends after `ticks`, which may be fewer than there are.
    fn ended(&mut self, _ticks: u64) {}

    /// The same frames again, from the first one on.
    ///
    /// # Errors
    /// [`SourceError`] if they are not to be had any more.
    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError>;

    /// The tick last made has these replies, by name.
    fn closed(&mut self, _replies: &mut dyn Iterator<Item = (&str, Reply)>) {}
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
    /// A robot that shares the world has no more ticks.
    #[error("robot {robot} ended after {ticks} ticks, and a world goes on with all of its robots")]
    OtherEnded {
        /// Its name.
        robot: String,
        /// Its complete ticks.
        ticks: u64,
    },
}

/// Returns the header of a simulated run, as this version writes it.
#[must_use]
pub fn simulated_header(config: RunConfig, roster: Vec<Participant>, on_loss: OnLoss) -> LogHeader {
    let writer = concat!("sim-server ", env!("CARGO_PKG_VERSION")).to_owned();
    LogHeader { writer, source: Source::Simulated, config, roster, on_loss }
}

/// The world itself.
pub struct Simulated<'a> {
    header: LogHeader,
    course: Course,
    before: Option<Box<dyn FnMut(u64) + 'a>>,
    /// Where other robots share the world.
    seat: Option<Seat>,
}

impl<'a> Simulated<'a> {
    /// The world of the configuration in this header, which its log will have;
    /// that of a fork's header changes where the fork does.
    ///
    /// # Errors
    /// [`SimError`] if the configuration cannot be used.
    pub fn new(header: LogHeader) -> Result<Self, SimError> {
        let course = match Course::of(&header)? {
            Some(course) => course,
            None => Course::unchanging(Sim::new(header.config.clone())?),
        };
        Ok(Self { header, course, before: None, seat: None })
    }

    /// The runs of the robots of one world, in the order of their places.
    ///
    /// # Errors
    /// [`SimError`] if a configuration cannot be used.
    pub fn together(headers: Vec<LogHeader>) -> Result<Vec<Self>, SimError> {
        let seats = Seat::all(headers.len());
        let robots = headers.into_iter().zip(seats);
        robots.map(|(header, seat)| Self::seated(header, seat)).collect()
    }

    fn seated(header: LogHeader, seat: Seat) -> Result<Self, SimError> {
        let course = Course::unchanging(Sim::among_driven(header.config.clone())?);
        Ok(Self { header, course, before: None, seat: Some(seat) })
    }

    /// Calls `before` with the index of each tick before it is made.
    #[must_use]
    pub fn before_each_tick(self, before: impl FnMut(u64) + 'a) -> Self {
        Self { before: Some(Box::new(before)), ..self }
    }
}

impl FrameSource for Simulated<'_> {
    fn header(&self) -> &LogHeader {
        &self.header
    }

    fn make(
        &mut self,
        driver: Option<Twist>,
        frame: &mut Frame,
    ) -> Result<Option<SE2>, SourceError> {
        if let Some(before) = &mut self.before {
            before(self.course.tick());
        }
        if let Some(seat) = &self.seat {
            let course = &mut self.course;
            seat.commands(course.tick(), |place, command| course.drive_other(place, command));
        }
        Ok(Some(self.course.step(driver, frame)?))
    }

    fn needs_no_answer(&self) -> bool {
        self.seat.is_none() && !self.header.config.script.is_driver()
    }

    fn prepare(&mut self) {
        self.course.prepare();
    }

    fn is_ready(&mut self, driver: Option<Twist>) -> Result<bool, SourceError> {
        let Some(seat) = &self.seat else { return Ok(true) };
        let script = &self.header.config.script;
        let command = script.is_driver().then(|| self.course.limit(driver.unwrap_or_default()));
        seat.ready(self.course.tick(), command)
    }

    fn ended(&mut self, ticks: u64) {
        if let (Some(seat), Some(fleet)) = (&self.seat, &self.header.config.fleet)
            && ticks < self.tick_count()
        {
            seat.end(&fleet.name, ticks);
        }
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        let header = self.header.clone();
        Ok(Box::new(match &self.seat {
            None => Simulated::new(header)?,
            Some(seat) => Simulated::seated(header, seat.clone())?,
        }))
    }
}
