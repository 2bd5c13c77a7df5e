//! Collects windows from a log, fits, and prints the result.

use clap::Args;
use nalgebra::Vector2;
use rusty_clients::recorder::{Ending, Step};
use rusty_clients::{ClientError, Recorder};
use rusty_contract::{Brief, Exit, Start, TextTable, errln, outln};

use crate::numbers::not_negative;

use super::{Alpha, Identifiability, MotionFit, Systematic, Windows, fit};

/// A log of more ticks than this says how far it has been read.
const LONG: u64 = 20_000;

/// Fit α₁ to α₄ of the odometry motion model to a log
///
/// The log must have true poses. The model (Probabilistic Robotics, section 5.4, with
/// variances proportional to the path) gives the error of odometry per metre and per
/// radian. The output has the maximum-likelihood values, their standard errors, and the
/// flags for a filter. The simulator draws its slip per tick, so the values of its logs
/// grow with speed and length of a tick. A value that the log does not determine has no
/// flag; keep the previous one. Noise of the true poses themselves is taken for noise of the
/// wheels, unless --reference-m and --reference-deg give it. A fit whose true poses contradict the odometry is refused.
///
///   fit-motion --log run.log
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(verbatim_doc_comment)]
pub struct Options {
    /// Standard deviation of the true poses, m: of a recording's, 0.01 to 0.05
    #[arg(long, value_name = "METRES", default_value_t = 0.0, value_parser = not_negative)]
    pub reference_m: f64,

    /// Standard deviation of the true headings, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, value_parser = not_negative)]
    pub reference_deg: f64,

    /// Print the log likelihood of every round
    #[arg(long, short)]
    pub verbose: bool,

    /// Print JSON, rounds included
    #[arg(long)]
    pub json: bool,
}

/// A log's motions on their way to a fit.
pub struct FitMotion {
    options: Options,
    windows: Windows,
    /// Before which ticks the robot is lifted.
    kidnapped_at: Vec<u64>,
    ticks: u64,
    with_truth: u64,
    read: u64,
}

impl FitMotion {
    /// Begins before the first tick.
    pub fn new(start: &Start, brief: &Brief, options: Options) -> Self {
        Self {
            options,
            windows: Windows::new(
                start.robot.drive,
                Vector2::new(options.reference_m, options.reference_deg.to_radians()),
            ),
            kidnapped_at: brief.header.kidnappings().map(|k| k.tick).collect(),
            ticks: start.ticks,
            with_truth: 0,
            read: 0,
        }
    }

    fn fitted(&self) -> Result<MotionFit, ClientError> {
        if self.with_truth == 0 {
            return Err(ClientError::Unusable(
                "no tick of this log has a true pose: errors of odometry are what they are beside \
                 the truth; give a log of a simulation, one with corrected poses, or the \
                 --key-file of a blind one"
                    .to_owned(),
            ));
        }
        fit(&self.windows).ok_or_else(|| {
            let left = self.windows.left;
            ClientError::Unusable(format!(
                "no motion to fit to: between {} true poses the robot stood {} times, was held {} \
                 and carried {} times; give a log in which it drives",
                self.with_truth, left.standing, left.held, left.carried
            ))
        })
    }
}

impl Recorder for FitMotion {
    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        self.read += 1;
        if self.ticks > LONG && self.read.is_multiple_of(self.ticks / 10) {
            let percent = self.read * 100 / self.ticks;
            errln!("{percent} % of {} ticks", self.ticks);
        }
        if self.kidnapped_at.contains(&step.frame.tick()) {
            self.windows.interrupt();
        }
        self.with_truth += u64::from(step.truth.is_some());
        self.windows.tick(step.frame.encoders(), step.truth);
        Ok(())
    }

    fn finish(self, ending: Ending) -> Result<Exit, ClientError> {
        let fit = self.fitted()?;
        let text = match self.options.json {
            true => serde_json::to_string_pretty(&fit).unwrap_or_default(),
            false => page(&fit, self.options.verbose),
        };
        outln!("{text}");
        match fit.problem() {
            Some(problem) => Err(ClientError::Unusable(problem)),
            None => Ok(ending.exit()),
        }
    }
}

/// What each of the four is, and what a log must have to tell it.
const OF: [(&str, &str); 4] = [
    ("heading per turn, rad²/rad", "turns on the spot"),
    ("heading per distance, rad²/m", "way straight on"),
    ("distance per distance, m²/m", "way straight on"),
    ("distance per turn, m²/rad", "turns on the spot"),
];

/// The fit for a person.
fn page(fit: &MotionFit, verbose: bool) -> String {
    let mut lines = Vec::new();
    if verbose {
        let mut table = TextTable::new(">round  >log likelihood");
        for (number, value) in fit.rounds.iter().enumerate() {
            table.row(&[&number, &format!("{value:.6}")]);
        }
        lines.push(format!("{table}\n"));
    }
    let left = fit.left;
    lines.push(format!(
        "{} motions of {:.1} ticks; left out: {} standing, {} held, {} carried; {} rounds, {}",
        fit.windows,
        fit.ticks_a_window,
        left.standing,
        left.held,
        left.carried,
        fit.rounds.len() - 1,
        if fit.converged { "converged" } else { "NOT converged" },
    ));
    let mut table = TextTable::new("parameter  value ± std. error  quantity  remark");
    for (i, (Alpha { value, std_error, told }, (what, lacks))) in
        fit.alphas.iter().zip(OF).enumerate()
    {
        let (figures, word) = match (told, std_error) {
            (Identifiability::Well, Some(e)) => (format!("{value:.3e} ± {e:.1e}"), String::new()),
            (Identifiability::Hardly, Some(e)) => {
                let word = format!("hardly told: too few {lacks} for so little");
                (format!("{value:.3e} ± {e:.1e}"), word)
            }
            _ => ("–".to_owned(), format!("not told: no {lacks}, or always together with others")),
        };
        table.row(&[&format!("alpha{}", i + 1), &figures, &what, &word]);
    }
    lines.push(table.to_string());
    let systematic = [
        ("ahead", fit.ahead_per_m, "m per m"),
        ("heading", fit.turn_per_m, "rad per m"),
        ("heading", fit.turn_per_rad, "rad per rad"),
    ];
    for (what, found, unit) in systematic {
        if let Some(Systematic { value, std_error }) = found.filter(Systematic::is_there) {
            lines.push(format!(
                "systematic: {what} is off by {value:+.2e} ± {std_error:.0e} {unit}, which the α \
                 have in them; calibrate wheels and track first"
            ));
        }
    }
    match fit.flags() {
        _ if fit.problem().is_some() => {}
        flags if flags.is_empty() => lines.push("no α is told well enough for a flag".to_owned()),
        flags => lines.push(flags),
    }
    lines.join("\n")
}
