//! Collects readings from a log, fits, and prints the result.

use std::path::PathBuf;

use clap::Args;
use rusty_clients::recorder::{Ending, Step};
use rusty_clients::{ClientError, Recorder};
use rusty_contract::data_sheet::LidarSheet;
use rusty_contract::{Brief, Exit, LidarConfig, Start, TextTable, errln, outln};
use rusty_geometry::{Scan, World};

use super::{BeamFit, Criterion, Expected, Fitted, Readings, Round, fit};
use crate::beams::believed_lidar;
use crate::mcl::LEAST_HIT;
use crate::numbers::number;
use crate::{BeamModel, Beams, OccupancyMap};

/// A log of more ticks than this says how far it has been read.
const LONG: u64 = 20_000;

/// Where readings are farther from the walls than this, m, or more of them than this share are
/// random, the map may be a wrong one. People make them short.
const FAR_M: f64 = 0.5;
const MANY: f64 = 0.3;
/// Greater figures are written as powers of ten.
const MOST: f64 = 1e6;

/// Fit the four-part beam model to the readings of a log
///
/// A reading hits a wall of the map (hit), hits something nearer that the map does
/// not have (short), hits nothing (max), or has another cause (rand). The true poses
/// of the log and the map give the expected reading. Expectation maximisation
/// (Probabilistic Robotics, Table 6.2) estimates the shares of the four parts, the
/// spread of hit and the rate of short, each with its standard error. In a world
/// without people and chair legs the share of short is zero.
///
///   fit-beam --log run.log
///   fit-beam --log intel.log --map intel.yaml --json
#[derive(Args, Clone, Debug, PartialEq)]
#[command(verbatim_doc_comment)]
pub struct Options {
    /// Map of a map_server pair [default: the log's floor plan]
    #[arg(long, value_name = "YAML")]
    pub map: Option<PathBuf>,

    /// Minimum rise of the mean log likelihood in a round
    #[arg(long, value_name = "X", default_value_t = Criterion::default().tolerance, value_parser = tolerance)]
    pub tolerance: f64,

    /// Maximum number of rounds
    #[arg(long, value_name = "N", default_value_t = Criterion::default().rounds, value_parser = rounds)]
    pub rounds: usize,

    /// Print every round
    #[arg(long, short)]
    pub verbose: bool,

    /// Print JSON, rounds included
    #[arg(long)]
    pub json: bool,
}

crate::numbers::default_of_command_line!(Options);

fn tolerance(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a number, 0 or more")
}

fn rounds(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(value) if (1..=1_000_000).contains(&value) => Ok(value),
        _ => Err("give a whole number from 1 to 1000000".to_owned()),
    }
}

/// A log's readings on their way to a fit.
pub struct FitBeam {
    options: Options,
    lidar: LidarConfig,
    sheet: LidarSheet,
    beams: Beams,
    expected: Expected,
    readings: Readings,
    scans: u64,
    scans_without_truth: u64,
    ticks: u64,
    read: u64,
}

impl FitBeam {
    /// Begins with the log's floor plan or a map of cells.
    ///
    /// # Errors
    /// There is no map, or none that can be read.
    pub fn new(start: &Start, brief: &Brief, options: Options) -> Result<Self, ClientError> {
        let lidar = believed_lidar(start);
        let beams = Beams::new(&lidar);
        let expected = match &options.map {
            Some(yaml) => Expected::Cells(OccupancyMap::load(yaml)?),
            None => plan(brief, &lidar)?,
        };
        let readings = Readings { range_max_m: lidar.range_max_m, all: Vec::new() };
        Ok(Self {
            options,
            lidar,
            sheet: start.lidar,
            beams,
            expected,
            readings,
            scans: 0,
            scans_without_truth: 0,
            ticks: start.ticks,
            read: 0,
        })
    }

    fn fitted(&self) -> Result<BeamFit, ClientError> {
        let Options { tolerance, rounds, .. } = self.options;
        let guess = BeamModel::of_lidar(&self.lidar);
        fit(&self.readings, guess, Criterion { tolerance, rounds }).ok_or_else(|| {
            let (scans, without) = (self.scans, self.scans_without_truth);
            ClientError::Unusable(format!(
                "no reading to fit to: {scans} scans had a true pose and {without} had none; give \
                 a log with scans and truth (with --key-file, if it is blind), and a map of where \
                 they were taken"
            ))
        })
    }
}

