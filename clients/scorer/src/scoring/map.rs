//! The map: walls, the true path, the believed paths with the ellipses of their
//! covariances, the last scan.

use std::collections::BTreeMap;

use nalgebra::Point2;
use rusty_contract::score::seconds;
use rusty_geometry::{SE2, trig};
use rusty_plot::ellipse::outline;
use rusty_plot::floor::{Extent, draw_line, draw_robot, draw_walls};
use rusty_plot::style::{INK, Look, RGBColor, SCAN, TRUTH, TRUTH_WIDTH, WHITE};
use rusty_plot::{Anchor, Axes, Canvas, Px, Rect, polyline};

use super::bands;
use super::bars::bars;
use super::beliefs::Mark;
use super::stops::Stop;
use super::timeline::Timeline;
use super::trace::{Jump, RunTrace};

/// Coordinates beyond this are drawn as if they were here, m: such a place is
/// off the map in any case, and its arithmetic stays finite.
const FARTHEST_M: f64 = 1e9;
/// An estimate that moves farther than this, and faster, was not driven: m, m/s.
const LEAP: [f64; 2] = [1.0, 5.0];
/// Width of the arrow of a kidnapping.
const JUMP_WIDTH: f64 = 1.8;

/// What is to be seen on the map, and the least box that holds it.
pub(crate) struct View {
    /// Points of the last scan, world frame, m; empty if its pose is not known.
    pub scan: Vec<[f64; 2]>,
    x_m: [f64; 2],
    y_m: [f64; 2],
}

impl View {
    /// Walls and true path decide how large the map is (believed paths where
    /// there are neither); scan and believed paths may widen it by half its
    /// size, so that an estimate that ran away does not shrink the rest.
    pub fn of(trace: &RunTrace) -> Self {
        let scan = scan_points_m(trace);
        let mut core = Extent::default();
        for wall in &trace.world.walls {
            core.include(wall.a);
            core.include(wall.b);
        }
        let truths = (0..trace.tick_count()).filter_map(|tick| trace.true_pose(tick));
        truths.for_each(|pose| core.include(place_m(&pose)));
        let believed = || {
            let all =
                (0..trace.names.len()).flat_map(|i| (0..trace.tick_count()).map(move |k| (i, k)));
            all.filter_map(|(i, k)| trace.estimate(i, k)).map(|pose| place_m(&pose))
        };
        if core.is_empty() {
            believed().for_each(|at| core.include(at));
        }
        if core.is_empty() {
            core.include([0.0, 0.0]);
        }
        let mut whole = core;
        let room_m = 0.5 * core.size();
        let near_by = core.grown(room_m.max(trace.lidar.range_max_m.min(10.0)));
        scan.iter().for_each(|&at| whole.include(near_by.nearest(at)));
        let near_by = core.grown(room_m.max(1.0));
        believed().for_each(|at| whole.include(near_by.nearest(at)));
        let whole = whole.grown((0.03 * whole.size()).max(0.5));
        Self { scan, x_m: whole.x(), y_m: whole.y() }
    }

    /// The box: least x and y, greatest x and y, m.
    pub fn bounds_m(&self) -> [f64; 4] {
        [self.x_m[0], self.y_m[0], self.x_m[1], self.y_m[1]]
    }

    /// Height of the map per width of it, for which no room is left over.
    pub fn aspect(&self) -> f64 {
        (self.y_m[1] - self.y_m[0]) / (self.x_m[1] - self.x_m[0])
    }

    /// The way from the world to a page. `frame` is filled.
    pub fn axes(&self, frame: Rect) -> Axes {
        Axes::equal(frame, self.x_m, self.y_m, 10.0)
    }

    /// Draws the scan as far as it is in the map.
    pub fn draw_scan(&self, canvas: &mut Canvas, axes: &Axes) {
        for at in self.scan.iter().map(|&at| axes.px(at)).filter(|&at| axes.holds(at)) {
            draw_echo(canvas, at);
        }
    }
}

