//! FastSLAM: the path by particles, and in each particle a map of landmarks.
//!
//! Source: M. Montemerlo, S. Thrun, D. Koller, B. Wegbreit, *FastSLAM* (AAAI 2002) and
//! *FastSLAM 2.0* (IJCAI 2003); *Probabilistic Robotics*, chapter 13: Table 13.1 (variant
//! 1, known correspondences), Table 13.2 (variant 1, unknown correspondences), Table 13.3
//! (variant 2). [`particle`] has the step of a particle, [`crate::landmarks`] the
//! measurement model and the choice of the landmark.
//!
//! Departures, and why:
//! * Particles move when a tick has readings, by the whole motion since the last ones.
//! * All readings of a tick are matched first. Variant 2 then corrects the proposal by one
//!   after the other, and draws one pose. The book draws anew for each reading.
//! * Particles are drawn anew when their weights are worth less than half of their number,
//!   as in [`crate::mcl`], and not at every step.
//! * Each particle has its map in a separate list, which is copied when the particle is
//!   drawn twice: O(N) for N landmarks. The book has a tree for larger maps.
//! * Landmarks are never removed (Table 13.2 counts for and against each): a wall hides a
//!   landmark as well as a wrong decision.
//! * The answer is the weighted mean on the group and the covariance around it. The
//!   particles begin at the initial pose, or at the origin if that is not given.
//!
//! The particles forget the alternatives of the early path: after some time all have the
//! same ancestor. The covariance is then too small (T. Bailey, J. Nieto, E. Nebot,
//! *Consistency of the FastSLAM algorithm*, ICRA 2006): `docs/filters.md` has the figures.

pub mod particle;

use clap::{Args, ValueEnum};
use nalgebra::{Matrix3, Vector3};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{BeliefKind, LandmarkReading, Reply, Start, WeightedPose};
use rusty_geometry::{EncoderCounts, SE2, trig};

use self::particle::Particle;
use crate::landmarks::{LandmarkModel, LandmarkOptions};
use crate::resampling::{effective_size, low_variance, normalise};
use crate::tangent::{estimate, placed, symmetric};
use crate::{Odometry, OdometryNoise, Random};

/// Particles are drawn anew when their weights are worth less than this share.
const WORTH: f64 = 0.5;
/// Smallest variance of an answer (m², rad²): a covariance of 0 has no inverse.
const LEAST: f64 = 1e-8;

/// The proposal that poses are drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Variant {
    /// The motion (FastSLAM 1.0)
    #[value(name = "1")]
    One,
    /// The motion and the readings (FastSLAM 2.0)
    #[value(name = "2")]
    Two,
}

/// Localise and map landmarks with particles (FastSLAM)
///
/// Each particle (Probabilistic Robotics, chapter 13) has a pose and an EKF for every
/// landmark that it saw. It uses encoders, ranges and bearings of landmarks, and no map.
/// Readings without identity are matched by each particle. It answers every tick with the
/// mean and the covariance of the particles.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Variant of the algorithm
    #[arg(long, value_enum, default_value_t = Variant::Two)]
    pub variant: Variant,

    /// Number of particles
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub particles: u32,

    /// Seed of the filter's random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,

    /// What is believed of the wheels.
    #[command(flatten)]
    pub odometry: OdometryNoise,

    /// What is believed of the readings.
    #[command(flatten)]
    pub landmarks: LandmarkOptions,
}

crate::numbers::default_of_command_line!(Options);

/// FastSLAM.
#[derive(Debug)]
pub struct FastSlam {
    variant: Variant,
    odometry: Odometry,
    model: LandmarkModel,
    particles: Vec<Particle>,
    /// They add up to 1.
    weights: Vec<f64>,
    /// Mean and covariance of the particles.
    mean: (SE2, Matrix3<f64>),
    normals: Random,
    draws: Random,
    drawn: Vec<u32>,
}

