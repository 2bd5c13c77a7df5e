//! The transport with no protocol of ours, for the bench: a frame goes to all,
//! each looks at it and answers, and so on.
//!
//! The services, the types, the number of clients and the way of waiting are
//! those of a run. There is no world, no digest, no seal, no slot, no ticket:
//! what a tick of a run takes beyond this is what the laboratory costs.

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::Node;
use iceoryx2::sample::Sample;
use rusty_contract::answer::Message;
use rusty_contract::{Answer, Phase, Reply, RunName};

use crate::server::FrameLoan;
use crate::services::{self, BUFFER, Direction, Ipc, WireAnswer, WireFrame};
use crate::wait::{LOOKS_BETWEEN_CHECKS, Waiter, may_sleep, monotonic_ns, readable};
use crate::{Domain, LinkError, Peer, WaitPolicy};

/// The number that a client's first word carries instead of a tick's.
const READY: u64 = u64::MAX;

/// The side that publishes.
pub struct RawServer {
    frames: Publisher<Ipc, WireFrame, ()>,
    answers: Subscriber<Ipc, WireAnswer, ()>,
    wake_clients: Notifier<Ipc>,
    woken: Listener<Ipc>,
    policy: WaitPolicy,
    clients: usize,
    /// When the first of the clients began to wait, ns.
    waiting_since_ns: u64,
    _node: Node<Ipc>,
}

impl RawServer {
    /// Creates the services in `domain` and the ports on them.
    ///
    /// # Errors
    /// [`LinkError::Transport`] says what could not be created.
    pub fn create(domain: &Domain, policy: WaitPolicy, clients: usize) -> Result<Self, LinkError> {
        let node = services::node(domain)?;
        let frames = services::create_pub_sub::<WireFrame>(&node, "frames", Direction::FromServer)?
            .publisher_builder()
            .max_loaned_samples(2)
            .create()
            .map_err(LinkError::transport("open the frames port"))?;
        let answers =
            services::create_pub_sub::<WireAnswer>(&node, "answers", Direction::ToServer)?
                .subscriber_builder()
                .create()
                .map_err(LinkError::transport("open the answers port"))?;
        let wake_clients = services::notifier(&node, "wake-clients", true)?;
        let woken = services::listener(&node, "wake-server", true)?;
        let waiting_since_ns = 0;
        Ok(Self {
            frames,
            answers,
            wake_clients,
            woken,
            policy,
            clients,
            waiting_since_ns,
            _node: node,
        })
    }

    /// Waits for all clients to be there. `is_over` is asked now and then; if
    /// it says so, this returns false.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn gather(&mut self, is_over: impl FnMut() -> bool) -> Result<bool, LinkError> {
        self.collect(READY, monotonic_ns(), is_over)
    }

    /// Publishes a frame and waits for everyone's answer to it; false once
    /// `is_over` says so.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn round(&mut self, tick: u64, is_over: impl FnMut() -> bool) -> Result<bool, LinkError> {
        let mut frame = FrameLoan::from(&self.frames)?;
        frame.begin(tick, 0.0, Default::default(), Default::default());
        let now = monotonic_ns();
        frame.send(now)?;
        if may_sleep(now, self.waiting_since_ns, self.policy.awake_ns()) {
            let _ = self.wake_clients.notify();
        }
        self.collect(tick, now, is_over)
    }

    /// Tells the clients to end.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn end(&mut self) -> Result<(), LinkError> {
        let mut frame = FrameLoan::from(&self.frames)?;
        frame.end(Phase::Done, 0);
        frame.send(monotonic_ns())?;
        let _ = self.wake_clients.notify();
        Ok(())
    }

    fn collect(
        &mut self,
        tick: u64,
        since_ns: u64,
        mut is_over: impl FnMut() -> bool,
    ) -> Result<bool, LinkError> {
        let mut waiter = Waiter::new(self.policy, since_ns);
        let (mut missing, mut looks) = (self.clients, 0u32);
        self.waiting_since_ns = u64::MAX;
        loop {
            let receive = || self.answers.receive();
            while let Some(sample) = receive().map_err(LinkError::transport("receive an answer"))? {
                let answer = &sample.payload().0;
                if answer.tick == tick {
                    missing = missing.saturating_sub(1);
                    self.waiting_since_ns = self.waiting_since_ns.min(answer.sent_ns);
                }
            }
            if missing == 0 {
                return Ok(true);
            }
            let awake = waiter.yielded();
            looks = looks.wrapping_add(1);
            if awake && !looks.is_multiple_of(LOOKS_BETWEEN_CHECKS) {
                continue;
            }
            if is_over() {
                return Ok(false);
            }
            if !awake {
                let fd = readable(services::listener_fd(&self.woken));
                waiter.block(&mut [fd], Waiter::FOR_EVER);
                services::drain(&self.woken);
            }
        }
    }
}

