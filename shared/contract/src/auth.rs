//! Authenticity: tags that show which process sent an answer, a frame, a request
//! to join or a control request.
//!
//! Everything that travels between processes of a run is in memory that all of
//! them can map, and the transport believes each process what it says of itself.
//! So each message has a tag of 64 bits, SipHash-2-4 (Aumasson, Bernstein 2012)
//! with a key of 128 bits that only the server and one participant have. The
//! server derives the keys of all participants from the key of the run, which is
//! drawn afresh at every start; a participant gets its own by a private channel
//! ([`Credentials`]). A tag that does not match is a message that is not used.
//!
//! Limits: a tag of 64 bits is guessed once in 2^64 tries. Tags do not hide what
//! they protect, and bytes that change after they were checked are not noticed.

use siphasher::sip::SipHasher24;
use thiserror::Error;

use crate::truth::{KEY_BYTES, KeyError, Purpose, TruthKey, bytes_from_hex};

/// A key that two processes share. Its `Debug` shows nothing.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct AuthKey([u64; 2]);

impl AuthKey {
    /// Length, bytes.
    pub const BYTES: usize = 16;

    /// The key with these bytes.
    #[must_use]
    pub fn from_bytes(bytes: [u8; Self::BYTES]) -> Self {
        Self(bytemuck::cast(bytes))
    }

    /// What the server shares with those who may control the run.
    #[must_use]
    pub fn of_control(key: &TruthKey) -> Self {
        Self::from_bytes(key.derive(Purpose::Control, 0))
    }

    /// The key as 32 hexadecimal digits.
    #[must_use]
    pub fn to_hex(&self) -> String {
        crate::hex::hex(bytemuck::bytes_of(&self.0))
    }

    /// Reads what [`to_hex`](Self::to_hex) wrote; white space around it is
    /// ignored.
    ///
    /// # Errors
    /// [`KeyError::NotAKey`], without repeating the text.
    pub fn from_hex(text: &str) -> Result<Self, KeyError> {
        Ok(Self::from_bytes(bytes_from_hex(text)?))
    }

    /// The tag of a message: SipHash-2-4.
    #[must_use]
    pub fn tag(&self, message: &[u8]) -> u64 {
        SipHasher24::new_with_keys(self.0[0], self.0[1]).hash(message)
    }
}

impl std::fmt::Debug for AuthKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("AuthKey(hidden)")
    }
}

/// What one participant and the server share: a key for each direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParticipantKey {
    /// For what the participant sends: requests to join, answers.
    pub to_server: AuthKey,
    /// For what the server sends: frames.
    pub from_server: AuthKey,
}

impl ParticipantKey {
    /// What the server shares with the participant at `slot` of the roster.
    #[must_use]
    pub fn of_slot(key: &TruthKey, slot: usize) -> Self {
        Self::from_bytes(key.derive(Purpose::Participant, slot as u64))
    }

    /// The key with these bytes.
    #[must_use]
    pub fn from_bytes(bytes: [u8; KEY_BYTES]) -> Self {
        let [to_server, from_server]: [[u8; AuthKey::BYTES]; 2] = bytemuck::cast(bytes);
        Self {
            to_server: AuthKey::from_bytes(to_server),
            from_server: AuthKey::from_bytes(from_server),
        }
    }
}

/// All that a participant is told by its private channel: a line with its own
/// key, and for scorers and loggers a second line with the key to the truth.
#[derive(Clone, Debug)]
pub struct Credentials {
    /// What it signs with.
    pub participant: ParticipantKey,
    /// What it opens the truth with.
    pub truth: Option<TruthKey>,
}

/// A text that does not hold the credentials of a participant.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the participant's credentials cannot be read: line {line}: {error}")]
pub struct CredentialsError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub error: KeyError,
}

impl Credentials {
    /// The most bytes that a text of credentials has.
    pub const MAX_BYTES: u64 = 256;

    /// What the participant at `slot` of the roster is told.
    #[must_use]
    pub fn new(key: &TruthKey, slot: usize, holds_key: bool) -> Self {
        Self {
            participant: ParticipantKey::of_slot(key, slot),
            truth: holds_key.then(|| key.clone()),
        }
    }

    /// Credentials of no participant: the server refuses what is signed with them.
    #[must_use]
    pub fn none() -> Self {
        Self { participant: ParticipantKey::from_bytes([0; KEY_BYTES]), truth: None }
    }

    /// The lines of the private channel.
    #[must_use]
    pub fn to_text(&self) -> String {
        let ParticipantKey { to_server, from_server } = &self.participant;
        let truth = self.truth.as_ref().map(|key| format!("{}\n", key.to_hex()));
        format!("{}{}\n{}", to_server.to_hex(), from_server.to_hex(), truth.unwrap_or_default())
    }

    /// Reads what [`to_text`](Self::to_text) wrote.
    ///
    /// # Errors
    /// [`CredentialsError`] names the line, without repeating it.
    pub fn from_text(text: &str) -> Result<Self, CredentialsError> {
        let mut lines = text.lines();
        let bad = |line| move |error| CredentialsError { line, error };
        let own = bytes_from_hex(lines.next().unwrap_or_default()).map_err(bad(1))?;
        let truth = lines.next().map(TruthKey::from_hex).transpose().map_err(bad(2))?;
        Ok(Self { participant: ParticipantKey::from_bytes(own), truth })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tag_is_siphash_2_4() {
        // Appendix A of the paper: key 00 01 .. 0f, message 00 01 .. 0e.
        let key = AuthKey::from_bytes(std::array::from_fn(|i| i as u8));
        let message: Vec<u8> = (0..15).collect();
        assert_eq!(key.tag(&message), 0xa129_ca61_49be_45e5);
    }

    #[test]
    fn every_slot_and_run_has_keys_of_its_own() {
        let (a, b) = (TruthKey::from_bytes([1; 32]), TruthKey::from_bytes([2; 32]));
        let mut keys = Vec::new();
        for key in [&a, &b] {
            keys.push(AuthKey::of_control(key));
            for slot in 0..3 {
                let ParticipantKey { to_server, from_server } = ParticipantKey::of_slot(key, slot);
                keys.extend([to_server, from_server]);
            }
        }
        for (i, key) in keys.iter().enumerate() {
            assert!(!keys[..i].contains(key), "key {i} is not new");
        }
    }

    #[test]
    fn credentials_survive_their_text_and_hide_in_debug() {
        let key = TruthKey::from_bytes([9; 32]);
        for holds_key in [false, true] {
            let told = Credentials::new(&key, 3, holds_key);
            let read = Credentials::from_text(&told.to_text()).unwrap();
            assert_eq!(read.participant, ParticipantKey::of_slot(&key, 3));
            assert_eq!(read.truth.map(|k| k.to_hex()), holds_key.then(|| key.to_hex()));
            assert!(told.to_text().len() as u64 <= Credentials::MAX_BYTES);
            let shown = format!("{told:?}");
            assert!(!shown.chars().any(|c| c.is_ascii_digit()), "{shown}");
        }
        let line = |text: &str| Credentials::from_text(text).unwrap_err().line;
        assert_eq!((line(""), line("0f")), (1, 1));
        assert_eq!(line(&format!("{}\nzz", key.to_hex())), 2);
    }
}