/// Draws the walls and the true path, on a grid with its numbers.
pub(crate) fn draw_ground(canvas: &mut Canvas, axes: &Axes, trace: &RunTrace) {
    axes.draw_grid(canvas);
    draw_walls(canvas, axes, &trace.world.walls);
    let truth = places_m(trace, |tick| trace.true_pose(tick));
    let time_s = |place: &(usize, _)| trace.time_s[place.0];
    // A kidnapping ends a path, and the next one begins.
    let driven = |a: &_, b: &_| {
        !trace.jumps.iter().any(|jump| time_s(a) <= jump.time_s && jump.time_s < time_s(b))
    };
    for part in truth.chunk_by(driven) {
        draw_path(canvas, axes, part, (&TRUTH, TRUTH_WIDTH));
    }
    trace.jumps.iter().for_each(|jump| draw_jump(canvas, axes, jump));
    axes.draw_frame(canvas, true);
    axes.draw_titles(canvas, "", "x (m)", "y (m)");
}

/// Draws the path that an estimator believed in. Returns whether it leaves the
/// map.
pub(crate) fn draw_believed(
    canvas: &mut Canvas,
    axes: &Axes,
    trace: &RunTrace,
    estimator: usize,
) -> bool {
    let look = Look::of(estimator, trace.names.len());
    let path = places_m(trace, |tick| trace.estimate(estimator, tick));
    let driven = |a: &(usize, [f64; 2]), b: &(usize, [f64; 2])| {
        let moved_m = trig::hypot(b.1[0] - a.1[0], b.1[1] - a.1[1]);
        let passed_s = trace.time_s[b.0] - trace.time_s[a.0];
        moved_m <= LEAP[0].max(LEAP[1] * passed_s)
    };
    for part in path.chunk_by(driven) {
        draw_path(canvas, axes, part, (&look.ink, look.width));
    }
    path.iter().any(|&(_, at)| !axes.holds(axes.px(at)))
}

/// Draws a kidnapping: a dotted arrow with its time.
fn draw_jump(canvas: &mut Canvas, axes: &Axes, jump: &Jump) {
    let ends = [&jump.from, &jump.to].map(|pose| axes.px(place_m(pose)));
    draw_dotted_arrow(canvas, ends);
    let text = jump_text(jump);
    let [x, y] = [0, 1].map(|k| 0.5 * (ends[0][k] + ends[1][k]));
    let (half, up) = (3.6 * text.chars().count() as f64 + 3.0, 8.5);
    let around = [[x - half, y - up], [x + half, y - up], [x + half, y + up], [x - half, y + up]];
    canvas.wash(&around, &WHITE, 0.85);
    canvas.text([x, y + 4.5], Anchor::Middle, 12.0, &INK, &text);
}

/// The time of a kidnapping, as words.
pub(crate) fn jump_text(jump: &Jump) -> String {
    format!("{} s", seconds(jump.time_s))
}

/// Draws a dotted arrow from one place of the page to another.
pub(crate) fn draw_dotted_arrow(canvas: &mut Canvas, [from, to]: [Px; 2]) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = trig::hypot(dx, dy).max(1e-9);
    let (c, s) = (dx / length, dy / length);
    let at =
        |along: f64, aside: f64| [to[0] + along * c - aside * s, to[1] + along * s + aside * c];
    canvas.dashes(&[from, at(-8.0, 0.0)], &INK, JUMP_WIDTH, 2.5);
    canvas.polygon(&[to, at(-10.0, 4.5), at(-10.0, -4.5)], &INK);
}

/// Draws an estimator's marks, each in the 95 % ellipse of its position where
/// there is a covariance.
pub(crate) fn draw_marks(
    canvas: &mut Canvas,
    axes: &Axes,
    (trace, time): (&RunTrace, &Timeline),
    estimator: usize,
) {
    let look = Look::of(estimator, trace.names.len());
    let given = |&tick: &usize| trace.estimate(estimator, tick).is_some();
    let last = (0..trace.tick_count()).rev().find(given);
    let marks: Vec<(usize, f64)> =
        time.marks(trace, estimator).into_iter().map(|tick| (tick, 4.2)).collect();
    let marks = || marks.iter().copied().chain(last.map(|tick| (tick, 5.4)));
    for (tick, _) in marks() {
        let stop = trace.time_s.get(tick).and_then(|&time_s| stop_at(trace, time_s));
        let Some(estimate) = stop.and_then(|stop| stop.estimate(estimator)) else { continue };
        let Some(ellipse) = bands::ellipse_m(estimate) else { continue };
        let around = outline(place_m(&estimate.pose_in_world), ellipse);
        draw_line(canvas, axes, &around, (&look.ink, 1.3));
    }
    for (tick, size) in marks() {
        let at = trace.estimate(estimator, tick).map(|pose| axes.px(place_m(&pose)));
        if let Some(at) = at.filter(|&at| axes.holds(at)) {
            look.mark(canvas, at, size);
        }
    }
}

