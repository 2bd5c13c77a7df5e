//! `umbmark`: calibrate wheels and wheelbase by a square in both directions.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_contract::config::check_within;
use rusty_contract::{Exit, errln, replace};
use rusty_engine::scenario_file;
use rusty_plot::png;
use rusty_study::umbmark::drawing::drawing;
use rusty_study::umbmark::{Square, umbmark as drive};

use super::arguments::{Output, check_apart, check_free, check_writable, png_file, seed, svg_file};

const AFTER_HELP: &str = "\
The robot of the scenario drives a square in both directions by its encoders only,
without walls, people and patches of floor. The true end points of the laps separate
two systematic errors:
  robot.track_bias         a wrong wheelbase changes every corner, with the same
                           sign in both directions
  robot.radius_bias_right  unequal wheels bend every side, with opposite signs in
                           the two directions
The output has E_b (true over nominal wheelbase) and E_d (right over left diameter)
with standard errors and true values, and the laps on the same seeds with the
factors applied.

E_b and E_d are estimated twice: by the first-order formulas of J. Borenstein and
L. Feng (1996), and by least squares with exact arcs. With a short wheelbase and a
long side only the second is right. A square does not show the common scale of both
wheels; E_b is the wheelbase over the mean wheel.

Slip is random: with robot.slip_std=0.02 five laps are not enough, and the standard
errors are large. Use more --runs or less slip.

Examples:
  sim-server umbmark --set robot.track_bias=0.01 --set robot.radius_bias_right=0.005
  sim-server umbmark --runs 50 --set robot.slip_std=0.005 --set robot.track_bias=0.01 --png laps.png";

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct UmbmarkArgs {
    /// Built-in (apartment, patrol, office, …) or a file
    #[arg(default_value = "apartment")]
    pub scenario: String,
    /// Number of laps in each direction, 2 or more
    #[arg(long, default_value_t = 5, value_name = "N",
        value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub runs: u32,
    /// Length of a side, m
    #[arg(long, default_value_t = 4.0, value_name = "M")]
    pub side: f64,
    /// Speed along the sides, m/s
    #[arg(long, default_value_t = 0.5, value_name = "M/S")]
    pub speed: f64,
    /// Turn rate at the corners, rad/s
    #[arg(long, default_value_t = 1.0, value_name = "RAD/S")]
    pub turn: f64,
    /// Seed of the first lap [default: the scenario's]
    #[arg(long, value_parser = seed, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Change a field, e.g. robot.track_bias=0.01
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Draw laps and end points into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    pub svg: Option<PathBuf>,
    /// Draw laps and end points into this PNG file
    #[arg(long, value_name = "FILE", value_parser = png_file)]
    pub png: Option<PathBuf>,
    /// Replace existing drawings
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(args: &UmbmarkArgs) -> Result<Exit> {
    check_within("--side", args.side, 0.01, 10_000.0)?;
    args.svg.iter().chain(&args.png).try_for_each(|path| check_free(path, args.force))?;
    args.svg.iter().chain(&args.png).try_for_each(|path| check_writable(path))?;
    let given = [("seed", "--seed", args.seed.is_some())];
    scenario_file::check_options(&args.changes, &given)?;
    let loaded = scenario_file::load(&args.scenario, &args.changes)?;
    let read = std::iter::once(PathBuf::from(&args.scenario)).chain(loaded.files());
    check_apart(&read.collect::<Vec<_>>(), args.svg.iter().chain(&args.png))?;
    let mut config = loaded.config_with(rusty_floorplan::read)?;
    let robot = &config.robot;
    let most_m_s = robot.wheel_limit_rad_s * robot.wheel_radius_m;
    check_within("--speed", args.speed, 1e-6, most_m_s)?;
    check_within("--turn", args.turn, 1e-6, 2.0 * most_m_s / robot.track_m)?;
    config.seed = args.seed.unwrap_or(config.seed);
    let square = Square { side_m: args.side, speed_m_s: args.speed, turn_rad_s: args.turn };
    let report = drive(&config, &square, args.runs)?;
    args.output.print(&report);
    let svg = drawing(&report);
    if let Some(path) = &args.svg {
        write(path, svg.as_bytes())?;
    }
    if let Some(path) = &args.png {
        write(path, &png(&svg).with_context(|| refused(path))?)?;
    }
    Ok(Exit::Done)
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, bytes).with_context(|| path.display().to_string())?;
    errln!("drawn into {}", path.display());
    Ok(())
}

fn refused(path: &Path) -> String {
    format!("cannot draw {}", path.display())
}
