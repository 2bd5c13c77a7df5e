//! The server's side: loan a frame, publish it, collect answers.

use std::ops::{Deref, DerefMut};
use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{AllocationStrategy, Node};
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut_uninit::SampleMutUninit;
use rustix::event::PollFd;
use rusty_contract::{Answer, Frame, JoinReply, JoinRequest, Json as _, Refusal, Tally, TruthKey};

use crate::control::{ControlCall, RESERVED_BYTES};
use crate::port::{process_of, respond};
use crate::services::{self, BeliefService, Direction, Ipc, WireAnswer, WireFrame, WireTally};
use crate::wait::{Waiter, may_sleep, monotonic_ns, readable};
use crate::{Domain, Feed, Keys, LinkError, Peer, WaitPolicy, memory};

/// The server's ports. They go before the domain goes.
pub struct ServerLink {
    frames: Publisher<Ipc, WireFrame, ()>,
    tallies: Publisher<Ipc, WireTally, ()>,
    /// The last tally, enciphered: its memory is used again.
    tally: Box<Tally>,
    answers: Subscriber<Ipc, WireAnswer, ()>,
    joins: Server<Ipc, [u8], (), [u8], ()>,
    controls: Server<Ipc, [u8], (), [u8], ()>,
    wake_clients: Notifier<Ipc>,
    woken: Listener<Ipc>,
    policy: WaitPolicy,
    /// When the current wait began: at the last publication.
    waiting_since_ns: u64,
    waiter: Waiter,
    /// Held for filters and viewers; `None` takes nothing from the run.
    _beliefs: Option<BeliefService>,
    node: Node<Ipc>,
    /// The folder of the run's shared memory.
    memory: PathBuf,
    pub(crate) keys: Keys,
    /// How many catch-ups there were: each enciphers its tallies in its own way.
    catch_ups: u32,
    /// Answers of this turn, given back at its end; no others.
    received: Vec<Sample<Ipc, WireAnswer, ()>>,
}

/// The room that a reply needs, in multiples of its length: the transport makes a
/// larger file for one that does not fit.
const REPLY_COPIES: u64 = 4;
/// The most answers that are taken in one turn: all ports' full buffers.
const ANSWERS_AT_ONCE: usize = services::MAX_PORTS * services::BUFFER;

/// A frame in shared memory that no other process sees yet: write into it, then
/// [`publish`](ServerLink::publish) it.
pub struct FrameLoan(SampleMutUninit<Ipc, std::mem::MaybeUninit<WireFrame>, ()>);

/// An answer as it arrived.
pub struct ReceivedAnswer {
    /// The answer, copied out of shared memory. Anything may be in it.
    pub answer: Answer,
    /// Where the participant that it names has not signed it: the process whose
    /// port it came through, as that process's library reports it.
    pub forged_by: Option<u32>,
}

/// A process asks to join.
pub struct JoinCall {
    active: ActiveRequest<Ipc, [u8], (), [u8], ()>,
}

impl Deref for FrameLoan {
    type Target = Frame;

    fn deref(&self) -> &Frame {
        // SAFETY: a loan is a slot of a segment mapped from the kernel. Its bytes
        // are zero at first, and later those of an older frame, so they are
        // initialised; `Frame` is `Pod`, so every pattern of bytes is a frame.
        unsafe { &self.0.payload().assume_init_ref().0 }
    }
}

impl DerefMut for FrameLoan {
    fn deref_mut(&mut self) -> &mut Frame {
        // SAFETY: as in `deref`; the loan is the only access to these bytes.
        unsafe { &mut self.0.payload_mut().assume_init_mut().0 }
    }
}

impl FrameLoan {
    pub(crate) fn from(port: &Publisher<Ipc, WireFrame, ()>) -> Result<Self, LinkError> {
        port.loan_uninit().map(Self).map_err(LinkError::transport("loan a frame"))
    }

    pub(crate) fn send(mut self, now_ns: u64) -> Result<(), LinkError> {
        self.published_ns = now_ns;
        // SAFETY: the frame is initialised, see `deref`.
        let sample = unsafe { self.0.assume_init() };
        sample.send().map(|_| ()).map_err(LinkError::transport("publish a frame"))
    }
}

/// Sends a tally enciphered. `tally` is private memory: every participant can map
/// the place of what is sent.
pub(crate) fn send_tally(
    port: &Publisher<Ipc, WireTally, ()>,
    tally: &mut Tally,
    keys: &Keys,
    stream: u32,
) -> Result<(), LinkError> {
    let mut sample = port.loan_uninit().map_err(LinkError::transport("loan a tally"))?;
    let sealed = tally.seal(&keys.truth, stream);
    let place = sample.payload_mut().as_mut_ptr().cast::<u8>();
    // SAFETY: `place` has the size of a `Tally`, and `sealed` is the first part of
    // one in private memory, so the copy fits and the two do not overlap. The bytes
    // after it are initialised, as in `FrameLoan::deref`; `Tally` is `Pod`, so every
    // pattern of bytes is a tally.
    let sample = unsafe {
        std::ptr::copy_nonoverlapping(sealed.as_ptr(), place, sealed.len());
        sample.assume_init()
    };
    sample.send().map(|_| ()).map_err(LinkError::transport("publish a tally"))
}

