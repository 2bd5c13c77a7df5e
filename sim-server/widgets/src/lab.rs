//! Runs of many seeds: the table of `sweep`, and the paths.
//!
//! Each run has 12 figures of its first estimator, those of a row of `sweep` in its
//! order: ticks, time, distance, final position error, final heading error, mean position
//! error, ATE, 95th percentile and greatest position error, RMSE and greatest heading
//! error, ticks in which a wall held the robot. Then follow for each tick the true x, y, θ
//! and the estimated x, y, θ. Metres, radians, seconds; what is not known is NaN.

use crate::run::Run;

/// Words of a row of [`Run::step`] before its estimators.
const HEAD: usize = 9;

/// Makes the runs with `count` seeds from `first` on, and adds their numbers. Returns a
/// line with the digest of each. `run` then has the last of them.
///
/// # Errors
/// A sentence: the run has no estimator, or a seed is too large.
pub fn lab(
    run: &mut Run,
    first: u64,
    count: u32,
    numbers: &mut Vec<f64>,
) -> Result<String, String> {
    let last = first.checked_add(u64::from(count)).ok_or("the last seed has more than 64 bits")?;
    let ticks = run.header.config.ticks;
    let (mut row, mut digests, mut paths) = (Vec::new(), Vec::new(), Vec::new());
    for seed in first..last {
        run.restart(seed)?;
        paths.clear();
        for _ in 0..ticks {
            row.clear();
            run.step(&mut row);
            let estimate = row.get(HEAD..HEAD + 3).ok_or("the scenario has no estimator")?;
            paths.extend_from_slice(&row[2..5]);
            paths.extend_from_slice(estimate);
        }
        let (time_s, distance_m) = (run.frame.time_s(), run.distance_m());
        let blocked = run.blocked_ticks as f64;
        let entry = run.entries.first_mut().ok_or("the scenario has no estimator")?;
        let figures = entry.errors.figures();
        numbers.extend([ticks as f64, time_s, distance_m]);
        let figures = [
            figures.final_position_error_m,
            figures.final_heading_error_rad,
            figures.mean_position_error_m,
            figures.ate_rmse_m,
            figures.p95_position_error_m,
            figures.max_position_error_m,
            figures.rmse_heading_error_rad,
            figures.max_heading_error_rad,
        ];
        numbers.extend(figures.map(|figure| figure.unwrap_or(f64::NAN)));
        numbers.push(blocked);
        numbers.extend_from_slice(&paths);
        digests.push(run.digest.run_hex());
    }
    Ok(digests.join("\n"))
}
