//! What an export can fail with.

use std::path::Path;

use rusty_contract::Exit;
use rusty_contract::log::LogError;
use thiserror::Error;

/// What an export can fail with. Nothing is left of one that fails.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// An error of the operating system about a file or folder.
    #[error("{0}: {1}")]
    Io(String, std::io::Error),
    /// A file that is there already.
    #[error("{0} is there already; choose another -o, or replace it with --force")]
    InTheWay(String),
    /// There is no scenario that repeats the run of this log.
    #[error("{log}: export scenario failed: {problem}; export a log of `launch` with one robot")]
    NoScenario {
        /// The log.
        log: String,
        /// What is in the way.
        problem: String,
    },
    /// The scenario or its world cannot be written as TOML.
    #[error("the scenario cannot be written as TOML: {0}")]
    Toml(String),
    /// An error while a Parquet file is written.
    #[error("{0}: writing Parquet failed: {1}; check the space on the disk, and repeat the export")]
    Parquet(String, parquet::errors::ParquetError),
    /// An error while an MCAP file is written.
    #[error("{0}: writing MCAP failed: {1}; check the space on the disk, and repeat the export")]
    Mcap(String, mcap::McapError),
    /// A tick that is no message.
    #[error("{0}: a tick does not fit a message of ROS: {1}; report it as a defect of this export")]
    Ros(String, rusty_ros::CdrError),
    /// True poses of a log that has none on purpose.
    #[error(
        "{0}: export of the truth failed: expected a log with its truth, got a blind one; leave \
         out --truth, or export the log that it was made from"
    )]
    NoTruth(String),
    /// A name that no participant has.
    #[error(
        "{log}: expected the name of a participant that answers ({known}) or none, got \
         {name:?}{hint}; give one of them with --estimator"
    )]
    NoEstimator {
        /// The log.
        log: String,
        /// The name.
        name: String,
        /// The name that may be meant.
        hint: String,
        /// The names there are.
        known: String,
    },
    /// A folder that an export may not replace.
    #[error(
        "{0}: expected a bag of rosbag2 and no other files to replace, or a new name; choose \
         another -o"
    )]
    NotABag(String),
    /// Ctrl-C during the export of a log.
    #[error("{0}: interrupted, nothing is written; export it again from the start")]
    Interrupted(String),
}

impl ExportError {
    /// Wraps an error about a file.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io(path, error)
    }

    /// Wraps an error of the writer of a Parquet file.
    pub fn parquet(path: &Path) -> impl Fn(parquet::errors::ParquetError) -> Self {
        let path = path.display().to_string();
        move |error| Self::Parquet(path.clone(), error)
    }

    /// Wraps an error of the writer of an MCAP file.
    pub fn mcap(path: &Path) -> impl Fn(mcap::McapError) -> Self {
        let path = path.display().to_string();
        move |error| Self::Mcap(path.clone(), error)
    }

    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::InTheWay(_)
            | Self::NoScenario { .. }
            | Self::NoTruth(_)
            | Self::NoEstimator { .. }
            | Self::NotABag(_) => Exit::Usage,
            Self::Interrupted(_) => Exit::Lost,
            Self::Log(_)
            | Self::Io(..)
            | Self::Toml(_)
            | Self::Parquet(..)
            | Self::Mcap(..)
            | Self::Ros(..) => Exit::Failed,
        }
    }
}
