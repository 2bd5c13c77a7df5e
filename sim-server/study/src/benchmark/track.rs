//! `Track`: what is asked of an estimator.

use clap::ValueEnum;
use rusty_contract::scenario::Access;
use serde::{Deserialize, Serialize};

/// What is asked of an estimator, and with which map.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum Track {
    /// Poses in a given map
    Localisation,
    /// Motion, without a map
    Odometry,
    /// Poses in a map that the estimator makes
    Slam,
}

impl Track {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Localisation, Self::Odometry, Self::Slam];

    /// Returns whether an estimator receives the walls. Tracks with the same map have the
    /// same runs.
    #[must_use]
    pub fn map(self) -> Access {
        match self {
            Self::Localisation => Access::Given,
            Self::Odometry | Self::Slam => Access::Hidden,
        }
    }

    /// Returns the word of files and tables.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Localisation => "localisation",
            Self::Odometry => "odometry",
            Self::Slam => "slam",
        }
    }
}

/// Returns the word of files for whether an estimator receives the walls.
#[must_use]
pub fn map_word(map: Access) -> &'static str {
    match map {
        Access::Given => "given",
        Access::Hidden => "hidden",
    }
}
