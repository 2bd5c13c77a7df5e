//! Every byte that crosses a process or reaches the disk.
//!
//! In reading order:
//!
//! * [`frame`]: what the world shows each tick, one fixed layout, read where it lies;
//! * [`answer`]: what a participant says to a frame; the answer is the acknowledgement;
//! * [`belief`]: what a filter holds possible, for observers;
//! * [`tally`]: the answers of one tick, for those who score and log;
//! * [`truth`]: the sealed pose, and the key without which it cannot be opened;
//! * [`digest`]: the bits a run is known by;
//! * [`layout`]: the tables of the three wire structs, and their hash;
//! * [`names`]: what runs and participants may be called;
//! * [`config`]: robot, LiDAR, script, run: every field with its unit, every error with its remedy;
//! * [`sandbox`]: whether the kernel holds a participant to what it may know;
//! * [`scenario`]: the file a person writes, and who takes part;
//! * [`join`]: the one exchange before the first tick;
//! * [`log`]: the run on disk, readable up to the last complete tick wherever it was cut;
//! * [`blind`]: a log without its truth to hand out, and the key that stays at home;
//! * [`score`]: what a scorer writes down;
//! * [`json`]: what of all this is read and written as JSON, compiled once;
//! * [`suggest`]: suggestions for misspelled names, for error messages;
//! * [`output`]: results to stdout, diagnostics to stderr, escape sequences made visible;
//! * [`text_table`]: tables for people; [`replacement`]: a file that is complete or not there;
//! * [`tum`]: a pose as a line of a trajectory file;
//! * [`exit`]: the exit codes that every program here shares; [`program`]: a program by name.
//!
//! # The protocol
//!
//! From joining to leaving, for an author of a client in another language. The
//! bytes are in the modules named; `sim-server layout --json` prints every
//! offset, and `sim-server conformance -- CLIENT` tests a client against what
//! follows, each check under the name of its rule.
//!
//! 1. **Start.** A launcher starts the client with its own arguments and then
//!    `--run NAME --name NAME --wait balanced|spin|block --launcher PID
//!    --key-stdin`. The first line of its standard input is the participant's key, 64
//!    hexadecimal digits; scorers and loggers get the key to the truth as the second
//!    line. Once that process has
//!    ended there is nothing left to join.
//! 2. **Find the run.** Its folder is `/dev/shm/rusty-<uid>/<run>`; the file
//!    `lock` in it holds `<server pid> <nonce>` and is locked (`flock`) for as
//!    long as the server lives. The transport is iceoryx2 in its file-based
//!    variant (`rusty_link`, `wire`), with the folder named after the nonce (eight
//!    hexadecimal digits) as root path and the prefix `r`. Its services are `join` and `control` (request-response of bytes), `frames`,
//!    `tallies` and `answers` (publish-subscribe of [`Frame`], [`Tally`],
//!    [`Answer`]), `wake-clients` and `wake-server` (events); `join` is created
//!    last, so where it is, all are.
//! 3. **Ask.** Send a [`JoinRequest`] as JSON. The reply is a [`JoinReply`]:
//!    a [`Start`], or a [`Refusal`]: print its reason and end, code not 0.
//!    Where `catch_up` of the `Start` is set, this client comes back into a run:
//!    the first N frames (and tallies) come by the services it names, in
//!    order, and all later ones as usual.
//! 4. **Ready.** Open the ports on `frames` and `answers` (scorers and loggers:
//!    `tallies`), then send an answer of kind 7. The first frame is published
//!    when everyone has; frames do not wait for ports that open later.
//! 5. **Take a frame** whose `run_id` is that of `Start`. Frames of other runs
//!    are skipped. Ticks only grow: *a frame whose tick is not greater than the
//!    last one taken was seen before and is skipped, without an answer.*
//!    A frame whose `lost` has the bit of one's own place says that the run
//!    goes on without this client: say so and end, with code 3.
//! 6. **Answer it**, exactly once: `run_id`, `participant` and `ticket` of
//!    `Start`, `tick` and `digest` of the frame, and a [`Reply`]. The answer is the
//!    acknowledgement; nothing happens until all awaited have answered.
//!    Estimators estimate or abstain, a driver gives a command (without one
//!    the robot stands), scorers and loggers say taken. What is not asked for
//!    (a second answer, one to an older tick, one of another run) is counted
//!    and changes nothing; a wrong digest, a tick yet to come, or an invalid
//!    number makes the sender count as lost.
//! 7. **Wake, and be woken.** `sent_ns` and `awake_ns` say when the other side
//!    may be asleep; a wake-up is sent only then. Wake-ups are hints: after a
//!    bounded wait look at the data, and at the process in `server_pid`.
//! 8. **Scorers and loggers** get a [`Tally`] of each tick once it is complete,
//!    before the frame of the next. They compute digests afresh, and fail where
//!    one differs.
//! 9. **The end of run** is a frame whose `phase` is not 0. Finish, answer no
//!    more, send kind 5 (leave message), end with 0, or with 3 where something was
//!    lost. Who cannot go on sends kind 6 (failed). Who is asked to stop
//!    (SIGINT, SIGTERM) sends kind 5 and ends, at any time.
//! 10. **If the server's process has ended** nothing more comes: say so, end
//!     with a code other than 0, and sweep folder and memory of the run (take
//!     the lock first: who holds it may remove both).
//!
//! Next to all that, and not part of it: a filter may show what it holds possible
//! on the service `beliefs` ([`belief`]), after its answer, if a process
//! subscribes there. Nothing is missed by who leaves it out; its structs are not
//! part of the layout hash.
//!
//! Nothing in this crate reads a clock, an environment variable or a random
//! number, and nothing in it knows how bytes travel.

