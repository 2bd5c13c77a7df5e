//! `score`: compares estimates with the truth, and reports on the run.

use clap::{Args, Parser};
use rusty_clients::{ClientArgs, witness::run_witness_from};
use rusty_contract::Exit;
use rusty_contract::score::Within;
use rusty_scorer::scorer::Scorer;
use rusty_scorer::scoring::Yardstick;

/// Scores every estimator of a run or of a log against the truth: a table on
/// stdout, score.json, report.html (a page that needs nothing else), report.svg
/// and report.png in the run's folder or in --out. On a log without --out it
/// writes no file; with it, it draws the beliefs that the run's scorer left next
/// to the log. docs/metrics.md explains each figure
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    judged: JudgedBy,
}

#[derive(Args)]
#[command(next_help_heading = "What estimates are judged by")]
struct JudgedBy {
    /// Call a filter consistent whose errors (NEES) or innovations (NIS) are as
    /// large as this share of right filters' are
    #[arg(long, default_value_t = 0.95, value_name = "0..1", value_parser = level)]
    level: f64,

    /// The robot is found within this distance, m,
    #[arg(long, default_value_t = 0.25, value_name = "METRES", value_parser = positive)]
    within_m: f64,

    /// and this heading error, degrees,
    #[arg(long, default_value_t = 10.0, value_name = "DEGREES", value_parser = angle)]
    within_deg: f64,

    /// for at least this long, s
    #[arg(long, default_value_t = 1.0, value_name = "SECONDS", value_parser = duration)]
    hold_s: f64,
}

impl From<JudgedBy> for Yardstick {
    fn from(by: JudgedBy) -> Self {
        let within = Within {
            position_m: by.within_m,
            heading_rad: by.within_deg.to_radians(),
            hold_s: by.hold_s,
        };
        Self { level: by.level, within }
    }
}

fn number(text: &str, fits: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if fits(value) => Ok(value),
        _ => Err(format!("give {wanted}")),
    }
}

fn level(text: &str) -> Result<f64, String> {
    let fits = |v: f64| (0.5..=0.999_999).contains(&v);
    number(text, fits, "a probability from 0.5 to 0.999999, 0.95 for 95 %")
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v.is_finite(), "a distance in metres, greater than 0")
}

fn angle(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v <= 180.0, "degrees, greater than 0 and at most 180")
}

fn duration(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a time in seconds, 0 or more")
}

fn main() -> Exit {
    let Cli { args, judged } = Cli::parse();
    let yardstick = Yardstick::from(judged);
    run_witness_from(&args, |_, brief, args| Scorer::with(yardstick, brief, args))
}
