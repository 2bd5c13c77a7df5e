//! A participant's side: join, borrow a frame where it lies, answer it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use rusty_contract::answer::Message;
use rusty_contract::scenario::Role;
use rusty_contract::{Answer, Credentials, Frame, JoinRequest, Refusal, RunName, Start};

use crate::belief::Beliefs;
use crate::borrowed::{BorrowedFrame, BorrowedTally};
use crate::feed::{Refeed, is_end_of_run};
use crate::lobby::{Lobby, RequestPort};
use crate::services::{self, BUFFER, Ipc, WireAnswer, WireFrame, WireTally};
use crate::wait::{LOOKS_BETWEEN_CHECKS, Waiter, may_sleep, monotonic_ns, readable};
use crate::{Domain, LinkError, Peer, WaitPolicy};

/// A frame that is sent so long after the last answer is one of a slow run, one
/// that is paused or goes at a pace: staying awake for it would be in vain.
const SLOW_NS: u64 = 4_000_000;
/// How long a participant of a slow run stays awake.
const SLOW_AWAKE_NS: u64 = 30_000;

/// A participant's ports on a run.
pub struct ClientLink {
    start: Start,
    credentials: Credentials,
    /// The request to join, and the port that it was sent by if there may be more runs.
    request: JoinRequest,
    joins: Option<RequestPort>,
    policy: WaitPolicy,
    frames: Subscriber<Ipc, WireFrame, ()>,
    /// What comes first, where this one comes back into a run.
    refeed: Option<Refeed>,
    tallies: Option<Subscriber<Ipc, WireTally, ()>>,
    answers: Publisher<Ipc, WireAnswer, ()>,
    /// Opened for those who look, and by the first look of those who show.
    beliefs: Option<Beliefs>,
    /// When the current wait for a frame began.
    waiting_since_ns: u64,
    /// The last frame was long in coming: the next will be, too.
    is_slow: bool,
    lobby: Lobby,
}

/// A participant that was given a slot.
struct Joined {
    start: Start,
    credentials: Credentials,
    request: JoinRequest,
    joins: RequestPort,
}

/// What a wait brought.
pub enum Incoming {
    /// A frame.
    Frame(BorrowedFrame),
    /// Nothing within the time given.
    Nothing,
}

impl ClientLink {
    /// Finds the run, asks to join it and opens the ports. Waits up to
    /// `timeout` for the run to appear.
    ///
    /// # Errors
    /// [`LinkError::Refused`] in the server's words; [`LinkError::Domain`] if
    /// there is no such run; [`LinkError::Stopped`] if `stop` was raised.
    pub fn join(
        run: &RunName,
        request: &JoinRequest,
        policy: WaitPolicy,
        timeout: Duration,
        stop: &AtomicBool,
    ) -> Result<Self, LinkError> {
        Self::join_launched(run, None, None, request, policy, timeout, stop)
    }

    /// The same for a participant that was started by the run's server, with the
    /// `credentials` that it was given; without any, those in the run's folder
    /// for one that is started by hand. One
    /// that is started by hand waits for its server to come; `launcher` has
    /// come, and once it has ended there is nothing to wait for.
    ///
    /// # Errors
    /// As [`join`](Self::join); [`LinkError::ServerGone`] if the launcher is.
    pub fn join_launched(
        run: &RunName,
        launcher: Option<&Peer>,
        credentials: Option<Credentials>,
        request: &JoinRequest,
        policy: WaitPolicy,
        timeout: Duration,
        stop: &AtomicBool,
    ) -> Result<Self, LinkError> {
        let deadline = Instant::now() + timeout;
        let joined = Lobby::find(run, launcher, deadline, stop).and_then(|lobby| {
            let server = Peer::new(lobby.server.pid());
            let asked = credentials.map_or_else(|| left_for(run, &request.name), Ok).and_then(
                |credentials| {
                    let mut request = request.clone();
                    request.sign(&credentials.participant.to_server);
                    let joins = lobby.requests("join")?;
                    let start = lobby.ask(&joins, &request, Some(deadline), stop)?;
                    Ok(Joined { start, credentials, request, joins })
                },
            );
            asked.and_then(|asked| Self::open(lobby, policy, asked)).map_err(|e| match e {
                // What is missing is what another process has swept meanwhile.
                LinkError::Transport { .. } if server.is_dead() => {
                    LinkError::ServerGone { pid: server.pid() }
                }
                e => e,
            })
        });
        if joined.is_err() {
            // A server that was killed before anyone had joined cannot sweep
            // its run either; see `drop`.
            let _ = Domain::named(run).sweep_if_dead();
        }
        joined
    }

