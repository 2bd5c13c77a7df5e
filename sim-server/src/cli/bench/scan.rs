//! What `bench scan` takes.

use clap::{Args, ValueEnum};

use super::BenchCommonArgs;

/// `bench scan`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
In the Apartment and in generated worlds: the scan as one problem, a ray for each
beam (the reference, which must have the same bits: exit code 4 if it has not),
and parry's own ray cast, all from the same poses in turns.
Example: sim-server bench scan --walls 4096 --beams 360 --patterns rooms")]
pub struct BenchScanArgs {
    /// Walls of the generated worlds
    #[arg(long, value_delimiter = ',', default_value = "64,512,4096,32768", value_name = "N,…",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub walls: Vec<u32>,
    /// Beams of a scan over the full circle
    #[arg(long, value_delimiter = ',', default_value = "180,1080", value_name = "N,…",
          value_parser = clap::value_parser!(u32).range(1..=1080))]
    pub beams: Vec<u32>,
    /// What stays the same when there are more walls
    #[arg(long, value_delimiter = ',', default_value = "constant,area", value_name = "WHAT,…")]
    pub density: Vec<DensityWord>,
    /// How the walls stand
    #[arg(long, value_delimiter = ',', default_value = "rooms,segments", value_name = "HOW,…")]
    pub patterns: Vec<PatternWord>,
    /// For how long each world is measured with each number of beams, s
    #[arg(long, default_value_t = 0.5, value_name = "SECONDS")]
    pub seconds: f64,
    /// What all share.
    #[command(flatten)]
    pub common: BenchCommonArgs,
}

/// What stays the same when there are more walls.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityWord {
    /// Walls per area
    Constant,
    /// The area
    Area,
}

/// How walls stand.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatternWord {
    /// A grid of rooms with doors
    Rooms,
    /// Free-standing, in all directions
    Segments,
}
