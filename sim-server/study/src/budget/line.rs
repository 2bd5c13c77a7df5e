//! A row of the budget: runs with the same sources, over all seeds.

use rusty_contract::{Frame, RunConfig};
use rusty_geometry::{EncoderCounts, odometry_delta};
use rusty_sim::{Sim, SimError, StepOutcome};
use serde::Serialize;

use crate::sweep::Seeds;
use rusty_metrics::{Moments, heading_error_rad, percentile, position_error_m};

/// Runs between two questions whether to go on.
const TURN: u64 = 16;

/// The results of the runs with some sources.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Which, in words.
    pub name: String,
    /// Runs that were made: one where no seed has a say.
    pub runs: u64,
    /// Those in which something blocked the robot, whose wheels turn on.
    pub blocked_runs: u64,
    /// Whether the runs differ from seed to seed.
    pub varies_with_seed: bool,
    /// Final position error of dead reckoning, m.
    pub final_position_error_m: Moments,
    /// Its 95th percentile over the runs, linear between ranks, m.
    pub p95_final_position_error_m: f64,
    /// Final heading error without its sign, degrees.
    pub final_heading_error_deg: Moments,
    /// Mean of the squares of the final position error, m².
    pub mean_square_m2: f64,
    /// Of the sum of the mean squares of all sources alone; `None` for all
    /// together, and if something blocked a robot in one of them.
    pub share: Option<f64>,
    /// Distance driven by command, mean, m.
    pub driven_m: f64,
}

/// One run, at its end.
struct Ended {
    position_m: f64,
    heading_deg: f64,
    driven_m: f64,
    is_blocked: bool,
}

/// Makes the runs. Without slip nothing in them is chance (scans are not made:
/// dead reckoning does not see them), and one is enough.
pub(super) fn of(
    config: &RunConfig,
    name: String,
    seeds: Seeds,
    each: &mut dyn FnMut(&str) -> bool,
) -> Result<Option<Line>, SimError> {
    let varies_with_seed = config.slips();
    let runs = if varies_with_seed { seeds.count() } else { 1 };
    let mut sim = Sim::new(RunConfig { scan_every: 0, ..config.clone() })?;
    let (mut frame, mut ended) = (Frame::boxed(), Vec::new());
    for k in 0..runs {
        if k.is_multiple_of(TURN) && !each(&name) {
            return Ok(None);
        }
        sim.restart(seeds.at(k));
        ended.push(reckoned(&mut sim, &mut frame));
    }
    let all = |of: fn(&Ended) -> f64| ended.iter().map(of).collect::<Vec<f64>>();
    let mut position_m = all(|e| e.position_m);
    let squares: Vec<f64> = position_m.iter().map(|d| d * d).collect();
    Ok(Some(Line {
        name,
        runs,
        blocked_runs: ended.iter().filter(|e| e.is_blocked).count() as u64,
        varies_with_seed,
        final_position_error_m: Moments::of(&position_m),
        p95_final_position_error_m: percentile(&mut position_m, 0.95).unwrap_or(f64::NAN),
        final_heading_error_deg: Moments::of(&all(|e| e.heading_deg)),
        mean_square_m2: Moments::of(&squares).mean,
        share: None,
        driven_m: Moments::of(&all(|e| e.driven_m)).mean,
    }))
}

/// Dead reckoning through a run, from the true start.
fn reckoned(sim: &mut Sim, frame: &mut Frame) -> Ended {
    let (drive, dt_s) = (sim.config().robot.nominal().drive, sim.config().dt_s);
    let (mut believed, mut last) = (sim.config().start, EncoderCounts::default());
    let (mut driven_m, mut is_blocked) = (0.0, false);
    for _ in 0..sim.config().ticks {
        is_blocked |= sim.step(None, frame) == StepOutcome::Blocked;
        driven_m += frame.command().v_m_s.abs() * dt_s;
        believed = believed.boxplus(&odometry_delta(last, frame.encoders(), &drive));
        last = frame.encoders();
    }
    let truth = sim.truth();
    let heading_deg = heading_error_rad(&believed, &truth).abs().to_degrees();
    let position_m = position_error_m(&believed, &truth);
    Ended { position_m, heading_deg, driven_m, is_blocked }
}
