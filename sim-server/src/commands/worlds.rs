//! `worlds`: list, draw, scan or check worlds.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_contract::{Exit, FieldError, errln, outln, replace};
use rusty_floorplan::check::check;
use rusty_floorplan::map_server::RosMap;
use rusty_floorplan::trace::{TOLERANCE_CELLS, Traced};
use rusty_floorplan::{FloorplanError, TracedMap, map_of, read_unchecked};
use rusty_geometry::WorldSpec;
use rusty_geometry::places::{PLACES, place};
use serde_json::json;

use super::arguments::{Output, check_apart, check_free, svg_file};
use drawing::drawing;
use scan::Scan;

mod drawing;
mod scan;

const AFTER_HELP: &str = "\
A world file is a floor plan (TOML, or JSON with the ending .json), a map of ROS (the
YAML page, .yaml or .yml, of a PGM or PNG picture) or a drawing (.svg). `worlds FILE
--json` converts each of them to JSON.

--check names gaps, walls that cover each other, openings through which the floor is
open to the outside, and loose ends. It exits with 1 unless there are loose ends only.

A cliff of a scan is a beam whose range differs from that of the beam before it by more
than half a metre: there, one surface ends in front of another.

Examples:
  sim-server worlds apartment --scan 4.9,2.84,1.5707963267948966 --noise --svg scan.svg
  sim-server worlds map.yaml --svg map.svg       walls over the cells of a map
  sim-server worlds plan.svg --check             check a drawing
  sim-server worlds plan.svg --json > plan.json  convert a drawing";

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct WorldsArgs {
    /// Built-in world or world file
    pub name: Option<String>,
    /// Check the floor plan
    #[arg(long, requires = "name", conflicts_with_all = ["scan", "svg"])]
    pub check: bool,
    /// Point on the floor to check, in m [default: inside the walls]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires = "check")]
    pub start: Option<String>,
    /// Scan from this sensor pose, in m, m, rad; with --svg, draw the beams and a
    /// strip of range over beam
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, requires = "name")]
    pub scan: Option<String>,
    /// Add noise with this standard deviation to the scan, m [default: 0.02]
    #[arg(long, value_name = "STD", num_args = 0..=1, default_missing_value = "0.02")]
    #[arg(requires = "scan")]
    pub noise: Option<f64>,
    /// Probability that a beam of the scan returns nothing
    #[arg(long, value_name = "P", requires = "scan", default_value_t = 0.0)]
    pub dropout: f64,
    /// Seed of noise and dropout: those of the first tick of a run with this seed
    #[arg(long, value_name = "N", requires = "scan", default_value_t = 42)]
    pub seed: u64,
    /// Number of beams of the scan over the full circle
    #[arg(long, requires = "scan", default_value_t = 180)]
    pub beams: u32,
    /// Longest range of the scan, m
    #[arg(long, requires = "scan", default_value_t = 8.0)]
    pub range_max: f64,
    /// Draw the world into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file, requires = "name")]
    pub svg: Option<PathBuf>,
    /// Replace an existing drawing
    #[arg(long, requires = "svg")]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(args: &WorldsArgs) -> Result<Exit> {
    let Some(name) = &args.name else { return list(args) };
    let path = Path::new(name);
    let built_in = place(name);
    let file = built_in.is_none().then(|| path.to_owned());
    let map = if built_in.is_some() { None } else { map_of(path)? };
    let spec = match (built_in, &map) {
        (Some(place), _) => place.spec().clone(),
        (None, Some(map)) => map.traced.world.clone(),
        (None, None) => read_unchecked(path)?,
    };
    let unusable = |error| FloorplanError::World { path: name.clone(), error };
    if args.check {
        let start = args.start.as_ref().map(|text| numbers("--start", text)).transpose()?;
        let report = check(&spec, start).map_err(unusable)?;
        args.output.print(&report);
        return Ok(if report.problems() == 0 { Exit::Done } else { Exit::Failed });
    }
    spec.check().map_err(unusable)?;
    let scan = args.scan.as_ref().map(|pose| Scan::take(args, &spec, pose));
    let scan = scan.transpose()?;
    if let Some(path) = &args.svg {
        check_free(path, args.force)?;
        check_apart(&file, [path])?;
        let map = map.as_ref();
        replace(path, drawing(&spec, map.map(|map| &map.map), scan.as_ref()).as_bytes())
            .with_context(|| path.display().to_string())?;
        if let Some(TracedMap { map, traced }) = map {
            errln!("{}", description(map, traced));
        }
        errln!("drawn into {}", path.display());
    }
    if let Some(scan) = scan {
        scan.print(&args.output);
    } else if args.output.json || args.svg.is_none() {
        args.output.print_with(&spec, || print(&spec));
    }
    Ok(Exit::Done)
}

