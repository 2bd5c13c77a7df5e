//! Rows and tracks for tests.

use rusty_contract::{Frame, RunConfig, ScriptConfig};
use rusty_geometry::{EncoderCounts, SE2, odometry_delta, open, trig};
use rusty_sim::Sim;

use super::{Row, Sample, Track};
use rusty_engine::scenario_file;

/// A run that came out well.
pub(super) fn row(cell: usize, seed: u64, estimator: &str) -> Row {
    Row {
        cell,
        seed,
        parameters: vec![("robot.slip_std".to_owned(), format!("0.0{cell}"))].into(),
        estimator: estimator.into(),
        ticks: 300,
        time_s: 30.0,
        distance_m: 14.0,
        final_position_error_m: 0.5,
        final_heading_error_rad: 0.1,
        mean_position_error_m: 0.2,
        ate_rmse_m: 0.3,
        p95_position_error_m: 0.45,
        max_position_error_m: 0.5,
        rmse_heading_error_rad: 0.05,
        max_heading_error_rad: 0.1,
        blocked_ticks: Some(0),
        z_short: 0.25,
        digest: "0".repeat(32),
        clients: None,
    }
}

/// A track from its samples.
pub(super) fn track(cell: usize, seed: u64, samples: Vec<Sample>) -> Track {
    Track { cell, seed, estimator: "dead-reckoning".into(), samples }
}

/// Straight ahead at 0.5 m/s for 3 s with a slip of 0.05: the chapter's
/// laboratory of seeds.
pub(super) fn straight_leg() -> RunConfig {
    let mut config = scenario_file::load("patrol", &[]).unwrap().config().unwrap();
    config.ticks = 30;
    config.robot.slip_std = 0.05;
    config.script = ScriptConfig::Straight { v_m_s: 0.5 };
    config.world = open().spec().clone();
    config
}

/// Dead reckoning through `config` with a seed, a sample every `every` ticks.
pub(super) fn reckoned(config: &RunConfig, cell: usize, seed: u64, every: u64) -> Track {
    let drive = config.robot.nominal().drive;
    let mut sim = Sim::new(RunConfig { seed, ..config.clone() }).unwrap();
    let mut frame = Frame::boxed();
    let (mut estimate, mut last) = (config.start, EncoderCounts::default());
    let (mut distance_m, mut samples) = (0.0, Vec::new());
    for tick in 0..config.ticks {
        let before = sim.truth();
        let _ = sim.step(None, &mut frame);
        let truth: SE2 = sim.truth();
        distance_m += trig::hypot(truth.x() - before.x(), truth.y() - before.y());
        estimate = estimate.boxplus(&odometry_delta(last, frame.encoders(), &drive));
        last = frame.encoders();
        if (tick + 1).is_multiple_of(every) {
            let time_s = frame.time_s();
            samples.push(Sample { time_s, distance_m, truth, estimate, nees: None });
        }
    }
    track(cell, seed, samples)
}
