//! `Crew`: the shared memory and the processes of a series of runs.
//!
//! A participant that stays sends its leave message at the end of a run, and then asks to
//! join the next one; the request waits until that begins, or the crew ends. The process
//! of a participant that does not ask ends, and is started again for the next run.

use std::path::Path;
use std::time::Instant;

use rusty_contract::{JoinReply, JoinRequest, MAX_PARTICIPANTS, Participant, Refusal, TruthKey};
use rusty_link::{Domain, JoinCall, LinkError, Peer, ServerLink};

use super::children::Leaving;
use super::participants::how_left;
use super::{Children, Outcome, Run, RunBuilder, RunError, RunIdentity, Stop};
use crate::source::FrameSource;

/// Requests for the next run that wait at a time.
const MOST_WAITING: usize = 2 * MAX_PARTICIPANTS;

/// What the runs of a series have in common but for shared memory and processes.
pub(super) struct Series {
    pub(super) options: RunBuilder,
    /// Of the first run.
    pub(super) run_id: u64,
    /// The key from which those of all runs derive.
    pub(super) key: TruthKey,
    /// Whether one of the participants is confined.
    pub(super) check_frames: bool,
    /// Number of the current run, from 0.
    number: u64,
    waiting: Vec<Waiting>,
}

/// A participant that has asked for the next run.
struct Waiting {
    pid: u32,
    call: JoinCall,
}

impl Series {
    pub(super) fn new(
        options: RunBuilder,
        (run_id, key): (u64, TruthKey),
        check_frames: bool,
    ) -> Self {
        Self { options, run_id, key, check_frames, number: 0, waiting: Vec::new() }
    }
}

/// Shared memory and participants, of which one run after the other is made. Its fields
/// are dropped in this order, as those of a [`Run`].
pub struct Crew {
    pub(super) series: Series,
    pub(super) link: ServerLink,
    pub(super) children: Children,
    pub(super) stop: Stop,
    pub(super) domain: Domain,
}

impl Crew {
    /// Begins the run of `source`, whose roster is that of the crew. Participants are told
    /// whether there may be more runs.
    pub(super) fn begin<'a>(
        mut self,
        source: &'a mut dyn FrameSource,
        out_dir: &Path,
        more_runs: bool,
    ) -> Result<Run<'a>, RunError> {
        let (options, number) = (&self.series.options, self.series.number);
        let identity = RunIdentity {
            run_id: if number == 0 { self.series.run_id } else { getrandom::u64()? },
            key: self.series.key.of_run(number),
            wait: options.wait,
            out_dir: out_dir.to_owned(),
            check_frames: self.series.check_frames,
            report: options.report,
            more_runs,
            run_number: number,
        };
        self.link.begin_run(identity.key.clone());
        let waiting = std::mem::take(&mut self.series.waiting);
        let mut remarks = Vec::new();
        if number > 0 {
            let (link, asked) = (&self.link, |pid| waiting.iter().any(|w| w.pid == pid));
            remarks = self.children.renew(asked, || link.forget_the_dead())?;
        }
        let mut run = Run::new(self, identity, source);
        run.ledger.remarks = remarks;
        let processes = run.processes();
        for Waiting { call, .. } in waiting.into_iter().filter(|w| processes.contains(&w.pid)) {
            run.admit(call)?;
        }
        run.wire.link.wake_all();
        Ok(run)
    }

    /// Makes the run of `source`, whose roster is that of the crew, up to where each process
    /// has ended or asked for the next run. Scorers and loggers write to `out_dir`.
    ///
    /// # Errors
    /// [`RunError`]; the participants are ended.
    pub fn run(
        self,
        source: &mut dyn FrameSource,
        out_dir: &Path,
    ) -> Result<(Outcome, Self), RunError> {
        let mut run = self.begin(source, out_dir, true)?;
        while !run.finished {
            run.step()?;
        }
        let ended_badly = run.settle()?;
        let Run { lockstep, wire, pacer, ledger, participants, progress, control, .. } = run;
        control.finish();
        let outputs = participants.outputs();
        let mut series = run.series;
        series.number += 1;
        let (link, children) = (wire.link, participants.children);
        let crew = Self { series, link, children, stop: run.stop, domain: run.domain };
        let done = Outcome::new(lockstep, pacer, ledger, &progress, (outputs, ended_badly));
        Ok((done, crew))
    }

    /// How many runs it has made.
    #[must_use]
    pub fn runs(&self) -> u64 {
        self.series.number
    }

    /// Names of those in its roster whose processes have asked for the next run.
    #[must_use]
    pub fn stayed(&self, roster: &[Participant]) -> Vec<String> {
        let waits = |pid| self.series.waiting.iter().any(|w| w.pid == pid);
        let slots = self.children.slots().filter(|(_, pid)| waits(*pid));
        slots.filter_map(|(slot, _)| Some(roster.get(slot)?.name.clone())).collect()
    }

    /// Refuses all requests for a next run, and waits for all
    /// processes to end. Returns those that did not end well: slot and how.
    pub fn finish(mut self) -> Vec<(usize, String)> {
        let waits = |pid: &u32| self.series.waiting.iter().any(|w| w.pid == *pid);
        let all = self.children.slots();
        let stayed: Vec<usize> = all.filter(|(_, pid)| waits(pid)).map(|(slot, _)| slot).collect();
        for Waiting { call, .. } in self.series.waiting.drain(..) {
            // A process that has ended needs no reply.
            let _ = call.reply(&JoinReply::Refused(Refusal::NoMoreRuns));
        }
        self.link.wake_all();
        // Their replies are in the shared memory of the server. How the others ended was
        // returned with their last run.
        self.children.finish(|slot| match stayed.contains(&slot) {
            true => Leaving::AtTheEnd,
            false => Leaving::Dead,
        })
    }
}

