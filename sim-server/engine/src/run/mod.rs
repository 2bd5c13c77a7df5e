//! A run from the first join to the last answer.
//!
//! [`Lockstep`] decides; this module acts: it makes frames, moves them through
//! shared memory, receives answers, watches processes, keeps the pace. A run has
//! four parts:
//!
//! * `wire`: the shared memory, and the clock that is read next to it;
//! * `pacer`: when the next tick may happen;
//! * `ledger`: digests, replies and losses so far;
//! * `participants`: their processes.
//!
//! A [`Crew`] makes one run after the other with the same shared memory and processes.

mod ahead;
mod arguments;
mod catch_up;
mod child;
mod children;
mod control;
mod crew;
mod error;
mod group;
mod history;
mod ledger;
mod limits;
mod listen;
mod pacer;
mod participants;
mod printed;
mod program;
mod progress;
mod setup;
mod stop;
mod together;
mod wire;

pub use arguments::{OUT, with_folder};
pub use child::{ChildProcess, ChildrenError, Spawn};
pub use children::Children;
pub use crew::Crew;
pub use error::RunError;
pub use group::{Groups, kill_group};
pub use limits::{LimitError, check_limits, prepare_process};
pub use pacer::Pace;
pub use printed::has_content;
pub use program::{check_programs, find_program};
pub use progress::Progress;
pub use setup::{PreparedRun, RunBuilder, RunIdentity, fresh_name};
pub use stop::Stop;

use std::path::PathBuf;
use std::time::Instant;

use rusty_contract::{OnLoss, Participant, Phase, RunDigest, RunName, Timing};
use rusty_link::{Domain, LinkError, monotonic_ns};

use self::ahead::Ahead;
use self::control::Control;
use self::crew::Series;
use self::ledger::Ledger;
use self::pacer::{May, Pacer};
use self::participants::Participants;
use self::wire::Wire;
use crate::lockstep::{Lockstep, Loss, ParticipantSummary, Rules, Step};
use crate::source::{FrameSource, SourceError};

/// Ticks between two looks at requests, for a server at full speed.
const TICKS_PER_CONTROL: u64 = 64;
/// How long a participant may take after the last frame: a scorer draws.
const LEAVE_TIMEOUT_S: f64 = 60.0;
/// The same where the run ends early.
const EARLY_LEAVE_TIMEOUT_S: f64 = 15.0;
/// From when on a missing answer is reported.
const SLOW_AFTER_S: f64 = 1.0;

/// The outcome of a run.
#[derive(Debug)]
pub struct Outcome {
    /// How it ended.
    pub phase: Phase,
    /// Ticks that are complete.
    pub ticks: u64,
    /// Its digests.
    pub digest: RunDigest,
    /// What everyone did, in roster order.
    pub slots: Vec<ParticipantSummary>,
    /// Participants that were lost.
    pub losses: Vec<Loss>,
    /// Participants that were lost and came back.
    pub restarts: Vec<Loss>,
    /// Effects of modelled compute times.
    pub timings: Vec<Timing>,
    /// Other remarks.
    pub remarks: Vec<String>,
    /// The monotonic clock when the first frame was published, ns.
    pub first_frame_ns: Option<u64>,
    /// From the first frame to the last answer, s.
    pub elapsed_s: f64,
    /// Why the source ended early, if it did.
    pub source_error: Option<SourceError>,
    /// Participants that ended badly after the run: slot and how.
    pub ended_badly: Vec<(usize, String)>,
    /// The files for what participants print, of those that the server started.
    pub outputs: Vec<(usize, PathBuf)>,
}

/// A run in progress. Its fields are dropped in this order: the participants end
/// after the shared memory is closed, and before its traces are removed.
pub struct Run<'a> {
    source: &'a mut dyn FrameSource,
    ahead: Ahead,
    identity: RunIdentity,
    lockstep: Lockstep,
    series: Series,
    wire: Wire,
    pacer: Pacer,
    ledger: Ledger,
    participants: Participants,
    control: Control,
    stop: Stop,
    progress: Progress,
    /// The run that sets the pace, where robots share a world and it is not this one.
    leader: Option<RunName>,
    finished: bool,
    domain: Domain,
}

