//! What the player of the page needs: the stops of the run, as compact as JSON can have
//! them.
//!
//! Rows of numbers are little-endian in base 64. `poses` has for each stop the
//! true x, y (m, from `origin_m`) and heading (rad), then for each estimator
//! believed x, y, heading, the ellipse of [`bands::ellipse_m`] and the NEES, all
//! as 32-bit floats; what is not known is no number. `scans` has for each stop
//! of `scan_stops` the ranges of its scan as 16-bit multiples of `range_unit_m`;
//! 0 is a beam from which nothing came back. `bounds_m` is the box of the map (least x
//! and y, greatest x and y); `chart` where the first and the last second of `range_s` lie
//! on a chart, in the coordinates of the drawings. `jumps` are kidnappings: tick, time,
//! and the places before and after.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use rusty_contract::log::LogHeader;
use rusty_geometry::{Material, SE2};
use rusty_plot::Rect;
use rusty_plot::layers::STEPS_PER_UNIT;
use rusty_plot::style::Look;
use serde::Serialize;

use super::beliefs::{Beliefs, TrackData};
use super::drawn::Drawn;
use crate::scoring::bands;
use crate::scoring::map::{jump_text, place_m};
use crate::scoring::stops::Stop;
use crate::scoring::timeline::Timeline;
use crate::scoring::trace::RunTrace;

/// All scans of a page together take at most this many bytes.
const MOST_SCAN_BYTES: usize = 640 << 10;

/// The scans that are kept: which stops have them, and how far a beam can tell.
struct Scans {
    /// Indices of the stops, ascending.
    stops: Vec<usize>,
    unit_m: f64,
}

#[derive(Serialize)]
struct Data {
    ticks: Vec<u64>,
    times_s: Vec<f64>,
    is_in_ticks: bool,
    estimators: Vec<Drawn>,
    bounds_m: [f64; 4],
    walls: Vec<(f64, f64, f64, f64, &'static str)>,
    body_radius_m: f64,
    origin_m: [f64; 2],
    poses: String,
    start: Option<[f64; 3]>,
    jumps: Vec<(u64, String, f64, f64, f64, f64)>,
    scan_stops: Vec<usize>,
    scans: String,
    beams: u32,
    range_unit_m: f64,
    first_bearing_rad: f64,
    bearing_step_rad: f64,
    sensor_in_body: [f64; 3],
    chart: [f64; 2],
    range_s: [f64; 2],
    beliefs: Vec<TrackData>,
}

impl Scans {
    fn of(trace: &RunTrace) -> Self {
        let drawn = |stop: &Stop| stop.has_scan && stop.truth.is_some();
        let mut stops: Vec<usize> =
            (0..trace.stops.len()).filter(|&k| drawn(&trace.stops[k])).collect();
        // Evenly thinned, the last one kept: the run ends with it.
        let most = (MOST_SCAN_BYTES / (2 * trace.lidar.beams.max(1) as usize)).max(1);
        let every = stops.len().div_ceil(most).max(1);
        let rest = stops.len().saturating_sub(1) % every;
        stops = stops.into_iter().skip(rest).step_by(every).collect();
        let unit_m = (trace.lidar.range_max_m / 65_000.0).max(1e-3);
        Self { stops, unit_m }
    }

    /// A range in steps; 0 if nothing came back.
    fn steps(&self, trace: &RunTrace, range_m: f64) -> u16 {
        let echo = range_m > 0.0 && range_m < trace.lidar.range_max_m * (1.0 - 1e-6);
        // The cast saturates.
        if echo { ((range_m / self.unit_m).round() as u16).max(1) } else { 0 }
    }

