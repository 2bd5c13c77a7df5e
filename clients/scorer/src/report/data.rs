//! What the page's script needs to move what is drawn to another tick: the
//! stops of the run, as compact as JSON can have them.
//!
//! Rows of numbers are little-endian in base 64. `poses` has for each stop the
//! true x, y (m, from `origin_m`) and heading (rad), then for each estimator
//! believed x, y, heading, the ellipse of [`bands::ellipse_m`] and the NEES, all
//! as 32-bit floats; what is not known is no number. `scans` has for each stop
//! of `scan_stops` the ranges of its scan as 16-bit multiples of `range_unit_m`;
//! 0 is a beam from which nothing came back. `map` is where `origin_m` lies on
//! the map, and what a metre is there; `chart` where the first and the last
//! second of `range_s` lie on a chart; both in the coordinates of the drawings.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use nalgebra::Point2;
use rusty_geometry::trig;
use rusty_plot::{Axes, Px, Rect};
use serde::Serialize;

use super::beliefs::{Beliefs, TrackData};
use super::units::{steps, units_per_m};
use crate::scoring::bands;
use crate::scoring::map::{HEAD, HEAD_SIZE, place_m};
use crate::scoring::stops::Stop;
use crate::scoring::timeline::Timeline;
use crate::scoring::trace::RunTrace;

/// All scans of a page together take at most this many bytes.
const MOST_SCAN_BYTES: usize = 640 << 10;

/// The scans that are kept: which stops have them, and how far a beam can tell.
pub(super) struct Scans {
    /// Indices of the stops, ascending.
    pub stops: Vec<usize>,
    unit_m: f64,
}

#[derive(Serialize)]
struct Data {
    ticks: Vec<u64>,
    times_s: Vec<f64>,
    estimators: usize,
    origin_m: [f64; 2],
    poses: String,
    scan_stops: Vec<usize>,
    scans: String,
    beams: u32,
    range_unit_m: f64,
    first_bearing_rad: f64,
    bearing_step_rad: f64,
    sensor_in_body: [f64; 3],
    map: [f64; 3],
    chart: [f64; 2],
    range_s: [f64; 2],
    #[serde(flatten)]
    beliefs: Option<BeliefData>,
}

/// Beliefs, and how an arrowhead is made; only pages that have any have it.
#[derive(Serialize)]
struct BeliefData {
    beliefs: Vec<TrackData>,
    corners: [[f64; 2]; 3],
    head: f64,
}

impl Scans {
    pub fn of(trace: &RunTrace) -> Self {
        let drawn = |stop: &Stop| stop.has_scan && stop.truth.is_some();
        let mut stops: Vec<usize> =
            (0..trace.stops.len()).filter(|&k| drawn(&trace.stops[k])).collect();
        // Evenly thinned, the last one kept: the page begins with it.
        let most = (MOST_SCAN_BYTES / (2 * trace.lidar.beams.max(1) as usize)).max(1);
        let every = stops.len().div_ceil(most).max(1);
        let rest = stops.len().saturating_sub(1) % every;
        stops = stops.into_iter().skip(rest).step_by(every).collect();
        let unit_m = (trace.lidar.range_max_m / 65_000.0).max(1e-3);
        Self { stops, unit_m }
    }

    /// The scan that is the latest one at a stop, as an index of `stops`.
    fn at(&self, stop: usize) -> Option<usize> {
        self.stops.partition_point(|&k| k <= stop).checked_sub(1)
    }

