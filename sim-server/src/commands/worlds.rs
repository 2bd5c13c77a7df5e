//! `worlds`: list, draw, scan or check worlds.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_contract::config::LidarConfig;
use rusty_contract::{Exit, FieldError, TextTable, errln, outln};
use rusty_floorplan::check::check;
use rusty_floorplan::map_server::{Cell, RosMap};
use rusty_floorplan::trace::{TOLERANCE_CELLS, Traced};
use rusty_floorplan::{FloorplanError, TracedMap, map_of, read_unchecked};
use rusty_geometry::places::{PLACES, place};
use rusty_geometry::{Hit, SE2, World, WorldSpec};
use rusty_plot::floor::draw_walls;
use rusty_plot::style::{INK, RGBColor};
use rusty_plot::{Anchor, Axes, Canvas, Rect, paint};
use rusty_sim::Lidar;
use serde_json::json;

use super::arguments::{Output, check_free};

const AFTER_HELP: &str = "\
A world file is a floor plan (TOML, or JSON with the ending .json), a map of ROS (the
YAML page, .yaml or .yml, of a PGM or PNG picture) or a drawing (.svg). `worlds FILE
--json` converts each of them to JSON.

--check names gaps, walls that cover each other, openings through which the floor is
open to the outside, and loose ends. It exits with 1 unless there are loose ends only.

Examples:
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
    /// Scan without noise from this sensor pose, in m, m, rad
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, requires = "name")]
    pub scan: Option<String>,
    /// Number of beams of the scan over the full circle
    #[arg(long, default_value_t = 180)]
    pub beams: u32,
    /// Longest range of the scan, m
    #[arg(long, default_value_t = 8.0)]
    pub range_max: f64,
    /// Draw the world into this SVG file
    #[arg(long, value_name = "FILE", requires = "name")]
    pub svg: Option<PathBuf>,
    /// Replace an existing drawing
    #[arg(long, requires = "svg")]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Width of a drawn world, and where it begins, CSS pixels.
const WIDTH: f64 = 920.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 44.0;

/// Colour of the occupied cells of a map.
const OCCUPIED: RGBColor = RGBColor(0xBD, 0xBD, 0xBD);

pub fn run(args: &WorldsArgs) -> Result<Exit> {
    let Some(name) = &args.name else { return list(args) };
    let path = Path::new(name);
    let built_in = place(name);
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
    if let Some(path) = &args.svg {
        check_free(path, args.force)?;
        let map = map.as_ref();
        std::fs::write(path, drawing(&spec, map.map(|map| &map.map)))
            .with_context(|| path.display().to_string())?;
        if let Some(TracedMap { map, traced }) = map {
            errln!("{}", description(map, traced));
        }
        errln!("drawn into {}", path.display());
    }
    if let Some(pose) = &args.scan {
        return scan(args, &World::new(spec).map_err(unusable)?, pose);
    }
    if args.output.json || args.svg.is_none() {
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

fn scan(args: &WorldsArgs, world: &World, pose: &str) -> Result<Exit> {
    let [x, y, theta] = numbers("--scan", pose)?;
    let sensor_in_world = SE2::new(x, y, theta);
    let lidar =
        LidarConfig { beams: args.beams, range_max_m: args.range_max, ..LidarConfig::default() };
    lidar.check()?;
    let mut hits = vec![Hit { distance_m: 0.0, material: None }; args.beams as usize];
    Lidar::new(&lidar).ranges_and_materials(world, &sensor_in_world, &mut hits);
    let ranges: Vec<f64> = hits.iter().map(|h| h.distance_m).collect();
    let materials: Vec<Option<String>> =
        hits.iter().map(|h| h.material.map(|m| m.to_string())).collect();
    args.output.print_with(&json!({ "ranges": ranges, "materials": materials }), || {
        let mut table = TextTable::new(">beam  >bearing  >range  material");
        for (k, (range, material)) in ranges.iter().zip(&materials).enumerate() {
            let bearing = format!("{:.1}°", lidar.bearing_rad(k as u32).to_degrees());
            let material = material.as_deref().unwrap_or("nothing within range");
            table.row(&[&k, &bearing, &format!("{range:.4} m"), &material]);
        }
        outln!("{table}");
    });
    Ok(Exit::Done)
}

fn drawing(spec: &WorldSpec, map: Option<&RosMap>) -> String {
    let [x0, y0, x1, y1] = if spec.walls.is_empty() { [-5.0, -5.0, 5.0, 5.0] } else { spec.bounds };
    let margin = 0.04 * (x1 - x0).max(y1 - y0);
    let (x, y) = ([x0 - margin, x1 + margin], [y0 - margin, y1 + margin]);
    let height = (WIDTH * (y[1] - y[0]) / (x[1] - x[0])).clamp(120.0, 10.0 * WIDTH);
    let frame = Rect { left: LEFT, top: TOP, right: LEFT + WIDTH, bottom: TOP + height };
    let axes = Axes::equal(frame, x, y, 12.0);
    paint((WIDTH + LEFT + 20.0, frame.bottom + 50.0), &spec.name, |canvas| {
        canvas.text([LEFT, 28.0], Anchor::Start, 22.0, &INK, &spec.name);
        axes.draw_grid(canvas);
        if let Some(map) = map {
            draw_cells(canvas, &axes, map);
        }
        draw_walls(canvas, &axes, &spec.walls);
        axes.draw_frame(canvas, true);
        axes.draw_titles(canvas, "", "x (m)", "y (m)");
    })
}

/// Draws the occupied cells of a map, those in a row together.
fn draw_cells(canvas: &mut Canvas, axes: &Axes, map: &RosMap) {
    let frame_in_world = SE2::new(map.origin_m[0], map.origin_m[1], map.yaw_rad);
    let place = |column: usize, row: usize| {
        let [x, y] = [column, row].map(|cells| map.cell_m * cells as f64);
        axes.px(frame_in_world.transform_point(&[x, y].into()).into())
    };
    for (row, cells) in map.cells.chunks_exact(map.width).enumerate() {
        let mut from = 0;
        for same in cells.chunk_by(|a, b| a == b) {
            let to = from + same.len();
            if same[0] == Cell::Occupied {
                let corners = [(from, row), (to, row), (to, row + 1), (from, row + 1)];
                canvas.polygon(&corners.map(|(x, y)| place(x, y)), &OCCUPIED);
            }
            from = to;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_can_be_drawn() {
        for (name, _) in PLACES {
            let svg = drawing(place(name).unwrap().spec(), None);
            assert!(svg.contains("<svg") && svg.contains(name), "{name}");
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
