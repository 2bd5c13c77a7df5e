//! `Track`: what is asked of an entry.

use clap::ValueEnum;
use rusty_contract::scenario::Access;
use serde::{Deserialize, Serialize};

/// What is asked of an entry, and with which map.
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
    /// Commands that bring the robot to goals in a given map
    Driving,
}

impl Track {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Localisation, Self::Odometry, Self::Slam, Self::Driving];

    /// Returns whether its entries are drivers; those of the others are estimators.
    #[must_use]
    pub fn is_driving(self) -> bool {
        self == Self::Driving
    }

    /// Returns whether an entry receives the walls. Tracks of estimators with the same map
    /// have the same runs.
    #[must_use]
    pub fn map(self) -> Access {
        match self {
            Self::Localisation | Self::Driving => Access::Given,
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
            Self::Driving => "driving",
        }
    }
}

/// Returns the word of files for whether an entry receives the walls.
#[must_use]
pub fn map_word(map: Access) -> &'static str {
    match map {
        Access::Given => "given",
        Access::Hidden => "hidden",
    }
}