    fn base64(&self, trace: &RunTrace) -> String {
        let mut bytes = Vec::new();
        for &k in &self.stops {
            let ranges_m = &trace.stops[k].ranges_m;
            for beam in 0..trace.lidar.beams as usize {
                let range_m = ranges_m.get(beam).map_or(0.0, |&r| f64::from(r));
                bytes.extend(self.steps(trace, range_m).to_le_bytes());
            }
        }
        BASE64_STANDARD.encode(bytes)
    }
}

/// Where a stop lies on the time axis, s; at its zero if its time is no number.
fn place_s(time: &Timeline, stop: &Stop) -> f64 {
    let place_s = time.place_s(stop.time_s).unwrap_or(0.0);
    // Tenths of milliseconds, and no zero with a sign.
    (place_s * 1e4).round() / 1e4 + 0.0
}

/// The words of a stop next to the slider; its time is its place on
/// the time axis, as everywhere on the page.
pub(super) fn now(trace: &RunTrace, time: &Timeline, stop: usize) -> String {
    match trace.stops.get(stop) {
        None => "no tick".to_owned(),
        Some(stop) if trace.is_in_ticks => format!("tick {}", stop.tick),
        // Rounded as the script does it, which does not go to the even digit.
        Some(stop) => {
            format!("tick {} · {:.2} s", stop.tick, (place_s(time, stop) * 1e2).round() / 1e2)
        }
    }
}

/// The document; nothing in it can end the element that it is in.
pub(super) fn json(
    header: &LogHeader,
    trace: &RunTrace,
    time: &Timeline,
    (bounds_m, beliefs): ([f64; 4], &Beliefs<'_>),
    chart: Rect,
) -> String {
    let scans = Scans::of(trace);
    let origin_m = [0, 1].map(|k| 0.5 * (bounds_m[k] + bounds_m[k + 2]));
    let count = trace.names.len();
    let poses: Vec<u8> = trace
        .stops
        .iter()
        .flat_map(|stop| row(trace, stop, origin_m))
        .flat_map(|v| (v as f32).to_le_bytes())
        .collect();
    let lidar = &trace.lidar;
    let looks = trace.names.iter().enumerate();
    let data = Data {
        ticks: trace.stops.iter().map(|stop| stop.tick).collect(),
        times_s: trace.stops.iter().map(|stop| place_s(time, stop)).collect(),
        is_in_ticks: trace.is_in_ticks,
        estimators: looks.map(|(i, name)| Drawn::of(name, &Look::of(i, count))).collect(),
        bounds_m: bounds_m.map(millimetres),
        walls: walls(trace),
        body_radius_m: header.config.robot.body_radius_m,
        origin_m,
        poses: BASE64_STANDARD.encode(poses),
        start: (0..trace.tick_count()).find_map(|tick| trace.true_pose(tick)).map(|p| numbers(&p)),
        jumps: trace.jumps.iter().map(jump).collect(),
        scans: scans.base64(trace),
        scan_stops: scans.stops,
        beams: lidar.beams,
        range_unit_m: scans.unit_m,
        first_bearing_rad: lidar.first_bearing_rad,
        bearing_step_rad: lidar.fov_rad / f64::from(lidar.beams.max(1)),
        sensor_in_body: numbers(&lidar.sensor_in_body),
        chart: [chart.left, chart.right].map(|units| units * STEPS_PER_UNIT),
        range_s: time.range_s,
        beliefs: beliefs.data(bounds_m.map(millimetres)),
    };
    serde_json::to_string(&data).unwrap_or_default().replace('<', "\\u003c")
}

fn millimetres(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}

fn walls(trace: &RunTrace) -> Vec<(f64, f64, f64, f64, &'static str)> {
    let wall = |wall: &rusty_geometry::WallSpec| {
        let [ax, ay, bx, by] = [wall.a[0], wall.a[1], wall.b[0], wall.b[1]].map(millimetres);
        let material = match wall.material {
            Material::Wall => "wall",
            Material::Glass => "glass",
            Material::Door(_) => "door",
        };
        (ax, ay, bx, by, material)
    };
    trace.world.walls.iter().map(wall).collect()
}

fn jump(jump: &crate::scoring::trace::Jump) -> (u64, String, f64, f64, f64, f64) {
    let ([x0, y0], [x, y]) = (place_m(&jump.from), place_m(&jump.to));
    (jump.tick, jump_text(jump), x0, y0, x, y)
}

/// The numbers of a pose: m, rad.
fn numbers(pose: &SE2) -> [f64; 3] {
    let [x_m, y_m] = place_m(pose);
    [x_m, y_m, pose.theta()]
}

/// The numbers of a stop.
fn row(trace: &RunTrace, stop: &Stop, origin_m: [f64; 2]) -> impl Iterator<Item = f64> {
    let pose = move |pose: &SE2| {
        let [x_m, y_m, theta_rad] = numbers(pose);
        [x_m - origin_m[0], y_m - origin_m[1], theta_rad]
    };
    let none = [f64::NAN; 3];
    let truth = stop.truth.as_ref().map_or(none, pose);
    let estimates = (0..trace.names.len()).flat_map(move |i| {
        let estimate = stop.estimate(i);
        let ellipse = estimate.and_then(bands::ellipse_m).unwrap_or(none);
        let nees = estimate
            .zip(stop.truth)
            .and_then(|(e, truth)| bands::nees(&truth, e, &trace.reference));
        let pose = estimate.map_or(none, |e| pose(&e.pose_in_world));
        pose.into_iter().chain(ellipse).chain([nees.unwrap_or(f64::NAN)])
    });
    truth.into_iter().chain(estimates)
}