    fn open(lobby: Lobby, policy: WaitPolicy, joined: Joined) -> Result<Self, LinkError> {
        let Joined { start, credentials, request, joins } = joined;
        let joins = start.more_runs.then_some(joins);
        let node = &lobby.node;
        let holds_key = start.role.holds_key();
        let frames = services::subscribe::<WireFrame>(node, "frames", BUFFER)?;
        let tallies = holds_key
            .then(|| services::subscribe::<WireTally>(node, "tallies", BUFFER))
            .transpose()?;
        let refeed = |catch_up| Refeed::open(node, catch_up, holds_key);
        let refeed = start.catch_up.as_ref().map(refeed).transpose()?;
        let answers = services::open_pub_sub::<WireAnswer>(node, "answers")?
            .publisher_builder()
            .max_loaned_samples(2)
            .create()
            .map_err(LinkError::transport("open the answers port"))?;
        // Open before the first frame, so that no belief is too early.
        let beliefs = (start.role == Role::Scorer).then(|| Beliefs::to_see(node));
        let waiting_since_ns = monotonic_ns();
        let mut link = Self {
            start,
            credentials,
            request,
            joins,
            policy,
            frames,
            refeed,
            tallies,
            answers,
            beliefs,
            waiting_since_ns,
            is_slow: false,
            lobby,
        };
        link.send_raw(Answer::carrying(&Message::Ready))?;
        Ok(link)
    }

    /// Leaves a run that has ended, and waits for the next run of its series for as long
    /// as the server lives. Returns whether there is one: [`start`](Self::start) is then
    /// that of the next run. Without a next run this participant has left.
    ///
    /// # Errors
    /// [`LinkError::ServerGone`], [`LinkError::Stopped`]; [`LinkError::Refused`] in the
    /// server's words.
    pub fn next_run(&mut self, stop: &AtomicBool) -> Result<bool, LinkError> {
        self.send_raw(Answer::carrying(&Message::Leave))?;
        let Some(joins) = &self.joins else { return Ok(false) };
        let mut request = self.request.after(self.start.run_id);
        request.sign(&self.credentials.participant.to_server);
        match self.lobby.ask(joins, &request, None, stop) {
            Ok(start) => self.start = start,
            Err(LinkError::Refused(Refusal::NoMoreRuns)) => return Ok(false),
            Err(error) => return Err(error),
        }
        let refeed = |catch_up| Refeed::open(&self.lobby.node, catch_up, self.tallies.is_some());
        self.refeed = self.start.catch_up.as_ref().map(refeed).transpose()?;
        self.is_slow = false;
        self.send_raw(Answer::carrying(&Message::Ready))?;
        Ok(true)
    }

    /// What this participant was told.
    #[must_use]
    pub fn start(&self) -> &Start {
        &self.start
    }

    /// What this participant was told by its private channel.
    #[must_use]
    pub fn credentials(&self) -> &Credentials {
        &self.credentials
    }

    /// The server's process.
    #[must_use]
    pub fn server(&self) -> &Peer {
        &self.lobby.server
    }

    /// Waits for the next frame, for at most `at_most`.
    ///
    /// # Errors
    /// [`LinkError::ServerGone`], [`LinkError::Stopped`];
    /// [`LinkError::Dropped`] once the run goes on without this participant.
    pub fn wait_frame(
        &mut self,
        at_most: Duration,
        stop: &AtomicBool,
    ) -> Result<Incoming, LinkError> {
        let mut waiter = Waiter::new(self.policy, self.waiting_since_ns);
        if self.is_slow {
            // Should it come at once for once, that costs a slice, and once.
            waiter.at_most_awake(self.waiting_since_ns, SLOW_AWAKE_NS);
        }
        let mut deadline = None;
        let mut looks = 0u32;
        loop {
            if let Some(frame) = self.next_frame()? {
                // When it was sent, not when it was seen: who overslept has
                // learnt nothing about the run.
                let waited_ns = frame.published_ns.saturating_sub(self.waiting_since_ns);
                self.is_slow = waited_ns >= SLOW_NS;
                return Ok(Incoming::Frame(frame));
            }
            if stop.load(Ordering::Relaxed) {
                return Err(LinkError::Stopped);
            }
            let awake = waiter.yielded();
            looks = looks.wrapping_add(1);
            if awake && !looks.is_multiple_of(LOOKS_BETWEEN_CHECKS) {
                continue;
            }
            // The server is asked about only before going to sleep, or now and
            // then by those who never sleep: while it answers in time there is
            // no need to.
            if self.lobby.server.is_dead() {
                // Its last frame may have come between the two looks.
                return match self.next_frame()? {
                    Some(frame) => Ok(Incoming::Frame(frame)),
                    None => Err(LinkError::ServerGone { pid: self.lobby.server.pid() }),
                };
            }
            let now = Instant::now();
            let until = *deadline.get_or_insert(now + at_most);
            if now >= until {
                return Ok(Incoming::Nothing);
            }
            if awake {
                continue;
            }
            let mut fds = vec![readable(services::listener_fd(&self.lobby.woken))];
            fds.extend(self.lobby.server.fd().map(readable));
            waiter.block(&mut fds, until - now);
            services::drain(&self.lobby.woken);
        }
    }

