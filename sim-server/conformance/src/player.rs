//! `Player`: a server of one little run that can misbehave on purpose.
//!
//! A check decides which steps there are: a frame can be shown
//! twice, late, damaged, or not at all. No wait outlasts the kit's patience.

mod close;

use std::collections::VecDeque;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::process::Signal;
use rusty_contract::answer::Message;
use rusty_contract::{
    Answer, Frame, JoinReply, JoinRequest, LogHeader, Phase, Refusal, RunDigest, RunName,
};
use rusty_geometry::{EncoderCounts, SE2, Twist};
use rusty_link::{Domain, JoinCall, Peer, ReceivedAnswer, ServerLink};
use rusty_sim::Sim;

use super::Kit;
use super::client::Client;
use super::fault::{Fault, Halt};
use super::setting::{CLIENT_SLOT, Setting};
use super::spoilt;
use super::transcript::{Response, Transcript};
use rusty_engine::run::RunIdentity;

/// How long an observer, that no process waits for, is listened to.
const OBSERVER_TIME: Duration = Duration::from_millis(10);

/// The server of one little run. What it leaves is removed when it goes.
pub(super) struct Player<'k> {
    kit: &'k Kit,
    /// The client. It goes before the ports do.
    pub(super) client: Client,
    peer: Peer,
    pub(super) said: Transcript,
    request: Option<JoinRequest>,
    waiting_since_ns: u64,
    left: bool,
    gave_up: bool,
    ready: bool,
    identity: RunIdentity,
    header: LogHeader,
    sim: Sim,
    /// The frame that was made last.
    pub(super) frame: Box<Frame>,
    digest: RunDigest,
    companion: (SE2, EncoderCounts),
    driver: Option<Twist>,
    /// Ticks that are complete.
    closed: u64,
    /// Digest of the end of run, once it was sent.
    end_of_run: Option<u64>,
    inbox: VecDeque<ReceivedAnswer>,
    link: ServerLink,
    _domain: Domain,
}

impl<'k> Player<'k> {
    /// Opens a run and starts the client on it.
    pub(super) fn open(kit: &'k Kit, setting: &Setting, folder: &Path) -> Result<Self, Halt> {
        let run = kit.fresh_run()?;
        let mut player = Self::serve(kit, setting, &run, kit.identity(folder)?)?;
        let client = Client::start(kit, &run, &player.identity.key, folder)?;
        player.peer = Peer::new(client.pid());
        player.client = client;
        Ok(player)
    }

    /// Opens a run for a client that another process starts.
    pub(super) fn serve(
        kit: &'k Kit,
        setting: &Setting,
        run: &RunName,
        identity: RunIdentity,
    ) -> Result<Self, Halt> {
        let (header, sim) = setting.world(kit)?;
        let domain = Domain::create(run)?;
        let link = ServerLink::create(&domain, kit.wait, &identity.key)?;
        Ok(Self {
            kit,
            client: Client::elsewhere(),
            peer: Peer::new(0),
            said: Transcript::default(),
            request: None,
            waiting_since_ns: 0,
            left: false,
            gave_up: false,
            ready: false,
            companion: (header.config.start, EncoderCounts::default()),
            identity,
            header,
            sim,
            frame: Frame::boxed(),
            digest: RunDigest::default(),
            driver: None,
            closed: 0,
            end_of_run: None,
            inbox: VecDeque::new(),
            link,
            _domain: domain,
        })
    }

    /// The process that joined; 0 before.
    pub(super) fn joined_pid(&self) -> u32 {
        self.request.as_ref().map_or(0, |r| r.pid)
    }

    /// How long the client looks for a frame before it may sleep, ns.
    pub(super) fn client_awake_ns(&self) -> u64 {
        self.request.as_ref().map_or(0, |r| r.awake_ns)
    }

    fn ended(&self, when: &str) -> Fault {
        Fault::Ended { when: when.to_owned(), how: self.client.end() }
    }

    /// Waits for a request to join.
    pub(super) fn asked(&mut self) -> Result<(JoinCall, JoinRequest), Halt> {
        let until = Instant::now() + self.kit.patience;
        loop {
            if let Some(call) = self.link.next_join()? {
                match call.request() {
                    Ok(request) => {
                        let keys = self.link.keys();
                        // A request for another slot is for the check to refuse.
                        let is_signed = request.name != self.kit.name
                            || keys.has_signed_request(&request, CLIENT_SLOT);
                        if !is_signed {
                            return Err(Fault::UnsignedRequest.into());
                        }
                        return Ok((call, request));
                    }
                    Err(refusal) => {
                        // It is told, as a server would.
                        let _ = call.reply(&JoinReply::Refused(refusal.clone()));
                        return Err(Fault::BadRequest(refusal).into());
                    }
                }
            }
            self.kit.go_on()?;
            if self.client.has_ended() {
                return Err(self.ended("before it asked to join").into());
            }
            let now = Instant::now();
            if now >= until {
                let words = self.client.last_lines();
                return Err(Fault::NeverAsked(self.kit.patience, words).into());
            }
            self.link.pause(|| std::iter::once(&self.peer), until - now);
        }
    }

