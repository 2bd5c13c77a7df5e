//! What `umbmark` takes.

use std::path::PathBuf;

use clap::Args;

const AFTER_HELP: &str = "\
The robot of the scenario drives a square both ways round, in the open, on its
encoders alone: it believes to have driven it perfectly. Where the laps really
end tells two systematic errors apart. A wrong wheelbase (robot.track_bias) turns
every corner short, both ways round alike; wheels of different size
(robot.radius_bias_right) bend every side, which the two ways show with opposite
signs. Out come E_b (true over believed wheelbase) and E_d (right over left
diameter) with standard errors, beside the true ones, and the laps again with the
factors applied, on the same seeds.

E_b and E_d are found twice: by the formulas of J. Borenstein and L. Feng (1996),
which are of first order, and by least squares with exact arcs. A short wheelbase
bends a long side far: then only the second is right. A square cannot see the
scale of both wheels together; E_b is the wheelbase over the mean wheel.

Slip is chance: with robot.slip_std=0.02 five laps say little, which the standard
errors show. Try more --runs, or less slip.

Examples:
  sim-server umbmark --set robot.track_bias=0.01 --set robot.radius_bias_right=0.005
  sim-server umbmark --runs 50 --set robot.slip_std=0.005 --set robot.track_bias=0.01 --png laps.png";

/// `umbmark`.
#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct UmbmarkArgs {
    /// Whose robot: a scenario file, or one of: apartment, patrol, figure-eight,
    /// hallway, driver
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Laps each way
    #[arg(long, default_value_t = 5, value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub runs: u32,
    /// Length of a side, m
    #[arg(long, default_value_t = 4.0, value_name = "M")]
    pub side: f64,
    /// Speed along the sides, m/s
    #[arg(long, default_value_t = 0.5, value_name = "M/S")]
    pub speed: f64,
    /// Turn rate on the corners, rad/s
    #[arg(long, default_value_t = 1.0, value_name = "RAD/S")]
    pub turn: f64,
    /// Seed of the first lap [default: the scenario's]
    #[arg(long, value_parser = super::seed::seed, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Change a field, e.g. --set robot.track_bias=0.01
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Draw laps and returns into this SVG file
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw laps and returns into this PNG file
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
