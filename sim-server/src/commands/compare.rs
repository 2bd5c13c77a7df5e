//! `compare`: compare two estimators seed by seed.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_contract::{Exit, FieldError, errln, replace};
use rusty_study::versus::contest::versus;
use rusty_study::versus::drawing::drawing;
use rusty_study::versus::{Contents, Metric, sides};

use super::arguments::{Output, check_apart, check_free, svg_file};

const AFTER_HELP: &str = "\
A row of a sweep is a run of an estimator. Runs of one seed have the same noise, so
the estimators are compared seed by seed. The output has
  the mean difference with Student's t interval,
  the number of seeds that each wins (exact sign test, ties omitted),
  the factor by which an unpaired comparison would need more runs.
If fields were swept, each setting is compared separately, because runs of one seed
in two settings are not independent. Less is better in every metric.

Two tables must have the same world, robot and settings, and each pair of runs the
same true path, to the bit. Otherwise they did not drive the same runs.

Examples:
  sim-server sweep apartment --seeds 0..100 --clients --out t.csv
  sim-server compare t.csv --a dead-reckoning --b my-filter
  sim-server compare t.csv --a dead-reckoning --b my-filter --svg compared.svg
  sim-server compare before.csv after.csv --a my-filter --metric ate --metric nees";

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct CompareArgs {
    /// Table written by `sweep --out`
    pub table: PathBuf,
    /// Second table, for B
    pub other: Option<PathBuf>,
    /// First estimator [default: the only one in the table]
    #[arg(long, value_name = "NAME")]
    pub a: Option<String>,
    /// Second estimator
    #[arg(long, value_name = "NAME")]
    pub b: Option<String>,
    /// Metric to compare; may be repeated [default: all that the
    /// tables have of ate, final, heading, p95, rpe-metre, nees]
    #[arg(long = "metric", value_name = "METRIC", value_enum, hide_possible_values = false)]
    pub metrics: Vec<Metric>,
    /// Confidence level of the intervals
    #[arg(long, default_value_t = 0.95, value_name = "P")]
    pub level: f64,
    /// Draw the differences and both distributions into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    pub svg: Option<PathBuf>,
    /// Replace an existing drawing
    #[arg(long, requires = "svg")]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(args: &CompareArgs) -> Result<Exit> {
    let level = args.level;
    if !(level > 0.0 && level < 1.0) {
        let (problem, remedy) = ("is no probability between 0 and 1", "give --level 0.95");
        return Err(FieldError::new("--level", level, problem, remedy).into());
    }
    args.svg.as_ref().map_or(Ok(()), |path| check_free(path, args.force))?;
    check_apart(std::iter::once(&args.table).chain(&args.other), &args.svg)?;
    let table = Contents::read(&args.table)?;
    let other = args.other.as_deref().map(Contents::read).transpose()?;
    let names = [args.a.as_deref(), args.b.as_deref()];
    let sides = sides(&table, other.as_ref(), names)?;
    let asked = !args.metrics.is_empty();
    let metrics = if asked { &args.metrics[..] } else { &Metric::USUAL[..] };
    let found = versus(sides, metrics, asked, level)?;
    args.output.print(&found);
    if let Some(path) = &args.svg {
        replace(path, drawing(&found).as_bytes()).with_context(|| path.display().to_string())?;
        errln!("drawn into {}", path.display());
    }
    Ok(Exit::Done)
}
