//! The arguments of `bench scan`.

use clap::{Args, ValueEnum};

use super::BenchCommonArgs;

/// `bench scan`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Three methods are measured in turns from the same poses, in the Apartment and in
generated worlds: all beams together, one ray per beam (the reference), and the
ray cast of parry. The first two must have the same bits (exit code 4 if not).
Example: sim-server bench scan --walls 4096 --beams 360 --patterns rooms")]
pub struct BenchScanArgs {
    /// Numbers of walls of the generated worlds
    #[arg(long, value_delimiter = ',', default_value = "64,512,4096,32768", value_name = "N,…",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub walls: Vec<u32>,
    /// Numbers of beams of a scan over the full circle
    #[arg(long, value_delimiter = ',', default_value = "180,1080", value_name = "N,…",
          value_parser = clap::value_parser!(u32).range(1..=1080))]
    pub beams: Vec<u32>,
    /// Quantity held constant when the number of walls grows
    #[arg(long, value_delimiter = ',', default_value = "constant,area", value_name = "WHAT,…")]
    pub density: Vec<DensityWord>,
    /// Arrangements of the walls
    #[arg(long, value_delimiter = ',', default_value = "rooms,segments", value_name = "HOW,…")]
    pub patterns: Vec<PatternWord>,
    /// Duration per world and number of beams, s
    #[arg(long, default_value_t = 0.5, value_name = "SECONDS")]
    pub seconds: f64,
    /// Common options.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// The quantity that stays constant when the number of walls grows.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityWord {
    /// Number of walls per area
    Constant,
    /// Total area
    Area,
}

/// The arrangement of walls.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatternWord {
    /// A grid of rooms with doors
    Rooms,
    /// Free-standing walls in all directions
    Segments,
}
