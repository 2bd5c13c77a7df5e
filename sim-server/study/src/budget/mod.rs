//! The odometry error budget: how much of the error comes from where.
//!
//! A run is made with each source of error alone, and with all of them, and dead
//! reckoning is held against the truth at its end. Sources are what separates
//! wheel from floor:
//!
//! * *quantization*: the encoders round each wheel to whole counts. It is in
//!   every row, because there is no robot without it; alone it is the first;
//! * *slip*: drawn anew for each wheel and tick (`robot.slip_std`), the only one
//!   that is chance;
//! * *radius bias* (`robot.radius_bias_right`) and *track bias*
//!   (`robot.track_bias`): the same on every seed, however many there are.
//!
//! Source: chapter 4 of the online *Probabilistic Robotics*, "The odometry error
//! budget: three sources, three behaviours". Departures: the second systematic
//! error has a row too; and each row has a share. Mean squares are what adds up
//! where sources are independent and small, so a row's share is its mean square
//! final error over the sum of those of all sources alone; what the sources come to
//! together is next to that sum, and where the two differ the sources
//! interact.
//!
//! In reading order: [`source`], [`line`](mod@line), [`report`].

pub mod line;
pub mod report;
pub mod source;

pub use line::Line;
pub use report::Report;
pub use source::Source;

use rusty_contract::RunConfig;
use rusty_sim::SimError;

use crate::sweep::Seeds;

#[cfg(test)]
mod tests;

/// Makes the budget of `config` over `seeds`. A source that the configuration
/// does not have (its number is zero) has no row. `each` is called before each
/// row with its name, and may say to stop by `false`; then the result is `None`.
///
/// # Errors
/// [`SimError`] if the configuration cannot be used.
pub fn budget(
    config: &RunConfig,
    seeds: Seeds,
    each: &mut dyn FnMut(&str) -> bool,
) -> Result<Option<Report>, SimError> {
    let present: Vec<Source> = Source::ALL.into_iter().filter(|s| s.is_in(config)).collect();
    let absent = Source::ALL.into_iter().filter(|s| !s.is_in(config)).collect();
    let mut lines = Vec::new();
    for source in &present {
        let Some(line) = line::of(&source.alone(config), source.name(config), seeds, each)? else {
            return Ok(None);
        };
        lines.push(line);
    }
    let sum: f64 = lines.iter().map(|l| l.mean_square_m2).sum();
    if lines.iter().all(|l| l.blocked_runs == 0) {
        lines.iter_mut().for_each(|l| l.share = Some(l.mean_square_m2 / sum));
    }
    let Some(together) = line::of(config, "all together".to_owned(), seeds, each)? else {
        return Ok(None);
    };
    Ok(Some(Report {
        scenario: config.scenario.clone(),
        seeds: seeds.to_string(),
        ticks: config.ticks,
        dt_s: config.dt_s,
        driven_m: together.driven_m,
        sources: lines,
        sum_of_squares_rms_m: sum.sqrt(),
        together,
        absent,
    }))
}