impl<'a> Run<'a> {
    /// A run of this crew, which waits for no participant yet.
    fn new(crew: Crew, identity: RunIdentity, source: &'a mut dyn FrameSource) -> Self {
        let Crew { series, link, children, stop, domain } = crew;
        let options = &series.options;
        let (header, ticks) = (source.header(), source.tick_count());
        let rules = rules(options, identity.run_id, ticks, header.on_loss);
        Self {
            lockstep: Lockstep::new(rules, &header.roster, monotonic_ns()),
            wire: Wire::new(link),
            pacer: Pacer::new(options.pace, header.config.dt_s, options.paused),
            ledger: Ledger::new(identity.run_id, header),
            participants: Participants::new(children, header.roster.len(), options.join_timeout_s),
            control: Control::default(),
            stop,
            progress: Progress::new(ticks, options.quiet || options.leader.is_some())
                .about(options.robot.as_deref()),
            ahead: Ahead::new(),
            leader: options.leader.clone(),
            finished: false,
            domain,
            identity,
            series,
            source,
        }
    }

    /// The processes that the server started, in roster order.
    #[must_use]
    pub fn processes(&self) -> Vec<u32> {
        self.participants.children.processes().collect()
    }

    /// Runs to the end, and waits for the participants to end.
    ///
    /// # Errors
    /// [`LinkError`] if shared memory fails under the run.
    pub fn drive(mut self) -> Result<Outcome, LinkError> {
        while !self.finished {
            self.step()?;
        }
        Ok(self.outcome())
    }

    /// Does what comes next. Returns false if that was to wait, and nothing came.
    fn step(&mut self) -> Result<bool, LinkError> {
        let now = self.wire.now_ns();
        let participants = &self.participants;
        match self.lockstep.next(now, |slot| participants.describe(slot)) {
            Step::Wait { until_ns } => return self.listen(until_ns.saturating_sub(now)),
            Step::Publish(tick) => return self.publish(tick),
            Step::Close(tick) => self.close(tick)?,
            Step::Slow { slot, waited_ns } => self.report_slow(slot, waited_ns),
            Step::Lost(loss) => {
                let output = self.participants.output(loss.slot);
                self.progress.say(&format!("lost: {loss}{output}"));
                self.ledger.losses.push(loss);
            }
            Step::Restart(loss) => self.bring_back(loss),
            Step::Feed { slot, tick } => self.feed(slot, tick)?,
            Step::Echo { slot, tick, reply } => self.echo(slot, tick, reply),
            Step::End(phase) => self.end(phase)?,
            Step::Finished => self.finished = true,
        }
        Ok(true)
    }

    fn report_slow(&self, slot: usize, waited_ns: u64) {
        let name = &self.lockstep.slots()[slot].name;
        let missing = if self.lockstep.has_ended() {
            "leave message".to_owned()
        } else {
            format!("answer to tick {}", self.lockstep.ticks_done())
        };
        let (seconds, state) = (waited_ns as f64 * 1e-9, self.participants.describe(slot));
        self.progress.say(&format!("{name} is slow: no {missing} for {seconds:.1} s{state}"));
    }

    fn publish(&mut self, tick: u64) -> Result<bool, LinkError> {
        if tick.is_multiple_of(TICKS_PER_CONTROL) {
            // At full speed the server never sleeps, so it looks now and then.
            self.take_requests()?;
            self.take_joins()?;
        }
        let is_stopped = self.stop.is_raised();
        let may = self.pacer.may(tick);
        if may != May::Now && !is_stopped {
            // The machine asks for this tick again. Joins, failures and deaths in
            // the meantime do not wait for the clock.
            let wait_ns = match may {
                May::In(early) => early.as_nanos() as u64,
                _ => {
                    self.progress.waits();
                    u64::MAX
                }
            };
            self.wire.rest(wait_ns);
            return self.listen(wait_ns);
        }
        if is_stopped {
            self.pacer.began.get_or_insert_with(Instant::now);
            self.lockstep.interrupt();
            return Ok(true);
        }
        let command = self.ledger.chain.effects.command();
        match self.source.is_ready(command) {
            Ok(true) => {}
            // Another robot's answers are missing.
            Ok(false) => return self.listen(u64::MAX),
            Err(e) => {
                self.end_for(e);
                return Ok(true);
            }
        }
        if self.pacer.began.is_none() {
            // During a pause another participant may have joined.
            self.wire.link.reserve()?;
            self.pacer.began = Some(Instant::now());
        }
        self.progress.goes_on_at(tick);
        let mut frame = self.wire.link.loan()?;
        let truth = match self.ahead.make(self.source, command, &mut frame, &self.identity.key) {
            Ok(truth) => truth,
            Err(e) => {
                self.end_for(e);
                return Ok(true);
            }
        };
        frame.run_id = self.identity.run_id;
        frame.set_lost(self.lockstep.lost());
        self.ledger.chain.frame(&frame, truth);
        let digest = frame.digest();
        let now = self.wire.publish(frame, self.lockstep.joined())?;
        self.lockstep.published(digest, now);
        self.pacer.published(tick, now);
        let waiting = self.lockstep.slots().iter().filter(|s| s.is_present());
        self.wire.link.wake_sleepers(waiting.map(|s| (s.waiting_since_ns, s.awake_ns)));
        // With a pace to keep there is time after the answers.
        if self.series.options.overlap
            && !self.pacer.has_pace()
            && tick + 1 < self.source.tick_count()
        {
            self.ahead.prepare(self.source, &self.identity.key);
        }
        Ok(true)
    }

