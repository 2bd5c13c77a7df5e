//! `bench idle`: what waiting costs, in a run that is paused and in one that
//! goes at the pace of real time.

use std::time::{Duration, Instant};

use rusty_contract::RunName;
use rusty_link::WaitPolicy;

use super::results::{Results, Row};
use super::stage::{Stage, mix};
use super::stamps::Stamps;
use super::usage::Usage;
use crate::error::BenchError;
use rusty_engine::run::{Pace, Stop};
use rusty_engine::scenario_file;

/// How long joining may take before it is measured, s: no part of waiting.
const SETTLED: Duration = Duration::from_secs(1);
/// Between two looks at the wish to stop.
const LOOK: Duration = Duration::from_millis(20);

/// The runs: what each does meanwhile, its pace, and whether it is paused.
const RUNS: [(&str, Pace, bool); 2] =
    [("paused", Pace::Max, true), ("real time, 50 ticks a second", Pace::Factor(1.0), false)];

/// Returns the names of the rows.
#[must_use]
pub fn rows() -> Vec<String> {
    let processes = processes();
    let of = |run: &'static str| processes.iter().map(move |process| label(run, process));
    RUNS.iter().flat_map(|(run, _, _)| of(run)).collect()
}

fn label(run: &str, process: &str) -> String {
    format!("{run}, {process}")
}

/// Watches a paused run and one at the pace of real time, each for `seconds`.
/// `None` if it was asked to stop.
///
/// # Errors
/// [`BenchError`] if a run cannot be set up or loses a participant.
pub fn measure(
    run: &RunName,
    wait: WaitPolicy,
    seconds: f64,
    stop: &Stop,
) -> Result<Option<Results>, BenchError> {
    let stage = Stage { run, wait, rounds: 1, warm_up: 0, pin: &[], stop };
    let mut rows = Vec::new();
    for (words, pace, paused) in RUNS {
        match one(&stage, (pace, paused), seconds)? {
            Some(cores) => rows.extend(cores.into_iter().map(|(process, cores)| {
                Row::new(label(words, &process)).with("core_percent", 100.0 * cores)
            })),
            None => return Ok(None),
        }
    }
    let results = Results::new(&[&[("core_percent", 2)]], rows);
    Ok(Some(results.fact("wait", wait.to_string()).fact("seconds", seconds)))
}

fn one(
    stage: &Stage<'_>,
    how: (Pace, bool),
    seconds: f64,
) -> Result<Option<Vec<(String, f64)>>, BenchError> {
    let roster = mix();
    let mut config = scenario_file::load("apartment", &[])?.config()?;
    // Longer than it will be watched.
    config.ticks = 1 << 32;
    let mut cores = None;
    let stamps = Stamps::new(0, 0, Vec::new());
    stage.at_pace(config, &roster, how, stamps, |pids| {
        cores = watch(pids, seconds, stage);
        // Enough was seen; this run ends as by Ctrl-C.
        stage.stop.raise();
    })?;
    let Some(cores) = cores else { return Ok(None) };
    stage.stop.lower();
    Ok(Some(processes().into_iter().zip(cores).collect()))
}

/// The processes of a run, in the order in which they are watched.
fn processes() -> Vec<String> {
    let clients = mix().into_iter().map(|participant| participant.name);
    std::iter::once("server".to_owned()).chain(clients).collect()
}

/// Cores' worth of time of this process and of `pids`, while `seconds` pass;
/// `None` if it was asked to stop, or the kernel does not say.
fn watch(pids: &[u32], seconds: f64, stage: &Stage<'_>) -> Option<Vec<f64>> {
    sleep(SETTLED, stage)?;
    let all = || {
        let others = pids.iter().map(|pid| Usage::of(*pid));
        std::iter::once(Usage::own()).chain(others).collect::<Option<Vec<Usage>>>()
    };
    let (began, before) = (Instant::now(), all()?);
    sleep(Duration::from_secs_f64(seconds), stage)?;
    let (after, elapsed_ns) = (all()?, began.elapsed().as_nanos() as f64);
    let used = after.into_iter().zip(before).map(|(after, before)| after - before);
    Some(used.map(|used| used.cpu_ns as f64 / elapsed_ns).collect())
}

fn sleep(time: Duration, stage: &Stage<'_>) -> Option<()> {
    let until = Instant::now() + time;
    while Instant::now() < until {
        if stage.stop.is_raised() {
            return None;
        }
        std::thread::sleep(LOOK.min(time));
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_for_each_process_of_each_run() {
        let rows = rows();
        assert_eq!(rows.len(), 2 * 4);
        assert_eq!(rows[0], "paused, server");
        assert_eq!(rows[7], "real time, 50 ticks a second, logger");
    }
}