    /// The next frame, if there is one and it is meant for this participant.
    fn next_frame(&mut self) -> Result<Option<BorrowedFrame>, LinkError> {
        let borrowed = |sample| BorrowedFrame { sample, taken_ns: monotonic_ns() };
        let again = match self.refeed.as_mut().filter(|refeed| !refeed.is_over()) {
            Some(refeed) => match refeed.next()? {
                Some(sample) => {
                    let frame = borrowed(sample);
                    self.check(&frame)?;
                    return Ok(Some(frame));
                }
                None => true,
            },
            None => false,
        };
        let sample = self.frames.receive().map_err(LinkError::transport("receive a frame"))?;
        // No tick of the run is out while this one catches up, but its end
        // of run may be.
        let sample = sample.filter(|s| !again || is_end_of_run(&s.payload().0));
        let Some(frame) = sample.map(borrowed) else { return Ok(None) };
        self.check(&frame)?;
        if frame.run_id == self.start.run_id && frame.has_lost(self.start.participant) {
            return Err(LinkError::Dropped { name: self.start.name.clone() });
        }
        Ok(Some(frame))
    }

    /// Whether the server sent this frame to this participant. One of another
    /// run is left to the caller.
    fn check(&self, frame: &Frame) -> Result<(), LinkError> {
        if frame.run_id != self.start.run_id {
            return Ok(());
        }
        let (tick, signed) = (frame.tick(), frame.digest());
        if !frame.is_signed_for(
            self.start.participant as usize,
            &self.credentials.participant.from_server,
        ) {
            return Err(LinkError::Unsigned { tick });
        }
        let found = if self.start.check_frames { frame.observable_digest() } else { signed };
        if found != signed {
            return Err(LinkError::Changed { tick, signed, found });
        }
        Ok(())
    }

    /// Answers a frame. The answer is the acknowledgement. With `ends_run`, a driver
    /// makes its tick the last one.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn answer(
        &mut self,
        frame: &BorrowedFrame,
        message: &Message,
        ends_run: bool,
    ) -> Result<(), LinkError> {
        let mut answer = Answer::carrying(message);
        if ends_run {
            answer.end_run();
        }
        answer.tick = frame.tick();
        answer.digest_seen = frame.digest();
        let now = monotonic_ns();
        answer.compute_ns = now.saturating_sub(frame.taken_ns);
        self.send(answer, now)?;
        if may_sleep(monotonic_ns(), frame.published_ns, self.start.server_awake_ns) {
            let _ = self.lobby.wake_server.notify();
        }
        Ok(())
    }

    /// Sends an answer as it is, but for run, participant and clock, and wakes
    /// the server. For tests of the server; a participant uses
    /// [`answer`](Self::answer).
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn send_raw(&mut self, answer: Answer) -> Result<(), LinkError> {
        self.send(answer, monotonic_ns())?;
        let _ = self.lobby.wake_server.notify();
        Ok(())
    }

    /// Signs an answer as it is, whosever it claims to be, sends it and wakes the
    /// server.
    /// For tests of the server.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn send_forged(&mut self, mut answer: Answer) -> Result<(), LinkError> {
        answer.sign(&self.credentials.participant.to_server);
        let sent = self.answers.send_copy(WireAnswer(answer));
        let _ = self.lobby.wake_server.notify();
        sent.map(|_| ()).map_err(LinkError::transport("send an answer"))
    }

    fn send(&mut self, mut answer: Answer, now_ns: u64) -> Result<(), LinkError> {
        answer.run_id = self.start.run_id;
        answer.participant = self.start.participant;
        answer.ticket = self.start.ticket;
        answer.sent_ns = now_ns;
        answer.sign(&self.credentials.participant.to_server);
        self.waiting_since_ns = answer.sent_ns;
        self.answers
            .send_copy(WireAnswer(answer))
            .map(|_| ())
            .map_err(LinkError::transport("send an answer"))
    }

    /// The way by which beliefs are shown, and seen by scorers.
    pub fn beliefs(&mut self) -> &mut Beliefs {
        self.beliefs.get_or_insert_with(|| Beliefs::to_show(&self.lobby.node))
    }

    /// The next tally, if there is one. Only scorers and loggers have any.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn next_tally(&self) -> Result<Option<BorrowedTally>, LinkError> {
        if let Some(tally) = self.refeed.as_ref().map(Refeed::next_tally).transpose()?.flatten() {
            return Ok(Some(BorrowedTally(tally)));
        }
        let Some(port) = &self.tallies else {
            return Ok(None);
        };
        let sample = port.receive().map_err(LinkError::transport("receive a tally"))?;
        Ok(sample.map(BorrowedTally))
    }
}

/// The credentials that the server left for a participant started by hand.
/// Without a file there are none, and the server says why it refuses.
fn left_for(run: &RunName, name: &str) -> Result<Credentials, LinkError> {
    let path = Domain::credentials_file(run, name);
    let unreadable =
        |error: String| LinkError::Credentials { path: path.display().to_string(), error };
    match std::fs::read_to_string(&path) {
        Ok(text) => Credentials::from_text(&text).map_err(|e| unreadable(e.to_string())),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(Credentials::none()),
        Err(e) => Err(unreadable(e.to_string())),
    }
}

impl Drop for ClientLink {
    fn drop(&mut self) {
        // A server that was killed cannot sweep its run, so everyone who leaves
        // does; while the server lives this does nothing.
        if self.lobby.server.is_dead() {
            let _ = self.lobby.domain.sweep_if_dead();
        }
    }
}