impl Run<'_> {
    /// Whether this is the request of a participant that has taken part to the end and asks
    /// for the next run.
    pub(super) fn is_for_next_run(&self, request: &JoinRequest) -> bool {
        let slots = self.lockstep.slots();
        self.identity.more_runs
            && request.after_run == self.identity.run_id
            && self.lockstep.has_ended()
            && self.series.waiting.len() < MOST_WAITING
            && slots.iter().any(|s| s.name == request.name && s.pid == request.pid)
    }

    /// Keeps a request for the next run until that begins.
    pub(super) fn keep_for_next_run(&mut self, pid: u32, call: JoinCall) {
        self.series.waiting.push(Waiting { pid, call });
    }

    /// Waits until each process that the server started has asked for the next run or has
    /// ended, and ends the rest. Returns those that did not end well: slot and how.
    fn settle(&mut self) -> Result<Vec<(usize, String)>, LinkError> {
        let phase = self.lockstep.phase();
        let slots: Vec<_> = self.lockstep.slots().iter().map(|s| s.summary()).collect();
        let leaving = |slot: usize| how_left(phase, &slots[slot]);
        let began = Instant::now();
        loop {
            self.take_joins()?;
            let Self { participants, series, wire, .. } = &mut *self;
            let asked = |pid| series.waiting.iter().any(|w| w.pid == pid);
            let late = participants.children.late(asked);
            let patience = late.iter().map(|(slot, _)| leaving(*slot).patience()).max();
            let left = patience.and_then(|time| time.checked_sub(began.elapsed()));
            let Some(left) = left.filter(|left| !left.is_zero()) else { break };
            for (slot, pid) in &late {
                // One that never joined is watched as well.
                participants.peers[*slot].get_or_insert_with(|| Peer::new(*pid));
            }
            let peers = &participants.peers;
            let peers = || late.iter().filter_map(|(slot, _)| peers[*slot].as_ref());
            wire.pause(true, peers, left.as_nanos() as u64);
        }
        let Self { participants, series, .. } = &mut *self;
        let children = &mut participants.children;
        let asked = |pid| series.waiting.iter().any(|w| w.pid == pid);
        let bad = children.judge(leaving, asked);
        children.end_late(asked);
        // One that has asked and ended since is judged by now, and will be started again.
        let ended = children.ended_processes();
        series.waiting.retain(|w| !ended.contains(&w.pid));
        Ok(bad)
    }
}
