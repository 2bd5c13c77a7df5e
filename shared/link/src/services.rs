//! The services of a run, with the numbers both sides must agree on.
//!
//! The server creates them all and so fixes their limits; clients only open.

use iceoryx2::node::NodeView as _;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{
    CallbackProgression, FileDescriptorBased as _, Node, NodeBuilder, NodeName,
};
use iceoryx2::prelude::{NodeState, ServiceName, SignalHandlingMode, ZeroCopySend};
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};
use rusty_contract::belief::belief_hash;
use rusty_contract::layout::layout_hash;
use rusty_contract::{Answer, BeliefHeader, Frame, Tally, WeightedPose};
use std::os::fd::BorrowedFd;
use std::time::Duration;

use crate::{Domain, LinkError, memory, with_umask};

pub(crate) use crate::wire::Wire as Ipc;
pub(crate) type PubSub<T> = publish_subscribe::PortFactory<Ipc, T, ()>;
pub(crate) type BeliefService = publish_subscribe::PortFactory<Ipc, [WirePose], WireBelief>;
pub(crate) type Exchange = request_response::PortFactory<Ipc, [u8], (), [u8], ()>;
pub(crate) type Wakes = event::PortFactory<Ipc>;

/// More ports than participants: observers come and go, and the port of a
/// process that was killed stays until the run is swept.
pub(crate) const MAX_PORTS: usize = 64;
/// Frames, tallies or answers that wait for a reader; lockstep needs one.
pub(crate) const BUFFER: usize = 4;
/// Frames and tallies that wait for an observer, which is never waited for.
pub(crate) const OBSERVER_BUFFER: usize = 16;
/// How many frames of a run a participant can hold at a time, the one it waits
/// for included.
pub const MAX_HELD_FRAMES: usize = BUFFER;

/// Filters that show beliefs, and those who look on at a time. The port of a filter
/// that was killed keeps its place until the run is swept, that of a viewer
/// until the next viewer comes.
const MAX_SHOWING: usize = 16;
const MAX_LOOKING: usize = 6;

/// Declares a payload: a contract struct whose type name carries a layout
/// hash, so that two builds with other layouts do not open each other's
/// service even where the sizes are equal.
macro_rules! payload {
    ($name:ident($inner:ty) = $text:literal, $hash:expr) => {
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub(crate) struct $name(pub(crate) $inner);

        // SAFETY: the inner struct is `#[repr(C)]`, `Pod` (no pointers, no
        // padding, every bit pattern valid) and self-contained; the name below
        // is unique to it and to its layout.
        unsafe impl ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                const TEXT: &[u8] = $text.as_bytes();
                const NAME: [u8; TEXT.len() + 16] = {
                    let mut name = [0; TEXT.len() + 16];
                    let mut i = 0;
                    while i < TEXT.len() {
                        name[i] = TEXT[i];
                        i += 1;
                    }
                    let hash: u64 = $hash;
                    let mut digit = 0;
                    while digit < 16 {
                        let nibble = (hash >> (60 - 4 * digit)) as usize & 0xF;
                        name[i + digit] = b"0123456789abcdef"[nibble];
                        digit += 1;
                    }
                    name
                };
                const STR: &str = match std::str::from_utf8(&NAME) {
                    Ok(text) => text,
                    Err(_) => $text,
                };
                STR
            }
        }
    };
}

payload!(WireFrame(Frame) = "rusty.Frame.", layout_hash());
payload!(WireAnswer(Answer) = "rusty.Answer.", layout_hash());
payload!(WireTally(Tally) = "rusty.Tally.", layout_hash());
payload!(WireBelief(BeliefHeader) = "rusty.BeliefHeader.", belief_hash());
payload!(WirePose(WeightedPose) = "rusty.WeightedPose.", belief_hash());

#[allow(clippy::derivable_impls)] // what the macro derives is for all payloads
impl Default for WireBelief {
    fn default() -> Self {
        Self(BeliefHeader::default())
    }
}

/// Poses as they go through the service.
pub(crate) fn wire_poses(poses: &[WeightedPose]) -> &[WirePose] {
    // SAFETY: `WirePose` is a transparent wrapper of `WeightedPose`.
    unsafe { std::slice::from_raw_parts(poses.as_ptr().cast(), poses.len()) }
}

