//! Arguments that several commands share, and the output that they select.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use clap::Args;
use rusty_contract::output::same_file;
use rusty_contract::replacement::Replacement;
use rusty_contract::suggest::did_you_mean;
use rusty_contract::{
    DataSheet, FieldError, Participant, RunName, Sandbox, Scenario, errln, outln,
};
use rusty_engine::run::Pace;
use rusty_engine::scenario_file::{self, SetupError};
use rusty_link::WaitPolicy;
use serde::Serialize;

use super::WrongUsage;

/// The form of the results.
#[derive(Args, Clone, Copy, Debug)]
pub struct Output {
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

impl Output {
    /// Prints a document in the form that was chosen.
    pub fn print<T: Serialize + std::fmt::Display>(self, document: &T) {
        self.print_with(document, || outln!("{document}"));
    }

    /// Prints a document that has its text printed by `text`.
    pub fn print_with(self, document: &impl Serialize, text: impl FnOnce()) {
        if !self.json {
            return text();
        }
        match serde_json::to_string_pretty(document) {
            Ok(json) => outln!("{json}"),
            // Every document consists of numbers, text and lists.
            Err(e) => errln!("sim-server: the document cannot be written: {e}"),
        }
    }
}

/// Options of every run.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
`{out}` in the COMMAND of --add is the run's folder, and quotes keep spaces in a word.
`control RUN step` or `resume` continues a paused run. Waiting by `spin` occupies one
core per process. --watch prints the address of a page, which stays after the run until
it is closed or Ctrl-C; `view --help` has more.")]
pub struct RunArgs {
    /// Name of the run [default: the scenario's and a random suffix]
    #[arg(long, value_name = "NAME")]
    pub run: Option<RunName>,
    /// Folder for log, scores and report [default: runs/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the whole folder of a run that has ended
    #[arg(long)]
    pub force: bool,
    /// Simulated speed, max, real or a factor such as 2.5
    /// [default: max, with --watch real]
    #[arg(long, value_name = "P")]
    pub pace: Option<Pace>,
    /// Show the run in a browser
    #[arg(long)]
    pub watch: bool,
    /// With --watch, let apps of this site connect
    #[arg(long, value_name = "ORIGIN", requires = "watch")]
    pub allow_origin: Vec<String>,
    /// Begin paused
    #[arg(long)]
    pub paused: bool,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Time limit of an answer, s [default: the scenario's]
    #[arg(long, value_name = "SECONDS")]
    pub answer_timeout: Option<f64>,
    /// Time limit of joining, s [default: the scenario's]
    #[arg(long, value_name = "SECONDS")]
    pub join_timeout: Option<f64>,
    /// Add an estimator, and start it if COMMAND is given (not with serve)
    #[arg(long, value_name = "NAME[=COMMAND]")]
    pub add: Vec<String>,
    /// Confine started participants that hold no key to the truth
    /// [default: the scenario's] [possible values: none, if-possible, required]
    #[arg(long, value_name = "HOW")]
    pub sandbox: Option<Sandbox>,
    /// Tell estimators and drivers these figures of their sensors
    /// [default: the scenario's] [possible values: given, nominal, hidden]
    #[arg(long, value_name = "WHICH")]
    pub data_sheet: Option<DataSheet>,
    /// Write the scores without a report and pictures
    #[arg(long)]
    pub no_report: bool,
    /// Leave a participant out
    #[arg(long, value_name = "NAME")]
    pub without: Vec<String>,
    #[command(flatten)]
    pub output: Output,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

/// The scenario and the changes to it.
#[derive(Args, Clone, Debug)]
pub struct ScenarioArgs {
    /// Built-in (apartment, patrol, office, …) or a file
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Seed of all noise, a number or random [default: the scenario's]
    #[arg(long, value_parser = seed_or_random, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Change a field, e.g. robot.slip_std=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
}

impl RunArgs {
    /// Applies `--add`, `--without`, `--sandbox` and `--data-sheet`.
    pub fn change_roster(&self, roster: &mut Vec<Participant>) -> Result<()> {
        for name in &self.without {
            let before = roster.len();
            roster.retain(|p| p.name != *name);
            if roster.len() == before {
                let names: Vec<&str> = roster.iter().map(|p| p.name.as_str()).collect();
                let hint = did_you_mean(name, names.iter().copied());
                let remedy = format!("use one of: {}{hint}", names.join(", "));
                bail!(FieldError::new("--without", name, "is not there", remedy));
            }
        }
        for text in &self.add {
            scenario_file::add_estimator(roster, "--add", text)?;
        }
        for participant in roster.iter_mut().filter(|p| !p.role.holds_key()) {
            participant.sandbox = self.sandbox.unwrap_or(participant.sandbox);
            participant.data_sheet = self.data_sheet.unwrap_or(participant.data_sheet);
        }
        let robots: BTreeSet<Option<&str>> = roster.iter().map(|p| p.robot.as_deref()).collect();
        for robot in robots {
            let its = roster.iter().filter(|p| p.takes_part_for(robot)).cloned();
            Scenario::check_roster(&its.collect::<Vec<_>>()).map_err(|error| {
                let path = "participants".to_owned();
                SetupError::Scenario { path, error }
            })?;
        }
        Ok(())
    }
}

/// The path of a drawing, whose name promises no other format.
pub fn svg_file(text: &str) -> Result<PathBuf, String> {
    drawing(text, "svg")
}

/// The path of a picture, whose name promises no other format.
pub fn png_file(text: &str) -> Result<PathBuf, String> {
    drawing(text, "png")
}

fn drawing(text: &str, format: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(other) if !other.eq_ignore_ascii_case(format) => {
            let name = path.with_extension(format);
            Err(format!("this option writes {format}; give e.g. {}", name.display()))
        }
        _ => Ok(path),
    }
}

/// Refuses to replace a file without `--force`. Devices are written to, not
/// replaced.
pub fn check_free(path: &Path, force: bool) -> Result<()> {
    if !force && std::fs::metadata(path).is_ok_and(|found| found.is_file()) {
        let path = path.display();
        bail!(WrongUsage(format!(
            "{path} is there already; give another path, or replace it with --force"
        )));
    }
    Ok(())
}

/// Refuses to write over files that the command reads, alone or in a folder, or one file
/// twice.
pub fn check_apart<'p>(
    read: impl IntoIterator<Item = &'p PathBuf>,
    written: impl IntoIterator<Item = &'p PathBuf>,
) -> Result<()> {
    let mut others: Vec<&PathBuf> = read.into_iter().collect();
    for path in written {
        let is_in = |folder: &Path| {
            folder.is_dir()
                && matches!((folder.canonicalize(), path.canonicalize()),
                    (Ok(folder), Ok(path)) if path.starts_with(&folder))
        };
        if others.iter().any(|other| *other == path || same_file(other, path) || is_in(other)) {
            let path = path.display();
            let text = format!("{path} is read or written by this command already");
            bail!(WrongUsage(format!("{text}; give another path")));
        }
        others.push(path);
    }
    Ok(())
}

/// Refuses a file that cannot be written, before the work that makes it: its folder is not
/// there, or nothing can be made in it.
pub fn check_writable(path: &Path) -> Result<()> {
    let made = Replacement::of(path).map(drop);
    made.with_context(|| path.display().to_string())
}

/// Reads a seed.
pub fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("a seed is a whole number from 0 to {}", u64::MAX))
}