impl ServerLink {
    /// Creates the services of a run and the server's ports on them, and leaves
    /// the control key in the run's folder. All other keys derive from `key`.
    ///
    /// # Errors
    /// [`LinkError::NoRoom`] if shared memory is full; [`LinkError::Transport`] says
    /// what could not be created.
    pub fn create(domain: &Domain, policy: WaitPolicy, key: &TruthKey) -> Result<Self, LinkError> {
        memory::ensure_room(memory::RUN_BYTES)?;
        let keys = Keys::new(key);
        domain.leave_control_key(&keys.control)?;
        let node = services::node(domain)?;
        let frames = services::create_pub_sub::<WireFrame>(&node, "frames", Direction::FromServer)?
            .publisher_builder()
            .max_loaned_samples(2)
            .create()
            .map_err(LinkError::transport("open the frames port"))?;
        let tallies =
            services::create_pub_sub::<WireTally>(&node, "tallies", Direction::FromServer)?
                .publisher_builder()
                .max_loaned_samples(2)
                .create()
                .map_err(LinkError::transport("open the tallies port"))?;
        let answers =
            services::create_pub_sub::<WireAnswer>(&node, "answers", Direction::ToServer)?
                .subscriber_builder()
                .create()
                .map_err(LinkError::transport("open the answers port"))?;
        let wake_clients = services::notifier(&node, "wake-clients", true)?;
        let woken = services::listener(&node, "wake-server", true)?;
        let beliefs = services::beliefs(&node, true).ok();
        // Last, because clients take it as the sign that all others exist.
        let controls = services::exchange(&node, "control", true)?
            .server_builder()
            .max_loaned_responses_per_request(1)
            .initial_max_slice_len(RESERVED_BYTES)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(LinkError::transport("open the control port"))?;
        let joins = services::exchange(&node, "join", true)?
            .server_builder()
            .max_loaned_responses_per_request(1)
            .initial_max_slice_len(1 << 12)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(LinkError::transport("open the join port"))?;
        let memory = domain.memory();
        memory::reserve(&memory)?;
        let waiting_since_ns = monotonic_ns();
        let waiter = Waiter::new(policy, waiting_since_ns);
        Ok(Self {
            frames,
            tallies,
            tally: Box::default(),
            answers,
            joins,
            controls,
            wake_clients,
            woken,
            policy,
            waiting_since_ns,
            waiter,
            _beliefs: beliefs,
            node,
            memory,
            keys,
            catch_ups: 0,
            received: Vec::with_capacity(ANSWERS_AT_ONCE),
        })
    }

    /// The keys of the run.
    #[must_use]
    pub fn keys(&self) -> &Keys {
        &self.keys
    }

    /// How the server waits.
    #[must_use]
    pub fn policy(&self) -> WaitPolicy {
        self.policy
    }

