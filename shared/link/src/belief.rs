//! Beliefs for looking at: the way from a filter to an observer.
//!
//! A slice goes into shared memory once and is copied out once by each reader.
//! Neither end ever waits for the other: the queue of a reader that is slow,
//! stands still or is dead loses its oldest slice, and a filter that cannot
//! open its end shows nothing and is told nothing. Memory is bounded by the
//! places of the service; of each place only the pages are there that were
//! written.

use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, Node, PortFactory as _};
use rusty_contract::belief::MAX_POSES;
use rusty_contract::{BeliefHeader, RunName, WeightedPose};

use crate::memory::free_bytes;
use crate::services::{self, BeliefService, Ipc, WireBelief, WirePose};
use crate::{Domain, LinkError, Peer};

/// A filter opens its end only where so much shared memory is free: a page that
/// the kernel cannot give ends the process that writes to it.
const ROOM_BYTES: u64 = 32 << 20;

/// It shows a belief only where this much is still free: several may be about to.
const SPARE_BYTES: u64 = 8 << 20;

/// One process's ends of the service.
pub struct Beliefs {
    /// `None` where the run has no such service, or one of another layout.
    service: Option<BeliefService>,
    publisher: Option<Publisher<Ipc, [WirePose], WireBelief>>,
    subscriber: Option<Subscriber<Ipc, [WirePose], WireBelief>>,
    /// Opening an end failed; it is not tried again.
    is_closed: bool,
}

impl Beliefs {
    /// For a filter that shows; its port is made when a process observes.
    pub(crate) fn to_show(node: &Node<Ipc>) -> Self {
        let service = services::beliefs(node, false).ok();
        Self { service, publisher: None, subscriber: None, is_closed: false }
    }

    /// For one who looks; its port is made at once.
    pub(crate) fn to_see(node: &Node<Ipc>) -> Self {
        let mut beliefs = Self::to_show(node);
        let port = |service: &BeliefService| service.subscriber_builder().create().ok();
        beliefs.subscriber = beliefs.service.as_ref().and_then(port);
        // A subscriber that has never looked is passed over once its queue is
        // full.
        let _ = beliefs.subscriber.as_ref().map(Subscriber::has_samples);
        beliefs
    }

    /// Whether a process observes. Cheap: one number in shared memory.
    #[must_use]
    pub fn is_watched(&self) -> bool {
        let seen = |service: &BeliefService| service.dynamic_config().number_of_subscribers() > 0;
        !self.is_closed && self.service.as_ref().is_some_and(seen)
    }

    /// Whether its port for looking is open.
    #[must_use]
    pub fn is_looking(&self) -> bool {
        self.subscriber.is_some()
    }

    /// Shows a belief: at most [`MAX_POSES`], counted in `header`. Says whether
    /// it went out; that it did not is of no consequence to anybody.
    pub fn show(&mut self, header: BeliefHeader, poses: &[WeightedPose]) -> bool {
        if self.publisher.is_none() && !self.is_closed {
            self.publisher = self.service.as_ref().and_then(publisher);
            self.is_closed = self.publisher.is_none();
        }
        // Others may have filled the memory since.
        if free_bytes() < SPARE_BYTES {
            return false;
        }
        let poses = &poses[..poses.len().min(MAX_POSES)];
        let Some(loan) = self.publisher.as_ref().map(|port| port.loan_slice_uninit(poses.len()))
        else {
            return false;
        };
        // Without a place there is none for this one; the next may find some.
        let Ok(mut slice) = loan else { return false };
        slice.user_header_mut().0 = BeliefHeader { count: poses.len() as u32, ..header };
        slice.write_from_slice(services::wire_poses(poses)).send().is_ok()
    }

    /// Copies the next belief into `poses` and gives its header, if there is
    /// one. Anything may be in both but for their number.
    pub fn next(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefHeader> {
        let sample = self.subscriber.as_ref()?.receive().ok()??;
        let header = sample.user_header().0;
        poses.clear();
        poses.extend(sample.payload().iter().take(MAX_POSES).map(|pose| pose.0));
        Some(BeliefHeader { count: poses.len() as u32, ..header })
    }
}

fn publisher(service: &BeliefService) -> Option<Publisher<Ipc, [WirePose], WireBelief>> {
    if free_bytes() < ROOM_BYTES {
        return None;
    }
    // Of full size from the start: one that grows would have to remove segments,
    // which a sandbox forbids. Pages that no process writes take no memory.
    let builder = service.publisher_builder().initial_max_slice_len(MAX_POSES);
    let builder = builder.allocation_strategy(AllocationStrategy::Static).max_loaned_samples(1);
    builder.backpressure_strategy(BackpressureStrategy::DiscardData).create().ok()
}

/// An observer that has no part in the run: nothing of it knows of
/// them.
pub struct BeliefViewer {
    beliefs: Beliefs,
    server: Peer,
    _node: Node<Ipc>,
    domain: Domain,
}

impl BeliefViewer {
    /// Observes a run that is being served.
    ///
    /// # Errors
    /// [`LinkError::Domain`] if there is no such run; [`LinkError::Transport`]
    /// if its server shows no beliefs, or of another layout.
    pub fn open(run: &RunName) -> Result<Self, LinkError> {
        let opened = Self::enter(run);
        if opened.is_err() {
            // A run that ended meanwhile; see `drop`.
            let _ = Domain::named(run).sweep_if_dead();
        }
        opened
    }