fn description(map: &RosMap, traced: &Traced) -> String {
    let Traced { world, occupied_cells, outlines, cell_corners, max_deviation_cells } = traced;
    format!(
        "{occupied_cells} occupied cells, {outlines} outlines with {cell_corners} corners: {} walls \
         with as many corners; greatest deviation {max_deviation_cells:.3} cells ({:.4} m) of at \
         most {TOLERANCE_CELLS:.3}",
        world.walls.len(),
        max_deviation_cells * map.cell_m
    )
}

fn list(args: &WorldsArgs) -> Result<Exit> {
    let entry = |(name, text): &(_, _)| json!({ "name": name, "description": text });
    args.output.print_with(&PLACES.iter().map(entry).collect::<Vec<_>>(), || {
        PLACES.iter().for_each(|(name, text)| outln!("{name:10}  {text}"));
        outln!("\nsim-server worlds NAME --svg FILE draws one; a world file can stand for NAME.");
    });
    Ok(Exit::Done)
}

fn print(spec: &WorldSpec) {
    let [x0, y0, x1, y1] = spec.bounds;
    outln!("{}: {} walls, x {x0} to {x1} m, y {y0} to {y1} m", spec.name, spec.walls.len());
    for (i, w) in spec.walls.iter().enumerate() {
        outln!("{i:4}  {:?} to {:?}  {}", w.a, w.b, w.material);
    }
}

/// Reads N finite numbers, separated by commas.
fn numbers<const N: usize>(option: &str, text: &str) -> Result<[f64; N], FieldError> {
    let words =
        text.split(',').map(|word| word.trim().parse().ok().filter(|x: &f64| x.is_finite()));
    let found = words.collect::<Option<Vec<f64>>>().and_then(|found| found.try_into().ok());
    found.ok_or_else(|| {
        let example = ["4.9", "2.84", "1.5707963267948966"][..N].join(",");
        let remedy = format!("write e.g. {option} {example}, in m (angles in rad)");
        FieldError::new(option, text, format!("is not {N} finite numbers"), remedy)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_can_be_drawn() {
        for (name, _) in PLACES {
            let svg = drawing(place(name).unwrap().spec(), None, None);
            assert!(svg.contains("<svg") && svg.contains(name), "{name}");
        }
    }

    #[test]
    fn the_cliffs_of_the_anatomy_are_where_the_chapter_has_them() {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            args: WorldsArgs,
        }
        let pose = "--scan 4.9,2.84,1.5707963267948966";
        let line = format!("worlds apartment {pose} --noise --dropout 0.2");
        let Line { args } = clap::Parser::parse_from(line.split(' '));
        let place = place("apartment").unwrap();
        let spec = place.spec();
        let scan = Scan::take(&args, spec, args.scan.as_ref().unwrap()).unwrap();
        assert_eq!(scan.cliffs(), [6, 78, 103]);
        let measured_m = scan.measured_m.as_ref().unwrap();
        let dropped = measured_m.iter().filter(|m| **m == 8.0).count();
        assert!((20..=55).contains(&dropped), "{dropped} of 180");
        let svg = drawing(spec, None, Some(&scan));
        for words in ["\n78\n", "\n103\n", "\nrange (m)\n"] {
            assert!(svg.contains(words), "{words}");
        }
    }

    #[test]
    fn a_pose_is_three_finite_numbers() {
        assert_eq!(numbers("--scan", "1, -2,0.5").unwrap(), [1.0, -2.0, 0.5]);
        for bad in ["", "1,2", "1,2,3,4", "1,2,nan", "1,two,3"] {
            assert!(numbers::<3>("--scan", bad).is_err(), "{bad}");
        }
    }
}
