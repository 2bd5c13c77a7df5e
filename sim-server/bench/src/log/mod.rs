//! `bench log`: how fast a run is written down, beside what its folder takes.
//!
//! `logger measure` does the work, in a process of its own as in a run: the same
//! records as the logger writes them, as a plain file of the same length, and
//! encoded to nowhere. Each repetition is a process; between them the machine is
//! looked at.
//!
//! * [`section`]: the results on the page.

pub mod section;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use rusty_contract::{errln, outln};
use serde::{Deserialize, Serialize};

use super::noise::NoiseMeter;
use super::quantiles::Spread;
use crate::error::BenchError;
use rusty_engine::run::find_program;

/// Numbers of beams that are measured if nobody asks for others; 0: no scan.
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

/// What came of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Results {
    /// Records.
    pub ticks: u64,
    /// Whether the disk had to have them.
    pub synced: bool,
    /// One for each number of beams.
    pub rows: Vec<Row>,
}

/// What came of one number of beams. Rates in MB (10⁶ bytes) a second.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Beams in each record; 0: no scan.
    pub beams: usize,
    /// Length of a record, bytes, on average.
    pub bytes_per_tick: f64,
    /// As the logger writes.
    pub log_mb_s: Spread,
    /// The same bytes as a plain file.
    pub plain_mb_s: Spread,
    /// The first of these divided by the second, in each repetition.
    pub log_over_plain: Spread,
    /// Encoding alone.
    pub encode_mb_s: Spread,
    /// The same for one record, ns.
    pub encode_ns_per_tick: Spread,
    /// Run digest over the records, which were read again.
    pub digest: String,
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
        let rows = rows.collect::<Result<_, _>>()?;
        Ok(Results { ticks: self.ticks, synced: self.sync, rows })
    }

    fn row(&self, logger: &Path, beams: usize, meter: &mut NoiseMeter) -> Result<Row, BenchError> {
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
        Ok(Row {
            beams,
            bytes_per_tick: last.bytes_per_tick,
            log_mb_s: spread(|m| m.log_mb_s),
            plain_mb_s: spread(|m| m.plain_mb_s),
            log_over_plain: spread(|m| m.log_per_plain),
            encode_mb_s: spread(|m| m.encode_mb_s),
            encode_ns_per_tick: spread(|m| m.encode_ns_per_tick),
            digest: last.digest.clone(),
        })
    }

    fn once(&self, logger: &Path, beams: usize) -> Result<Measured, BenchError> {
        let mut command = Command::new(logger);
        command.arg("measure").arg(&self.folder).args(["--rounds", "1", "--json"]);
        command.args(["--ticks", &self.ticks.to_string(), "--beams", &beams.to_string()]);
        if self.sync {
            command.arg("--sync");
        }
        let out = command.stdin(Stdio::null()).output().map_err(BenchError::io(logger))?;
        if !out.status.success() {
            let said = String::from_utf8_lossy(&out.stderr);
            return Err(BenchError::Nothing(said.trim().to_owned()));
        }
        serde_json::from_slice(&out.stdout).map_err(|e| {
            let logger = logger.display();
            BenchError::Nothing(format!(
                "{logger} printed no measurement ({e}); is it this version's?"
            ))
        })
    }
}

/// Prints the results.
pub fn print(results: &Results) {
    let whose = if results.synced { "the disk has them" } else { "the system has them" };
    outln!("{} ticks, until {whose}; medians (least to greatest)", results.ticks);
    let spread = |s: Spread| format!("{:.0} ({:.0} to {:.0})", s.median, s.min, s.max);
    for row in &results.rows {
        outln!("\n{} beams, {:.1} bytes a tick", row.beams, row.bytes_per_tick);
        outln!("  log       {} MB/s", spread(row.log_mb_s));
        outln!("  plain     {} MB/s", spread(row.plain_mb_s));
        let s = row.log_over_plain;
        outln!("  log/plain {:.2} ({:.2} to {:.2})", s.median, s.min, s.max);
        outln!("  encoding  {} MB/s", spread(row.encode_mb_s));
        outln!("            {} ns a tick", spread(row.encode_ns_per_tick));
        outln!("  digest    {}", row.digest);
    }
}