    /// Refuses a request.
    pub(super) fn refuse(&mut self, call: JoinCall, refusal: Refusal) -> Result<(), Halt> {
        call.reply(&JoinReply::Refused(refusal))?;
        self.link.wake_all();
        Ok(())
    }

    /// Gives the client its slot.
    pub(super) fn admit(&mut self, call: JoinCall, request: JoinRequest) -> Result<(), Halt> {
        self.request = Some(request);
        let start = self.identity.start(&self.header, CLIENT_SLOT);
        call.reply(&JoinReply::Start(Box::new(start)))?;
        self.link.wake_all();
        Ok(())
    }

    /// Waits for Ready, which comes before anything else.
    pub(super) fn until_ready(&mut self) -> Result<(), Halt> {
        let until = Instant::now() + self.kit.patience;
        while !self.ready {
            match self.receive(until, "before it said Ready")? {
                None => return Err(Fault::NeverReady(self.kit.patience).into()),
                Some(_) if self.ready => {}
                Some(early) => self.said.strays.push(early),
            }
        }
        Ok(())
    }

    /// Join, Start, Ready.
    pub(super) fn gather(&mut self) -> Result<(), Halt> {
        let (call, request) = self.asked()?;
        self.admit(call, request)?;
        self.until_ready()
    }

    /// The next message of the client until `until`. Ready, leave message and failure
    /// are noted. `when` says where in the run this is.
    fn receive(&mut self, until: Instant, when: &str) -> Result<Option<Response>, Halt> {
        loop {
            if let Some(answer) = self.next_answer()? {
                return Ok(Some(self.note(answer)));
            }
            self.kit.go_on()?;
            if self.client.has_ended() {
                // What it said before it ended still counts.
                if let Some(answer) = self.next_answer()? {
                    return Ok(Some(self.note(answer)));
                }
                return Err(self.ended(when).into());
            }
            let now = Instant::now();
            if now >= until {
                return Ok(None);
            }
            self.link.pause(|| std::iter::once(&self.peer), until - now);
        }
    }

    fn next_answer(&mut self) -> Result<Option<Answer>, Halt> {
        if self.inbox.is_empty() {
            let inbox = &mut self.inbox;
            self.link.take_answers(|received| inbox.push_back(received))?;
        }
        let Some(received) = self.inbox.pop_front() else { return Ok(None) };
        if received.forged_by.is_some() {
            return Err(Fault::Unsigned(received.answer.tick).into());
        }
        Ok(Some(received.answer))
    }

    fn note(&mut self, answer: Answer) -> Response {
        let message = answer.message();
        self.waiting_since_ns = answer.sent_ns;
        match message {
            Ok(Message::Ready) => self.ready = true,
            Ok(Message::Leave) => self.left = true,
            Ok(Message::Failed) => self.gave_up = true,
            Ok(Message::Reply(_)) | Err(_) => {}
        }
        Response { answer, message, asked: (self.frame.tick(), self.frame.digest()) }
    }

    /// Lets the world move on by a tick, into `frame`.
    pub(super) fn make(&mut self) {
        let _ = self.sim.step(self.driver, &mut self.frame);
        let truth = Some(self.sim.truth());
        self.frame.run_id = self.identity.run_id;
        self.frame.seal(&self.identity.key, truth);
        self.digest.absorb_frame(&self.frame, truth);
    }

    /// Publishes `frame`, without waking anybody.
    pub(super) fn show(&mut self) -> Result<(), Halt> {
        let frame = self.frame.clone();
        self.show_other(&frame)
    }

    /// Publishes another frame than that of the tick.
    pub(super) fn show_other(&mut self, other: &Frame) -> Result<(), Halt> {
        let mut loan = self.link.loan()?;
        *loan = *other;
        self.link.publish(loan, std::iter::once(CLIENT_SLOT))?;
        Ok(())
    }

    /// A frame of the same tick of another run.
    pub(super) fn foreign(&self) -> Box<Frame> {
        spoilt::foreign(&self.frame, &self.identity.key)
    }

    /// Sends a signal to the client.
    pub(super) fn signal(&self, signal: Signal) {
        self.client.signal(self.joined_pid(), signal);
    }

    /// Wakes the client if it may be asleep.
    pub(super) fn wake(&self) {
        self.link.wake_sleepers(std::iter::once((self.waiting_since_ns, self.client_awake_ns())));
    }

