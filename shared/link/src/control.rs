//! The way to say to a run that goes on when its ticks may happen.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use rusty_contract::control::{ControlError, ControlReply, ControlRequest};
use rusty_contract::{AuthKey, RunName};

use crate::lobby::Lobby;
use crate::port::{process_of, respond};
use crate::services::Ipc;
use crate::{Domain, Keys, LinkError};

/// A control request.
pub struct ControlCall(pub(crate) ActiveRequest<Ipc, [u8], (), [u8], ()>);

impl ControlCall {
    /// The request and its number, if it is signed with the run's control key.
    ///
    /// # Errors
    /// [`ControlError`], to be sent back.
    pub fn request(&self, keys: &Keys) -> Result<(ControlRequest, u64), ControlError> {
        ControlRequest::from_signed(self.0.payload(), &keys.control)
    }

    /// The process that sent it; 0 if the transport does not say.
    #[must_use]
    pub fn pid(&self) -> u32 {
        process_of(self.0.origin().value())
    }

    /// Answers it.
    ///
    /// # Errors
    /// [`LinkError::Transport`], for instance because the caller has ended.
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
    let key = control_key(&lobby.domain)?;
    let number = getrandom::u64().map_err(LinkError::transport("draw a number"))?;
    let bytes = request.signed(&key, number).map_err(LinkError::transport("write a request"))?;
    let deadline = now.checked_add(timeout).unwrap_or(now);
    let reply = lobby.exchange("control", &bytes, deadline, &never)?;
    serde_json::from_slice(&reply).map_err(LinkError::transport("read the reply"))
}

/// The key that the server left in its run's folder.
fn control_key(domain: &Domain) -> Result<AuthKey, LinkError> {
    let path = domain.control_key_file();
    let unreadable = |error: String| LinkError::NoControlKey {
        run: domain.run().to_string(),
        path: path.display().to_string(),
        error,
    };
    let text = std::fs::read_to_string(&path).map_err(|e| unreadable(e.to_string()))?;
    AuthKey::from_hex(&text).map_err(|e| unreadable(e.to_string()))
}
