//! `umbmark`: a square, both ways round, and what it tells of the wheels.

use std::path::Path;

use rusty_contract::config::check_within;
use rusty_contract::{Exit, errln, outln};
use rusty_plot::{PlotError, png};

use super::{Verbed, check_free, print_json};
use crate::cli::UmbmarkArgs;
use crate::error::VerbError;
use rusty_engine::scenario_file;
use rusty_study::umbmark::drawing::drawing;
use rusty_study::umbmark::{Square, umbmark as drive};

/// Drives the laps, prints what they say, and draws them if asked to.
///
/// # Errors
/// [`VerbError`] if scenario or square cannot be used, or a file not be written.
pub fn umbmark(args: &UmbmarkArgs) -> Verbed {
    check_within("--side", args.side, 0.01, 10_000.0)?;
    check_within("--speed", args.speed, 0.001, 100.0)?;
    check_within("--turn", args.turn, 0.001, 1000.0)?;
    args.svg.iter().chain(&args.png).try_for_each(|path| check_free(path, args.force))?;
    let mut config = scenario_file::load(&args.scenario, &args.changes)?.config()?;
    config.seed = args.seed.unwrap_or(config.seed);
    let square = Square { side_m: args.side, speed_m_s: args.speed, turn_rad_s: args.turn };
    let report = drive(&config, &square, args.runs)?;
    if args.json {
        print_json(&report);
    } else {
        outln!("{report}");
    }
    if args.svg.is_none() && args.png.is_none() {
        return Ok(Exit::Done);
    }
    let place = args.svg.as_deref().or(args.png.as_deref()).unwrap_or(Path::new("picture"));
    let svg = drawing(&report).map_err(refused(place))?;
    if let Some(path) = &args.svg {
        write(path, svg.as_bytes())?;
    }
    if let Some(path) = &args.png {
        write(path, &png(&svg).map_err(refused(path))?)?;
    }
    Ok(Exit::Done)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), VerbError> {
    std::fs::write(path, bytes).map_err(VerbError::io(path))?;
    errln!("drawn into {}", path.display());
    Ok(())
}

fn refused(path: &Path) -> impl FnOnce(PlotError) -> VerbError {
    let path = path.display().to_string();
    move |error| VerbError::Draw { path, why: error.to_string() }
}
