//! `bench log`: how fast a run is written down, compared with what its folder takes.
//!
//! `logger measure` does the work, in a separate process as in a run: the same
//! records as the logger writes them, as a plain file of the same length, and
//! encoded to nowhere. Each repetition is a process; between them the machine is
//! looked at.

use std::path::PathBuf;
use std::process::Stdio;

use rusty_contract::errln;
use serde::Deserialize;

use super::noise::NoiseMeter;
use super::quantiles::Spread;
use super::results::{Results, Row};
use crate::error::BenchError;
use rusty_engine::executable::Executable;
use rusty_engine::run::{RunError, find_program};

/// Numbers of beams that are measured by default; 0: no scan.
pub const BEAMS: [usize; 3] = [0, 180, 1080];

/// What to measure.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Where to write.
    pub folder: PathBuf,
    /// Records.
    pub ticks: u64,
    /// Numbers of beams in each of them.
    pub beams: Vec<usize>,
    /// Whether the disk has to have them.
    pub sync: bool,
    /// How often.
    pub repeat: usize,
    /// Shows no progress.
    pub quiet: bool,
}

/// Returns the names of the rows.
#[must_use]
pub fn rows() -> Vec<String> {
    BEAMS.iter().map(|&beams| label(beams)).collect()
}

fn label(beams: usize) -> String {
    if beams == 0 { "no scan".to_owned() } else { format!("{beams} beams") }
}

/// What `logger measure --json` prints.
#[derive(Deserialize)]
struct Measured {
    bytes_per_tick: f64,
    log_mb_s: f64,
    plain_mb_s: f64,
    log_per_plain: f64,
    encode_mb_s: f64,
    encode_ns_per_tick: f64,
    digest: String,
}

impl Plan {
    /// Measures.
    ///
    /// # Errors
    /// [`BenchError`] if there is no logger, or it cannot measure.
    pub fn measure(&self, meter: &mut NoiseMeter) -> Result<Results, BenchError> {
        let logger = find_program("logger", "logger")?;
        let rows = self.beams.iter().map(|&beams| self.row(&logger, beams, meter));
        let rows = rows.collect::<Result<Vec<Row>, _>>()?;
        let tables: [&[_]; 2] = [
            &[
                ("bytes_per_tick", 1),
                ("log_mb_s", 0),
                ("plain_mb_s", 0),
                ("log_over_plain", 2),
                ("encode_mb_s", 0),
                ("encode_ns_per_tick", 0),
            ],
            &[("digest", 0)],
        ];
        Ok(Results::new(&tables, rows).fact("ticks", self.ticks).fact("synced", self.sync))
    }

    fn row(
        &self,
        logger: &Executable,
        beams: usize,
        meter: &mut NoiseMeter,
    ) -> Result<Row, BenchError> {
        let mut all = Vec::new();
        for round in 1..=self.repeat {
            if !self.quiet {
                errln!("{beams} beams, {round} of {}", self.repeat);
            }
            all.push(self.once(logger, beams)?);
            meter.look();
        }
        let Some(last) = all.last() else {
            return Err(BenchError::Nothing("--repeat is 0".to_owned()));
        };
        if let Some(other) = all.iter().find(|m| m.digest != last.digest) {
            let text = format!("one log has the digest {}, one {}", other.digest, last.digest);
            return Err(BenchError::Nothing(text));
        }
        let spread = |value: fn(&Measured) -> f64| Spread::of(all.iter().map(value));
        Ok(Row::new(label(beams))
            .with("beams", beams)
            .with("bytes_per_tick", last.bytes_per_tick)
            .with("log_mb_s", spread(|m| m.log_mb_s))
            .with("plain_mb_s", spread(|m| m.plain_mb_s))
            .with("log_over_plain", spread(|m| m.log_per_plain))
            .with("encode_mb_s", spread(|m| m.encode_mb_s))
            .with("encode_ns_per_tick", spread(|m| m.encode_ns_per_tick))
            .with("digest", last.digest.clone()))
    }

    fn once(&self, logger: &Executable, beams: usize) -> Result<Measured, BenchError> {
        let mut command = logger.command();
        command.arg("measure").arg(&self.folder).args(["--rounds", "1", "--json"]);
        command.args(["--ticks", &self.ticks.to_string(), "--beams", &beams.to_string()]);
        if self.sync {
            command.arg("--sync");
        }
        let out = command
            .stdin(Stdio::null())
            .output()
            .map_err(RunError::io(logger.to_string().as_ref()))?;
        if !out.status.success() {
            let said = String::from_utf8_lossy(&out.stderr);
            return Err(BenchError::Nothing(said.trim().to_owned()));
        }
        serde_json::from_slice(&out.stdout).map_err(|e| {
            BenchError::Nothing(format!(
                "{logger} printed no measurement ({e}); is it this version's?"
            ))
        })
    }
}
