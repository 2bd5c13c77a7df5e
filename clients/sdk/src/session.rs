//! `Session`: one participant's part in a run, live or on a log.

use std::io::Read as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rusty_contract::answer::Message;
use rusty_contract::config::check_seconds;
use rusty_contract::{
    Brief, Credentials, Exit, Frame, JoinRequest, Json as _, Phase, Reply, Start, TruthKey,
};
use rusty_link::{BorrowedTally, ClientLink, Incoming, LinkError, Peer};
use signal_hook::flag::{register, register_conditional_shutdown};

use crate::held_frame::{FrameHandle, HeldFrame};
use crate::log_session::LogSession;
use crate::tick::Answering;
use crate::{ClientArgs, ClientError, Tick};

mod beliefs;
mod next_run;

/// How long a wait lasts before it looks around; it is repeated for ever.
const SLICE: Duration = Duration::from_millis(500);

/// One participant's part in a run, or in one run after the other:
///
/// ```no_run
/// # use rusty_clients::prelude::*;
/// let mut session = Session::from_command_line()?;
/// while let Some(run) = session.next_run()? {
///     let mut pose = run.start().initial_pose.unwrap_or_default(); // anew for each run
///     while let Some(tick) = run.next()? {
///         # let _ = &mut pose;
///         tick.answer(pose)?;
///     }
/// }
/// # Ok::<(), ClientError>(())
/// ```
///
/// Dropped after the last frame, or because this process was asked to stop, it sends a
/// leave message; dropped for any other reason it tells the server that it failed.
pub struct Session {
    source: Source,
    start: Start,
    stop: Arc<AtomicBool>,
    /// Whether [`next_run`](Self::next_run) has returned the current run.
    is_begun: bool,
    /// Whether the leave message of the current run was sent.
    has_left: bool,
    /// The tick taken last. Ticks of a run only grow.
    last_tick: Option<u64>,
    ending: Option<Phase>,
    is_behind: bool,
    failed: bool,
    /// The next answer makes its tick the last one.
    ends_run: bool,
}

enum Source {
    Live(Box<ClientLink>),
    Log(Box<LogSession>),
}

/// What a bounded wait for a tick brought.
pub enum Arrival {
    /// A tick. [`Session::answer`] it.
    Frame(HeldFrame),
    /// Nothing within the time given.
    Nothing,
    /// No tick comes any more; [`Session::ending`] says how the run ended.
    End,
}

/// A flag that SIGINT and SIGTERM raise; a second one of them ends the process even
/// in the middle of a tick.
///
/// Without a handler the signal ends the process, which the server notices as well;
/// so a failure to register is no error.
#[must_use]
pub fn stop_by_signal() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        let code = i32::from(Exit::Failed as u8);
        let _ = register_conditional_shutdown(signal, code, Arc::clone(&stop));
        let _ = register(signal, Arc::clone(&stop));
    }
    stop
}

impl Session {
    /// Joins as this process's command line says (`--run NAME` or `--log PATH`).
    ///
    /// # Errors
    /// [`ClientError`], for instance the server's refusal in its own words.
    pub fn from_command_line() -> Result<Self, ClientError> {
        Self::join(&ClientArgs::from_command_line())
    }

    /// Joins the run of `--run`, or opens the log of `--log`.
    ///
    /// # Errors
    /// [`ClientError`], for instance the server's refusal in its own words.
    pub fn join(args: &ClientArgs) -> Result<Self, ClientError> {
        args.check_no_beliefs()?;
        Self::enter(args)
    }

    /// The same for one who knows what to do with `--beliefs`.
    pub(crate) fn enter(args: &ClientArgs) -> Result<Self, ClientError> {
        Self::enter_until(args, stop_by_signal())
    }

    /// The same without signal handlers: for a process that has its own. Once
    /// `stop` is raised, waiting ends with [`LinkError::Stopped`], and the
    /// session sends a leave message instead of reporting a failure.
    ///
    /// # Errors
    /// As [`join`](Self::join).
    pub fn join_until(args: &ClientArgs, stop: Arc<AtomicBool>) -> Result<Self, ClientError> {
        args.check_no_beliefs()?;
        Self::enter_until(args, stop)
    }

