//! What a person or script may say to a run that goes on: when its next tick
//! may happen, never what is in it. JSON, like joining.

use serde::{Deserialize, Serialize};

/// Longest request the server reads, bytes.
pub const MAX_CONTROL_BYTES: usize = 256;

/// A wish about the time of a run. None of them changes a bit of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControlRequest {
    /// Where does it stand?
    Status,
    /// No tick after the one that is being worked on.
    Pause,
    /// So many ticks more, then pause. The reply comes when they are complete.
    Step(u64),
    /// On, at the pace it had.
    Resume,
    /// The run ends after this tick, as by Ctrl-C.
    Stop,
}

/// Where a run stands.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ControlStatus {
    /// Its name.
    pub run: String,
    /// Whether it waits for a `step` or `resume`.
    pub paused: bool,
    /// Ticks that are complete.
    pub ticks_done: u64,
    /// Ticks there are to be.
    pub ticks: u64,
}

/// What the server says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ControlReply {
    /// Done; this is where the run stands now.
    Status(ControlStatus),
    /// It cannot be done.
    Refused(String),
}

impl ControlRequest {
    /// Reads what arrived.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() > MAX_CONTROL_BYTES {
            return Err(format!("{} bytes, at most {MAX_CONTROL_BYTES}", bytes.len()));
        }
        serde_json::from_slice(bytes).map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_request_is_refused_in_words() {
        let json = serde_json::to_vec(&ControlRequest::Step(3)).unwrap();
        assert_eq!(ControlRequest::from_bytes(&json), Ok(ControlRequest::Step(3)));
        assert!(ControlRequest::from_bytes(b"\"dance\"").unwrap_err().contains("dance"));
        assert!(ControlRequest::from_bytes(b"{\"step\":-1}").is_err());
        assert!(ControlRequest::from_bytes(&[b' '; 300]).unwrap_err().contains("at most 256"));
    }
}
