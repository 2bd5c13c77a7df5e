//! Every byte that crosses a process or reaches the disk.
//!
//! In reading order:
//!
//! * [`frame`]: what the world shows each tick, one fixed layout, read where it lies;
//! * [`answer`]: what a participant says to a frame; the answer is the acknowledgement;
//! * [`tally`]: the answers of one tick, for those who score and log;
//! * [`truth`]: the sealed pose, and the key without which it cannot be opened;
//! * [`digest`]: the bits a run is known by;
//! * [`layout`]: the tables of the three wire structs, and their hash;
//! * [`names`]: what runs and participants may be called;
//! * [`config`]: robot, LiDAR, script, run: every field with its unit, every error with its remedy;
//! * [`scenario`]: the file a person writes, and who takes part;
//! * [`join`]: the one exchange before the first tick;
//! * [`log`]: the run on disk, readable up to the last complete tick wherever it was cut;
//! * [`blind`]: a log without its truth to hand out, and the key that stays at home;
//! * [`score`]: what a scorer writes down;
//! * [`exit`]: the exit codes that every program here shares.
//!
//! Nothing in this crate reads a clock, an environment variable or a random
//! number, and nothing in it knows how bytes travel.

pub mod answer;
pub mod blind;
pub mod config;
pub mod digest;
pub mod exit;
pub mod frame;
pub mod join;
pub mod layout;
pub mod log;
pub mod names;
pub mod scenario;
pub mod score;
pub mod tally;
pub mod truth;

pub use answer::{Answer, AnswerError, Estimate, Reply};
pub use blind::{BlindKey, BlindKeyError};
pub use config::{FieldError, LidarConfig, NominalRobot, RobotConfig, RunConfig, ScriptConfig};
pub use digest::RunDigest;
pub use exit::Exit;
pub use frame::{Frame, MAX_BEAMS, Phase};
pub use join::{Brief, JoinReply, JoinRequest, Refusal, Start};
pub use log::LogHeader;
pub use names::{NameError, RunName};
pub use scenario::{OnLoss, Participant, Role, Scenario};
pub use score::ScoreReport;
pub use tally::{MAX_PARTICIPANTS, Tally};
pub use truth::{KeyError, SealedTruth, Truth, TruthKey};

/// The version of the protocol between server and participants. It changes
/// when the meaning of a message changes; a change of layout shows in
/// [`layout::layout_hash`] by itself.
pub const PROTOCOL_VERSION: u32 = 1;

const _: () = assert!(
    cfg!(target_endian = "little"),
    "frames and digests are defined on little-endian bytes"
);
