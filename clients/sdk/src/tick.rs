//! `Tick`: one frame, and the duty to answer it.

use std::rc::Rc;

use rusty_contract::{Frame, Readings, Reply};
use rusty_geometry::{EncoderCounts, Twist};

use crate::ClientError;
use crate::held_frame::FrameHandle;

/// The way of an answer to the server or into a file.
pub(crate) trait Answering {
    /// Sends the answer to a frame.
    fn reply(&mut self, frame: &FrameHandle, reply: Reply) -> Result<(), ClientError>;

    /// Makes the next answer end the run.
    fn end_run(&mut self);

    /// Marks the part as failed.
    fn fail(&mut self);
}

/// One tick of the world, read where it lies. [`answer`](Self::answer) it;
/// dropped without an answer it abstains.
pub struct Tick<'a> {
    /// None for a tick of a test.
    session: Option<&'a mut dyn Answering>,
    frame: FrameHandle,
    answered: bool,
}

impl<'a> Tick<'a> {
    #[cfg(feature = "link")]
    pub(crate) fn new(session: &'a mut dyn Answering, frame: FrameHandle) -> Self {
        Self { session: Some(session), frame, answered: false }
    }

    /// A tick without a session, for tests of a filter: its answer goes nowhere.
    #[must_use]
    pub fn detached(frame: &Frame) -> Self {
        Self { session: None, frame: FrameHandle::Log(Rc::new(*frame)), answered: true }
    }

    #[cfg(feature = "link")]
    pub(crate) fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Index of the tick, from 0.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.frame.tick()
    }

    /// Time at the end of the tick, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.frame.time_s()
    }

    /// Cumulative encoder counts at the end of the tick.
    #[must_use]
    pub fn encoders(&self) -> EncoderCounts {
        self.frame.encoders()
    }

    /// The command that was applied during the tick, body frame.
    #[must_use]
    pub fn command(&self) -> Twist {
        self.frame.command()
    }

    /// The scan taken at the end of the tick, if there is one: ranges in
    /// metres, one per beam, in shared memory.
    #[must_use]
    pub fn ranges_m(&self) -> Option<&[f64]> {
        self.frame.ranges_m()
    }

    /// What the small sensors of the robot say at the end of the tick, in shared
    /// memory: bumper, IMU, sonars, doors, landmarks. [`Session::start`](crate::Session::start) has their
    /// geometry, and of their noise what the data sheet has.
    #[must_use]
    pub fn readings(&self) -> Readings<'_> {
        self.frame.readings()
    }

    /// Answers with an estimate (a pose, or an `Estimate` with covariance), a
    /// command, or any other `Reply`. The answer is the acknowledgement: only
    /// when all have answered does the next tick happen.
    ///
    /// # Errors
    /// [`ClientError::Answer`] names an invalid number; the tick then
    /// abstains.
    pub fn answer(mut self, reply: impl Into<Reply>) -> Result<(), ClientError> {
        self.reply(reply.into())
    }

    /// Makes this tick the last one of the run, once all have answered it: for a
    /// driver that is done. The run then ends as it would after its last tick, and its
    /// log repeats it. Of other participants it changes nothing.
    pub fn end_run(&mut self) {
        if let Some(session) = &mut self.session {
            session.end_run();
        }
    }

    /// Counts the compute time of the answer from now.
    #[cfg(feature = "link")]
    pub(crate) fn restart_clock(&mut self) {
        if let FrameHandle::Live(frame) = &mut self.frame {
            frame.restart_clock();
        }
    }

    pub(crate) fn reply(&mut self, reply: Reply) -> Result<(), ClientError> {
        if let Some(session) = &mut self.session {
            session.reply(&self.frame, reply)?;
        }
        self.answered = true;
        Ok(())
    }

    /// Leaves the tick without a word: the server learns of the failure when
    /// the session goes.
    #[cfg(feature = "link")]
    pub(crate) fn fail(mut self) {
        self.answered = true;
        if let Some(session) = &mut self.session {
            session.fail();
        }
    }
}

impl Drop for Tick<'_> {
    fn drop(&mut self) {
        let Some(session) = self.session.as_mut().filter(|_| !self.answered) else { return };
        if std::thread::panicking() {
            session.fail();
        } else {
            // If the server has ended, the wait for the next frame reports it.
            let _ = session.reply(&self.frame, Reply::Abstain);
        }
    }
}