    /// Waits for the answer to `frame`. Whose tick is older, or of another run,
    /// is a stray; a newer one is taken for the answer, wrongly labelled.
    pub(super) fn answered(&mut self) -> Result<(), Halt> {
        let patience = if self.is_awaited() { self.kit.patience } else { OBSERVER_TIME };
        let until = Instant::now() + patience;
        let (tick, strays) = (self.frame.tick(), self.said.strays.len());
        loop {
            let Some(received) = self.receive(until, &format!("at tick {tick}"))? else {
                if !self.is_awaited() {
                    return Ok(());
                }
                let beside = self.said.strays[strays..].last().map_or_else(String::new, |s| {
                    let (run, number) = (s.answer.run_id, s.answer.tick);
                    format!("; what came instead is labelled run {run:016x}, tick {number}")
                });
                return Err(Fault::NoAnswer { tick, patience, beside }.into());
            };
            match received.message {
                Ok(Message::Ready) => {}
                Ok(Message::Leave) => return Err(Fault::Left(tick).into()),
                Ok(Message::Failed) => {
                    let how = match self.until_ended() {
                        Ok(()) => self.client.end(),
                        Err(Halt::Client(fault)) => fault.to_string(),
                        Err(halt) => return Err(halt),
                    };
                    return Err(Fault::GaveUp { tick, how: format!("; {how}") }.into());
                }
                Ok(Message::Reply(_)) | Err(_) => {
                    if received.answer.tick < tick || received.answer.run_id != self.identity.run_id
                    {
                        self.said.strays.push(received);
                        continue;
                    }
                    self.driver = received.reply().and_then(|r| r.command());
                    self.said.answers.push(received);
                    return Ok(());
                }
            }
        }
    }

    fn is_awaited(&self) -> bool {
        self.header.roster[CLIENT_SLOT].is_awaited()
    }

    /// One tick as it should be.
    pub(super) fn tick(&mut self) -> Result<(), Halt> {
        self.make();
        self.show()?;
        self.wake();
        self.answered()?;
        self.close()
    }

    /// N ticks as they should be.
    pub(super) fn ticks(&mut self, count: u64) -> Result<(), Halt> {
        (0..count).try_for_each(|_| self.tick())
    }

    /// The end of run; waits for the leave message and the end of the process.
    pub(super) fn end(&mut self, phase: Phase) -> Result<(), Halt> {
        let mut last = Frame::boxed();
        last.end(phase, self.closed);
        last.run_id = self.identity.run_id;
        self.end_of_run = Some(last.digest());
        self.show_other(&last)?;
        self.link.wake_all();
        self.until_leave()?;
        self.until_ended()
    }

    /// Whether the client answered the end of run, or ticks that there never were.
    /// Answers to earlier frames may be on their way when it is said.
    pub(super) fn answered_end_of_run(&self) -> bool {
        let newest = self.frame.tick();
        self.said.strays.iter().any(|received| {
            Some(received.answer.digest_seen) == self.end_of_run || received.answer.tick > newest
        })
    }

    /// Waits for the leave message.
    pub(super) fn until_leave(&mut self) -> Result<(), Halt> {
        let until = Instant::now() + self.kit.patience;
        while !self.left {
            match self.receive(until, "without a leave message")? {
                None => return Err(Fault::NoLeave(self.kit.patience).into()),
                Some(received) if matches!(received.message, Ok(Message::Reply(_)) | Err(_)) => {
                    self.said.strays.push(received);
                }
                Some(_) if self.gave_up => {
                    let tick = self.frame.tick();
                    let how = "; asked was a leave message".to_owned();
                    return Err(Fault::GaveUp { tick, how }.into());
                }
                Some(_) => {}
            }
        }
        Ok(())
    }

    /// Waits until the process has ended; what it still says is noted.
    pub(super) fn until_ended(&mut self) -> Result<(), Halt> {
        let until = Instant::now() + self.kit.patience;
        loop {
            match self.receive(until, "") {
                Ok(Some(received))
                    if matches!(received.message, Ok(Message::Reply(_)) | Err(_)) =>
                {
                    self.said.strays.push(received);
                }
                Ok(Some(_)) => {}
                Ok(None) => return Err(Fault::NeverEnded(self.kit.patience).into()),
                Err(Halt::Client(Fault::Ended { .. })) => return Ok(()),
                Err(halt) => return Err(halt),
            }
        }
    }

    /// Says nothing for a while, unless the kit is asked to stop.
    pub(super) fn rest(&self, time: Duration) -> Result<(), Halt> {
        std::thread::sleep(time);
        self.kit.go_on()
    }
}
