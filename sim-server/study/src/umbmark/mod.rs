//! UMBmark: what is wrong with a robot, found by letting it drive a square.
//!
//! The procedure of Borenstein and Feng (1996): a square path both ways round, n
//! times each, on odometry alone; where the laps really ended tells the two
//! systematic errors of a differential drive apart, and gives the factors that
//! correct them. Here the truth is known, so the estimate can be compared with
//! what is to be found.
//!
//! In reading order:
//!
//! * [`factors`]: the two errors;
//! * [`belief`]: what the robot believes of its wheels;
//! * [`mod@lap`]: the square, driven by odometry;
//! * [`model`]: the same without noise, in closed form;
//! * [`mod@estimate`]: from returns to factors, with their standard errors;
//! * [`report`]: what it came to;
//! * [`drawing`]: the laps and their ends.

pub mod belief;
pub mod drawing;
pub mod estimate;
pub mod factors;
pub mod lap;
pub mod model;
pub mod report;

pub use lap::{LapError, Square, Way};
pub use report::Report;

use rusty_contract::RunConfig;

use belief::Belief;
use estimate::estimate;
use lap::{Return, lap};
use report::Corrected;

#[cfg(test)]
mod tests;

/// Runs the whole procedure: laps, estimates, and the laps again with each
/// estimate applied, on the same seeds. Of lap k (from 0) each way, the seed is
/// the configuration's + 2k for clockwise, + 2k + 1 for the other.
///
/// # Errors
/// [`LapError`] if the configuration cannot be used, or a lap leads nowhere.
pub fn umbmark(config: &RunConfig, square: &Square, runs: u32) -> Result<Report, LapError> {
    let nominal = Belief::nominal(config.robot.nominal().drive);
    let before = laps(config, &nominal, square, runs)?;
    let found = estimate(&before, square.side_m, nominal.track_m);
    let again = |factors| -> Result<Corrected, LapError> {
        let belief = nominal.corrected(factors);
        let returns = laps(config, &belief, square, runs)?;
        let after = estimate(&returns, square.side_m, belief.track_m);
        Ok(Corrected { belief, e_max_syst_m: after.e_max_syst_m, returns })
    };
    Ok(Report {
        scenario: config.scenario.clone(),
        seed: config.seed,
        runs,
        square: *square,
        slip_std: config.robot.slip_std,
        truth: factors::Factors::of(&config.robot),
        corrected_by_paper: again(&found.paper.factors)?,
        corrected_by_exact: again(&found.exact.factors)?,
        returns: before,
        estimate: found,
    })
}

fn laps(
    config: &RunConfig,
    belief: &Belief,
    square: &Square,
    runs: u32,
) -> Result<Vec<Return>, LapError> {
    let mut returns = Vec::new();
    for (way, odd) in Way::BOTH.into_iter().zip([0, 1]) {
        for k in 0..u64::from(runs) {
            let seed = config.seed.wrapping_add(2 * k + odd);
            returns.push(lap(config, belief, square, way, seed)?);
        }
    }
    Ok(returns)
}