impl FastSlam {
    /// Begins at the initial pose, or at the origin, with empty maps.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: the robot has no landmark sensor.
    pub fn new(start: &Start, options: &Options) -> Result<Self, ClientError> {
        let (count, pose) = (options.particles as usize, start.initial_pose.unwrap_or_default());
        let first = Particle { pose, landmarks: Vec::new() };
        Ok(Self {
            variant: options.variant,
            odometry: Odometry::new(start.robot.drive, options.odometry),
            model: LandmarkModel::of_start(start, &options.landmarks)?,
            particles: vec![first; count],
            weights: vec![1.0 / count as f64; count],
            mean: (pose, Matrix3::identity() * LEAST),
            normals: Random::new(options.seed, 1),
            draws: Random::new(options.seed, 2),
            drawn: Vec::new(),
        })
    }

    /// Takes the encoder counts at the end of a tick.
    pub fn advance(&mut self, counts: EncoderCounts) {
        self.odometry.advance(counts);
    }

    /// Takes the readings of a tick: moves, weighs and draws the particles.
    pub fn see(&mut self, readings: &[LandmarkReading]) {
        let motion = self.odometry.take();
        let mut log_weights = Vec::with_capacity(self.particles.len());
        for particle in &mut self.particles {
            let z = Vector3::from_fn(|_, _| self.normals.normal());
            log_weights.push(particle.step(&motion, readings, &self.model, self.variant, &z));
        }
        let most = log_weights.iter().copied().fold(f64::MIN, f64::max);
        for (weight, log) in self.weights.iter_mut().zip(&log_weights) {
            *weight *= trig::exp(log - most);
        }
        normalise(&mut self.weights);
        self.mean = mean(&self.particles, &self.weights);
        self.draw();
    }

    /// Draws the next generation, if the weights call for one (Table 13.1).
    fn draw(&mut self) {
        let count = self.particles.len();
        if effective_size(&self.weights) >= WORTH * count as f64 {
            return;
        }
        low_variance(&self.weights, count, self.draws.uniform(), &mut self.drawn);
        self.particles = self.drawn.iter().map(|k| self.particles[*k as usize].clone()).collect();
        self.weights.fill(1.0 / count as f64);
    }

    /// The particles after the last readings.
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// The believed pose, and the covariance (m, m, rad) of its error τ: those after the
    /// last readings, carried on by the wheels.
    pub fn pose(&self) -> (SE2, Matrix3<f64>) {
        placed(&self.mean.0, &self.mean.1, self.odometry.so_far())
    }
}

/// Mean on the group and covariance in the tangent space there.
fn mean(particles: &[Particle], weights: &[f64]) -> (SE2, Matrix3<f64>) {
    let heaviest = |a: &usize, b: &usize| weights[*a].total_cmp(&weights[*b]).then(b.cmp(a));
    let Some(heaviest) = (0..particles.len()).max_by(heaviest) else {
        return (SE2::default(), Matrix3::identity() * LEAST);
    };
    let (mut mean, all) = (particles[heaviest].pose, || particles.iter().zip(weights));
    // Two or three steps come as near as numbers go.
    for _ in 0..3 {
        let step = |sum, (p, w): (&Particle, &f64)| sum + p.pose.boxminus(&mean) * *w;
        mean = mean.boxplus(&all().fold(Vector3::zeros(), step));
    }
    let mut covariance = Matrix3::identity() * LEAST;
    for (particle, weight) in all() {
        let tau = particle.pose.boxminus(&mean);
        covariance += tau * tau.transpose() * *weight;
    }
    (mean, symmetric(&covariance))
}

impl Filter for FastSlam {
    const SHOWS_BELIEF: bool = true;

    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders());
        if let Some(readings) = tick.readings().landmarks() {
            self.see(readings);
        }
        let (pose, covariance) = self.pose();
        estimate(&pose, &covariance).into()
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let since = self.odometry.so_far().now_in_then;
        poses.extend(self.particles.iter().zip(&self.weights).map(|(particle, &weight)| {
            let now = particle.pose.compose(&since);
            WeightedPose { x_m: now.x(), y_m: now.y(), theta_rad: now.theta(), weight }
        }));
        Some(BeliefKind::Particles)
    }
}

#[cfg(test)]
mod tests;
