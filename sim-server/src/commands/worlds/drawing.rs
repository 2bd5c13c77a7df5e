//! A world as a drawing: walls, the map they come from, and the beams of a scan.

use rusty_floorplan::map_server::{Cell, RosMap};
use rusty_geometry::{SE2, WorldSpec};
use rusty_plot::floor::{draw_line, draw_robot, draw_walls};
use rusty_plot::style::{INK, Look, RGBColor, SOFT_INK};
use rusty_plot::{Anchor, Axes, Axis, Canvas, Px, Rect, paint};

use super::scan::Scan;

/// Width of a drawn world, and where it begins, CSS pixels.
const WIDTH: f64 = 920.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 44.0;
/// Height of the strip of a scan, and its distance from the world above it.
const STRIP: f64 = 220.0;
const GAP: f64 = 78.0;

/// Colour of the occupied cells of a map.
const OCCUPIED: RGBColor = RGBColor(0xBD, 0xBD, 0xBD);

pub fn drawing(spec: &WorldSpec, map: Option<&RosMap>, scan: Option<&Scan>) -> String {
    let [x0, y0, x1, y1] = if spec.walls.is_empty() { [-5.0, -5.0, 5.0, 5.0] } else { spec.bounds };
    let margin = 0.04 * (x1 - x0).max(y1 - y0);
    let (x, y) = ([x0 - margin, x1 + margin], [y0 - margin, y1 + margin]);
    let height = (WIDTH * (y[1] - y[0]) / (x[1] - x[0])).clamp(120.0, 10.0 * WIDTH);
    let frame = Rect { left: LEFT, top: TOP, right: LEFT + WIDTH, bottom: TOP + height };
    let axes = Axes::equal(frame, x, y, 12.0);
    let below = if scan.is_some() { GAP + STRIP } else { 0.0 };
    paint((WIDTH + LEFT + 20.0, frame.bottom + below + 50.0), &spec.name, |canvas| {
        canvas.text([LEFT, 28.0], Anchor::Start, 22.0, &INK, &spec.name);
        axes.draw_grid(canvas);
        if let Some(map) = map {
            draw_cells(canvas, &axes, map);
        }
        if let Some(scan) = scan {
            draw_beams(canvas, &axes, scan);
        }
        draw_walls(canvas, &axes, &spec.walls);
        if let Some(scan) = scan {
            draw_ends(canvas, &axes, scan);
            draw_strip(canvas, frame.bottom + GAP, scan);
        }
        axes.draw_frame(canvas, true);
        axes.draw_titles(canvas, "", "x (m)", "y (m)");
    })
}

/// Where a beam ends, world frame, m.
fn end(scan: &Scan, k: usize, range_m: f64) -> [f64; 2] {
    let ray = SE2::new(0.0, 0.0, scan.lidar.bearing_rad(k as u32));
    let beam = scan.sensor_in_world.compose(&ray);
    beam.transform_point(&[range_m, 0.0].into()).into()
}

fn draw_beams(canvas: &mut Canvas, axes: &Axes, scan: &Scan) {
    let sensor = scan.sensor_in_world.translation();
    for (k, hit) in scan.hits.iter().enumerate() {
        let beam = [[sensor.x, sensor.y], end(scan, k, hit.distance_m)];
        draw_line(canvas, axes, &beam, (&OCCUPIED, 0.8));
    }
}

/// What the sensor says, as points on the floor, and the sensor.
fn draw_ends(canvas: &mut Canvas, axes: &Axes, scan: &Scan) {
    let ink = Look::of(0, 1).ink;
    for (k, hit) in scan.hits.iter().enumerate() {
        let range_m = scan.measured_m.as_ref().map_or(hit.distance_m, |all| all[k]);
        let at = axes.px(end(scan, k, range_m));
        if range_m < scan.lidar.range_max_m && axes.holds(at) {
            canvas.disc(at, 2.4, &ink);
        }
    }
    let sensor = scan.sensor_in_world;
    draw_robot(canvas, axes.px([sensor.x(), sensor.y()]), sensor.theta(), true);
}

/// Range over beam: the exact one as steps, broken at cliffs, and what the sensor says
/// as points. A cliff has the number of its beam.
fn draw_strip(canvas: &mut Canvas, top: f64, scan: &Scan) {
    let frame = Rect { left: LEFT, top, right: LEFT + WIDTH, bottom: top + STRIP };
    let beams = scan.hits.len() as f64;
    let farthest_m = scan.hits.iter().map(|hit| hit.distance_m).fold(0.0, f64::max);
    let said_m = scan.measured_m.iter().flatten().copied().fold(farthest_m, f64::max);
    let (x, y) = (Axis::linear([-0.5, beams - 0.5], 12.0), Axis::linear([0.0, 1.08 * said_m], 6.0));
    let axes = Axes { frame, x, y };
    axes.draw_grid(canvas);
    let cliffs = scan.cliffs();
    for k in &cliffs {
        let [x, _] = axes.px([*k as f64 - 0.5, 0.0]);
        canvas.dashes(&[[x, frame.top], [x, frame.bottom]], &SOFT_INK, 1.0, 4.0);
        let place: Px = [x + 4.0, frame.top + 14.0];
        canvas.text(place, Anchor::Start, 13.0, &SOFT_INK, &k.to_string());
    }
    let mut from = 0;
    for to in cliffs.into_iter().chain([scan.hits.len()]) {
        let steps = (from..to).flat_map(|k| {
            let range_m = scan.hits[k].distance_m;
            [[k as f64 - 0.5, range_m], [k as f64 + 0.5, range_m]]
        });
        draw_line(canvas, &axes, &steps.collect::<Vec<_>>(), (&INK, 1.6));
        from = to;
    }
    let ink = Look::of(0, 1).ink;
    for (k, range_m) in scan.measured_m.iter().flatten().enumerate() {
        canvas.disc(axes.px([k as f64, *range_m]), 2.4, &ink);
    }
    axes.draw_frame(canvas, true);
    axes.draw_titles(canvas, "", "beam", "range (m)");
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