    /// The next request to join, if there is one.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn next_join(&self) -> Result<Option<JoinCall>, LinkError> {
        let active = self.joins.receive().map_err(LinkError::transport("receive a request"))?;
        Ok(active.map(|active| JoinCall { active }))
    }

    /// The next wish about the time of the run, if there is one.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn next_control(&self) -> Result<Option<ControlCall>, LinkError> {
        let active = self.controls.receive().map_err(LinkError::transport("receive a request"))?;
        Ok(active.map(ControlCall))
    }

    /// A frame in shared memory to write the next tick into.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn loan(&self) -> Result<FrameLoan, LinkError> {
        FrameLoan::from(&self.frames)
    }

    /// Signs a frame for the participants at `slots`, sends it to everyone, and
    /// returns when. The wait for its answers
    /// begins; who did not get it shows by not answering.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn publish(
        &mut self,
        mut frame: FrameLoan,
        slots: impl Iterator<Item = usize>,
    ) -> Result<u64, LinkError> {
        for slot in slots {
            if let Some(key) = self.keys.participant(slot) {
                frame.sign(slot, &key.from_server);
            }
        }
        let now = monotonic_ns();
        frame.send(now)?;
        self.stay_awake(now);
        Ok(now)
    }

    /// The wait begins anew, as after a publication.
    pub fn stay_awake(&mut self, now_ns: u64) {
        self.waiting_since_ns = now_ns;
        self.waiter = Waiter::new(self.policy, now_ns);
    }

    /// Sleeps from now on until the next publication: there is no answer to wait
    /// for, and requests wake the server by themselves. Nothing changes for a
    /// server that never sleeps.
    pub fn rest(&mut self) {
        self.waiter.rest();
    }

    /// Gives back what participants that were killed had opened: each port has
    /// one of a bounded number of places. What cannot be given back now will be
    /// at the next call, or goes with the run.
    pub fn forget_the_dead(&self) {
        let _ = self.node.try_cleanup_dead_nodes();
    }

    /// Allocates the shared memory that participants have opened since the last
    /// call: to be called before the first tick.
    ///
    /// # Errors
    /// [`LinkError::NoRoom`] if shared memory is full.
    pub fn reserve(&self) -> Result<(), LinkError> {
        memory::reserve(&self.memory)
    }

    /// A separate way for one that comes back into the run.
    ///
    /// # Errors
    /// [`LinkError::Transport`] says what could not be created.
    pub fn feed(&mut self, service: &str, slot: usize) -> Result<Feed, LinkError> {
        memory::ensure_room(memory::RUN_BYTES)?;
        self.catch_ups += 1;
        Feed::create(&self.node, service, slot, self.keys.clone(), self.catch_ups)
    }

    /// Sends the answers of a tick to scorers and loggers.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn publish_tally(&mut self, write: impl FnOnce(&mut Tally)) -> Result<(), LinkError> {
        write(&mut self.tally);
        send_tally(&self.tallies, &mut self.tally, &self.keys, 0)
    }

    /// Wakes the clients if one of them may be asleep: each is given by when
    /// it began to wait and how long it stays awake, ns.
    pub fn wake_sleepers(&self, mut waiting: impl Iterator<Item = (u64, u64)>) {
        let now = monotonic_ns();
        if waiting.any(|(since_ns, awake_ns)| may_sleep(now, since_ns, awake_ns)) {
            self.wake_all();
        }
    }

    /// Wakes every client.
    pub fn wake_all(&self) {
        // A wake-up that fails is one that is lost: the client looks by itself
        // after a slice.
        let _ = self.wake_clients.notify();
    }

    /// Takes the answers that are there, and returns how many. Each is copied
    /// out of shared memory once, before anybody looks at it.
    ///
    /// A sender without end is served a few times in each turn, and no process
    /// waits behind it: the transport lends no more than a buffer's worth of one
    /// sender's answers at once, and they are given back when the turn is over.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn take_answers(
        &mut self,
        mut take: impl FnMut(ReceivedAnswer),
    ) -> Result<usize, LinkError> {
        while self.received.len() < ANSWERS_AT_ONCE {
            match self.answers.receive() {
                Ok(Some(sample)) => {
                    let answer = sample.payload().0;
                    let is_signed = self.keys.has_signed_answer(&answer);
                    let forged_by = (!is_signed).then(|| process_of(sample.origin().value()));
                    take(ReceivedAnswer { answer, forged_by });
                    self.received.push(sample);
                }
                Ok(None) | Err(ReceiveError::ExceedsMaxBorrows) => break,
                Err(e) => return Err(LinkError::transport("receive an answer")(e)),
            }
        }
        let taken = self.received.len();
        self.received.clear();
        Ok(taken)
    }

    /// Gives the others time: yields while the awake time lasts, then blocks
    /// until a process wakes the server, a process of `peers` (asked for only
    /// then) ends, or a slice or `at_most` is over. Says whether it blocked.
    pub fn pause<'p, P>(&mut self, peers: impl FnOnce() -> P, at_most: Duration) -> bool
    where
        P: Iterator<Item = &'p Peer>,
    {
        if self.waiter.yielded() {
            return false;
        }
        let mut fds = vec![readable(services::listener_fd(&self.woken))];
        fds.extend(peers().filter_map(|peer| peer.fd()).map(|fd| readable(fd)));
        self.waiter.block(&mut fds, at_most);
        services::drain(&self.woken);
        true
    }

    /// Gives the others time if its awake time lasts; says whether it does.
    #[must_use]
    pub fn yielded(&self) -> bool {
        self.waiter.yielded()
    }

    /// Blocks for several runs of one process until one of them is woken, a process of
    /// `peers` ends, or a slice or `at_most` is over.
    pub fn block_all(links: &mut [&mut Self], peers: &[&Peer], at_most: Duration) {
        let Some(mut waiter) = links.first().map(|link| link.waiter.clone()) else { return };
        let woken = links.iter().map(|link| readable(services::listener_fd(&link.woken)));
        let mut fds: Vec<PollFd<'_>> = woken.collect();
        fds.extend(peers.iter().filter_map(|peer| peer.fd()).map(readable));
        waiter.block(&mut fds, at_most);
        drop(fds);
        links.iter().for_each(|link| services::drain(&link.woken));
        links[0].waiter = waiter;
    }
}

impl JoinCall {
    /// The request.
    ///
    /// # Errors
    /// [`Refusal::Unreadable`] to send back.
    pub fn request(&self) -> Result<JoinRequest, Refusal> {
        let request = JoinRequest::from_bytes(self.active.payload())?;
        let from = process_of(self.active.origin().value());
        if from != request.pid {
            let problem = format!("it names process {}, process {from} sent it", request.pid);
            return Err(Refusal::Unreadable(problem));
        }
        Ok(request)
    }

    /// Answers the request.
    ///
    /// # Errors
    /// [`LinkError::Transport`], for instance because the caller has ended.
    pub fn reply(self, reply: &JoinReply) -> Result<(), LinkError> {
        let json = reply.to_json().map_err(LinkError::transport("write a reply"))?;
        memory::ensure_room(REPLY_COPIES * json.len() as u64)?;
        respond(&self.active, &json)
    }
}
