//! A run from the first join to the last goodbye.
//!
//! [`Lockstep`] decides; this module does: it makes frames, moves them through
//! the link, listens, asks the kernel about processes, keeps the pace.

pub mod arguments;
mod children;
mod clock;
mod comeback;
mod group;
mod history;
mod limits;
mod listen;
mod pace;
mod printed;
mod program;
mod progress;
mod start;
mod stop;
mod wishes;

pub use arguments::with_folder;
pub use children::{Children, ChildrenError, Leaving, Spawn};
pub use children::{invite, open_talk, spawn_with_credentials};
pub use group::Groups;
pub use group::{exit_status, kill_group};
pub use limits::LimitError;
pub use limits::{check_limits, prepare_process};
pub use pace::Pace;
pub use printed::has_content;
pub use program::find_program;
pub use progress::Progress;
pub use start::RunSetup;
pub use stop::Stop;

use std::collections::BTreeSet;
use std::sync::atomic::Ordering;
use std::time::Instant;

use rusty_contract::tally::TallyEntry;
use rusty_contract::{Effects, OnLoss, Phase, RunDigest, Timing, TruthKey};
use rusty_link::{LinkError, Peer, PeerState, ServerLink, monotonic_ns};

use self::clock::{Clock, May};
use self::comeback::Feeding;
use self::history::History;
use self::wishes::PendingStep;
use crate::lockstep::{Lockstep, Loss, SeatSummary, Step};
use crate::source::{FrameSource, SourceError};

/// How often it hears at full speed what somebody has to say, in ticks.
const TICKS_BETWEEN_WISHES: u64 = 64;

/// How often the clock is read while nobody sleeps, in turns of the machine.
const TURNS_PER_CLOCK: u32 = 16;
/// From how long on waiting for the clock is done asleep.
const WORTH_SLEEPING_NS: u64 = 1_000_000;

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// How it ended.
    pub phase: Phase,
    /// Ticks that are complete.
    pub ticks: u64,
    /// Its digests.
    pub digest: RunDigest,
    /// What everyone did, in roster order.
    pub seats: Vec<SeatSummary>,
    /// Who was lost.
    pub losses: Vec<Loss>,
    /// Who was lost and came back.
    pub restarts: Vec<Loss>,
    /// What came of modelled compute times.
    pub timings: Vec<Timing>,
    /// What else there is to say of it.
    pub remarks: Vec<String>,
    /// The monotonic clock when the first frame went out, ns.
    pub first_frame_ns: Option<u64>,
    /// From the first frame to the last answer, s.
    pub elapsed_s: f64,
    /// Why the source ended early, if it did.
    pub source_error: Option<SourceError>,
}

/// A run in progress.
pub struct Run<'a> {
    setup: RunSetup,
    source: &'a mut dyn FrameSource,
    link: ServerLink,
    children: &'a mut Children,
    stop: &'a Stop,
    progress: Progress,
    lockstep: Lockstep,
    peers: Vec<Option<Peer>>,
    key: TruthKey,
    digest: RunDigest,
    /// The digests up to the last tick that is complete.
    closed: RunDigest,
    /// Which answers are in effect.
    effects: Effects,
    /// Whether the frame of the current tick has a scan.
    has_scan: bool,
    losses: Vec<Loss>,
    restarts: Vec<Loss>,
    remarks: Vec<String>,
    /// Replies so far, where somebody may come back.
    history: History,
    /// The run again, for those who came back.
    feedings: Vec<Option<Feeding>>,
    source_error: Option<SourceError>,
    began: Option<Instant>,
    first_frame_ns: Option<u64>,
    clock: Clock,
    /// Ticks whose frame is out.
    begun: u64,
    steps: Vec<PendingStep>,
    has_key_holders: bool,
    /// The last word is out.
    ended: bool,
    looks: u32,
    /// The monotonic clock, read a few turns ago at most.
    clock_ns: u64,
    turns: u32,
    /// This process has slept since.
    slept: bool,
    /// A forged answer was reported.
    forged: bool,
    /// Numbers of the control requests so far: each is carried out once.
    control_numbers: BTreeSet<u64>,
    refused: u32,
}

