//! The arguments of `umbmark`.

use std::path::PathBuf;

use clap::Args;

const AFTER_HELP: &str = "\
The robot of the scenario drives a square in both directions, without walls, and by
its encoders only. The true end points of the laps separate two systematic errors:
  robot.track_bias         a wrong wheelbase changes every corner, with the same
                           sign in both directions
  robot.radius_bias_right  unequal wheels bend every side, with opposite signs in
                           the two directions
The output has E_b (true over nominal wheelbase) and E_d (right over left diameter)
with standard errors and true values, and the laps on the same seeds with the
factors applied.

E_b and E_d are estimated twice: by the first-order formulas of J. Borenstein and
L. Feng (1996), and by least squares with exact arcs. With a short wheelbase and a
long side only the second is right. A square does not show the common scale of both
wheels; E_b is the wheelbase over the mean wheel.

Slip is random: with robot.slip_std=0.02 five laps are not enough, and the standard
errors are large. Use more --runs or less slip.

Examples:
  sim-server umbmark --set robot.track_bias=0.01 --set robot.radius_bias_right=0.005
  sim-server umbmark --runs 50 --set robot.slip_std=0.005 --set robot.track_bias=0.01 --png laps.png";

/// `umbmark`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct UmbmarkArgs {
    /// apartment, patrol, figure-eight, hallway, driver or a file
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Number of laps in each direction
    #[arg(long, default_value_t = 5, value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub runs: u32,
    /// Length of a side, m
    #[arg(long, default_value_t = 4.0, value_name = "M")]
    pub side: f64,
    /// Speed along the sides, m/s
    #[arg(long, default_value_t = 0.5, value_name = "M/S")]
    pub speed: f64,
    /// Turn rate at the corners, rad/s
    #[arg(long, default_value_t = 1.0, value_name = "RAD/S")]
    pub turn: f64,
    /// Seed of the first lap [default: the scenario's]
    #[arg(long, value_parser = super::seed::seed, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Change a field, e.g. robot.track_bias=0.01
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Draw laps and end points into this SVG file
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw laps and end points into this PNG file
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Replace existing drawings
    #[arg(long)]
    pub force: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
