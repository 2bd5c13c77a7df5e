//! The way to say to a run that goes on when its ticks may happen.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use rusty_contract::RunName;
use rusty_contract::control::{ControlReply, ControlRequest};

use crate::LinkError;
use crate::lobby::Lobby;
use crate::server::{process_of, respond};
use crate::services::Ipc;

/// Somebody has a wish.
pub struct ControlCall(pub(crate) ActiveRequest<Ipc, [u8], (), [u8], ()>);

impl ControlCall {
    /// The wish.
    ///
    /// # Errors
    /// What is wrong with it, to be sent back.
    pub fn request(&self) -> Result<ControlRequest, String> {
        ControlRequest::from_bytes(self.0.payload())
    }

    /// The process that sent it; 0 if the transport does not say.
    #[must_use]
    pub fn pid(&self) -> u32 {
        process_of(self.0.origin().value())
    }

    /// Answers it.
    ///
    /// # Errors
    /// [`LinkError::Transport`], for instance because the caller is gone.
    pub fn reply(self, reply: &ControlReply) -> Result<(), LinkError> {
        let json = serde_json::to_vec(reply).map_err(LinkError::transport("write a reply"))?;
        respond(&self.0, &json)
    }
}

/// Says something to a run and waits for its reply, up to `timeout`.
///
/// # Errors
/// [`LinkError::Domain`] if there is no such run, [`LinkError::NoAnswer`],
/// [`LinkError::ServerGone`].
pub fn control(
    run: &RunName,
    request: ControlRequest,
    timeout: Duration,
) -> Result<ControlReply, LinkError> {
    let never = AtomicBool::new(false);
    let now = Instant::now();
    let lobby = Lobby::find(run, None, now, &never)?;
    let json = serde_json::to_vec(&request).map_err(LinkError::transport("write a request"))?;
    let deadline = now.checked_add(timeout).unwrap_or(now);
    let reply = lobby.exchange("control", &json, deadline, &never)?;
    serde_json::from_slice(&reply).map_err(LinkError::transport("read the reply"))
}
