//! Dead reckoning as a cloud of particles, and how a filter shows one.
//!
//! Each particle is a robot that could be: it drives what the wheels counted, with
//! slip of its own (the prediction of a particle filter: Thrun, Burgard, Fox,
//! *Probabilistic Robotics*, table 4.3, line 4). No scan corrects them, so the cloud
//! only grows, and it bends: the banana that an ellipse cannot be.
//!
//! `Filter::belief` shows it. It is asked only while somebody looks, which the
//! scorer does for its report, and `belief --run NAME` for you. On a log,
//! `--beliefs FILE` writes it.
use rusty_clients::clap::{self, Parser};
use rusty_clients::geometry::normal::standard_normal;
use rusty_clients::prelude::*;

/// Dead reckoning as a cloud of particles
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    /// How many particles
    #[arg(long, default_value_t = 500, value_name = "N")]
    particles: usize,

    /// How much a wheel slips in a tick, as a share of what it counted (σ)
    #[arg(long, default_value_t = 0.05, value_name = "SHARE")]
    slip: f64,
}

struct Cloud {
    drive: DiffDrive,
    last: EncoderTicks,
    slip: f64,
    reckoned: SE2,
    particles: Vec<SE2>,
    /// Numbers drawn so far: chance of our own, the same in every run.
    drawn: u64,
}

impl Cloud {
    /// A standard normal number: a counter, stirred (G. Steele et al., *Fast
    /// splittable pseudorandom number generators*, 2014), and the inverse
    /// distribution.
    fn normal(&mut self) -> f64 {
        self.drawn += 1;
        let mut word = self.drawn.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        standard_normal(word ^ (word >> 31))
    }
}

impl Filter for Cloud {
    fn tick(&mut self, tick: &Tick) -> Reply {
        let moved = odometry_delta(self.last, tick.ticks(), &self.drive);
        self.last = tick.ticks();
        self.reckoned = self.reckoned.boxplus(&moved);
        let half_track_m = 0.5 * self.drive.track_m;
        let wheels_m = [-1.0, 1.0].map(|side| moved.x + side * half_track_m * moved.z);
        for k in 0..self.particles.len() {
            let [left_m, right_m] = wheels_m.map(|m| m * (1.0 + self.slip * self.normal()));
            let its_own = self.drive.tangent(left_m, right_m);
            self.particles[k] = self.particles[k].boxplus(&its_own);
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
    let Cli { args, particles, slip } = Cli::parse();
    run_from(&args, |start| {
        let (drive, last) = (start.robot.drive, EncoderTicks::default());
        let reckoned = start.initial_pose.unwrap_or_default();
        let particles = vec![reckoned; particles];
        Ok(Cloud { drive, last, slip, reckoned, particles, drawn: 0 })
    })
}
