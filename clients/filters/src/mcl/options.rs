//! What can be told to `mcl` on its command line.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::OdometryNoise;

/// Which model of the laser weighs the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Model {
    /// The likelihood field (§6.4): where beams end
    #[default]
    Field,
    /// The beam model (§6.3): a ray for each beam and particle
    Beam,
}

/// The options of Monte Carlo localisation.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Monte Carlo localisation")]
pub struct Options {
    /// The most particles; where the robot may be anywhere, it begins with them
    #[arg(long, default_value_t = 5000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub particles: u32,

    /// The fewest particles [default: 1000, or --particles if these are fewer]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub particles_min: Option<u32>,

    /// Seed of its own random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,

    /// What weighs the particles
    #[arg(long, value_enum, default_value_t)]
    pub model: Model,

    /// Take every N-th beam: neighbours err in the same way where the map is wrong
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1080))]
    pub skip: u32,

    /// Raise the likelihood of a scan to this power, against errors that its
    /// beams have in common
    #[arg(long, default_value_t = 1.0, value_name = "0..1", value_parser = exponent)]
    pub exponent: f64,

    /// Believe in this σ of a range, m [default: what the laser's maker says]
    #[arg(long, value_name = "METRES", value_parser = sigma)]
    pub sigma_m: Option<f64>,

    /// Localise in this map (a ROS map_server YAML file) instead of the given walls
    #[arg(long, value_name = "FILE.yaml")]
    pub map: Option<PathBuf>,

    /// Begin anywhere, even where an initial pose is given
    #[arg(long)]
    pub global: bool,

    /// Sleep until so many seconds after the first tick: count odometry, say nothing
    #[arg(long, default_value_t = 0.0, value_name = "SECONDS", value_parser = seconds)]
    pub from: f64,

    /// What is believed of the wheels.
    #[command(flatten)]
    pub noise: OdometryNoise,
}

/// The fewest particles where nothing is said of it.
const LEAST: u32 = 1000;

impl Options {
    /// The fewest particles.
    #[must_use]
    pub fn least(&self) -> u32 {
        self.particles_min.unwrap_or(LEAST.min(self.particles))
    }
}

fn number(text: &str, fits: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if fits(value) => Ok(value),
        _ => Err(format!("give {wanted}")),
    }
}

fn exponent(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v <= 1.0, "a power greater than 0 and at most 1")
}

fn sigma(text: &str) -> Result<f64, String> {
    number(text, |v| (1e-3..=10.0).contains(&v), "a distance from 0.001 to 10 m")
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a time in seconds, 0 or more")
}

impl Default for Options {
    fn default() -> Self {
        Self {
            particles: 5000,
            particles_min: None,
            seed: 1,
            model: Model::Field,
            skip: 1,
            exponent: 1.0,
            sigma_m: None,
            map: None,
            global: false,
            from: 0.0,
            noise: OdometryNoise::default(),
        }
    }
}