/// The name of a viewer's node.
const VIEWER: &str = "viewer";

/// A node in the run's domain, with our own signal handling.
pub(crate) fn node(domain: &Domain) -> Result<Node<Ipc>, LinkError> {
    named_node(domain, "")
}

/// The node of a viewer. Places of viewers that were killed are freed first:
/// their nodes have no part in the run, so their removal disturbs no participant.
pub(crate) fn viewer_node(domain: &Domain) -> Result<Node<Ipc>, LinkError> {
    let config = domain.transport()?;
    // A list that cannot be had frees no place, and the next one may.
    let _ = Node::<Ipc>::list(&config, |state| {
        if let NodeState::Dead(dead) = state
            && dead.details().as_ref().is_some_and(|of| of.name().as_str() == VIEWER)
        {
            let _ = dead.blocking_remove_stale_resources(OTHERS_TIME);
        }
        CallbackProgression::Continue
    });
    named_node(domain, VIEWER)
}

/// How long another process may take to remove the same dead node.
const OTHERS_TIME: Duration = Duration::from_secs(1);

fn named_node(domain: &Domain, name: &str) -> Result<Node<Ipc>, LinkError> {
    memory::ensure_room(memory::PORTS_BYTES)?;
    NodeBuilder::new()
        .name(&NodeName::new(name).map_err(LinkError::transport("name a node"))?)
        .config(&domain.transport()?)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Ipc>()
        .map_err(LinkError::transport("join the run's domain"))
}

fn name(text: &str) -> Result<ServiceName, LinkError> {
    ServiceName::new(text).map_err(LinkError::transport("name a service"))
}

/// Who sends on a service and who receives: one side is the server alone, so no
/// other process can open a port there.
#[derive(Clone, Copy)]
pub(crate) enum Direction {
    FromServer,
    ToServer,
}

/// Creates a publish-subscribe service.
pub(crate) fn create_pub_sub<T: ZeroCopySend + std::fmt::Debug>(
    node: &Node<Ipc>,
    text: &str,
    direction: Direction,
) -> Result<PubSub<T>, LinkError> {
    let (publishers, subscribers, waiting) = match direction {
        Direction::FromServer => (1, MAX_PORTS, OBSERVER_BUFFER),
        Direction::ToServer => (MAX_PORTS, 1, BUFFER),
    };
    node.service_builder(&name(text)?)
        .publish_subscribe::<T>()
        .max_publishers(publishers)
        .max_subscribers(subscribers)
        .max_nodes(2 * MAX_PORTS)
        .subscriber_max_buffer_size(waiting)
        .subscriber_max_borrowed_samples(BUFFER)
        .history_size(0)
        // A dead or slow reader loses its oldest sample; it never blocks
        // the writer.
        .enable_safe_overflow(true)
        .create()
        .map_err(LinkError::transport("create a service"))
}

/// Opens a publish-subscribe service that the server has created.
pub(crate) fn open_pub_sub<T: ZeroCopySend + std::fmt::Debug>(
    node: &Node<Ipc>,
    text: &str,
) -> Result<PubSub<T>, LinkError> {
    let builder = node.service_builder(&name(text)?).publish_subscribe::<T>();
    builder.open().map_err(LinkError::transport("open a service"))
}

/// Opens a port on a service of the server, where `waiting` samples may wait.
pub(crate) fn subscribe<T: ZeroCopySend + std::fmt::Debug>(
    node: &Node<Ipc>,
    text: &str,
    waiting: usize,
) -> Result<Subscriber<Ipc, T, ()>, LinkError> {
    let port = open_pub_sub::<T>(node, text)?
        .subscriber_builder()
        .buffer_size(waiting)
        .create()
        .map_err(LinkError::transport("open a port for what the server sends"))?;
    // A subscriber that has never looked is passed over once its queue is full; the
    // first look also connects it.
    let _ = port.has_samples();
    Ok(port)
}

