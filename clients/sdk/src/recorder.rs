//! `Recorder`: a scorer or logger as a type, and the loop that runs it.
//!
//! A recorder holds the key. It acknowledges every frame at once and works on a
//! tick when the answers to it are in, which is while the estimators work on
//! the next one.

use rustix::process::{DumpableBehavior, set_dumpable_behavior};
use rusty_contract::tally::TallyEntry;
use rusty_contract::{BeliefHeader, Brief, Exit, Frame, Phase, Reply, RunDigest, Start, errln};
use rusty_contract::{Tally, TruthKey, WeightedPose};
use rusty_geometry::SE2;
use rusty_link::{BorrowedTally, LinkError};

use crate::held_frame::FrameHandle;
use crate::run::{conclude, every_run};
use crate::tick::Answering as _;
use crate::{ClientArgs, ClientError, Session};

/// A complete tick: the frame, the truth, and what everyone answered.
pub struct Step<'a> {
    /// The frame, where it lies.
    pub frame: &'a Frame,
    /// True pose in the world frame, where known.
    pub truth: Option<SE2>,
    /// Replies of the answering participants, in roster order.
    pub replies: &'a [Reply],
    /// How long each of them took; `None` where none came. Empty for a log,
    /// which does not say.
    pub delays: &'a [Option<Delay>],
    /// The digests up to and with this tick, computed by this process.
    pub digest: RunDigest,
}

/// How long an answer took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delay {
    /// From taking the frame to sending the answer, ns, as the participant says.
    pub reported_ns: u64,
    /// From publishing the frame to the answer's arrival, ns, as the server saw.
    pub observed_ns: u64,
}

/// A participant that is shown everything and answers nothing.
pub trait Recorder: Sized {
    /// Looks at a belief that a filter showed; scorers get those that came in
    /// time, somewhere between the ticks. Anything may be in it.
    fn belief(&mut self, header: &BeliefHeader, poses: &mut Vec<WeightedPose>) {
        let _ = (header, poses);
    }

    /// Looks at one complete tick.
    ///
    /// # Errors
    /// Whatever keeps it from working; the server is told.
    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError>;

    /// The run is over.
    ///
    /// # Errors
    /// Whatever kept it from finishing; the server is told.
    fn finish(self, ending: Ending) -> Result<Exit, ClientError>;
}

/// How a run ended for a recorder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The server said so; every tick it made was seen.
    Told(Phase),
    /// The log it reads is complete.
    LogEnd,
    /// The log it reads was cut off.
    LogCut,
    /// The server has ended without an end of run, the run went on without this
    /// participant, or this process was asked to stop.
    Broken,
}

impl Ending {
    /// The exit code of a participant that has nothing else to report.
    #[must_use]
    pub fn exit(self) -> Exit {
        match self {
            Self::Broken | Self::LogCut => Exit::Lost,
            Self::Told(_) | Self::LogEnd => Exit::Done,
        }
    }
}

/// Runs a recorder to the end of a run or log, or of the last run where the server offers
/// several to one process. `begin` makes it, anew for each run, from everything that
/// is known of the run.
pub fn run_recorder<W: Recorder>(
    args: &ClientArgs,
    begin: impl FnMut(&Start, &Brief) -> Result<W, ClientError>,
) -> Exit {
    // It will hold the key and the truth: no core dumps, and no other process
    // of this user reads its memory. Where that cannot be had, it goes on.
    let _ = set_dumpable_behavior(DumpableBehavior::NotDumpable);
    conclude(args, drive(args, begin))
}

fn drive<W: Recorder>(
    args: &ClientArgs,
    mut begin: impl FnMut(&Start, &Brief) -> Result<W, ClientError>,
) -> Result<Exit, ClientError> {
    every_run(&mut Session::enter(args)?, |run| {
        watch(run, args, &mut begin).inspect_err(|_| run.fail())
    })
}

