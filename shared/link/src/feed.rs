//! The separate way by which one that comes back into a run is given the
//! ticks it missed, while all others go on seeing the ticks of the run alone.

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::Node;
use iceoryx2::sample::Sample;
use rusty_contract::{CatchUp, Frame, Tally};

use crate::server::{FrameLoan, send_tally};
use crate::services::{self, BUFFER, Direction, Ipc, WireFrame, WireTally};
use crate::wait::monotonic_ns;
use crate::{Keys, LinkError};

/// The server's end: frames, and tallies for scorers and loggers.
pub struct Feed {
    frames: Publisher<Ipc, WireFrame, ()>,
    tallies: Publisher<Ipc, WireTally, ()>,
    slot: usize,
    keys: Keys,
    stream: u32,
}

impl Feed {
    pub(crate) fn create(
        node: &Node<Ipc>,
        service: &str,
        slot: usize,
        keys: Keys,
        stream: u32,
    ) -> Result<Self, LinkError> {
        let frames = services::create_pub_sub::<WireFrame>(node, service, Direction::FromServer)?
            .publisher_builder()
            .max_loaned_samples(2)
            .create()
            .map_err(LinkError::transport("open a port for ticks given again"))?;
        let tallies = services::create_pub_sub::<WireTally>(
            node,
            &tallies_of(service),
            Direction::FromServer,
        )?
        .publisher_builder()
        .max_loaned_samples(2)
        .create()
        .map_err(LinkError::transport("open a port for tallies given again"))?;
        Ok(Self { frames, tallies, slot, keys, stream })
    }

    /// A frame in shared memory to write the next tick into.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn loan(&self) -> Result<FrameLoan, LinkError> {
        FrameLoan::from(&self.frames)
    }

    /// Sends a frame, and says when.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn publish(&self, mut frame: FrameLoan) -> Result<u64, LinkError> {
        if let Some(key) = self.keys.participant(self.slot) {
            frame.sign(self.slot, &key.from_server);
        }
        let now = monotonic_ns();
        frame.send(now)?;
        Ok(now)
    }

    /// Sends the answers of a tick.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn publish_tally(&self, write: impl FnOnce(&mut Tally)) -> Result<(), LinkError> {
        let mut tally = Tally::default();
        write(&mut tally);
        send_tally(&self.tallies, &mut tally, &self.keys, self.stream)
    }
}

fn tallies_of(service: &str) -> String {
    format!("{service}-tallies")
}

/// A participant's end. It is read to its last tick before the run's own
/// frames are looked at.
pub(crate) struct Refeed {
    frames: Subscriber<Ipc, WireFrame, ()>,
    tallies: Option<Subscriber<Ipc, WireTally, ()>>,
    /// Frames that are still to come this way.
    left: u64,
}

impl Refeed {
    pub(crate) fn open(
        node: &Node<Ipc>,
        catch_up: &CatchUp,
        with_tallies: bool,
    ) -> Result<Self, LinkError> {
        let frames = services::subscribe::<WireFrame>(node, &catch_up.service, BUFFER)?;
        let tallies = tallies_of(&catch_up.service);
        let tallies = with_tallies
            .then(|| services::subscribe::<WireTally>(node, &tallies, BUFFER))
            .transpose()?;
        Ok(Self { frames, tallies, left: catch_up.ticks })
    }

    /// Whether all frames have come.
    pub(crate) fn is_over(&self) -> bool {
        self.left == 0
    }

    pub(crate) fn next(&mut self) -> Result<Option<Sample<Ipc, WireFrame, ()>>, LinkError> {
        let sample = self.frames.receive().map_err(LinkError::transport("receive a frame"))?;
        self.left -= u64::from(sample.is_some());
        Ok(sample)
    }

    pub(crate) fn next_tally(&self) -> Result<Option<Sample<Ipc, WireTally, ()>>, LinkError> {
        let Some(port) = &self.tallies else { return Ok(None) };
        port.receive().map_err(LinkError::transport("receive a tally"))
    }
}

/// Whether a frame is the end of a run, which comes to everyone at once.
pub(crate) fn is_end_of_run(frame: &Frame) -> bool {
    frame.phase() != rusty_contract::Phase::Tick
}
