//! `sim-server benchmark`: a fixed suite of scenarios, with a result that others can check
//! bit by bit.
//!
//! In reading order:
//!
//! * [`suite`], [`track`]: scenarios, tracks and baselines;
//! * [`selection`]: the part of the suite that a result is about;
//! * [`entry`]: a program that takes part;
//! * [`recorded_log`], [`recordings`]: logs of robots as one more scenario;
//! * [`block`]: the runs of an entry in a scenario; [`job`] makes them, [`play`] one;
//! * [`sealing`], [`answering`]: runs handed out without their truth, and a filter on them;
//! * [`run`], [`standings`], [`result`]: figures, scores and verdicts in one file;
//! * [`verify`]: a result compared with the same runs made again;
//! * [`mod@leaderboard`], [`page`]: several results in a table, and drawn;
//! * [`error`].

pub mod answering;
pub mod block;
pub mod entry;
pub mod error;
pub mod job;
pub mod leaderboard;
pub mod page;
pub mod play;
pub mod recorded_log;
pub mod recordings;
pub mod result;
pub mod run;
pub mod sealing;
pub mod selection;
pub mod standings;
pub mod suite;
#[cfg(test)]
mod tests;
pub mod track;
pub mod verify;

pub use answering::Answering;
pub use entry::Entry;
pub use error::BenchmarkError;
pub use job::BenchmarkJob;
pub use leaderboard::{LeaderboardText, leaderboard};
pub use recordings::Recordings;
pub use result::BenchmarkResult;
pub use sealing::Sealing;
pub use selection::Selection;
pub use suite::Suite;
pub use track::Track;
