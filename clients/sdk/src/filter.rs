//! `Filter`: an estimator or driver as a type.

use rusty_contract::{BeliefKind, Reply, WeightedPose};

use crate::{ClientError, Tick};

/// An estimator or a driver. [`run`](crate::run()) does everything else: command line, joining,
/// answering, logs, leaving.
pub trait Filter: Sized {
    /// Whether [`belief`](Self::belief) returns anything. Set it with `belief`, which is
    /// never called otherwise; if not, `--beliefs` is
    /// refused at once.
    const SHOWS_BELIEF: bool = false;

    /// Waits before a tick is updated, for a driver that answers late on purpose; returns
    /// whether it did. The time is not reported as compute time.
    fn wait(&mut self) -> bool {
        false
    }

    /// Answers one tick: a pose, an `Estimate`, a command, or `Reply::Abstain`.
    fn update(&mut self, tick: &Tick<'_>) -> Reply;

    /// Adds the poses that are possible now to `poses`, for observers. Called after
    /// a tick with a scan was answered (after every tick before the first scan), and
    /// only while an observer is attached; so no answer may depend on it. Invalid
    /// poses are removed, and of more than
    /// [`MAX_POSES`](rusty_contract::belief::MAX_POSES) a part is shown.
    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let _ = poses;
        None
    }

    /// Whether the run is to end with the tick that was just updated: see
    /// [`Tick::end_run`].
    fn is_done(&self) -> bool {
        false
    }

    /// Writes results at the end of the run.
    ///
    /// # Errors
    /// The reason why they cannot be written; this process then fails.
    fn finish(self) -> Result<(), ClientError> {
        Ok(())
    }
}
