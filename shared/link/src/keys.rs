//! The keys of a run: what the server signs and checks with.

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use rusty_contract::{
    Answer, AuthKey, Credentials, JoinRequest, MAX_PARTICIPANTS, ParticipantKey, RunName, TruthKey,
};

use crate::domain_error::io;
use crate::{Domain, DomainError, ServerLink, with_umask};

/// The keys that the server shares with each participant and with those who
/// control the run. Those of participants and control stay the same in a series of runs.
#[derive(Clone)]
pub struct Keys {
    participants: [ParticipantKey; MAX_PARTICIPANTS],
    pub(crate) control: AuthKey,
    /// The key to the truth of the current run.
    pub(crate) truth: TruthKey,
}

impl Keys {
    /// All keys of the run with this key.
    #[must_use]
    pub fn new(truth: &TruthKey) -> Self {
        Self {
            participants: std::array::from_fn(|slot| ParticipantKey::of_slot(truth, slot)),
            control: AuthKey::of_control(truth),
            truth: truth.clone(),
        }
    }

    /// The key of the participant at `slot`.
    #[must_use]
    pub fn participant(&self, slot: usize) -> Option<&ParticipantKey> {
        self.participants.get(slot)
    }

    /// Whether the participant that the answer names has signed it.
    #[must_use]
    pub fn has_signed_answer(&self, answer: &Answer) -> bool {
        let key = self.participant(answer.participant as usize);
        key.is_some_and(|key| answer.is_signed_by(&key.to_server))
    }

    /// Whether the participant at `slot` has signed the request.
    #[must_use]
    pub fn has_signed_request(&self, request: &JoinRequest, slot: usize) -> bool {
        self.participant(slot).is_some_and(|key| request.is_signed_by(&key.to_server))
    }
}

impl ServerLink {
    /// Begins another run of a series, whose truth has this key.
    pub fn begin_run(&mut self, truth: TruthKey) {
        self.keys.truth = truth;
    }
}

impl Domain {
    /// The file with the credentials of a participant that is started by hand.
    #[must_use]
    pub fn credentials_file(run: &RunName, participant: &str) -> PathBuf {
        Self::base().join(run.as_str()).join("keys").join(participant)
    }

    /// Leaves the credentials of a participant that is started by hand in the
    /// run's folder, for this user alone. A confined process cannot read there.
    ///
    /// # Errors
    /// [`DomainError::Io`] names the file.
    pub fn leave_credentials(
        &self,
        participant: &str,
        credentials: &Credentials,
    ) -> Result<(), DomainError> {
        let file = Self::credentials_file(self.run(), participant);
        let folder = self.folder().join("keys");
        with_umask(|| fs::create_dir_all(&folder)).map_err(io(&folder, "make the folder"))?;
        leave(&file, &credentials.to_text())
    }

    /// The file with the key that signs control requests.
    pub(crate) fn control_key_file(&self) -> PathBuf {
        self.folder().join("control-key")
    }

    pub(crate) fn leave_control_key(&self, key: &AuthKey) -> Result<(), DomainError> {
        leave(&self.control_key_file(), &format!("{}\n", key.to_hex()))
    }
}

/// Writes a file that this user alone can read.
fn leave(file: &Path, text: &str) -> Result<(), DomainError> {
    let open =
        fs::OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(file);
    open.and_then(|mut open| open.write_all(text.as_bytes())).map_err(io(file, "write the key"))
}
