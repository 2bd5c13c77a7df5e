//! The sources of odometry's error.

use rusty_contract::RunConfig;
use serde::Serialize;

/// A source of odometry's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Encoders count in whole numbers.
    Quantization,
    /// Wheels slip, otherwise in every tick.
    Slip,
    /// The right wheel is larger than it is said to be.
    RadiusBias,
    /// The wheels are farther apart than they are said to be.
    TrackBias,
}

impl Source {
    /// All, in the order of the chapter's table.
    pub const ALL: [Self; 4] = [Self::Quantization, Self::Slip, Self::RadiusBias, Self::TrackBias];

    /// The field it is set by, and a value that shows it.
    #[must_use]
    pub fn field(self) -> &'static str {
        match self {
            Self::Quantization => "robot.ticks_per_rev=4096",
            Self::Slip => "robot.slip_std=0.02",
            Self::RadiusBias => "robot.radius_bias_right=0.01",
            Self::TrackBias => "robot.track_bias=0.01",
        }
    }

    /// Whether a run with this configuration has it.
    #[must_use]
    pub fn is_in(self, config: &RunConfig) -> bool {
        match self {
            Self::Quantization => true,
            Self::Slip => config.slips(),
            Self::RadiusBias => config.robot.radius_bias_right != 0.0,
            Self::TrackBias => config.robot.track_bias != 0.0,
        }
    }

    /// The configuration with no other source than this one, and quantization.
    #[must_use]
    pub fn alone(self, config: &RunConfig) -> RunConfig {
        let mut alone = config.clone();
        if self != Self::Slip {
            alone.remove_slip();
        }
        if self != Self::RadiusBias {
            alone.robot.radius_bias_right = 0.0;
        }
        if self != Self::TrackBias {
            alone.robot.track_bias = 0.0;
        }
        alone
    }

    /// As in the table, with its size.
    #[must_use]
    pub fn name(self, config: &RunConfig) -> String {
        let robot = &config.robot;
        match self {
            Self::Quantization => format!("quantization only, N = {}", robot.ticks_per_rev),
            Self::Slip => format!("slip, σ = {}", config.slip_in_words("")),
            Self::RadiusBias => format!("right radius {:+} %", 100.0 * robot.radius_bias_right),
            Self::TrackBias => format!("track {:+} %", 100.0 * robot.track_bias),
        }
    }
}
