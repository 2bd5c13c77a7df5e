//! The next tick, made while the participants work on this one.
//!
//! It is in private memory: nothing of a tick reaches shared memory before all answers
//! to the one before it are in.

use rusty_contract::{Frame, TruthKey};
use rusty_geometry::{SE2, Twist};

use crate::source::{FrameSource, SourceError};

/// A sealed frame and the true pose in it.
pub(super) struct Ahead {
    frame: Box<Frame>,
    /// What the source returned, if it has made the next tick.
    made: Option<Result<Option<SE2>, SourceError>>,
}

impl Ahead {
    pub(super) fn new() -> Self {
        Self { frame: Frame::boxed(), made: None }
    }

    /// Makes the next tick, or what of it depends on no answer.
    pub(super) fn prepare(&mut self, source: &mut dyn FrameSource, key: &TruthKey) {
        if !source.needs_no_answer() {
            source.prepare();
        } else if self.made.is_none() {
            self.made = Some(make(source, None, &mut self.frame, key));
        }
    }

    /// Writes the next tick into `frame`, sealed. Returns the true pose, if it is known.
    pub(super) fn make(
        &mut self,
        source: &mut dyn FrameSource,
        driver: Option<Twist>,
        frame: &mut Frame,
        key: &TruthKey,
    ) -> Result<Option<SE2>, SourceError> {
        match self.made.take() {
            Some(made) => made.inspect(|_| frame.copy_tick(&self.frame)),
            None => make(source, driver, frame, key),
        }
    }
}

fn make(
    source: &mut dyn FrameSource,
    driver: Option<Twist>,
    frame: &mut Frame,
    key: &TruthKey,
) -> Result<Option<SE2>, SourceError> {
    let truth = source.make(driver, frame)?;
    frame.seal(key, truth);
    Ok(truth)
}
