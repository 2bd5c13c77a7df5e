//! The way to say to a run that goes on when its ticks may happen.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use rusty_contract::control::{ControlError, ControlReply, ControlRequest};
use rusty_contract::{AuthKey, Json as _, RunName};

use crate::lobby::Lobby;
use crate::port::{process_of, respond};
use crate::services::Ipc;
use crate::{Domain, Keys, LinkError, memory};

/// Replies up to this length have their place from the start, bytes.
pub(crate) const RESERVED_BYTES: usize = 1 << 10;
/// Time for the server of a run to appear: it may have been started a moment ago.
const START_TIME: Duration = Duration::from_secs(2);

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

    /// Whether the caller still waits: it has not taken the reply. One that was killed
    /// seems to wait.
    #[must_use]
    pub fn is_awaited(&self) -> bool {
        self.0.is_connected()
    }

    /// Answers it. The caller maps the reply when it takes it, so the server's port has
    /// to be there until then.
    ///
    /// # Errors
    /// [`LinkError::Transport`], for instance because the caller has ended.
    pub fn reply(&self, reply: &ControlReply) -> Result<(), LinkError> {
        let json = reply.to_json().map_err(LinkError::transport("write a reply"))?;
        if json.len() > RESERVED_BYTES {
            // The port grows by as much, with copies on the way.
            memory::ensure_room(4 * json.len() as u64)?;
        }
        respond(&self.0, &json)
    }
}

/// Sends a request to a run, which may be about to start, and waits for its reply, up to
/// `timeout`.
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
    let [soon, deadline] =
        [timeout.min(START_TIME), timeout].map(|time| now.checked_add(time).unwrap_or(now));
    let lobby = match Lobby::find(run, None, soon, &never) {
        // There is a run, which is still being set up.
        Err(LinkError::Transport { .. }) => Lobby::find(run, None, deadline, &never)?,
        found => found?,
    };
    ask(&lobby, request, deadline, &never)
}

/// Makes a request in a run that was found.
pub(crate) fn ask(
    lobby: &Lobby,
    request: ControlRequest,
    deadline: Instant,
    stop: &AtomicBool,
) -> Result<ControlReply, LinkError> {
    let key = control_key(&lobby.domain)?;
    let number = getrandom::u64().map_err(LinkError::transport("draw a number"))?;
    let bytes = request.signed(&key, number).map_err(LinkError::transport("write a request"))?;
    let reply = lobby.exchange(&lobby.requests("control")?, &bytes, Some(deadline), stop)?;
    ControlReply::from_json(&reply).map_err(LinkError::transport("read the reply"))
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