impl<'a> Run<'a> {
    /// A run over `link`, which waits for nobody yet. The link is made before
    /// any participant is started: one that is killed while it makes the first
    /// file of a domain leaves a name that nobody can use, the server included.
    #[must_use]
    pub fn new(
        setup: RunSetup,
        link: ServerLink,
        source: &'a mut dyn FrameSource,
        children: &'a mut Children,
        stop: &'a Stop,
        progress: Progress,
    ) -> Self {
        let header = source.header();
        let rules = setup.rules(source.ticks());
        let lockstep = Lockstep::new(rules, &header.roster, monotonic_ns());
        let seats = header.roster.len();
        let has_key_holders = header.roster.iter().any(|p| p.role.holds_key());
        let effects = Effects::of(header);
        let clock = Clock::new(setup.pace, setup.dt_s, setup.paused);
        Self {
            key: setup.key.clone(),
            setup,
            source,
            link,
            children,
            stop,
            progress,
            lockstep,
            peers: (0..seats).map(|_| None).collect(),
            digest: RunDigest::default(),
            closed: RunDigest::default(),
            effects,
            has_scan: false,
            losses: Vec::new(),
            restarts: Vec::new(),
            remarks: Vec::new(),
            history: History::default(),
            feedings: (0..seats).map(|_| None).collect(),
            source_error: None,
            began: None,
            first_frame_ns: None,
            clock,
            begun: 0,
            steps: Vec::new(),
            has_key_holders,
            ended: false,
            looks: 0,
            clock_ns: 0,
            turns: 0,
            slept: true,
            forged: false,
            control_numbers: BTreeSet::new(),
            refused: 0,
        }
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// [`LinkError`] if shared memory fails under the run.
    pub fn drive(mut self) -> Result<Outcome, LinkError> {
        loop {
            let now = self.now_ns();
            let peers = &self.peers;
            match self.lockstep.next(now, |seat| describe(peers[seat].as_ref())) {
                Step::Wait { until_ns } => self.listen(until_ns.saturating_sub(now))?,
                Step::Publish(tick) => self.publish(tick)?,
                Step::Close(tick) => self.close(tick)?,
                Step::Slow { seat, waited_ns } => {
                    let name = &self.lockstep.seats()[seat].name;
                    let what = describe(self.peers[seat].as_ref());
                    let seconds = waited_ns as f64 * 1e-9;
                    let missing = if self.ended {
                        "goodbye".to_owned()
                    } else {
                        format!("answer to tick {}", self.lockstep.ticks_done())
                    };
                    self.progress
                        .say(&format!("{name} is slow: no {missing} for {seconds:.1} s{what}"));
                }
                Step::Lost(loss) => {
                    self.progress.say(&format!("lost: {loss}{}", self.output(loss.seat)));
                    self.losses.push(loss);
                }
                Step::Restart(loss) => self.bring_back(loss),
                Step::Feed { seat, tick } => self.feed(seat, tick)?,
                Step::Echo { seat, tick, reply } => self.echo(seat, tick, reply),
                Step::End(phase) => self.end(phase)?,
                Step::Finished => break,
            }
        }
        Ok(self.outcome())
    }

    /// The monotonic clock, ns, or what it was a few turns ago: it costs as much
    /// as a look for answers, and what depends on it here are timeouts. Those
    /// may come a little later, never early.
    fn now_ns(&mut self) -> u64 {
        self.turns = self.turns.wrapping_add(1);
        if self.slept || self.turns.is_multiple_of(TURNS_PER_CLOCK) {
            self.slept = false;
            self.clock_ns = monotonic_ns();
        }
        self.clock_ns
    }

    fn publish(&mut self, tick: u64) -> Result<(), LinkError> {
        if tick.is_multiple_of(TICKS_BETWEEN_WISHES) {
            // At full speed the server never sleeps, so it looks now and then.
            self.take_wishes()?;
            self.take_joins()?;
        }
        if self.began.is_none() {
            self.link.reserve()?;
        }
        let may = self.clock.may(tick);
        if may != May::Now && !self.stop.flag().load(Ordering::Relaxed) {
            // The machine asks for this tick again. Whoever comes, fails or
            // dies meanwhile does not wait for the clock.
            let wait_ns = match may {
                May::In(early) => early.as_nanos() as u64,
                _ => {
                    self.progress.waits();
                    u64::MAX
                }
            };
            if wait_ns >= WORTH_SLEEPING_NS {
                self.link.rest();
            }
            return self.listen(wait_ns);
        }
        self.began.get_or_insert_with(Instant::now);
        self.progress.goes_on_at(tick);
        if self.stop.flag().load(Ordering::Relaxed) {
            self.lockstep.interrupt();
            return Ok(());
        }
        let mut frame = self.link.loan()?;
        let truth = match self.source.make(self.effects.command(), &mut frame) {
            Ok(truth) => truth,
            Err(e) => {
                self.end_for(e);
                return Ok(());
            }
        };
        frame.run_id = self.setup.run_id;
        frame.set_lost(self.lockstep.lost());
        self.has_scan = frame.ranges_m().is_some();
        frame.seal(&self.key, truth);
        self.digest.absorb_frame(&frame, truth);
        let digest = frame.digest();
        let now = self.link.publish(frame, joined(&self.lockstep))?;
        self.clock_ns = now;
        self.first_frame_ns.get_or_insert(now);
        self.lockstep.published(digest, now);
        self.clock.tick();
        self.begun = tick + 1;
        self.wake();
        Ok(())
    }

    /// The source has no more frames: the run ends, and says why.
    fn end_for(&mut self, error: SourceError) {
        self.progress.say(&error.to_string());
        self.source_error = Some(error);
        self.lockstep.abort();
    }

    /// Where all that a lost participant printed can be read, on a line.
    fn output(&self, seat: usize) -> String {
        let path = self.children.output(seat).filter(|path| has_content(path));
        path.map(|path| format!("\n    full output: {}", path.display())).unwrap_or_default()
    }

    fn wake(&self) {
        let waiting = self.lockstep.seats().iter().filter(|s| s.is_present());
        self.link.wake_sleepers(waiting.map(|s| (s.waiting_since_ns, s.awake_ns)));
    }

    fn close(&mut self, tick: u64) -> Result<(), LinkError> {
        let lockstep = &self.lockstep;
        self.digest.absorb_replies(lockstep.replies().map(|(_, reply)| reply));
        self.closed = self.digest;
        if self.setup.on_loss == OnLoss::Restart {
            self.history.push(lockstep.replies().map(|(_, reply)| reply));
        }
        self.effects.close(tick, self.has_scan, lockstep.replies().map(|(_, reply)| reply));
        let seats = lockstep.seats();
        self.source.closed(&mut lockstep.replies().map(|(i, r)| (seats[i].name.as_str(), r)));
        if self.has_key_holders {
            let (run_id, digest) = (self.setup.run_id, self.digest);
            self.link.publish_tally(|tally| {
                tally.begin(run_id, tick);
                tally.run_digest = digest.run();
                tally.world_digest = digest.world();
                for (i, _) in lockstep.replies() {
                    let seat = &seats[i];
                    tally.push(match seat.reply {
                        Some(_) => TallyEntry::answered(seat.last, seat.latency_ns),
                        None => TallyEntry::missing(i as u32),
                    });
                }
            })?;
        }
        self.progress.tick(tick + 1);
        self.reply_to_steps(tick + 1);
        Ok(())
    }

    fn end(&mut self, phase: Phase) -> Result<(), LinkError> {
        let mut frame = self.link.loan()?;
        frame.end(phase, self.lockstep.ticks_done());
        frame.run_id = self.setup.run_id;
        frame.set_lost(self.lockstep.lost());
        let digest = frame.digest();
        let now = self.link.publish(frame, joined(&self.lockstep))?;
        self.lockstep.published(digest, now);
        self.link.wake_all();
        self.ended = true;
        self.reply_to_steps(self.lockstep.ticks_done());
        self.progress.done();
        Ok(())
    }

    fn outcome(self) -> Outcome {
        Outcome {
            phase: self.lockstep.phase(),
            ticks: self.lockstep.ticks_done(),
            digest: self.closed,
            seats: self.lockstep.seats().iter().map(|s| s.summary()).collect(),
            losses: self.losses,
            restarts: self.restarts,
            timings: self.effects.timings(),
            remarks: self.remarks,
            first_frame_ns: self.first_frame_ns,
            elapsed_s: self.progress.elapsed_s(self.began),
            source_error: self.source_error,
        }
    }
}

/// The slots of the participants that have joined, the lost included: each of
/// them believes only a frame that is signed for it.
fn joined(lockstep: &Lockstep) -> impl Iterator<Item = usize> {
    lockstep.seats().iter().enumerate().filter(|(_, s)| s.pid != 0).map(|(slot, _)| slot)
}

/// What the kernel says of a participant, as the end of a sentence.
fn describe(peer: Option<&Peer>) -> String {
    match peer.map(|p| (p.pid(), p.state())) {
        None => String::new(),
        Some((pid, PeerState::Running)) => format!(" (process {pid} is running)"),
        Some((pid, PeerState::Stopped)) => {
            format!(" (process {pid} is stopped by a signal; `kill -CONT {pid}` lets it go on)")
        }
        Some((pid, PeerState::Dead)) => format!(" (process {pid} has ended)"),
    }
}
