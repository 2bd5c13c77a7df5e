//! What the tests share: a configuration, and a run with dead reckoning.
#![allow(dead_code, reason = "every test binary uses its own part")]

use rusty_contract::config::PatrolConfig;
use rusty_contract::{Frame, LidarConfig, RobotConfig, RunConfig, ScriptConfig};
use rusty_geometry::{EncoderCounts, SE2, World, odometry_delta, trig};
use rusty_sim::{Sim, StepOutcome};

/// Rusty without slip, dt = 0.1 s, no scans; for tests to change.
pub fn config(script: ScriptConfig, world: &World, start: SE2) -> RunConfig {
    RunConfig {
        scenario: "test".into(),
        seed: 0,
        ticks: 300,
        dt_s: 0.1,
        scan_every: 0,
        start,
        robot: RobotConfig { slip_std: 0.0, ..RobotConfig::default() },
        lidar: LidarConfig::default(),
        script,
        world: world.spec().clone(),
        sensors: rusty_contract::Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    }
}

/// Where the patrol starts in the Apartment, and everywhere else.
pub fn patrol_start() -> SE2 {
    SE2::new(6.0, 4.5, 0.0)
}

/// Script G, open loop.
pub fn patrol() -> ScriptConfig {
    ScriptConfig::Patrol(PatrolConfig::default())
}

/// Script G, steered on the truth.
pub fn steered() -> ScriptConfig {
    ScriptConfig::TruthSteeredPatrol(PatrolConfig::default())
}

/// A finished run.
pub struct Run {
    pub truth: SE2,
    /// The pose that encoders alone give, from the true start.
    pub reckoned: SE2,
    pub ticks: EncoderCounts,
    /// Sum of |v|·dt over the commands as applied, m.
    pub driven_m: f64,
    pub blocked: usize,
}

impl Run {
    pub fn drift_m(&self) -> f64 {
        let d = self.reckoned.translation() - self.truth.translation();
        trig::hypot(d.x, d.y)
    }

    pub fn heading_deg(&self) -> f64 {
        self.reckoned.boxminus(&self.truth).z.abs().to_degrees()
    }
}

/// The simulation of a configuration that is known to be good.
#[allow(clippy::unwrap_used, reason = "part of tests, though not of a test function")]
pub fn sim(config: RunConfig) -> Sim {
    Sim::new(config).unwrap()
}

/// Runs `config` to its end, with dead reckoning on what the frames show.
pub fn run(config: RunConfig) -> Run {
    let drive = config.robot.nominal().drive;
    let (ticks, dt_s, start) = (config.ticks, config.dt_s, config.start);
    let mut sim = sim(config);
    let mut frame = Frame::boxed();
    let mut run = Run {
        truth: start,
        reckoned: start,
        ticks: EncoderCounts::default(),
        driven_m: 0.0,
        blocked: 0,
    };
    for _ in 0..ticks {
        if sim.step(None, &mut frame) == StepOutcome::Blocked {
            run.blocked += 1;
        }
        run.driven_m += frame.command().v_m_s.abs() * dt_s;
        let delta = odometry_delta(run.ticks, frame.encoders(), &drive);
        run.reckoned = run.reckoned.boxplus(&delta);
        run.ticks = frame.encoders();
    }
    run.truth = sim.truth();
    run
}

/// Mean of `values`.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The value that 95 % of `values` do not exceed, linear between ranks.
pub fn p95(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = 0.95 * (sorted.len() - 1) as f64;
    let below = rank.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (rank - below as f64) * (sorted[above] - sorted[below])
}
