//! `bench start`: from starting `launch` to its first frame, with an
//! estimator, a scorer and a logger as processes; and what memory it takes.

use std::path::Path;
use std::process::{Command, Stdio};

use rusty_contract::RunName;
use rusty_link::{Domain, monotonic_ns};
use serde_json::Value;

use super::noise::NoiseMeter;
use super::quantiles::Quantiles;
use super::results::{Results, Row};
use crate::error::BenchError;
use rusty_engine::run::{RunError, Stop};

/// What is measured from the start of a launch.
const UNTIL: [&str; 2] = ["to the first frame", "to the end"];

/// Returns the names of the rows.
#[must_use]
pub fn rows() -> Vec<String> {
    UNTIL.map(str::to_owned).to_vec()
}

/// Launches N runs, one after the other. `None` if it was asked to
/// stop.
///
/// # Errors
/// [`BenchError::Nothing`] if one of them does not end well.
pub fn measure(
    run: &RunName,
    repeat: usize,
    stop: &Stop,
    noise: &mut NoiseMeter,
) -> Result<Option<Results>, BenchError> {
    let domain = Domain::create(run)?;
    let folder = domain.folder().join("out");
    let (mut first, mut end, mut peak) = (Vec::new(), Vec::new(), 0);
    // The first finds programs on the disk; it does not count.
    for i in 0..=repeat {
        let began_ns = monotonic_ns();
        let report = launch(run, &folder)?;
        let ended_ns = monotonic_ns();
        if stop.is_raised() {
            return Ok(None);
        }
        let number = |key: &str| {
            let missing = || BenchError::Nothing(format!("its report has no {key}"));
            report[key].as_u64().ok_or_else(missing)
        };
        if i > 0 {
            first.push(number("first_frame_ns")?.saturating_sub(began_ns));
            end.push(ended_ns - began_ns);
            peak = peak.max(number("peak_resident_bytes")?);
        }
        noise.look();
    }
    Ok(Some(results(&mut first, &mut end, peak)))
}

fn results(first_ns: &mut [u64], end_ns: &mut [u64], peak_bytes: u64) -> Results {
    let row = |(until, durations_ns): (&str, &mut [u64])| {
        let q = Quantiles::of(durations_ns);
        let ms = |ns: u64| ns as f64 * 1e-6;
        let row = Row::new(until).with("count", q.count).with("mean_ms", q.mean_ns * 1e-6);
        row.with("p50_ms", ms(q.p50_ns)).with("p90_ms", ms(q.p90_ns)).with("max_ms", ms(q.max_ns))
    };
    let server = Row::new("server").with("peak_resident_mb", peak_bytes as f64 * 1e-6);
    let rows = UNTIL.into_iter().zip([first_ns, end_ns]).map(row);
    let tables: [&[_]; 2] =
        [&[("count", 0), ("p50_ms", 1), ("p90_ms", 1), ("max_ms", 1)], &[("peak_resident_mb", 1)]];
    Results::new(&tables, rows.chain([server]))
}

/// One run of two ticks, and its report.
fn launch(run: &RunName, folder: &Path) -> Result<Value, BenchError> {
    let program = std::env::current_exe().map_err(RunError::io("/proc/self/exe".as_ref()))?;
    let run = format!("{run}-start");
    let output = Command::new(&program)
        .args(["launch", "apartment", "--ticks", "2", "--json", "--quiet"])
        .args(["--force", "--run", &run, "--out"])
        .arg(folder)
        .stdin(Stdio::null())
        .output()
        .map_err(RunError::io(&program))?;
    serde_json::from_slice(&output.stdout).map_err(|_| {
        let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        BenchError::Nothing(format!("a launch ended with {}: {said}", output.status))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_ms_and_memory_in_mb() {
        let found = results(&mut [31_250_000], &mut [80_000_000], 12_340_000);
        assert_eq!(found.rows[0].name, rows()[0]);
        assert_eq!((found.rows[0].number("p50_ms"), found.rows[1].number("max_ms")), (31.25, 80.0));
        assert_eq!(found.rows[2].number("peak_resident_mb"), 12.34);
    }
}
