//! The participants that the server starts itself.

use std::fs;
use std::path::Path;
use std::process::ExitStatus;
use std::time::{Duration, Instant};

use rusty_contract::{Exit, Participant};

use super::child::{ChildProcess, ChildrenError, Spawn};
use super::group::adopt_orphans;
use super::printed;
use crate::confine::Gate;

/// How long participants may take to end after their leave message.
const PATIENCE: Duration = Duration::from_secs(10);
/// The same for those that are not required.
const SHORT_PATIENCE: Duration = Duration::from_millis(300);
/// The same for those that reported a failure: an interpreter writes down what
/// happened and takes itself apart before it ends, and its last lines are wanted.
const FAILED_PATIENCE: Duration = Duration::from_secs(3);

/// How a participant left the run, for how long its process is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leaving {
    /// It took part to the end.
    AtTheEnd,
    /// It took part until the run was aborted.
    Aborted,
    /// It said that it failed.
    Failed,
    /// It never took part, or was lost in another way.
    Lost,
    /// Its process was found dead: the loss has all that there is to report.
    Dead,
    /// The run was aborted before it had joined.
    TooLate,
}

impl Leaving {
    pub(super) fn patience(self) -> Duration {
        match self {
            Self::AtTheEnd | Self::Aborted => PATIENCE,
            Self::Failed => FAILED_PATIENCE,
            Self::Lost | Self::Dead | Self::TooLate => SHORT_PATIENCE,
        }
    }

    /// Whether ending like this is a failure that nothing else reports. Of an
    /// aborted run the logger ends with code 3, and one that asks to join it with
    /// code 1.
    fn is_own_fault(self, status: ExitStatus) -> bool {
        let follows = match self {
            Self::Dead => return false,
            Self::Aborted => Some(Exit::Lost as i32),
            Self::TooLate => Some(Exit::Failed as i32),
            _ => None,
        };
        !status.success() && (follows.is_none() || status.code() != follows)
    }
}

/// The participants that the server started.
#[derive(Default)]
pub struct Children(Vec<ChildProcess>);

impl Children {
    /// Starts everyone in the roster who has a command; those with a gate that
    /// confines are confined.
    ///
    /// # Errors
    /// [`ChildrenError`] names the participant; those already started are
    /// ended.
    pub(super) fn start(
        roster: &[Participant],
        gates: &[Gate],
        spawn: &Spawn<'_>,
    ) -> Result<Self, ChildrenError> {
        let mut children = Self::default();
        if gates.iter().any(Gate::confines) {
            adopt_orphans();
        }
        for (slot, participant) in roster.iter().enumerate() {
            if !participant.command.is_empty() {
                let confined = gates.get(slot).is_some_and(Gate::confines);
                children.0.push(ChildProcess::start(slot, participant, confined, spawn)?);
            }
        }
        Ok(children)
    }

    /// Their slots and processes, in roster order.
    pub(super) fn slots(&self) -> impl Iterator<Item = (usize, u32)> {
        self.0.iter().map(|child| (child.slot, child.pid()))
    }

    /// Their processes, which lead their groups, in roster order.
    pub fn processes(&self) -> impl Iterator<Item = u32> {
        self.0.iter().map(ChildProcess::pid)
    }

    fn at(&mut self, slot: usize) -> Option<&mut ChildProcess> {
        self.0.iter_mut().find(|r| r.slot == slot)
    }

    /// How the participant at `slot` ended, if the server started it and it
    /// has ended. `pid` is the process that has joined there, 0 if none has.
    pub fn ended(&mut self, slot: usize, pid: u32) -> Option<String> {
        let child = self.at(slot)?;
        if pid != 0 && pid != child.pid() && child.last_status().is_some() {
            return None;
        }
        child.ending()
    }

    /// Whether the program at `slot` has ended because of a wrong argument.
    pub(super) fn is_misused(&mut self, slot: usize) -> bool {
        self.at(slot).and_then(|r| r.last_status()?.code()) == Some(Exit::Usage as i32)
    }

