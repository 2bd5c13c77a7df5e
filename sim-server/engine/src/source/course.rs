//! The course of a simulated run: its world, and what changes in the middle.

use rusty_contract::log::Source;
use rusty_contract::{Frame, LogHeader, RunConfig};
use rusty_geometry::{SE2, Twist};
use rusty_sim::{Sim, SimError};

/// A world that follows the header of a log, tick by tick.
pub struct Course {
    sim: Sim,
    /// What holds from which tick on, until it does.
    change: Option<(u64, RunConfig)>,
}

impl Course {
    /// A world that stays as it is.
    pub(super) fn unchanging(sim: Sim) -> Self {
        Self { sim, change: None }
    }

    /// The course of a run with this header, before its first tick; `None`
    /// where no world made the frames.
    ///
    /// # Errors
    /// [`SimError`] if the configuration, or the change, cannot be used.
    pub fn of(header: &LogHeader) -> Result<Option<Self>, SimError> {
        Self::with(header, Sim::new)
    }

    /// The same where other robots may have drivers, whose commands are given.
    ///
    /// # Errors
    /// [`SimError`] as of [`Course::of`].
    pub fn of_driven(header: &LogHeader) -> Result<Option<Self>, SimError> {
        Self::with(header, Sim::among_driven)
    }

    fn with(
        header: &LogHeader,
        sim: impl Fn(RunConfig) -> Result<Sim, SimError>,
    ) -> Result<Option<Self>, SimError> {
        let config = header.config.clone();
        match &header.source {
            Source::Simulated => Ok(Some(Self::unchanging(sim(config)?))),
            Source::Forked { at_tick, before } => {
                let sim = sim((**before).clone())?;
                // What cannot be used is said before the first tick.
                sim.clone().reconfigure(config.clone())?;
                Ok(Some(Self { sim, change: Some((*at_tick, config)) }))
            }
            Source::Recorded { .. } | Source::Blind { .. } => Ok(None),
        }
    }

    /// The index of the next tick.
    pub(super) fn tick(&self) -> u64 {
        self.sim.tick()
    }

    /// Sets the command of another robot's driver for the next tick, see
    /// [`Sim::drive_other`].
    pub fn drive_other(&mut self, place: usize, applied: Twist) {
        self.sim.drive_other(place, applied);
    }

    /// A driver's command as the robot's wheels can follow it.
    pub(super) fn limit(&self, command: Twist) -> Twist {
        self.sim.limit(command)
    }

    /// Draws the noise of the next tick, see [`Sim::prepare`].
    pub fn prepare(&mut self) {
        self.sim.prepare();
    }

    /// The next tick, written into `frame`, unsealed; the true pose after it.
    ///
    /// # Errors
    /// [`SimError`] if the change cannot be used.
    pub fn step(&mut self, driver: Option<Twist>, frame: &mut Frame) -> Result<SE2, SimError> {
        let tick = self.sim.tick();
        if let Some((_, config)) = self.change.take_if(|(at_tick, _)| *at_tick <= tick) {
            self.sim.reconfigure(config)?;
        }
        // Whether the robot was blocked shows in the truth.
        let _ = self.sim.step(driver, frame);
        Ok(self.sim.truth())
    }
}