/// The first stop that is not before this time, or the last.
fn stop_at(trace: &RunTrace, time_s: f64) -> Option<&Stop> {
    let next = trace.stops.partition_point(|stop| stop.time_s < time_s);
    trace.stops.get(next).or(trace.stops.last())
}

/// Draws where the robot truly started and stopped.
pub(crate) fn draw_ends(canvas: &mut Canvas, axes: &Axes, trace: &RunTrace) {
    let mut ticks = 0..trace.tick_count();
    let first = ticks.find_map(|tick| trace.true_pose(tick));
    let last = (0..trace.tick_count()).rev().find_map(|tick| trace.true_pose(tick));
    for (pose, started) in [(first, true), (last, false)] {
        if let Some(pose) = pose {
            draw_robot(canvas, axes.px(place_m(&pose)), pose.theta(), started);
        }
    }
}

/// How the poses of a filter's belief are drawn: in its colour, and one that is
/// no estimator of this run in one of those after them.
pub(crate) fn possible_look(trace: &RunTrace, track: usize) -> Look {
    let known = trace.names.iter().position(|name| *name == trace.beliefs[track].name);
    Look::of(known.unwrap_or(trace.names.len() + track), trace.names.len())
}

/// How much of the colour of a bar is its own.
pub(crate) const BAR_OPACITY: f64 = 0.6;
/// Corners of an arrowhead that looks along x, and its size, units of the page.
const HEAD: [[f64; 2]; 3] = [[1.0, 0.0], [-0.8, 0.62], [-0.8, -0.62]];
const HEAD_SIZE: f64 = 5.4;

/// Draws a pose that is held possible.
pub(crate) fn draw_possible(canvas: &mut Canvas, look: &Look, at: Px, mark: &Mark) {
    let (s, c) = trig::sin_cos(f64::from(mark.theta_rad));
    let size = HEAD_SIZE * (0.3 + 0.7 * f64::from(mark.share).sqrt());
    let corner =
        |[u, v]: [f64; 2]| [at[0] + size * (c * u - s * v), at[1] - size * (s * u + c * v)];
    canvas.wash(&HEAD.map(corner), &look.ink, 0.4)
}

/// More poses than this in one unit of the page are as opaque as this many.
const MOST_IN_PLACE: u32 = 6;

/// Draws the last belief of each filter that showed any, as far as it is in
/// the map: bars along a corridor, otherwise arrowheads.
pub(crate) fn draw_beliefs(canvas: &mut Canvas, axes: &Axes, trace: &RunTrace) {
    for (k, track) in trace.beliefs.iter().enumerate() {
        let look = possible_look(trace, k);
        let Some(moment) = track.moments.last() else { continue };
        if let Some(bars) = bars(moment) {
            let corners = bars.iter().map(|bar| bar.map(|at| axes.px(at)));
            let seen = corners.filter(|bar| (bar[2][1] - bar[1][1]).abs() > 0.1);
            seen.for_each(|bar| canvas.wash(&bar, &look.ink, BAR_OPACITY));
            continue;
        }
        let mut drawn = BTreeMap::new();
        for mark in &moment.marks {
            let at = axes.px([mark.x_m, mark.y_m].map(f64::from));
            let there: &mut u32 = drawn.entry(at.map(|v| v as i64)).or_default();
            *there += 1;
            if axes.holds(at) && *there <= MOST_IN_PLACE {
                draw_possible(canvas, &look, at, mark);
            }
        }
    }
}

/// Draws a point of a scan: to be seen on white and on a dark wall.
pub(crate) fn draw_echo(canvas: &mut Canvas, at: Px) {
    canvas.disc(at, 2.6, &INK);
    canvas.disc(at, 1.7, &SCAN)
}