pub mod answer;
pub mod auth;
pub mod belief;
pub mod blind;
pub mod config;
pub mod control;
pub mod data_sheet;
pub mod digest;
pub mod effects;
pub mod exit;
mod field_table;
pub mod frame;
mod hex;
pub mod input;
pub mod join;
pub mod json;
pub mod layout;
pub mod log;
pub mod names;
pub mod output;
pub mod program;
pub mod readings;
pub mod replacement;
pub mod reply;
pub mod sandbox;
pub mod scenario;
pub mod score;
pub mod suggest;
pub mod tally;
pub mod text_table;
pub mod timing;
pub mod truth;
pub mod tum;

pub use answer::Answer;
pub use auth::{AuthKey, Credentials, CredentialsError, ParticipantKey};
pub use belief::{BeliefHeader, BeliefKind, WeightedPose};
pub use blind::{BlindKey, BlindKeyError};
pub use config::ScriptConfig;
pub use config::{
    FieldError, Kidnapping, LidarConfig, NominalRobot, RobotConfig, RunConfig, Sensors,
};
pub use data_sheet::DataSheet;
pub use digest::RunDigest;
pub use effects::{Effects, Timing};
pub use exit::Exit;
pub use frame::{Frame, MAX_BEAMS, Phase};
pub use join::{Brief, CatchUp, JoinReply, JoinRequest, Refusal, Start};
pub use json::{Json, JsonTree};
pub use log::{Log, LogHeader};
pub use names::{NameError, RunName};
pub use program::Program;
pub use readings::{ImuReading, LandmarkReading, OwnedReadings, Present, Readings};
pub use replacement::{Replacement, replace};
pub use reply::{AnswerError, Estimate, Innovation, Reply};
pub use sandbox::Sandbox;
pub use scenario::{OnLoss, Participant, Role, Scenario};
pub use score::ScoreReport;
pub use tally::{MAX_PARTICIPANTS, Tally};
pub use text_table::TextTable;
pub use timing::ComputeTime;
pub use truth::{KeyError, SealedTruth, Truth, TruthKey};

/// The version of the protocol between server and participants. It changes
/// when the meaning of a message changes; a change of layout shows in
/// [`layout::layout_hash`] by itself.
pub const PROTOCOL_VERSION: u32 = 2;

const _: () = assert!(
    cfg!(target_endian = "little"),
    "frames and digests are defined on little-endian bytes"
);