/// The floor plan of the run.
fn plan(brief: &Brief, lidar: &LidarConfig) -> Result<Expected, ClientError> {
    let unusable = |why: String| {
        let remedy = "give a map with --map, or the --key-file of a blind log";
        ClientError::Unusable(format!("the log's floor plan cannot be used: {why}; {remedy}"))
    };
    let header = &brief.header;
    let is_recording = header.is_recording() && !header.is_blind();
    let why = if is_recording { "a recording has no walls" } else { "it is hidden" };
    let spec = header.known_world().ok_or_else(|| unusable(why.to_owned()))?;
    let world = World::new(spec.clone()).map_err(|e| unusable(e.to_string()))?;
    if world.is_open() {
        return Err(unusable("it has no walls".to_owned()));
    }
    let scan = Box::new(Scan::new(lidar.fan()));
    let distances_m = vec![0.0; lidar.beams as usize];
    Ok(Expected::Plan { world: Box::new(world), scan, distances_m })
}

impl Recorder for FitBeam {
    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        self.read += 1;
        if self.ticks > LONG && self.read.is_multiple_of(self.ticks / 10) {
            let percent = self.read * 100 / self.ticks;
            errln!("{percent} % of {} ticks", self.ticks);
        }
        let Some(ranges_m) = step.frame.ranges_m() else { return Ok(()) };
        match step.truth {
            Some(pose) => {
                self.scans += 1;
                self.expected.add(&mut self.readings, &pose, ranges_m, &self.beams);
            }
            None => self.scans_without_truth += 1,
        }
        Ok(())
    }

    fn finish(self, ending: Ending) -> Result<Exit, ClientError> {
        let fit = self.fitted()?;
        let text = match self.options.json {
            true => serde_json::to_string_pretty(&fit).unwrap_or_default(),
            false => page(&fit, &self.sheet, self.scans, self.options.verbose),
        };
        outln!("{text}");
        let (sigma_m, z_rand) = (fit.sigma_hit_m.value, fit.z_rand.value);
        if sigma_m > FAR_M || z_rand > MANY {
            errln!("z_rand {z_rand:.2}, σ_hit {sigma_m:.2} m: is this the right map?");
        }
        Ok(ending.exit())
    }
}

/// The fit for a person.
fn page(fit: &BeamFit, sheet: &LidarSheet, scans: u64, verbose: bool) -> String {
    let mut lines = Vec::new();
    if verbose {
        lines.push(format!("{}\n", table_of(&fit.rounds)));
    }
    let ended = if fit.converged { "converged" } else { "NOT converged: give more --rounds" };
    lines.push(format!(
        "{} readings of {scans} scans, {} rounds, {ended}",
        fit.readings,
        fit.rounds.len() - 1
    ));
    let mut table = TextTable::new("parameter  >value  >std. error  >data sheet");
    let sheet = [None, None, sheet.dropout, None, sheet.range_std_m, None];
    let rows = [
        ("z_hit", fit.z_hit),
        ("z_short", fit.z_short),
        ("z_max", fit.z_max),
        ("z_rand", fit.z_rand),
        ("σ_hit", fit.sigma_hit_m),
        ("λ_short", fit.lambda_short_per_m),
    ];
    for ((name, Fitted { value, std_error }), sheet) in rows.into_iter().zip(sheet) {
        let figure = |v: Option<f64>| match v {
            Some(v) if v < MOST => format!("{v:.6}"),
            Some(v) => format!("{v:.1e}"),
            None => "–".to_owned(),
        };
        // What no reading depends on has no value either.
        let value = std_error.map(|_| value);
        table.row(&[&name, &figure(value), &figure(std_error), &figure(sheet)]);
    }
    lines.push(table.to_string());
    // As above: no reading says what it is.
    let sigma = fit.sigma_hit_m.std_error.map_or_else(String::new, |_| {
        // The least that `mcl` takes.
        format!(" --sigma-m {:.4}", fit.sigma_hit_m.value.max(0.001))
    });
    lines.push(match fit.z_hit.value < LEAST_HIT {
        true => "no options for mcl: almost no reading hits a wall of the map".to_owned(),
        false => format!(
            "for mcl:{sigma} --z-short {:.4} --z-max {:.4} --z-rand {:.4}",
            fit.z_short.value, fit.z_max.value, fit.z_rand.value
        ),
    });
    lines.join("\n")
}

/// Returns the rounds as a table.
fn table_of(rounds: &[Round]) -> TextTable {
    let heads = ">round  >log likelihood  >hit  >short  >max  >rand  >sigma m  >lambda 1/m";
    let mut table = TextTable::new(heads);
    for (number, round) in rounds.iter().enumerate() {
        let mut cells = vec![number.to_string(), format!("{:.9}", round.log_likelihood)];
        let sigma_and_lambda = [round.sigma_hit_m, round.lambda_short_per_m];
        let figures = round.weights.iter().chain(&sigma_and_lambda);
        cells.extend(figures.map(|figure| format!("{figure:.6}")));
        table.push(cells);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    #[test]
    fn nonsense_is_refused() {
        for nonsense in
            ["--tolerance=nan", "--tolerance=-1", "--tolerance=inf", "--rounds=0", "--rounds=-1"]
        {
            assert!(Line::try_parse_from(["fit-beam", nonsense]).is_err(), "{nonsense}");
        }
    }
}
