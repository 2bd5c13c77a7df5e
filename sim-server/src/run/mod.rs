//! A run from the first join to the last goodbye.
//!
//! [`Lockstep`] decides; this module does: it makes frames, moves them through
//! the link, listens, asks the kernel about processes, keeps the pace.

mod children;
mod pace;
mod progress;
mod start;
mod stop;

pub use children::{Children, ChildrenError, Spawn};
pub use pace::Pace;
pub use progress::Progress;
pub use start::RunSetup;
pub use stop::Stop;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rusty_contract::tally::TallyEntry;
use rusty_contract::{JoinReply, Phase, RunDigest, TruthKey};
use rusty_geometry::Twist;
use rusty_link::{JoinCall, LinkError, Peer, PeerState, ServerLink, monotonic_ns};

use crate::lockstep::{Lockstep, Loss, SeatState, SeatSummary, Step};
use crate::source::{FrameSource, SourceError};

/// How often a server that never sleeps looks for deaths and new faces, in
/// looks at the data.
const LOOKS_BETWEEN_CHECKS: u32 = 4096;

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
    stop: &'a AtomicBool,
    progress: Progress,
    lockstep: Lockstep,
    peers: Vec<Option<Peer>>,
    key: TruthKey,
    digest: RunDigest,
    /// The digests up to the last tick that is complete.
    closed: RunDigest,
    driver: Option<Twist>,
    losses: Vec<Loss>,
    source_error: Option<SourceError>,
    began: Option<Instant>,
    has_key_holders: bool,
    /// The last word is out.
    ended: bool,
    looks: u32,
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
        stop: &'a AtomicBool,
        progress: Progress,
    ) -> Self {
        let header = source.header();
        let rules = setup.rules(source.ticks());
        let lockstep = Lockstep::new(rules, &header.roster, monotonic_ns());
        let seats = header.roster.len();
        let has_key_holders = header.roster.iter().any(|p| p.role.holds_key());
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
            driver: None,
            losses: Vec::new(),
            source_error: None,
            began: None,
            has_key_holders,
            ended: false,
            looks: 0,
        }
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// [`LinkError`] if shared memory fails under the run.
    pub fn drive(mut self) -> Result<Outcome, LinkError> {
        loop {
            let now = monotonic_ns();
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
                    self.progress.say(&format!("lost: {loss}"));
                    self.losses.push(loss);
                }
                Step::End(phase) => self.end(phase)?,
                Step::Finished => break,
            }
        }
        Ok(self.outcome())
    }

    fn publish(&mut self, tick: u64) -> Result<(), LinkError> {
        let began = *self.began.get_or_insert_with(Instant::now);
        let due = self.setup.pace.due(tick, self.setup.dt_s);
        let early = due.and_then(|due| due.checked_sub(began.elapsed())).unwrap_or_default();
        if !early.is_zero() && !self.stop.load(Ordering::Relaxed) {
            // The machine asks for this tick again. Whoever comes, fails or
            // dies meanwhile does not wait for the clock.
            return self.listen(early.as_nanos() as u64);
        }
        if self.stop.load(Ordering::Relaxed) {
            self.lockstep.interrupt();
            return Ok(());
        }
        let mut frame = self.link.loan()?;
        let truth = match self.source.make(self.driver, &mut frame) {
            Ok(truth) => truth,
            Err(e) => {
                self.progress.say(&e.to_string());
                self.source_error = Some(e);
                self.lockstep.abort();
                return Ok(());
            }
        };
        frame.run_id = self.setup.run_id;
        frame.set_lost(self.lockstep.lost());
        frame.seal(&self.key, truth);
        self.digest.absorb_frame(&frame, truth);
        let digest = frame.digest();
        let now = self.link.publish(frame)?;
        self.lockstep.published(digest, now);
        self.wake();
        Ok(())
    }

    fn wake(&self) {
        let waiting = self.lockstep.seats().iter().filter(|s| s.is_present());
        self.link.wake_sleepers(waiting.map(|s| (s.waiting_since_ns, s.awake_ns)));
    }

    fn close(&mut self, tick: u64) -> Result<(), LinkError> {
        let lockstep = &self.lockstep;
        self.digest.absorb_replies(lockstep.replies().map(|(_, reply)| reply));
        self.closed = self.digest;
        self.driver = lockstep.driver_command();
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
        Ok(())
    }

    fn end(&mut self, phase: Phase) -> Result<(), LinkError> {
        let mut frame = self.link.loan()?;
        frame.end(phase, self.lockstep.ticks_done());
        frame.run_id = self.setup.run_id;
        frame.set_lost(self.lockstep.lost());
        let digest = frame.digest();
        let now = self.link.publish(frame)?;
        self.lockstep.published(digest, now);
        self.link.wake_all();
        self.ended = true;
        self.progress.done();
        Ok(())
    }

    fn listen(&mut self, at_most_ns: u64) -> Result<(), LinkError> {
        if self.take_answers()? > 0 {
            return Ok(());
        }
        let (peers, seats) = (&self.peers, self.lockstep.seats());
        // One whose end is known would end every wait at once.
        let present = || peers.iter().zip(seats).filter(|(_, s)| s.is_present());
        let at_most = Duration::from_nanos(at_most_ns);
        let blocked = self.link.pause(|| present().filter_map(|(p, _)| p.as_ref()), at_most);
        self.looks = self.looks.wrapping_add(1);
        if blocked
            || self.looks.is_multiple_of(LOOKS_BETWEEN_CHECKS)
            || self.lockstep.is_gathering()
        {
            self.take_joins()?;
            self.look_for_deaths()?;
            if self.stop.load(Ordering::Relaxed) {
                self.lockstep.interrupt();
            }
        }
        Ok(())
    }

    fn take_answers(&mut self) -> Result<usize, LinkError> {
        let mut taken = 0;
        while let Some(answer) = self.link.next_answer()? {
            self.lockstep.answer(&answer, monotonic_ns());
            taken += 1;
        }
        Ok(taken)
    }

    fn take_joins(&mut self) -> Result<(), LinkError> {
        while let Some(call) = self.link.next_join()? {
            self.admit(call);
            self.link.wake_all();
        }
        Ok(())
    }

    fn admit(&mut self, call: JoinCall) {
        let seated = call.request().and_then(|r| self.lockstep.join(&r).map(|seat| (seat, r)));
        let reply = match seated {
            Ok((seat, request)) => {
                self.peers[seat] = Some(Peer::new(request.pid));
                JoinReply::Start(Box::new(self.setup.start(self.source.header(), seat)))
            }
            Err(refusal) => {
                self.progress.say(&format!("refused a client: {refusal}"));
                JoinReply::Refused(refusal)
            }
        };
        if let Err(e) = call.reply(&reply) {
            // The caller is gone; if it had a seat, its death shows next.
            self.progress.say(&format!("a client left while it was being answered ({e})"));
        }
    }

    fn look_for_deaths(&mut self) -> Result<(), LinkError> {
        for seat in 0..self.peers.len() {
            if matches!(self.lockstep.seats()[seat].state, SeatState::Left | SeatState::Lost(_)) {
                continue;
            }
            // A seat that was taken again by hand is no longer the child's.
            let pid = self.lockstep.seats()[seat].pid;
            let child = self.children.ended(seat, pid);
            let joined_dead = self.peers[seat].as_ref().is_some_and(Peer::is_dead);
            if child.is_none() && !joined_dead {
                continue;
            }
            // What it said before it ended still counts.
            self.take_answers()?;
            let how = child.unwrap_or_else(|| "its process has ended".to_owned());
            self.lockstep.died(seat, &how);
        }
        Ok(())
    }

    fn outcome(self) -> Outcome {
        Outcome {
            phase: self.lockstep.phase(),
            ticks: self.lockstep.ticks_done(),
            digest: self.closed,
            seats: self.lockstep.seats().iter().map(|s| s.summary()).collect(),
            losses: self.losses,
            elapsed_s: self.progress.elapsed_s(self.began),
            source_error: self.source_error,
        }
    }
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