    /// Ends the run because the source has no more frames.
    fn end_for(&mut self, error: SourceError) {
        self.progress.say(&error.to_string());
        self.ledger.source_error = Some(error);
        self.lockstep.abort();
    }

    fn close(&mut self, tick: u64) -> Result<(), LinkError> {
        let lockstep = &self.lockstep;
        self.ledger.close(tick, lockstep);
        let slots = lockstep.slots();
        self.source.closed(&mut lockstep.replies().map(|(i, r)| (slots[i].name.as_str(), r)));
        if let Some(write) = self.ledger.tally(tick, lockstep) {
            self.wire.link.publish_tally(write)?;
        }
        self.progress.tick(tick + 1);
        self.reply_to_steps(tick + 1);
        Ok(())
    }

    fn end(&mut self, phase: Phase) -> Result<(), LinkError> {
        let mut frame = self.wire.link.loan()?;
        frame.end(phase, self.lockstep.ticks_done());
        self.source.ended(self.lockstep.ticks_done());
        frame.run_id = self.identity.run_id;
        frame.set_lost(self.lockstep.lost());
        let digest = frame.digest();
        let now = self.wire.publish(frame, self.lockstep.joined())?;
        self.lockstep.published(digest, now);
        self.wire.link.wake_all();
        self.reply_to_steps(self.lockstep.ticks_done());
        self.progress.done();
        Ok(())
    }

    fn outcome(self) -> Outcome {
        let Self { lockstep, wire, pacer, ledger, participants, progress, control, .. } = self;
        control.finish();
        drop(wire);
        let slots: Vec<ParticipantSummary> = lockstep.slots().iter().map(|s| s.summary()).collect();
        let outputs = participants.outputs();
        let ended_badly = participants.finish(lockstep.phase(), &slots);
        Outcome::new(lockstep, pacer, ledger, &progress, (outputs, ended_badly))
    }
}

/// Something of some participants, by slot.
type BySlot<T> = Vec<(usize, T)>;

impl Outcome {
    /// Returns what there is to remark, in words: participants that ended badly, and why
    /// the run ended early.
    #[must_use]
    pub fn remarks(&self, roster: &[Participant]) -> Vec<String> {
        let badly = self.ended_badly.iter();
        let badly = badly.map(|(slot, how)| format!("{}: {how}", roster[*slot].name));
        let early = self.source_error.iter().map(ToString::to_string);
        badly.chain(self.remarks.iter().cloned()).chain(early).collect()
    }

    fn new(
        lockstep: Lockstep,
        pacer: Pacer,
        ledger: Ledger,
        progress: &Progress,
        (outputs, ended_badly): (BySlot<PathBuf>, BySlot<String>),
    ) -> Self {
        Self {
            phase: lockstep.phase(),
            ticks: lockstep.ticks_done(),
            digest: ledger.closed,
            slots: lockstep.slots().iter().map(|s| s.summary()).collect(),
            losses: ledger.losses,
            restarts: ledger.restarts,
            timings: ledger.chain.effects.timings(),
            remarks: ledger.remarks,
            first_frame_ns: pacer.first_frame_ns,
            elapsed_s: progress.elapsed_s(pacer.began),
            source_error: ledger.source_error,
            ended_badly,
            outputs,
        }
    }
}

fn rules(options: &RunBuilder, run_id: u64, ticks: u64, on_loss: OnLoss) -> Rules {
    let ns = |seconds: f64| (seconds * 1e9) as u64;
    let answer_s = options.answer_timeout_s;
    Rules {
        run_id,
        ticks,
        on_loss,
        join_timeout_ns: ns(options.join_timeout_s),
        answer_timeout_ns: ns(answer_s),
        leave_timeout_ns: ns(answer_s.max(LEAVE_TIMEOUT_S)),
        early_leave_timeout_ns: ns(EARLY_LEAVE_TIMEOUT_S),
        slow_after_ns: ns(SLOW_AFTER_S.min(answer_s / 2.0)),
    }
}