/// Creates the service of beliefs, or opens it.
pub(crate) fn beliefs(node: &Node<Ipc>, create: bool) -> Result<BeliefService, LinkError> {
    let builder = node.service_builder(&name("beliefs")?).publish_subscribe::<[WirePose]>();
    let builder = builder.user_header::<WireBelief>();
    if create {
        builder
            .max_publishers(MAX_SHOWING)
            .max_subscribers(MAX_LOOKING)
            .max_nodes(2 * MAX_PORTS)
            // Of a reader that keeps pace with the ticks, as scorers do, no
            // more than three are on the way.
            .subscriber_max_buffer_size(BUFFER)
            .subscriber_max_borrowed_samples(1)
            .history_size(0)
            .enable_safe_overflow(true)
            .create()
            .map_err(LinkError::transport("create the service of beliefs"))
    } else {
        builder.open().map_err(LinkError::transport("open the service of beliefs"))
    }
}

/// Creates a service of requests and replies, or opens it.
pub(crate) fn exchange(node: &Node<Ipc>, text: &str, create: bool) -> Result<Exchange, LinkError> {
    let builder = node.service_builder(&name(text)?).request_response::<[u8], [u8]>();
    if create {
        builder
            .max_servers(1)
            .max_clients(MAX_PORTS)
            .max_nodes(2 * MAX_PORTS)
            .max_active_requests_per_client(2)
            // A request has one reply. What is reserved for more costs time at
            // every joining: the transport walks through it.
            .max_response_buffer_size(1)
            .max_borrowed_responses_per_pending_response(1)
            .create()
            .map_err(LinkError::transport("create a service of requests"))
    } else {
        builder.open().map_err(LinkError::transport("open a service of requests"))
    }
}

/// A port that wakes the listeners of a service, which it creates, or opens.
pub(crate) fn notifier(
    node: &Node<Ipc>,
    text: &'static str,
    create: bool,
) -> Result<Notifier<Ipc>, LinkError> {
    let port = wakes(node, text, create)?.notifier_builder().create();
    port.map_err(LinkError::transport("open a wake-up port"))
}

/// A port that is woken through a service, which it creates, or opens.
pub(crate) fn listener(
    node: &Node<Ipc>,
    text: &'static str,
    create: bool,
) -> Result<Listener<Ipc>, LinkError> {
    let wakes = wakes(node, text, create)?;
    let port = with_umask(|| wakes.listener_builder().create());
    port.map_err(LinkError::transport("open a wake-up port"))
}

/// Creates a wake-up service, or opens it.
fn wakes(node: &Node<Ipc>, text: &'static str, create: bool) -> Result<Wakes, LinkError> {
    let builder = node.service_builder(&name(text)?).event();
    if create {
        builder
            .max_listeners(MAX_PORTS)
            .max_notifiers(MAX_PORTS)
            .max_nodes(2 * MAX_PORTS)
            .event_id_max_value(1)
            .create()
            .map_err(LinkError::transport("create a wake-up service"))
    } else {
        builder.open().map_err(LinkError::transport("open a wake-up service"))
    }
}

/// The descriptor behind a listener.
pub(crate) fn listener_fd(listener: &Listener<Ipc>) -> BorrowedFd<'_> {
    // SAFETY: the descriptor is open for as long as the listener lives, and
    // the borrow ends before it.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}

/// Takes all waiting wake-ups. What they were for shows in the data.
pub(crate) fn drain(listener: &Listener<Ipc>) {
    // An error here means a wake-up is lost; the next look at the data comes
    // with the next slice.
    let _ = listener.try_wait(|_| {});
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ServerLink, WaitPolicy};
    use rusty_contract::{RunName, TruthKey};

    #[test]
    fn frames_and_tallies_have_one_sender_and_answers_one_receiver() {
        let run = RunName::new(&format!("t{}-ports", std::process::id())).unwrap();
        let domain = Domain::create(&run).unwrap();
        let key = TruthKey::from_bytes([7; 32]);
        let _server = ServerLink::create(&domain, WaitPolicy::Block, &key).unwrap();
        let other = node(&domain).unwrap();
        let frames = open_pub_sub::<WireFrame>(&other, "frames").unwrap();
        assert!(frames.publisher_builder().create().is_err());
        assert!(frames.subscriber_builder().create().is_ok());
        let tallies = open_pub_sub::<WireTally>(&other, "tallies").unwrap();
        assert!(tallies.publisher_builder().create().is_err());
        let answers = open_pub_sub::<WireAnswer>(&other, "answers").unwrap();
        assert!(answers.subscriber_builder().create().is_err());
        assert!(answers.publisher_builder().create().is_ok());
    }
}