    /// The file for all that the participant at `slot` prints, if the server
    /// started it.
    pub(super) fn output(&self, slot: usize) -> Option<&Path> {
        self.0.iter().find(|r| r.slot == slot).map(ChildProcess::output)
    }

    /// Ends what is left of the participant at `slot` and starts it once more,
    /// with `between` in between. Returns whether the server started it before.
    pub(super) fn restart(
        &mut self,
        slot: usize,
        between: impl FnOnce(),
    ) -> Result<bool, ChildrenError> {
        let Some(child) = self.at(slot) else { return Ok(false) };
        child.restart(between)?;
        Ok(true)
    }

    /// Waits for all to end by themselves after a run to its end, then ends the
    /// rest.
    pub fn finish_all(self) {
        self.finish(|_| Leaving::AtTheEnd);
    }

    /// Waits for all to end by themselves, then ends the rest. Returns those that
    /// did not end well: slot and how. The wait is short for a participant that
    /// never joined, or is known to be lost.
    pub(super) fn finish(mut self, how_left: impl Fn(usize) -> Leaving) -> Vec<(usize, String)> {
        let began = Instant::now();
        loop {
            let late = self.0.iter_mut().filter_map(|r| r.status().is_none().then_some(r.slot));
            let patience = late.map(|slot| how_left(slot).patience()).max();
            if patience.is_none_or(|patience| began.elapsed() >= patience) {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let bad = self.judge(&how_left, |_| false);
        for child in self.0.iter().filter(|child| !printed::has_content(child.output())) {
            let _ = fs::remove_file(child.output());
        }
        bad
    }

    /// Returns those that did not end well: slot and how. `asked` tells which processes
    /// have asked for the next run.
    pub(super) fn judge(
        &mut self,
        how_left: impl Fn(usize) -> Leaving,
        asked: impl Fn(u32) -> bool,
    ) -> Vec<(usize, String)> {
        let is_missed = |slot| matches!(how_left(slot), Leaving::AtTheEnd | Leaving::Aborted);
        let mut bad = Vec::new();
        for child in &mut self.0 {
            let slot = child.slot;
            match (child.ending(), child.last_status()) {
                (None, _) if !is_missed(slot) || asked(child.pid()) => {}
                (None, _) => bad.push((slot, "it did not end by itself".to_owned())),
                (Some(how), Some(status)) if how_left(slot).is_own_fault(status) => {
                    bad.push((slot, how));
                }
                _ => {}
            }
        }
        bad
    }

    /// Returns slot and process of those that have not ended, nor asked for the next run.
    pub(super) fn late(&mut self, asked: impl Fn(u32) -> bool) -> Vec<(usize, u32)> {
        let others = self.0.iter_mut().filter(|child| !asked(child.pid()));
        let late = others.filter_map(|child| child.status().is_none().then_some(&*child));
        late.map(|child| (child.slot, child.pid())).collect()
    }

    /// The processes that are known to have ended.
    pub(super) fn ended_processes(&self) -> Vec<u32> {
        let ended = self.0.iter().filter(|child| child.last_status().is_some());
        ended.map(ChildProcess::pid).collect()
    }

    /// Ends those that have not ended, nor asked for the next run.
    pub(super) fn end_late(&mut self, asked: impl Fn(u32) -> bool) {
        let late = self.0.iter_mut().filter(|r| !asked(r.pid()));
        late.for_each(|r| r.end_now());
    }

    /// Starts everyone once more for the next run who has not asked for it, or has ended
    /// since. Returns a remark for each of the latter.
    ///
    /// # Errors
    /// [`ChildrenError`] names the participant.
    pub(super) fn renew(
        &mut self,
        asked: impl Fn(u32) -> bool,
        between: impl Fn(),
    ) -> Result<Vec<String>, ChildrenError> {
        let mut remarks = Vec::new();
        for child in &mut self.0 {
            let (ending, asked) = (child.ending(), asked(child.pid()));
            if let (Some(how), true) = (&ending, asked) {
                let name = child.name();
                remarks.push(format!("{name}: between two runs, {how}; it was started again"));
            }
            if ending.is_some() || !asked {
                child.restart(&between)?;
            }
        }
        Ok(remarks)
    }
}