    fn enter_until(args: &ClientArgs, stop: Arc<AtomicBool>) -> Result<Self, ClientError> {
        // A file that may not grow (`ulimit -f`) is an error like others, and does
        // not end the process.
        let _ = register(signal_hook::consts::SIGXFSZ, Arc::default());
        let name = args.name();
        let (source, start) = match (&args.run, &args.log) {
            (Some(run), _) => {
                let version = concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"));
                let awake_ns = args.wait.awake_ns();
                let request = JoinRequest::new(&name, std::process::id(), awake_ns, version);
                check_seconds("--join-timeout", args.join_timeout)?;
                let timeout = Duration::from_secs_f64(args.join_timeout);
                let launcher = args.launcher.map(Peer::new);
                let launcher = launcher.as_ref();
                let wait = args.wait;
                let told = credentials(args)?;
                let link =
                    ClientLink::join_launched(run, launcher, told, &request, wait, timeout, &stop)?;
                let start = link.start().clone();
                (Source::Live(Box::new(link)), start)
            }
            (None, Some(log)) => {
                args.check_out()?;
                let session = LogSession::open(log, &name, args.out.as_deref())?;
                let start = session.start().clone();
                (Source::Log(Box::new(session)), start)
            }
            (None, None) => {
                let remedy = "give --run NAME or --log PATH";
                return Err(ClientError::Unusable(remedy.to_owned()));
            }
        };
        Ok(Self {
            source,
            start,
            stop,
            is_begun: false,
            has_left: false,
            last_tick: None,
            ending: None,
            is_behind: false,
            failed: false,
            ends_run: false,
        })
    }

    /// What this participant is told: time step, robot, LiDAR, and map and
    /// initial pose where they are given.
    #[must_use]
    pub fn start(&self) -> &Start {
        &self.start
    }

    /// The next tick; `None` after the last. Answer it: a tick that is dropped
    /// without an answer abstains.
    ///
    /// # Errors
    /// [`ClientError::Link`] if the server has ended.
    #[allow(clippy::should_implement_trait)] // a tick borrows the session: no iterator can
    pub fn next(&mut self) -> Result<Option<Tick<'_>>, ClientError> {
        match self.next_frame()? {
            Some(frame) => Ok(Some(Tick::new(self, frame))),
            None => Ok(None),
        }
    }

    pub(crate) fn next_frame(&mut self) -> Result<Option<FrameHandle>, ClientError> {
        loop {
            match self.next_within(SLICE)? {
                Arrival::Frame(frame) => return Ok(Some(frame.0)),
                Arrival::Nothing => {}
                Arrival::End => return Ok(None),
            }
        }
    }

    /// Waits for the next tick, for about `at_most`: for a caller that must
    /// look around itself meanwhile. Unlike a [`Tick`], the frame does not
    /// borrow the session, and nothing abstains for it.
    ///
    /// # Errors
    /// [`ClientError::Link`] if the server has ended.
    pub fn next_within(&mut self, at_most: Duration) -> Result<Arrival, ClientError> {
        if self.ending.is_some() {
            return Ok(Arrival::End);
        }
        let frame = match &mut self.source {
            Source::Live(link) => match link.wait_frame(at_most, &self.stop)? {
                Incoming::Frame(frame) if is_news(&frame, self.start.run_id, self.last_tick) => {
                    FrameHandle::Live(frame)
                }
                Incoming::Frame(_) | Incoming::Nothing => return Ok(Arrival::Nothing),
            },
            Source::Log(_) if self.stop.load(Ordering::Relaxed) => {
                return Err(LinkError::Stopped.into());
            }
            Source::Log(log) => match log.next()? {
                Some(frame) => FrameHandle::Log(frame),
                None => {
                    self.ending = Some(Phase::Done);
                    return Ok(Arrival::End);
                }
            },
        };
        match frame.phase() {
            Phase::Tick => {
                self.last_tick = Some(frame.tick());
                Ok(Arrival::Frame(HeldFrame(frame)))
            }
            phase => {
                // One who comes back may receive the end of run before all ticks.
                self.is_behind = frame.tick() > self.last_tick.map_or(0, |tick| tick + 1);
                self.ending = Some(phase);
                Ok(Arrival::End)
            }
        }
    }

    /// Answers a frame that [`next_within`](Self::next_within) brought. A second
    /// answer to it is left aside by the server.
    ///
    /// # Errors
    /// [`ClientError::Answer`] names an invalid number; the frame is then
    /// not answered.
    pub fn answer(&mut self, frame: &HeldFrame, reply: Reply) -> Result<(), ClientError> {
        self.reply(&frame.0, reply)
    }

    /// Makes the next answer end the run: see [`Tick::end_run`].
    pub fn end_run(&mut self) {
        self.ends_run = true;
    }

    /// The answers of the next complete tick (scorers and loggers).
    pub(crate) fn next_tally(&mut self) -> Result<Option<BorrowedTally>, ClientError> {
        match &mut self.source {
            Source::Live(link) => Ok(link.next_tally()?),
            Source::Log(_) => Ok(None),
        }
    }

    /// Reads the key and opens what only scorers and loggers are told.
    pub(crate) fn brief(&mut self, args: &ClientArgs) -> Result<(TruthKey, Brief), ClientError> {
        if let (Source::Log(log), Some(file)) = (&mut self.source, &args.key_file) {
            let brief = Brief { header: log.unblind(file)?, out_dir: None, report: true };
            return Ok((log.key().clone(), brief));
        }
        let Some(sealed) = &self.start.sealed_brief else {
            let (name, role) = (&self.start.name, self.start.role);
            return Err(ClientError::Unusable(format!(
                "{name:?} has the role {role} in this run; a scorer or logger needs its own role"
            )));
        };
        let key = match &self.source {
            Source::Live(link) => {
                let key = link.credentials().truth.as_ref();
                let key = key.map(|series| series.of_run(self.start.run_number));
                key.ok_or_else(|| ClientError::NoKey(self.start.name.clone()))?
            }
            Source::Log(log) => log.key().clone(),
        };
        let json = key.open_brief(self.start.run_id, sealed)?;
        let brief = Brief::from_json(&json)
            .map_err(|e| ClientError::Unusable(format!("the run's brief cannot be read: {e}")))?;
        Ok((key, brief))
    }

    /// What a log recorded with the frame that was read last.
    pub(crate) fn recorded_replies(&self) -> Option<&[Reply]> {
        match &self.source {
            Source::Live(_) => None,
            Source::Log(log) => Some(log.recorded_replies()),
        }
    }

    /// Whether the run ended before it had been given all ticks again.
    pub(crate) fn is_behind(&self) -> bool {
        self.is_behind
    }

    /// How the run ended, once it has.
    #[must_use]
    pub fn ending(&self) -> Option<Phase> {
        self.ending
    }

    /// Whether the log it works on lacks its end, or holds a record that is not
    /// what was written.
    #[must_use]
    pub fn log_is_broken(&self) -> bool {
        matches!(&self.source, Source::Log(log) if log.is_broken())
    }
}

