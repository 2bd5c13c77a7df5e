//! What can be told to `mcl` on its command line.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use rusty_clients::ClientError;
use rusty_contract::config::LidarConfig;
use rusty_geometry::SE2;

use crate::moment::Moment;
use crate::numbers::number;
use crate::{BeamModel, OdometryNoise};

/// Which model of the laser weighs the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Model {
    /// The likelihood field (§6.4): where beams end
    #[default]
    Field,
    /// The beam model (§6.3): a ray for each beam and particle
    Beam,
}

/// Localise in a known map with Monte Carlo localisation
///
/// Each particle is a possible pose. Odometry moves the particles, the laser weighs
/// them, and resampling prefers the heavy ones. Without an initial pose the particles
/// start everywhere, and the filter abstains until most of the belief is at one place.
/// It finds the robot again after a kidnapping.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Monte Carlo localisation")]
pub struct Options {
    /// Maximum number of particles
    #[arg(long, default_value_t = 5000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub particles: u32,

    /// Minimum number [default: 1000, at most --particles]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub particles_min: Option<u32>,

    /// Seed of the filter's random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,

    /// Sensor model
    #[arg(long, value_enum, default_value_t)]
    pub model: Model,

    /// Use every N-th beam
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1080))]
    pub skip: u32,

    /// Exponent of the likelihood of a scan
    #[arg(long, default_value_t = 1.0, value_name = "0..1", value_parser = exponent)]
    pub exponent: f64,

    /// Localise in this map_server map instead of the given walls
    #[arg(long, value_name = "FILE.yaml")]
    pub map: Option<PathBuf>,

    /// Start anywhere, even if an initial pose is given
    #[arg(long, conflicts_with = "at")]
    pub global: bool,

    /// Start at this pose in the world frame, m and rad
    #[arg(long, value_name = "X,Y,THETA", value_parser = pose, allow_hyphen_values = true)]
    pub at: Option<SE2>,

    /// First scan that is used after the start of the run, s or ticks (12.5, 400ticks)
    #[arg(long, value_name = "MOMENT", default_value = "0")]
    pub from: Moment,

    /// What is believed of a reading.
    #[command(flatten)]
    pub reading: Reading,

    /// What is believed of the wheels.
    #[command(flatten)]
    pub noise: OdometryNoise,
}

/// What is believed of a reading of the laser, where that is not what its maker says.
/// The rest of the weights is that of hits.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq)]
#[command(next_help_heading = "Sensor model (Probabilistic Robotics, §6.3; fit-beam fits it)")]
pub struct Reading {
    /// Standard deviation of a hit, m [default: the data sheet's, or 0.03]
    #[arg(long, value_name = "METRES", value_parser = sigma)]
    pub sigma_m: Option<f64>,

    /// Weight of readings in front of the map [default: 0.01]
    #[arg(long, value_name = "0..1", value_parser = weight)]
    pub z_short: Option<f64>,

    /// Weight of maximum readings [default: the data sheet's, or 0.02]
    #[arg(long, value_name = "0..1", value_parser = weight)]
    pub z_max: Option<f64>,

    /// Weight of random readings [default: 0.01]
    #[arg(long, value_name = "0..1", value_parser = weight)]
    pub z_rand: Option<f64>,
}

impl Reading {
    /// The model of this laser's readings.
    ///
    /// # Errors
    /// The weights leave nothing for hits.
    pub fn model(&self, lidar: &LidarConfig) -> Result<BeamModel, ClientError> {
        let said = BeamModel::of_lidar(lidar);
        let z_short = self.z_short.unwrap_or(said.z_short);
        let z_max = self.z_max.unwrap_or(said.z_max);
        let z_rand = self.z_rand.unwrap_or(said.z_rand);
        let z_hit = 1.0 - z_short - z_max - z_rand;
        if z_hit < LEAST_HIT {
            let by = match self.z_max {
                Some(_) => "",
                None => " (the dropout of the data sheet)",
            };
            return Err(ClientError::Usage(format!(
                "--z-short {z_short}, --z-max {z_max}{by} and --z-rand {z_rand} leave {z_hit:.3} \
                 for hits, and without {LEAST_HIT} a scan says nothing: give smaller ones"
            )));
        }
        let sigma_hit_m = self.sigma_m.unwrap_or(said.sigma_hit_m);
        Ok(BeamModel { z_hit, z_short, z_max, z_rand, sigma_hit_m, ..said })
    }
}

/// The least weight of hits.
pub(crate) const LEAST_HIT: f64 = 0.01;

/// The fewest particles where nothing is said of it.
const LEAST: u32 = 1000;

impl Options {
    /// The fewest particles.
    pub fn least(&self) -> u32 {
        self.particles_min.unwrap_or(LEAST.min(self.particles))
    }
}

fn exponent(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v <= 1.0, "a power greater than 0 and at most 1")
}

fn sigma(text: &str) -> Result<f64, String> {
    number(text, |v| (1e-3..=10.0).contains(&v), "a distance from 0.001 to 10 m")
}

fn weight(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..1.0).contains(&v), "a share from 0 to below 1")
}

fn pose(text: &str) -> Result<SE2, String> {
    let numbers = text.split(',').map(|word| word.trim().parse::<f64>().ok());
    match numbers.collect::<Option<Vec<f64>>>().as_deref() {
        Some(&[x_m, y_m, theta_rad]) if [x_m, y_m, theta_rad].iter().all(|v| v.is_finite()) => {
            Ok(SE2::new(x_m, y_m, theta_rad))
        }
        _ => Err("give three numbers, x and y in metres and a heading in rad: 6,4.5,0".to_owned()),
    }
}

crate::numbers::default_of_command_line!(Options);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_of_readings_is_believed_and_the_rest_are_hits() {
        let lidar = LidarConfig { dropout: 0.02, ..LidarConfig::default() };
        let told = Reading::default().model(&lidar).unwrap();
        assert_eq!(told, BeamModel::of_lidar(&lidar));
        let reading = Reading { sigma_m: Some(0.05), z_rand: Some(0.1), ..Reading::default() };
        let model = reading.model(&lidar).unwrap();
        assert_eq!((model.sigma_hit_m, model.z_rand, model.z_max), (0.05, 0.1, 0.02));
        assert!((model.z_hit - 0.87).abs() < 1e-12, "{model:?}");
        let none = Reading { z_short: Some(0.5), z_rand: Some(0.5), ..Reading::default() };
        let refused = none.model(&lidar).unwrap_err().to_string();
        assert!(refused.contains("--z-short 0.5") && refused.contains("hits"), "{refused}");
    }

    #[test]
    fn a_pose_is_three_numbers() {
        assert_eq!(pose("5.3, -21.9,-0.8"), Ok(SE2::new(5.3, -21.9, -0.8)));
        for text in ["", "1,2", "1,2,3,4", "1,2,nan", "a,b,c"] {
            assert!(pose(text).is_err(), "{text}");
        }
    }
}