/// Takes part in the rounds of `run` until they end or the server has ended.
///
/// # Errors
/// [`LinkError`] if there is no such run or the transport fails.
pub fn serve_raw(run: &RunName, policy: WaitPolicy) -> Result<(), LinkError> {
    let client = RawClient::open(run, policy)?;
    let mut since_ns = client.answer(READY, &Message::Ready, 0)?;
    while let Some(sample) = client.wait(since_ns)? {
        let frame = &sample.payload().0;
        if frame.phase() != Phase::Tick {
            break;
        }
        // Looks at the frame where it lies, and answers with what is in it.
        let message = Message::Reply(Reply::from(frame.command()));
        since_ns = client.answer(frame.tick(), &message, frame.published_ns)?;
    }
    Ok(())
}

/// The side that answers.
struct RawClient {
    frames: Subscriber<Ipc, WireFrame, ()>,
    answers: Publisher<Ipc, WireAnswer, ()>,
    wake_server: Notifier<Ipc>,
    woken: Listener<Ipc>,
    policy: WaitPolicy,
    server: Peer,
    _node: Node<Ipc>,
}

impl RawClient {
    fn open(run: &RunName, policy: WaitPolicy) -> Result<Self, LinkError> {
        let domain = Domain::find(run)?;
        let server = Peer::new(domain.server_pid());
        let node = services::node(&domain)?;
        let woken = services::listener(&node, "wake-clients", false)?;
        let wake_server = services::notifier(&node, "wake-server", false)?;
        let frames = services::subscribe::<WireFrame>(&node, "frames", BUFFER)?;
        let answers = services::open_pub_sub::<WireAnswer>(&node, "answers")?
            .publisher_builder()
            .max_loaned_samples(2)
            .create()
            .map_err(LinkError::transport("open the answers port"))?;
        Ok(Self { frames, answers, wake_server, woken, policy, server, _node: node })
    }

    /// Sends an answer, and says when.
    fn answer(&self, tick: u64, message: &Message, published_ns: u64) -> Result<u64, LinkError> {
        let mut answer = Answer::carrying(message);
        answer.tick = tick;
        answer.sent_ns = monotonic_ns();
        let now = answer.sent_ns;
        let sent = self.answers.send_copy(WireAnswer(answer));
        sent.map_err(LinkError::transport("send an answer"))?;
        if may_sleep(now, published_ns, self.policy.awake_ns()) {
            let _ = self.wake_server.notify();
        }
        Ok(now)
    }

    /// The next frame; `None` once the server has ended.
    fn wait(&self, since_ns: u64) -> Result<Option<Sample<Ipc, WireFrame, ()>>, LinkError> {
        let mut waiter = Waiter::new(self.policy, since_ns);
        let mut looks = 0u32;
        loop {
            let sample = self.frames.receive();
            if let Some(sample) = sample.map_err(LinkError::transport("receive a frame"))? {
                return Ok(Some(sample));
            }
            let awake = waiter.yielded();
            looks = looks.wrapping_add(1);
            if awake && !looks.is_multiple_of(LOOKS_BETWEEN_CHECKS) {
                continue;
            }
            if self.server.is_dead() {
                return Ok(None);
            }
            if !awake {
                let fd = readable(services::listener_fd(&self.woken));
                waiter.block(&mut [fd], Waiter::FOR_EVER);
                services::drain(&self.woken);
            }
        }
    }
}