/// Reads a seed, or draws one from the operating system for `random`.
pub fn seed_or_random(text: &str) -> Result<u64, String> {
    if text == "random" {
        return getrandom::u64().map_err(|e| format!("no random numbers: {e}; give a number"));
    }
    seed(text).map_err(|e| format!("{e}, or random"))
}

#[cfg(test)]
mod tests {
    use crate::commands::Cli;
    use clap::Parser as _;

    #[test]
    fn a_seed_out_of_range_is_refused_with_the_range() {
        for verb in ["launch", "umbmark", "fork x --at 1"] {
            let parse = |seed: &str| {
                let words = ["sim-server"].into_iter().chain(verb.split(' '));
                Cli::try_parse_from(words.chain(["--seed", seed]))
            };
            assert!(parse("18446744073709551615").is_ok());
            for seed in ["-1", "1.5", "18446744073709551616"] {
                let error = parse(seed).err().unwrap().to_string();
                assert!(error.contains("--seed") && error.contains(seed), "{error}");
                assert!(error.contains("from 0 to 18446744073709551615"), "{error}");
            }
        }
    }

    #[test]
    fn a_drawing_has_no_name_of_another_format() {
        let path = |text: &str| super::svg_file(text).map(|path| path.display().to_string());
        for text in ["a.svg", "a.SVG", "a", "/dev/stdout", "b.c/a.svg"] {
            assert_eq!(path(text).unwrap(), text);
        }
        assert!(path("b.c/a.png").unwrap_err().contains("b.c/a.svg"));
        assert!(super::png_file("a.svg").is_err() && super::png_file("a.png").is_ok());
    }

    #[test]
    fn random_seeds_of_runs_use_64_bits_and_differ() {
        let drawn: Vec<u64> = (0..64).map(|_| super::seed_or_random("random").unwrap()).collect();
        let set = drawn.iter().fold((0, u64::MAX), |(or, and), seed| (or | seed, and & seed));
        // Each bit was once 1 and once 0, but for one case in 2^57.
        assert_eq!(set, (u64::MAX, 0), "{drawn:x?}");
        for (verb, taken) in
            [("launch", true), ("serve", true), ("fork x --at 1", true), ("umbmark", false)]
        {
            let words = ["sim-server"].into_iter().chain(verb.split(' '));
            let parsed = Cli::try_parse_from(words.chain(["--seed", "random"]));
            assert_eq!(parsed.is_ok(), taken, "{verb}");
        }
    }
}
