//! Before a participant has a slot: finding the run, asking to join it; and asking for
//! the next run of a series.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::Node;
use rusty_contract::{JoinReply, JoinRequest, Json as _, RunName, Start};

use crate::services::{self, Ipc};
use crate::wait::{Waiter, readable};
use crate::{Domain, DomainError, LinkError, Peer, WaitPolicy};

/// How long between two looks for a server that is not there yet.
const RETRY: Duration = Duration::from_millis(5);

type Pending = PendingResponse<Ipc, [u8], (), [u8], ()>;

/// What a process has in common with the server of a run that it has found, whether it
/// has a slot or not.
pub(crate) struct Lobby {
    pub(crate) wake_server: Notifier<Ipc>,
    pub(crate) woken: Listener<Ipc>,
    pub(crate) server: Peer,
    pub(crate) node: Node<Ipc>,
    pub(crate) domain: Domain,
}

/// A port for requests on a service of the server.
pub(crate) struct RequestPort(Client<Ipc, [u8], (), [u8], ()>);

impl Lobby {
    /// Looks for the run until it is there, the server that launched this
    /// process for it has ended, or `deadline` is over.
    pub(crate) fn find(
        run: &RunName,
        launcher: Option<&Peer>,
        deadline: Instant,
        stop: &AtomicBool,
    ) -> Result<Self, LinkError> {
        loop {
            let entered = Self::enter(run);
            // Asked last: the run that was entered may be a later one of the
            // same name.
            if let Some(server) = launcher.filter(|server| server.is_dead()) {
                return Err(LinkError::ServerGone { pid: server.pid() });
            }
            match entered {
                Ok(lobby) => return Ok(lobby),
                Err(e) if Instant::now() >= deadline => return Err(e),
                // Not there yet, or still being set up.
                Err(
                    LinkError::Domain(DomainError::NoSuchRun { .. }) | LinkError::Transport { .. },
                ) => {}
                Err(e) => return Err(e),
            }
            if stop.load(Ordering::Relaxed) {
                return Err(LinkError::Stopped);
            }
            std::thread::sleep(RETRY);
        }
    }

    fn enter(run: &RunName) -> Result<Self, LinkError> {
        let domain = Domain::find(run)?;
        let node = services::node(&domain)?;
        // The server creates this one last: where it is, all are.
        services::exchange(&node, "join", false)?;
        let woken = services::listener(&node, "wake-clients", false)?;
        let wake_server = services::notifier(&node, "wake-server", false)?;
        let server = Peer::new(domain.server_pid());
        Ok(Self { wake_server, woken, server, node, domain })
    }

    /// Opens a port for requests.
    pub(crate) fn requests(&self, service: &str) -> Result<RequestPort, LinkError> {
        services::exchange(&self.node, service, false)?
            .client_builder()
            .initial_max_slice_len(rusty_contract::join::MAX_REQUEST_BYTES)
            .create()
            .map(RequestPort)
            .map_err(LinkError::transport("open a port for requests"))
    }

    /// Asks for a slot and waits for the reply; without a deadline as long as the server
    /// lives.
    pub(crate) fn ask(
        &self,
        port: &RequestPort,
        request: &JoinRequest,
        deadline: Option<Instant>,
        stop: &AtomicBool,
    ) -> Result<Start, LinkError> {
        let json = request.to_json().map_err(LinkError::transport("write a request"))?;
        let reply = self.exchange(port, &json, deadline, stop)?;
        match JoinReply::from_json(&reply).map_err(LinkError::transport("read the reply"))? {
            JoinReply::Start(start) => Ok(*start),
            JoinReply::Refused(refusal) => Err(refusal.into()),
        }
    }

    /// Sends a request and waits for the reply to it.
    pub(crate) fn exchange(
        &self,
        port: &RequestPort,
        request: &[u8],
        deadline: Option<Instant>,
        stop: &AtomicBool,
    ) -> Result<Vec<u8>, LinkError> {
        let send = || {
            let pending = port
                .0
                .loan_slice_uninit(request.len())
                .map_err(LinkError::transport("loan a request"))?
                .write_from_slice(request)
                .send()
                .map_err(LinkError::transport("send a request"))?;
            let _ = self.wake_server.notify();
            Ok::<_, LinkError>(pending)
        };
        let mut pending = send()?;
        let asked = Instant::now();
        let mut waiter = Waiter::new(WaitPolicy::Block, 0);
        let reply = |pending: &Pending| {
            let reply = pending.receive().map_err(LinkError::transport("receive the reply"))?;
            Ok::<_, LinkError>(reply.map(|reply| reply.payload().to_vec()))
        };
        loop {
            // Before the look, so that the last reply of a server that ends is seen.
            let is_dead = self.server.is_dead();
            if let Some(reply) = reply(&pending)? {
                return Ok(reply);
            }
            if stop.load(Ordering::Relaxed) {
                return Err(LinkError::Stopped);
            }
            let pid = self.server.pid();
            if is_dead {
                return Err(LinkError::ServerGone { pid });
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                let seconds = asked.elapsed().as_secs_f64();
                let run = self.domain.run().to_string();
                return Err(LinkError::NoAnswer { run, seconds, pid });
            }
            let mut fds = vec![readable(services::listener_fd(&self.woken))];
            fds.extend(self.server.fd().map(readable));
            waiter.block(&mut fds, RETRY);
            services::drain(&self.woken);
            // A service is there a moment before the server's port on it: a
            // request that reached no process is made again. The port of a server
            // that has replied and ended is gone as well, and its reply is there.
            if pending.number_of_server_connections() == 0 {
                if let Some(reply) = reply(&pending)? {
                    return Ok(reply);
                }
                pending = send()?;
            }
        }
    }
}
