//! `bench start`: from starting `launch` to its first frame, with an
//! estimator, a scorer and a logger as processes; and what memory it takes.
//!
//! * [`section`]: the results on the page.

pub mod section;

use std::path::Path;
use std::process::{Command, Stdio};

use rusty_contract::{RunName, outln};
use rusty_link::{Domain, monotonic_ns};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::noise::NoiseMeter;
use super::quantiles::Quantiles;
use crate::error::BenchError;
use rusty_engine::run::Stop;

/// What came of it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Results {
    /// From before the process is made to its first frame.
    pub to_first_frame: Quantiles,
    /// From before the process is made to its end, for two ticks, scores and a
    /// picture.
    pub to_end: Quantiles,
    /// The most memory that was resident in any of the servers, bytes.
    pub server_peak_resident_bytes: u64,
}

/// Launches so many runs, one after the other. `None` if somebody wanted it to
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
        if stop.flag().load(std::sync::atomic::Ordering::Relaxed) {
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
    Ok(Some(Results {
        to_first_frame: Quantiles::of(&mut first),
        to_end: Quantiles::of(&mut end),
        server_peak_resident_bytes: peak,
    }))
}

/// One run of two ticks, and its report.
fn launch(run: &RunName, folder: &Path) -> Result<Value, BenchError> {
    let program = std::env::current_exe().map_err(BenchError::io("/proc/self/exe".as_ref()))?;
    let run = format!("{run}-start");
    let output = Command::new(&program)
        .args(["launch", "apartment", "--ticks", "2", "--json", "--quiet"])
        .args(["--force", "--run", &run, "--out"])
        .arg(folder)
        .stdin(Stdio::null())
        .output()
        .map_err(BenchError::io(&program))?;
    serde_json::from_slice(&output.stdout).map_err(|_| {
        let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        BenchError::Nothing(format!("a launch ended with {}: {said}", output.status))
    })
}

/// Prints the results.
pub fn print(results: &Results) {
    let ms = |ns: u64| ns as f64 * 1e-6;
    for (what, q) in
        [("to the first frame", results.to_first_frame), ("to the end", results.to_end)]
    {
        outln!(
            "{what:20} p50 {:7.1} ms, p90 {:7.1} ms, max {:7.1} ms ({} launches)",
            ms(q.p50_ns),
            ms(q.p90_ns),
            ms(q.max_ns),
            q.count
        );
    }
    let peak = results.server_peak_resident_bytes as f64 * 1e-6;
    outln!("{:20} {peak:.1} MB at most", "server resident");
}