fn draw_path(
    canvas: &mut Canvas,
    axes: &Axes,
    path: &[(usize, [f64; 2])],
    style: (&RGBColor, f64),
) {
    for line in polyline::runs(path) {
        match line[..] {
            [at] if axes.holds(axes.px(at)) => canvas.disc(axes.px(at), 0.5 * style.1, style.0),
            _ => draw_line(canvas, axes, &line, style),
        }
    }
}

/// Where the beams of the last scan ended, world frame, m: true pose of its tick,
/// then the sensor's pose on the body, then the beam. Beams from which nothing
/// came back are left out.
fn scan_points_m(trace: &RunTrace) -> Vec<[f64; 2]> {
    let Some((tick, ranges_m)) = &trace.last_scan else {
        return Vec::new();
    };
    let Some(body) = trace.true_pose(*tick) else {
        return Vec::new();
    };
    let lidar = &trace.lidar;
    let sensor = body * lidar.sensor_in_body;
    let mut points = Vec::new();
    for (k, &range_m) in (0u32..).zip(ranges_m) {
        if !(range_m > 0.0 && range_m < lidar.range_max_m) {
            continue;
        }
        let (s, c) = trig::sin_cos(lidar.bearing_rad(k));
        let point = sensor.transform_point(&Point2::new(range_m * c, range_m * s));
        if point.x.is_finite() && point.y.is_finite() {
            points.push([point.x, point.y]);
        }
    }
    points
}

fn places_m(trace: &RunTrace, pose_at: impl Fn(usize) -> Option<SE2>) -> Vec<(usize, [f64; 2])> {
    let known = |tick| pose_at(tick).map(|pose| (tick, place_m(&pose)));
    (0..trace.tick_count()).filter_map(known).collect()
}

/// Where a pose is drawn, m.
pub(crate) fn place_m(pose: &SE2) -> [f64; 2] {
    [pose.x().clamp(-FARTHEST_M, FARTHEST_M), pose.y().clamp(-FARTHEST_M, FARTHEST_M)]
}

#[cfg(test)]
mod tests {
    use super::super::trace::tests::empty;
    use super::*;

    #[test]
    fn a_scan_is_drawn_from_the_sensor_on_the_true_body() {
        let mut trace = empty(&[]);
        trace.lidar.beams = 4;
        trace.lidar.sensor_in_body = SE2::new(1.0, 0.0, 0.0);
        let north = Some(SE2::new(10.0, 0.0, core::f64::consts::FRAC_PI_2));
        // Beams look back, right, ahead, left; ahead nothing came back.
        let scan = [3.0, 2.0, 8.0, f64::NAN];
        trace.push(0.1, north, Some(&scan), std::iter::empty());
        trace.push(0.2, Some(SE2::identity()), None, std::iter::empty());
        let points = scan_points_m(&trace);
        let expected = [[10.0, -2.0], [12.0, 1.0]];
        assert_eq!(points.len(), expected.len());
        for (point, expected) in points.iter().zip(expected) {
            assert!(trig::hypot(point[0] - expected[0], point[1] - expected[1]) < 1e-12);
        }
        trace.truth[0] = None;
        assert!(scan_points_m(&trace).is_empty());
    }

    #[test]
    fn an_estimate_that_ran_away_does_not_shrink_the_map() {
        let mut trace = empty(&["a"]);
        for k in 0..10 {
            let x_m = f64::from(k);
            let truth = Some(SE2::new(x_m, 0.0, 0.0));
            let estimate = Some(SE2::new(x_m * 1e6, f64::MAX, 0.0));
            trace.push(x_m, truth, None, [estimate].into_iter());
        }
        let view = View::of(&trace);
        assert!(view.x_m[0] > -6.0 && view.x_m[1] < 15.0, "{:?}", view.x_m);
        assert!(view.y_m[0] > -6.0 && view.y_m[1] < 6.0, "{:?}", view.y_m);
    }

    #[test]
    fn an_empty_run_has_a_map_of_some_size() {
        let view = View::of(&empty(&["a"]));
        assert_eq!((view.x_m, view.y_m, view.aspect()), ([-0.5, 0.5], [-0.5, 0.5], 1.0));
    }
}
