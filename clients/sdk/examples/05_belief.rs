//! Dead reckoning as a cloud of particles, and how a filter shows one.
//!
//! Each particle is a robot that could be: it drives what the wheels counted, with
//! separate slip (the prediction of a particle filter: Thrun, Burgard, Fox,
//! *Probabilistic Robotics*, table 4.3, line 4). No scan corrects them, so the cloud
//! only grows, and it bends: the banana that an ellipse cannot be.
//!
//! `Filter::belief` shows it. It is called only while an observer is attached: the
//! scorer for its report, or `belief --run NAME`. On a log,
//! `--beliefs FILE` writes it.
use rusty_clients::clap;
use rusty_clients::prelude::*;

/// Dead reckoning as a cloud of particles
#[derive(clap::Args)]
struct Options {
    /// Number of particles
    #[arg(long, default_value_t = 500, value_name = "N")]
    particles: usize,

    /// Slip of a wheel in a tick, as a share of its counts (σ)
    #[arg(long, default_value_t = 0.05, value_name = "SHARE")]
    slip: f64,
}

struct Cloud {
    drive: DiffDrive,
    last: EncoderCounts,
    slip: f64,
    reckoned: SE2,
    particles: Vec<SE2>,
    random: Random,
}

impl Filter for Cloud {
    const SHOWS_BELIEF: bool = true;

    fn update(&mut self, tick: &Tick) -> Reply {
        let moved = odometry_delta(self.last, tick.encoders(), &self.drive);
        self.last = tick.encoders();
        self.reckoned = self.reckoned.boxplus(&moved);
        let half_track_m = 0.5 * self.drive.track_m;
        let wheels_m = [-1.0, 1.0].map(|side| moved.x + side * half_track_m * moved.z);
        for particle in &mut self.particles {
            let [left_m, right_m] = wheels_m.map(|m| m * (1.0 + self.slip * self.random.normal()));
            *particle = particle.boxplus(&self.drive.tangent(left_m, right_m));
        }
        self.reckoned.into()
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let weight = 1.0 / self.particles.len() as f64;
        poses.extend(self.particles.iter().map(|p| WeightedPose {
            x_m: p.x(),
            y_m: p.y(),
            theta_rad: p.theta(),
            weight,
        }));
        Some(BeliefKind::Particles)
    }
}

fn main() -> Exit {
    rusty_clients::run(|start, Options { particles, slip }| {
        let (drive, last) = (start.robot.drive, EncoderCounts::default());
        let reckoned = start.initial_pose.unwrap_or_default();
        let (particles, random) = (vec![reckoned; particles], Random::new(1, 1));
        Ok(Cloud { drive, last, slip, reckoned, particles, random })
    })
}