fn watch<W: Recorder>(
    session: &mut Session,
    args: &ClientArgs,
    begin: impl FnOnce(&Start, &Brief) -> Result<W, ClientError>,
) -> Result<Exit, ClientError> {
    let (key, brief) = session.brief(args)?;
    let answering = brief.header.answering().count();
    let mut recorder = begin(session.start(), &brief)?;
    let mut state = State {
        key,
        digest: RunDigest::default(),
        replies: Vec::with_capacity(answering),
        delays: Vec::with_capacity(answering),
        poses: Vec::new(),
        tally: Box::default(),
    };
    let mut waiting: Option<FrameHandle> = None;
    let broken = loop {
        let frame = match session.next_frame() {
            Ok(frame) => frame,
            Err(ClientError::Link(
                e @ (LinkError::ServerGone { .. } | LinkError::Dropped { .. } | LinkError::Stopped),
            )) => break Some(e),
            Err(e) => return Err(e),
        };
        if let Some(frame) = &frame {
            session.reply(frame, Reply::Taken)?;
        }
        // The answers to the frame before this one are in by now.
        if let Some(frame) = waiting.take() {
            complete(session, &mut recorder, &mut state, &frame)?;
        }
        match frame {
            Some(frame) if session.recorded_replies().is_some() => {
                complete(session, &mut recorder, &mut state, &frame)?;
            }
            Some(frame) => waiting = Some(frame),
            None => break None,
        }
    };
    if let Some(e) = &broken {
        errln!("{}: {e}", args.name());
        // The last tick counts if it was completed before the end.
        let _ = waiting.map(|frame| complete(session, &mut recorder, &mut state, &frame));
    }
    let ending = match (broken, session.ending()) {
        (Some(_), _) | (None, None) => Ending::Broken,
        (None, Some(_)) if session.is_behind() => Ending::Broken,
        (None, Some(_)) if session.log_is_broken() => Ending::LogCut,
        (None, Some(_)) if session.recorded_replies().is_some() => Ending::LogEnd,
        (None, Some(phase)) => Ending::Told(phase),
    };
    recorder.finish(ending)
}

struct State {
    key: TruthKey,
    digest: RunDigest,
    replies: Vec<Reply>,
    delays: Vec<Option<Delay>>,
    /// Those of a belief.
    poses: Vec<WeightedPose>,
    /// That of the tick, deciphered: in shared memory it stays enciphered.
    tally: Box<Tally>,
}

/// The most beliefs taken in a tick: a filter that shows without end does not hold it up.
const BELIEFS_AT_ONCE: usize = 64;

fn complete<W: Recorder>(
    session: &mut Session,
    recorder: &mut W,
    state: &mut State,
    frame: &FrameHandle,
) -> Result<(), ClientError> {
    if frame.observable_digest() != frame.digest() {
        return Err(ClientError::Unusable(format!(
            "tick {}: the frame's bytes do not have the digest it carries; do not trust this run",
            frame.tick()
        )));
    }
    let truth = frame.open_truth(&state.key)?.map(|t| t.pose_in_world());
    state.digest.absorb_frame(frame, truth);
    let mut expected = None;
    state.delays.clear();
    if let Some(recorded) = session.recorded_replies() {
        state.replies.clear();
        state.replies.extend_from_slice(recorded);
    } else {
        let Some(sealed) = tally_of(session, frame)? else {
            // The run was aborted in the middle of this tick: it does not count.
            return Ok(());
        };
        let tally = &mut *state.tally;
        sealed.open_into(&state.key, tally);
        state.replies.clear();
        state.replies.extend(tally.entries().iter().map(|e| e.reply()));
        state.delays.extend(tally.entries().iter().map(delay_of));
        expected = Some(tally.run_digest);
    }
    state.digest.absorb_replies(state.replies.iter().copied());
    if expected.is_some_and(|digest| digest != state.digest.run()) {
        return Err(ClientError::Unusable(format!(
            "tick {}: what was read does not have the digest the server has; do not trust this run",
            frame.tick()
        )));
    }
    for _ in 0..BELIEFS_AT_ONCE {
        let Some(header) = session.next_belief(&mut state.poses) else { break };
        recorder.belief(&header, &mut state.poses);
    }
    let State { replies, delays, .. } = state;
    recorder.step(&Step { frame, truth, replies, delays, digest: state.digest })
}

fn delay_of(entry: &TallyEntry) -> Option<Delay> {
    let came = entry.reply() != Reply::Missing;
    came.then_some(Delay { reported_ns: entry.answer.compute_ns, observed_ns: entry.latency_ns })
}

/// The tally of a frame: it was published before the frame after it.
fn tally_of(session: &mut Session, frame: &Frame) -> Result<Option<BorrowedTally>, ClientError> {
    while let Some(tally) = session.next_tally()? {
        if (tally.run_id, tally.tick) == (frame.run_id, frame.tick()) {
            return Ok(Some(tally));
        }
    }
    Ok(None)
}