    fn enter(run: &RunName) -> Result<Self, LinkError> {
        let domain = Domain::find(run)?;
        let server = Peer::new(domain.server_pid());
        let node = services::viewer_node(&domain)?;
        let beliefs = Beliefs::to_see(&node);
        let viewer = Self { beliefs, server, _node: node, domain };
        match viewer.beliefs.is_looking() {
            true => Ok(viewer),
            false => Err(LinkError::Transport {
                doing: "look on",
                why: "the run has no service of beliefs that this build reads, or too many look on"
                    .to_owned(),
            }),
        }
    }

    /// Waits for the next belief, for about `at_most`; see [`Beliefs::next`].
    pub fn wait(&self, at_most: Duration, poses: &mut Vec<WeightedPose>) -> Option<BeliefHeader> {
        const LOOK: Duration = Duration::from_millis(2);
        let mut left = at_most;
        loop {
            if let Some(header) = self.beliefs.next(poses) {
                return Some(header);
            }
            if left.is_zero() {
                return None;
            }
            std::thread::sleep(LOOK.min(left));
            left = left.saturating_sub(LOOK);
        }
    }

    /// Whether the server's process has ended.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.server.is_dead()
    }
}

impl Drop for BeliefViewer {
    fn drop(&mut self) {
        if self.server.is_dead() {
            let _ = self.domain.sweep_if_dead();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::files_in;
    use crate::memory::memory_state;
    use rusty_contract::BeliefKind;
    use std::os::unix::fs::MetadataExt as _;

    fn run(tag: &str) -> RunName {
        RunName::new(&format!("t{}-{tag}", std::process::id())).unwrap()
    }

    fn poses(n: usize, x_m: f64) -> Vec<WeightedPose> {
        vec![WeightedPose { x_m, y_m: 1.0, theta_rad: 0.5, weight: 0.25 }; n]
    }

    fn header(tick: u64) -> BeliefHeader {
        let name = BeliefHeader::padded("mcl");
        BeliefHeader { tick, kind: BeliefKind::Particles.number(), name, ..Default::default() }
    }

    /// A domain with the service, which is held.
    fn served(tag: &str) -> (Domain, Node<Ipc>, BeliefService) {
        let domain = Domain::create(&run(tag)).unwrap();
        let node = services::node(&domain).unwrap();
        let service = services::beliefs(&node, true).unwrap();
        (domain, node, service)
    }

    #[test]
    fn who_looks_sees_and_nobody_is_shown_to_without() {
        if memory_state().free_bytes < ROOM_BYTES {
            println!("skipped: too little shared memory");
            return;
        }
        let (domain, node, _service) = served("seen");
        let mut filter = Beliefs::to_show(&node);
        assert!(!filter.is_watched() && !filter.is_looking());
        let mut seen = Vec::new();
        {
            let scorer = Beliefs::to_see(&node);
            let viewer = BeliefViewer::open(domain.run()).unwrap();
            assert!(filter.is_watched() && scorer.is_looking() && !viewer.is_over());
            assert_eq!(scorer.next(&mut seen), None);
            for (tick, n) in [(3, 2), (8, 0), (9, MAX_POSES)] {
                assert!(filter.show(header(tick), &poses(n, tick as f64)));
                let expected = BeliefHeader { count: n as u32, ..header(tick) };
                assert_eq!(scorer.next(&mut seen), Some(expected));
                assert!(seen == poses(n, tick as f64));
            }
            // More than fits is cut; the viewer, who did not look meanwhile,
            // has the latest ones.
            assert!(filter.show(header(10), &poses(MAX_POSES + 1, 0.0)));
            let later = |seen: &mut Vec<WeightedPose>| viewer.wait(Duration::ZERO, seen);
            assert_eq!(later(&mut seen).map(|h| (h.tick, h.count)), Some((3, 2)));
            assert!(filter.show(header(11), &poses(1, 0.0)));
            let ticks: Vec<u64> = std::iter::from_fn(|| later(&mut seen)).map(|h| h.tick).collect();
            assert_eq!(ticks, [8, 9, 10, 11]);
        }
        assert!(!filter.is_watched());
    }

    #[test]
    fn who_stands_still_costs_nothing_but_the_oldest() {
        if memory_state().free_bytes < ROOM_BYTES {
            println!("skipped: too little shared memory");
            return;
        }
        let (domain, node, _service) = served("still");
        let mut filter = Beliefs::to_show(&node);
        let still = Beliefs::to_see(&node);
        let large = poses(MAX_POSES, 1.0);
        for tick in 0..200 {
            assert!(filter.show(header(tick), &large), "{tick}");
        }
        let mut seen = Vec::new();
        let ticks: Vec<u64> =
            std::iter::from_fn(|| still.next(&mut seen)).map(|h| h.tick).collect();
        assert_eq!(ticks, [196, 197, 198, 199]);
        // Of the places of the service only those are there that were used.
        let used =
            |path: &std::path::PathBuf| std::fs::metadata(path).map_or(0, |m| 512 * m.blocks());
        let used: u64 = files_in(&domain.memory()).iter().map(used).sum();
        assert!(used < 8 << 20, "{used} bytes");
        drop((filter, still));
    }

    #[test]
    fn without_the_service_nothing_is_shown_and_nothing_fails() {
        let domain = Domain::create(&run("without")).unwrap();
        let node = services::node(&domain).unwrap();
        let (mut filter, scorer) = (Beliefs::to_show(&node), Beliefs::to_see(&node));
        assert!(!filter.is_watched() && !scorer.is_looking());
        assert!(!filter.show(header(0), &poses(1, 0.0)));
        assert_eq!(scorer.next(&mut Vec::new()), None);
        let refused = BeliefViewer::open(domain.run()).err().unwrap().to_string();
        assert!(refused.contains("no service of beliefs"), "{refused}");
        assert!(BeliefViewer::open(&run("nobody")).is_err());
    }
}
