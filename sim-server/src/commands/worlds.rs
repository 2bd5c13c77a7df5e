//! `worlds`: list, draw or scan worlds.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow};
use clap::Args;
use plotters::prelude::*;
use rusty_contract::config::LidarConfig;
use rusty_contract::{Exit, FieldError, errln, outln};
use rusty_engine::scenario_file::{self, SetupError};
use rusty_geometry::places::PLACES;
use rusty_geometry::{Hit, Material, SE2, World, WorldSpec};
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

/// Width of a drawing, pixels.
const WIDTH_PX: f64 = 1000.0;

pub fn run(args: &WorldsArgs) -> Result<Exit> {
    let Some(name) = &args.name else { return list(args) };
    let spec = scenario_file::world(name)?;
    if let Some(path) = &args.svg {
        check_free(path, args.force)?;
        draw(&spec, path)?;
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
        outln!("beam  bearing     range  material");
        for (k, (range, material)) in ranges.iter().zip(&materials).enumerate() {
            let bearing_deg = lidar.bearing_rad(k as u32).to_degrees();
            let material = material.as_deref().unwrap_or("nothing within range");
            outln!("{k:4}  {bearing_deg:6.1}°  {range:7.4} m  {material}");
        }
    });
    Ok(Exit::Done)
}

fn draw(spec: &WorldSpec, path: &Path) -> Result<()> {
    let path_name = path.display();
    let svg = drawing(spec).map_err(|why| anyhow!("cannot draw {path_name}: {why}"))?;
    std::fs::write(path, svg).with_context(|| path_name.to_string())
}

fn drawing(spec: &WorldSpec) -> Result<String, String> {
    let text = |e: &dyn std::fmt::Display| e.to_string();
    let [x0, y0, x1, y1] = if spec.walls.is_empty() { [-5.0, -5.0, 5.0, 5.0] } else { spec.bounds };
    let margin = 0.04 * (x1 - x0).max(y1 - y0);
    let (width, height) = (x1 - x0 + 2.0 * margin, y1 - y0 + 2.0 * margin);
    let px_per_m = WIDTH_PX / width;
    // Room for the labels of the axes.
    let size = ((width * px_per_m) as u32 + 60, (height * px_per_m).max(120.0) as u32 + 80);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(|e| text(&e))?;
        let mut chart = ChartBuilder::on(&root)
            .caption(&spec.name, ("sans-serif", 22))
            .margin(8)
            .x_label_area_size(36)
            .y_label_area_size(44)
            .build_cartesian_2d(x0 - margin..x1 + margin, y0 - margin..y1 + margin)
            .map_err(|e| text(&e))?;
        chart
            .configure_mesh()
            .x_desc("x, m")
            .y_desc("y, m")
            .light_line_style(TRANSPARENT)
            .draw()
            .map_err(|e| text(&e))?;
        let walls = spec.walls.iter().map(|w| {
            let color = match w.material {
                Material::Wall => RGBColor(34, 34, 34),
                Material::Glass => RGBColor(0, 114, 178),
                Material::Door(_) => RGBColor(213, 94, 0),
            };
            PathElement::new(vec![(w.a[0], w.a[1]), (w.b[0], w.b[1])], color.stroke_width(3))
        });
        chart.draw_series(walls).map_err(|e| text(&e))?;
        root.present().map_err(|e| text(&e))?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_can_be_drawn() {
        for (name, _) in PLACES {
            let svg = drawing(&scenario_file::world(name).unwrap()).unwrap();
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
