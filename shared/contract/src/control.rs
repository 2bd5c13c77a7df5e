//! What a person or script may say to a run that goes on: when its next tick
//! may happen, never what is in it. JSON, like joining.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::auth::AuthKey;
use crate::join::Start;
use crate::json::{Json as _, json};

/// Longest JSON text of a request that the server reads, bytes.
pub const MAX_CONTROL_BYTES: usize = 256;

/// A wish about the time of a run. None of them changes a bit of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControlRequest {
    /// Where does it stand?
    Status,
    /// No tick after the one that is being worked on.
    Pause,
    /// N ticks more, then pause. The reply comes when they are complete.
    Step(u64),
    /// On, at the pace it had.
    Resume,
    /// Simulated seconds per second from the next tick on, greater than 0; `None`: as
    /// fast as everyone answers. A pause stays.
    Pace(Option<f64>),
    /// The run ends after this tick, as by Ctrl-C.
    Stop,
    /// What an observer is told: a [`Start`] with the sealed brief.
    Describe,
}

/// Where a run stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlStatus {
    /// Its name.
    pub run: String,
    /// Whether it waits for a `step` or `resume`.
    pub paused: bool,
    /// Ticks that are complete.
    pub ticks_done: u64,
    /// Ticks there are to be.
    pub ticks: u64,
    /// Simulated seconds per second; `None`: as fast as everyone answers.
    pub pace: Option<f64>,
}

/// What the server says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ControlReply {
    /// Done; this is where the run stands now.
    Status(ControlStatus),
    /// The reply to [`ControlRequest::Describe`]. All that a participant may not know is
    /// in the sealed brief.
    Start(Box<Start>),
    /// It cannot be done.
    Refused(String),
}

/// Why a control request is not carried out.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ControlError {
    /// It does not carry the tag of the run's control key.
    #[error("it is not signed with the control key of this run")]
    Unsigned,
    /// It was received before.
    #[error("it was received before; every request has a number of its own")]
    Repeated,
    /// It cannot be read.
    #[error("it cannot be read: {0}")]
    Unreadable(String),
}

/// Bytes before the JSON text: the tag, then the number that the tag covers too.
const FRONT_BYTES: usize = 16;

json!(ControlReply, ControlRequest);

impl ControlRequest {
    /// The request as it travels: tag, `number`, JSON. A number is used once.
    ///
    /// # Errors
    /// What serde says; these requests have nothing that JSON cannot hold.
    pub fn signed(&self, key: &AuthKey, number: u64) -> Result<Vec<u8>, serde_json::Error> {
        let mut bytes = vec![0; 8];
        bytes.extend(number.to_le_bytes());
        bytes.extend(self.to_json()?);
        let tag = key.tag(&bytes[8..]);
        bytes[..8].copy_from_slice(&tag.to_le_bytes());
        Ok(bytes)
    }

    /// Reads what arrived: the request and its number. Anything may be in it.
    ///
    /// # Errors
    /// [`ControlError::Unsigned`], before anything else is looked at;
    /// [`ControlError::Unreadable`].
    pub fn from_signed(bytes: &[u8], key: &AuthKey) -> Result<(Self, u64), ControlError> {
        if bytes.len() > FRONT_BYTES + MAX_CONTROL_BYTES {
            let problem = format!("{} bytes, at most {MAX_CONTROL_BYTES}", bytes.len());
            return Err(ControlError::Unreadable(problem));
        }
        let (tag, signed) = bytes.split_first_chunk().ok_or(ControlError::Unsigned)?;
        let (number, json) = signed.split_first_chunk().ok_or(ControlError::Unsigned)?;
        if key.tag(signed) != u64::from_le_bytes(*tag) {
            return Err(ControlError::Unsigned);
        }
        let request = Self::from_json(json).map_err(|e| ControlError::Unreadable(e.to_string()))?;
        Ok((request, u64::from_le_bytes(*number)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_signed_requests_are_read() {
        let (key, other) = (AuthKey::from_bytes([1; 16]), AuthKey::from_bytes([2; 16]));
        let bytes = ControlRequest::Step(3).signed(&key, 9).unwrap();
        assert_eq!(ControlRequest::from_signed(&bytes, &key), Ok((ControlRequest::Step(3), 9)));
        assert_eq!(ControlRequest::from_signed(&bytes, &other), Err(ControlError::Unsigned));
        for byte in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[byte] ^= 1;
            let read = ControlRequest::from_signed(&changed, &key);
            assert_eq!(read, Err(ControlError::Unsigned), "byte {byte}");
            let cut = ControlRequest::from_signed(&bytes[..byte], &key);
            assert_eq!(cut, Err(ControlError::Unsigned), "{byte} bytes");
        }
    }

    #[test]
    fn text_that_is_not_a_request_is_an_error() {
        let key = AuthKey::from_bytes([1; 16]);
        let read = |json: &[u8]| {
            let signed = [&9u64.to_le_bytes()[..], json].concat();
            let tag = key.tag(&signed).to_le_bytes();
            ControlRequest::from_signed(&[&tag[..], &signed].concat(), &key)
        };
        let text = |json| read(json).unwrap_err().to_string();
        assert!(text(b"\"dance\"").contains("dance"));
        assert!(read(b"{\"step\":-1}").is_err());
        assert!(text(&[b' '; 300]).contains("at most 256"));
    }
}