    /// Where the echoes of a stop's latest scan lie on the page, one for each
    /// beam.
    pub fn points_px(&self, trace: &RunTrace, axes: &Axes, stop: usize) -> Vec<Option<Px>> {
        let beams = 0..if self.stops.is_empty() { 0 } else { trace.lidar.beams };
        let stop = self.at(stop).map(|k| &trace.stops[self.stops[k]]);
        let Some((stop, truth)) = stop.and_then(|stop| Some((stop, stop.truth?))) else {
            return beams.map(|_| None).collect();
        };
        let sensor = truth * trace.lidar.sensor_in_body;
        let point = |beam: u32| {
            let range_m = f64::from(*stop.ranges_m.get(beam as usize)?);
            let (s, c) = trig::sin_cos(trace.lidar.bearing_rad(beam));
            let at = sensor.transform_point(&Point2::new(range_m * c, range_m * s));
            (self.steps(trace, range_m) > 0).then(|| axes.px([at.x, at.y]))
        };
        beams.map(point).collect()
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
    trace.stops.get(stop).map_or_else(
        || "no tick".to_owned(),
        // Rounded as the script does it, which does not go to the even digit.
        |stop| match trace.is_in_ticks {
            true => format!("tick {}", stop.tick),
            false => {
                format!("tick {} · {:.2} s", stop.tick, (place_s(time, stop) * 1e2).round() / 1e2)
            }
        },
    )
}

/// The document.
pub(super) fn json(
    trace: &RunTrace,
    time: &Timeline,
    axes: &Axes,
    (scans, beliefs): (&Scans, &Beliefs<'_>),
    chart: Rect,
) -> String {
    let origin_m = [axes.x, axes.y].map(|axis| 0.5 * (axis.range[0] + axis.range[1]));
    let poses: Vec<u8> = trace
        .stops
        .iter()
        .flat_map(|stop| row(stop, trace.names.len(), origin_m))
        .flat_map(|v| (v as f32).to_le_bytes())
        .collect();
    let lidar = &trace.lidar;
    let sensor = lidar.sensor_in_body;
    let [x, y] = axes.px(origin_m).map(steps);
    let data = Data {
        ticks: trace.stops.iter().map(|stop| stop.tick).collect(),
        times_s: trace.stops.iter().map(|stop| place_s(time, stop)).collect(),
        estimators: trace.names.len(),
        origin_m,
        poses: BASE64_STANDARD.encode(poses),
        scan_stops: scans.stops.clone(),
        scans: scans.base64(trace),
        beams: lidar.beams,
        range_unit_m: scans.unit_m,
        first_bearing_rad: lidar.first_bearing_rad,
        bearing_step_rad: lidar.fov_rad / f64::from(lidar.beams.max(1)),
        sensor_in_body: [sensor.x(), sensor.y(), sensor.theta()],
        map: [x, y, steps(units_per_m(axes))],
        chart: [chart.left, chart.right].map(steps),
        range_s: time.range_s,
        beliefs: (!beliefs.is_empty()).then(|| BeliefData {
            beliefs: beliefs.data(axes),
            corners: HEAD,
            head: steps(HEAD_SIZE),
        }),
    };
    // Numbers, and names of letters, digits, '-' and '_': nothing in it can end
    // the element that it is in.
    serde_json::to_string(&data).unwrap_or_default()
}

/// The numbers of a stop.
fn row(stop: &Stop, estimators: usize, origin_m: [f64; 2]) -> impl Iterator<Item = f64> {
    let pose = move |pose: &rusty_geometry::SE2| {
        let [x_m, y_m] = place_m(pose);
        [x_m - origin_m[0], y_m - origin_m[1], pose.theta()]
    };
    let none = [f64::NAN; 3];
    let truth = stop.truth.as_ref().map_or(none, pose);
    let estimates = (0..estimators).flat_map(move |i| {
        let estimate = stop.estimate(i);
        let ellipse = estimate.and_then(bands::ellipse_m).unwrap_or(none);
        let nees = estimate.zip(stop.truth).and_then(|(e, truth)| bands::nees(&truth, e));
        let pose = estimate.map_or(none, |e| pose(&e.pose_in_world));
        pose.into_iter().chain(ellipse).chain([nees.unwrap_or(f64::NAN)])
    });
    truth.into_iter().chain(estimates)
}
