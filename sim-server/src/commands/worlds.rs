//! `worlds`: list, draw or scan worlds.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_contract::config::LidarConfig;
use rusty_contract::{Exit, FieldError, TextTable, errln, outln};
use rusty_engine::scenario_file::{self, SetupError};
use rusty_geometry::places::PLACES;
use rusty_geometry::{Hit, SE2, World, WorldSpec};
use rusty_plot::floor::draw_walls;
use rusty_plot::style::INK;
use rusty_plot::{Anchor, Axes, Rect, paint};
use rusty_sim::Lidar;
use serde_json::json;

use super::arguments::{Output, check_free};

#[derive(Args, Clone, Debug)]
pub struct WorldsArgs {
    /// Built-in world or world file
    pub name: Option<String>,
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

pub fn run(args: &WorldsArgs) -> Result<Exit> {
    let Some(name) = &args.name else { return list(args) };
    let spec = scenario_file::world(name)?;
    if let Some(path) = &args.svg {
        check_free(path, args.force)?;
        std::fs::write(path, drawing(&spec)).with_context(|| path.display().to_string())?;
        errln!("drawn into {}", path.display());
    }
    if let Some(pose) = &args.scan {
        return scan(args, name, spec, pose);
    }
    if args.output.json || args.svg.is_none() {
        args.output.print_with(&spec, || print(&spec));
    }
    Ok(Exit::Done)
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

fn parse_pose(text: &str) -> Result<SE2, FieldError> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|word| word.trim().parse().ok())
        .filter(|x: &f64| x.is_finite())
        .collect();
    match numbers.as_slice() {
        [x, y, theta] if text.split(',').count() == 3 => Ok(SE2::new(*x, *y, *theta)),
        _ => {
            let remedy = "write X,Y,THETA in m, m, rad, e.g. --scan 4.9,2.84,1.5707963267948966";
            Err(FieldError::new("--scan", text, "is not three finite numbers", remedy))
        }
    }
}

fn scan(args: &WorldsArgs, name: &str, spec: WorldSpec, pose: &str) -> Result<Exit> {
    let sensor_in_world = parse_pose(pose)?;
    let lidar =
        LidarConfig { beams: args.beams, range_max_m: args.range_max, ..LidarConfig::default() };
    lidar.check()?;
    let world =
        World::new(spec).map_err(|error| SetupError::World { path: name.to_owned(), error })?;
    let mut hits = vec![Hit { distance_m: 0.0, material: None }; args.beams as usize];
    Lidar::new(&lidar).ranges_and_materials(&world, &sensor_in_world, &mut hits);
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

fn drawing(spec: &WorldSpec) -> String {
    let [x0, y0, x1, y1] = if spec.walls.is_empty() { [-5.0, -5.0, 5.0, 5.0] } else { spec.bounds };
    let margin = 0.04 * (x1 - x0).max(y1 - y0);
    let (x, y) = ([x0 - margin, x1 + margin], [y0 - margin, y1 + margin]);
    let height = (WIDTH * (y[1] - y[0]) / (x[1] - x[0])).clamp(120.0, 10.0 * WIDTH);
    let frame = Rect { left: LEFT, top: TOP, right: LEFT + WIDTH, bottom: TOP + height };
    let axes = Axes::equal(frame, x, y, 12.0);
    paint((WIDTH + LEFT + 20.0, frame.bottom + 50.0), &spec.name, |canvas| {
        canvas.text([LEFT, 28.0], Anchor::Start, 22.0, &INK, &spec.name);
        axes.draw_grid(canvas);
        draw_walls(canvas, &axes, &spec.walls);
        axes.draw_frame(canvas, true);
        axes.draw_titles(canvas, "", "x (m)", "y (m)");
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_can_be_drawn() {
        for (name, _) in PLACES {
            let svg = drawing(&scenario_file::world(name).unwrap());
            assert!(svg.contains("<svg") && svg.contains(name), "{name}");
        }
    }

    #[test]
    fn a_pose_is_three_finite_numbers() {
        assert_eq!(parse_pose("1, -2,0.5").unwrap(), SE2::new(1.0, -2.0, 0.5));
        for bad in ["", "1,2", "1,2,3,4", "1,2,nan", "1,two,3"] {
            assert!(parse_pose(bad).is_err(), "{bad}");
        }
    }
}