impl Answering for Session {
    fn reply(&mut self, frame: &FrameHandle, reply: Reply) -> Result<(), ClientError> {
        let (tick, ends_run) = (frame.tick(), std::mem::take(&mut self.ends_run));
        reply.check().map_err(|error| ClientError::Answer { tick, error })?;
        match (&mut self.source, frame) {
            (Source::Live(link), FrameHandle::Live(frame)) => {
                link.answer(frame, &Message::Reply(reply), ends_run)?;
            }
            (Source::Log(log), _) => log.reply(frame, reply)?,
            (Source::Live(_), FrameHandle::Log(_)) => {}
        }
        Ok(())
    }

    fn end_run(&mut self) {
        Self::end_run(self);
    }

    /// Marks the part as failed: the server is told so at the end.
    fn fail(&mut self) {
        self.failed = true;
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let Source::Live(link) = &mut self.source else { return };
        if self.has_left {
            return;
        }
        let told = self.ending.is_some() || self.stop.load(Ordering::Relaxed);
        let well = told && !self.failed && !std::thread::panicking();
        let message = if well { Message::Leave } else { Message::Failed };
        // No process misses it if the server has ended.
        let _ = link.send_raw(rusty_contract::Answer::carrying(&message));
    }
}

/// Whether a frame is of this run and was not seen before: a tick that is worked
/// in twice would spoil an estimate. The end of run carries no tick.
fn is_news(frame: &Frame, run_id: u64, last_tick: Option<u64>) -> bool {
    frame.run_id == run_id
        && (frame.phase() != Phase::Tick || last_tick.is_none_or(|last| frame.tick() > last))
}

/// The credentials by the private channel: standard input, or a file that was
/// named. `None`: those that the server left in the run's folder.
fn credentials(args: &ClientArgs) -> Result<Option<Credentials>, ClientError> {
    let mut text = String::new();
    let most = Credentials::MAX_BYTES;
    if args.key_stdin {
        let path = std::path::Path::new("standard input");
        std::io::stdin().take(most).read_to_string(&mut text).map_err(ClientError::io(path))?;
        if text.is_empty() {
            // The launcher died first; joining finds that out.
            return Ok(Some(Credentials::none()));
        }
    } else if let Some(file) = &args.key_file {
        let read =
            rusty_contract::input::open(file).and_then(|f| f.take(most).read_to_string(&mut text));
        read.map_err(ClientError::io(file))?;
    } else {
        return Ok(None);
    }
    Ok(Some(Credentials::from_text(&text)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_later_ticks_of_this_run_and_its_end_of_run_are_news() {
        let mut frame = Frame::boxed();
        frame.begin(5, 0.12, Default::default(), Default::default());
        frame.run_id = 7;
        assert!(is_news(&frame, 7, None) && is_news(&frame, 7, Some(4)));
        assert!(!is_news(&frame, 8, None));
        assert!(!is_news(&frame, 7, Some(5)) && !is_news(&frame, 7, Some(6)));
        // A run that is aborted in the middle of tick 5 ends with that number.
        frame.end(Phase::Aborted, 5);
        assert!(is_news(&frame, 7, Some(5)) && !is_news(&frame, 8, Some(5)));
    }
}
