//! What a run is set up with, and what each participant is told of it.

use std::path::PathBuf;

use rusty_contract::{Brief, LogHeader, OnLoss, RunName, Start, TruthKey};
use rusty_link::WaitPolicy;

use super::Pace;
use crate::lockstep::Rules;

/// How long a participant may take after the last frame: a scorer draws.
const GOODBYE_TIMEOUT_S: f64 = 60.0;
/// The same where the run ends early.
const EARLY_GOODBYE_TIMEOUT_S: f64 = 15.0;
/// From when on a missing answer is worth a line.
const SLOW_AFTER_S: f64 = 1.0;

/// All that a run needs beside its source.
#[derive(Clone, Debug)]
pub struct RunSetup {
    /// Its name.
    pub run: RunName,
    /// Drawn afresh.
    pub run_id: u64,
    /// Drawn afresh.
    pub key: TruthKey,
    /// How the server waits.
    pub wait: WaitPolicy,
    /// How fast time goes.
    pub pace: Pace,
    /// Whether it begins paused.
    pub paused: bool,
    /// Length of a tick, s.
    pub dt_s: f64,
    /// How long all may take to join, s.
    pub join_timeout_s: f64,
    /// How long an answer may take, s.
    pub answer_timeout_s: f64,
    /// What happens when somebody is lost.
    pub on_loss: OnLoss,
    /// Where scorers and loggers write.
    pub out_dir: Option<PathBuf>,
    /// Whether participants check the bytes of every frame: where one of them is
    /// confined.
    pub check_frames: bool,
}

fn ns(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}

impl RunSetup {
    /// A run id and a key from the operating system.
    ///
    /// # Errors
    /// [`getrandom::Error`] if it has no randomness to give.
    pub fn draw() -> Result<(u64, TruthKey), getrandom::Error> {
        let mut key = [0; 32];
        getrandom::fill(&mut key)?;
        Ok((getrandom::u64()?, TruthKey::from_bytes(key)))
    }

    pub(super) fn rules(&self, ticks: u64) -> Rules {
        Rules {
            run_id: self.run_id,
            ticks,
            on_loss: self.on_loss,
            join_timeout_ns: ns(self.join_timeout_s),
            answer_timeout_ns: ns(self.answer_timeout_s),
            goodbye_timeout_ns: ns(self.answer_timeout_s.max(GOODBYE_TIMEOUT_S)),
            early_goodbye_timeout_ns: ns(EARLY_GOODBYE_TIMEOUT_S),
            slow_after_ns: ns(SLOW_AFTER_S.min(self.answer_timeout_s / 2.0)),
        }
    }

    /// What the participant on `seat` is told: what its role may know.
    pub fn start(&self, header: &LogHeader, seat: usize) -> Start {
        let participant = &header.roster[seat];
        let sealed_brief = participant.role.holds_key().then(|| {
            let out_dir = self.out_dir.as_ref().map(|p| p.display().to_string());
            let brief = Brief { header: header.clone(), out_dir };
            // A header that came from JSON goes back to JSON.
            let json = serde_json::to_vec(&brief).unwrap_or_default();
            self.key.seal_brief(self.run_id, &json)
        });
        Start {
            run_id: self.run_id,
            server_pid: std::process::id(),
            server_awake_ns: self.wait.awake_ns(),
            check_frames: self.check_frames,
            sealed_brief,
            ..Start::new(header, seat, participant)
        }
    }
}
