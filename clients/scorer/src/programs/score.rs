//! `score`: compares estimates with the truth and writes the report.

use std::path::PathBuf;

use clap::{Args, Parser};
use nalgebra::Point2;
use rusty_clients::{ClientArgs, parsed, run_recorder};
use rusty_contract::Exit;
use rusty_contract::score::{ReferenceNoise, Within};
use rusty_metrics::{Goals, Yardstick};

use crate::scorer::Scorer;

/// Score the estimators of a run or a log against the truth
///
/// The table goes to stdout. The run's folder or --out gets score.json, report.html
/// (one self-contained page), report.svg and report.png. On a log, no file is written
/// without --out; with it, the report also has the beliefs that the scorer of the run
/// saved next to the log. docs/metrics.md explains each figure.
///
/// A recording has no walls: if there is a map.yaml next to the log, as `gridmap --save`
/// writes it, or with --map, the report draws the walls of that map.
///
/// The robot is found if the errors stay within --within-m and --within-deg for --hold-s.
///
/// The true poses of a recording are estimates. With --reference-m and --reference-deg, NEES
/// compares the errors with the covariances of both.
#[derive(Parser)]
#[command(name = "score", version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    judged: JudgedBy,

    #[command(flatten)]
    to: Destinations,

    #[command(flatten)]
    drawn: Drawn,
}

#[derive(Args)]
#[command(next_help_heading = "Goals of a driver")]
struct Destinations {
    /// Goal in the world frame, m, reached in order, repeatable
    #[arg(long = "goal", value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    goals: Vec<Point2<f64>>,

    /// Distance at which a goal counts as reached, m
    #[arg(long, default_value_t = 0.25, value_name = "METRES", value_parser = positive,
        requires = "goals")]
    goal_within_m: f64,
}

#[derive(Args)]
#[command(next_help_heading = "Report")]
struct Drawn {
    /// World file or map to draw under a recording
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,

    /// Score and draw these estimators only
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,
}

#[derive(Args)]
#[command(next_help_heading = "Scoring thresholds")]
struct JudgedBy {
    /// Confidence level of the consistency tests (NEES and NIS)
    #[arg(long, default_value_t = 0.95, value_name = "0..1", value_parser = level)]
    level: f64,

    /// Standard deviation of the true positions, each axis, m: of a recording's, 0.01 to 0.05
    #[arg(long, default_value_t = 0.0, value_name = "METRES", value_parser = not_negative)]
    reference_m: f64,

    /// Standard deviation of the true headings, degrees
    #[arg(long, default_value_t = 0.0, value_name = "DEGREES", value_parser = not_negative)]
    reference_deg: f64,

    /// Position error at which the robot counts as found, m
    #[arg(long, default_value_t = 0.25, value_name = "METRES", value_parser = positive)]
    within_m: f64,

    /// Heading error at which the robot counts as found, degrees
    #[arg(long, default_value_t = 10.0, value_name = "DEGREES", value_parser = angle)]
    within_deg: f64,

    /// Time that both errors must stay within the limits, s
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
        let (std_m, std_rad) = (by.reference_m, by.reference_deg.to_radians());
        Self { level: by.level, within, reference: ReferenceNoise { std_m, std_rad } }
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

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=1e3).contains(&v), "a standard deviation from 0 to 1000")
}

fn point(text: &str) -> Result<Point2<f64>, String> {
    let number = |word: &str| word.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match text.split_once(',').map(|(x, y)| (number(x), number(y))) {
        Some((Some(x), Some(y))) => Ok(Point2::new(x, y)),
        _ => Err("give two numbers, x and y in metres: 5.4,7".to_owned()),
    }
}

fn angle(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v <= 180.0, "degrees, greater than 0 and at most 180")
}

fn duration(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a time in seconds, 0 or more")
}

pub(super) fn main() -> Exit {
    let Cli { args, judged, to, drawn } = parsed();
    let yardstick = Yardstick::from(judged);
    run_recorder(&args, |_, brief| {
        let scorer = Scorer::with(yardstick, brief, &args)?;
        let goals = Goals::new(to.goals.clone(), to.goal_within_m);
        scorer.with_goals(goals).with_map(drawn.map.as_deref())?.with_only(&drawn.only)
    })
}
