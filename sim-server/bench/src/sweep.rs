//! `bench sweep`: how fast a sweep simulates, on one core and on all.
//!
//! Sweeps without clients, the table kept in memory, compared with the bare world: the
//! same runs stepped one after the other, with nothing reckoned, digested or
//! kept. A sweep pays the difference.

use std::sync::Arc;
use std::time::Duration;

use rusty_contract::{FieldError, Frame};
use rusty_sim::Sim;

use super::alternate::{Rival, alternate};
use super::quantiles::Spread;
use super::report::results_hash;
use super::results::{Results, Row};
use crate::error::BenchError;
use rusty_engine::run::Progress;
use rusty_study::sweep::{Axis, Plan, Request, SweepJob};

/// Seeds of the larger sweep, that of the chapter.
const SEEDS: u64 = 500;
/// Seeds of the one with scans, which take longer.
const SEEDS_WITH_SCANS: u64 = 50;
/// Ticks of a run.
const TICKS: u64 = 300;
/// The scenario of all: a room with walls, a patrol.
const SCENARIO: &str = "apartment";

/// What is swept, in the order of the table: name, seeds, ticks between scans.
pub const CASES: [(&str, u64, u64); 2] = [
    ("500 seeds × 300 ticks, no scans", SEEDS, 0),
    ("50 seeds × 300 ticks, 180 beams every 5 ticks", SEEDS_WITH_SCANS, 5),
];

/// Returns the names of the rows.
#[must_use]
pub fn rows() -> Vec<String> {
    CASES.iter().map(|(name, ..)| (*name).to_owned()).collect()
}

/// Measures for about `time`, with one worker and with `jobs`.
///
/// # Errors
/// None that the built-in scenario can cause.
pub fn run(time: Duration, jobs: usize) -> Result<Results, BenchError> {
    let mut rows = Vec::new();
    for (name, seeds, scan_every) in CASES {
        rows.push(case(name, seeds, scan_every, jobs, time / CASES.len() as u32)?);
    }
    let columns = [
        ("one_ms", 1),
        ("all_ms", 1),
        ("one_over_all", 2),
        ("one_over_bare", 2),
        ("ticks_per_s", 0),
        ("digests_hash", 0),
    ];
    Ok(Results::new(&[&columns], rows).fact("jobs", jobs))
}

fn case(
    name: &str,
    seeds: u64,
    scan_every: u64,
    jobs: usize,
    time: Duration,
) -> Result<Row, BenchError> {
    let digests = sweep(seeds, scan_every, jobs)?;
    let plan = plan(seeds, scan_every)?;
    let ticks = seeds * TICKS;
    let mut world = plan.worlds[0].clone();
    let mut frame = Frame::boxed();
    let mut rivals = [
        Rival::new(1, || {
            // It went through the first time.
            let _ = sweep(seeds, scan_every, 1);
        }),
        Rival::new(1, || {
            let _ = sweep(seeds, scan_every, jobs);
        }),
        Rival::new(1, || bare(&mut world, &mut frame, seeds)),
    ];
    let rounds = alternate(&mut rivals, time);
    let [one, all, bare] = &rivals;
    let ms = |Spread { median, min, max }: Spread| Spread {
        median: median * 1e-6,
        min: min * 1e-6,
        max: max * 1e-6,
    };
    Ok(Row::new(name)
        .with("ticks", ticks)
        .with("rounds", rounds)
        .with("one_ms", ms(one.ns()))
        .with("all_ms", ms(all.ns()))
        .with("one_over_all", one.over(all))
        .with("one_over_bare", one.over(bare))
        .with("ticks_per_s", ticks as f64 / (one.ns().median * 1e-9))
        .with("digests_hash", results_hash(&digests)))
}

fn plan(seeds: u64, scan_every: u64) -> Result<Plan, BenchError> {
    let seeds = format!("0..{seeds}");
    let seeds = seeds.parse().map_err(|why: String| FieldError::new("seeds", &seeds, why, ""))?;
    let axes = vec![Axis::parse("--set", &format!("scan_every={scan_every}"))?];
    let (scenario, ticks) = (SCENARIO.to_owned(), Some(TICKS));
    let (clients, add) = (false, Vec::new());
    let request = Request { scenario, seeds, axes, ticks, clients, add };
    Plan::new(request).map_err(BenchError::Sweep)
}

/// One sweep, from its plan to its rows.
fn sweep(seeds: u64, scan_every: u64, jobs: usize) -> Result<Vec<String>, BenchError> {
    let sweeping = SweepJob {
        plan: plan(seeds, scan_every)?,
        writer: String::new(),
        jobs,
        table: None,
        resume: false,
        force: false,
        runs_dir: None,
    };
    let came = sweeping.run(&Arc::default(), Progress::new(0, true));
    let came = came.map_err(BenchError::Sweep)?;
    Ok(came.swept.rows.into_iter().map(|row| row.digest).collect())
}

/// The worlds of a sweep and nothing else.
fn bare(world: &mut Sim, frame: &mut Frame, seeds: u64) {
    for seed in 0..seeds {
        world.restart(seed);
        for _ in 0..TICKS {
            let _ = std::hint::black_box(world.step(None, frame));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digests_do_not_depend_on_the_workers() {
        let case = |jobs| case("x", 6, 5, jobs, Duration::ZERO).unwrap();
        let (one, three) = (case(1), case(3));
        assert_eq!(one.figures["digests_hash"], three.figures["digests_hash"]);
        assert_eq!(one.number("ticks"), 1800.0);
    }
}
