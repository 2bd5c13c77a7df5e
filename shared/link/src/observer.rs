//! An observer: a process that sees a run and has no part in it.
//!
//! It has ports on frames, tallies and beliefs, and no slot: nothing waits for it, no
//! digest knows it, and of what it is too slow for it loses the oldest. What is sealed
//! it can open if it has the key of a scorer.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::Node;
use rusty_contract::control::{ControlReply, ControlRequest};
use rusty_contract::{BeliefHeader, Credentials, RunName, Start, TruthKey, WeightedPose};

use crate::belief::Beliefs;
use crate::borrowed::{BorrowedFrame, BorrowedTally};
use crate::control::ask;
use crate::lobby::Lobby;
use crate::services::{self, Ipc, OBSERVER_BUFFER, WireFrame, WireTally};
use crate::wait::monotonic_ns;
use crate::{Domain, LinkError, Peer};

/// An observer's ports on a run.
pub struct Observer {
    start: Start,
    frames: Subscriber<Ipc, WireFrame, ()>,
    tallies: Subscriber<Ipc, WireTally, ()>,
    beliefs: Beliefs,
    server: Peer,
    _node: Node<Ipc>,
    domain: Domain,
}

impl Observer {
    /// Observes a run, which replies within `timeout`. With a `launcher`, the process that
    /// is about to serve it, it also waits for the run to appear while that lives.
    ///
    /// # Errors
    /// [`LinkError::Domain`] if there is no such run; [`LinkError::Unobserved`] with the
    /// server's reason; [`LinkError::Stopped`] if `stop` was raised.
    pub fn open(
        run: &RunName,
        launcher: Option<&Peer>,
        timeout: Duration,
        stop: &AtomicBool,
    ) -> Result<Self, LinkError> {
        let now = Instant::now();
        let deadline = now + timeout;
        let appears = if launcher.is_some() { deadline } else { now };
        let opened = Lobby::find(run, launcher, appears, stop)
            .and_then(|lobby| Self::enter(&lobby, deadline, stop));
        if opened.is_err() {
            // A run that ended meanwhile; see `drop`.
            let _ = Domain::named(run).sweep_if_dead();
        }
        opened
    }

    fn enter(lobby: &Lobby, deadline: Instant, stop: &AtomicBool) -> Result<Self, LinkError> {
        let start = match ask(lobby, ControlRequest::Describe, deadline, stop)? {
            ControlReply::Start(start) => *start,
            ControlReply::Refused(why) => return Err(LinkError::Unobserved { why }),
            ControlReply::Status(_) => {
                let why = "the server replied to another request".to_owned();
                return Err(LinkError::Unobserved { why });
            }
        };
        let domain = Domain::find(lobby.domain.run())?;
        let node = services::viewer_node(&domain)?;
        let frames = services::subscribe::<WireFrame>(&node, "frames", OBSERVER_BUFFER)?;
        let tallies = services::subscribe::<WireTally>(&node, "tallies", OBSERVER_BUFFER)?;
        let beliefs = Beliefs::to_see(&node);
        let server = Peer::new(domain.server_pid());
        Ok(Self { start, frames, tallies, beliefs, server, _node: node, domain })
    }

    /// What an observer is told; the rest is in its sealed brief.
    #[must_use]
    pub fn start(&self) -> &Start {
        &self.start
    }

    /// The run's place on this machine.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// The key to the truth that the server left for a scorer or logger which is started
    /// by hand; `None` where it left none, as in a run whose participants it started.
    #[must_use]
    pub fn key_left(&self) -> Option<TruthKey> {
        let files = std::fs::read_dir(self.domain.folder().join("keys")).ok()?;
        let mut texts = files.flatten().filter_map(|f| std::fs::read_to_string(f.path()).ok());
        texts.find_map(|text| Credentials::from_text(&text).ok()?.truth)
    }

    /// The next frame, if there is one. A process can hold few of them: copy what is
    /// needed for longer.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn next_frame(&self) -> Result<Option<BorrowedFrame>, LinkError> {
        let sample = self.frames.receive().map_err(LinkError::transport("receive a frame"))?;
        Ok(sample.map(|sample| BorrowedFrame { sample, taken_ns: monotonic_ns() }))
    }

    /// The next tally, if there is one. It is published after the frame of its tick.
    ///
    /// # Errors
    /// [`LinkError::Transport`].
    pub fn next_tally(&self) -> Result<Option<BorrowedTally>, LinkError> {
        let sample = self.tallies.receive().map_err(LinkError::transport("receive a tally"))?;
        Ok(sample.map(BorrowedTally))
    }

    /// Copies the next belief; see [`Beliefs::next`].
    pub fn next_belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefHeader> {
        self.beliefs.next(poses)
    }

    /// Whether the server's process has ended.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.server.is_dead()
    }
}

impl Drop for Observer {
    fn drop(&mut self) {
        if self.server.is_dead() {
            let _ = self.domain.sweep_if_dead();
        }
    }
}
