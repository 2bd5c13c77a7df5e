//! The document that every bench prints.

use rusty_contract::{Exit, errln, outln};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use xxhash_rust::xxh3::xxh3_64;

use super::machine::Machine;
use super::noise::{Noise, Verdict};
use super::results::Results;

/// The results of a benchmark, the machine, and its noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The benchmark: the word after `sim-server bench`.
    pub bench: String,
    /// The command that made it.
    pub command: String,
    /// The machine.
    pub machine: Machine,
    /// The noise of the machine.
    pub noise: Noise,
    /// The results.
    pub results: Results,
    /// XXH3-64 of the results as canonical JSON: keys sorted, no spaces.
    pub results_hash: String,
}

/// How a bench is to print.
#[derive(Clone, Copy, Debug, Default)]
pub struct Printing {
    /// One JSON document instead of a table.
    pub json: bool,
    /// A machine that was too noisy is no failure.
    pub accept_noise: bool,
}

impl Report {
    /// Returns the report of this process's command line on this machine.
    #[must_use]
    pub fn new(bench: &str, noise: Noise, results: Results) -> Self {
        let mut words: Vec<String> = std::env::args().collect();
        if let Some(program) = words.first_mut() {
            // The program's folder is not part of the command.
            *program = "sim-server".to_owned();
        }
        let (command, results_hash) = (words.join(" "), results_hash(&results));
        let bench = bench.to_owned();
        Self { bench, command, machine: Machine::here(), noise, results, results_hash }
    }

    /// Prints the tables, machine, noise and hash; or all of it as JSON. Returns
    /// failure if the noise is too high and was not accepted.
    pub fn finish(&self, printing: Printing) -> Exit {
        if printing.json {
            match serde_json::to_string_pretty(self) {
                Ok(text) => outln!("{text}"),
                Err(e) => errln!("sim-server: the document cannot be written: {e}"),
            }
        } else {
            outln!("{}", self.results);
            outln!("machine  {}", self.machine.line());
            outln!("noise    {}", self.noise.line());
            outln!("results  {}", self.results_hash);
        }
        if self.noise.verdict != Verdict::NotToBeBelieved {
            return Exit::Done;
        }
        errln!("not to be believed: {}", self.noise.reasons.join("; "));
        if printing.accept_noise {
            return Exit::Done;
        }
        errln!("measure again on a machine that is left alone, or take it with --accept-noise");
        Exit::Failed
    }
}

/// XXH3-64 of the canonical JSON of `results`, as 16 hexadecimal digits.
#[must_use]
pub fn results_hash(results: &impl Serialize) -> String {
    // Objects of a `Value` are sorted by key.
    let canonical = serde_json::to_value(results).unwrap_or(Value::Null);
    format!("{:016x}", xxh3_64(canonical.to_string().as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_hash_knows_numbers_and_not_their_order() {
        let a = results_hash(&json!({"p50_ns": 7, "ratio": 1.5}));
        assert_eq!(a, results_hash(&json!({"ratio": 1.5, "p50_ns": 7})));
        assert_ne!(a, results_hash(&json!({"p50_ns": 8, "ratio": 1.5})));
        assert_eq!(a.len(), 16);
    }

    #[test]
    fn what_is_not_to_be_believed_fails_unless_noise_is_accepted() {
        let noise =
            |verdict| Noise { verdict, reasons: vec!["a test".to_owned()], disturbances: None };
        let end = |verdict, accept_noise| {
            let printing = Printing { json: false, accept_noise };
            Report::new("test", noise(verdict), Results::default()).finish(printing)
        };
        assert_eq!(end(Verdict::Quiet, false), Exit::Done);
        assert_eq!(end(Verdict::Noisy, false), Exit::Done);
        assert_eq!(end(Verdict::NotToBeBelieved, false), Exit::Failed);
        assert_eq!(end(Verdict::NotToBeBelieved, true), Exit::Done);
    }
}
