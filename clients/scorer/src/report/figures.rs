//! The map and the charts over time, in layers that the page's script can move.
//!
//! Classes: `e` and `eK` is what belongs to estimator K; `robot`, `scan`, and of
//! each estimator `ellipse`, `nose` and `mark`, show the chosen tick on the map;
//! `cursor` shows it on a chart.

use rusty_geometry::{SE2, trig};
use rusty_plot::ellipse::circle;
use rusty_plot::floor::draw_robot;
use rusty_plot::style::{INK, Look, WHITE};
use rusty_plot::{Axes, Drawing, Layer, Px, Rect};

use super::beliefs::Beliefs;
use super::data::{self, Scans};
use super::units::units_per_m;
use crate::scoring::bands;
use crate::scoring::chart::{Chart, Kind};
use crate::scoring::map::{self, View, place_m};
use crate::scoring::stops::Stop;
use crate::scoring::timeline::Timeline;
use crate::scoring::trace::RunTrace;

/// Narrow enough that what is written can be read on a phone.
const MAP_WIDTH: f64 = 560.0;
const CHART: (f64, f64) = (480.0, 236.0);
/// Heights of the map: at least, at most.
const MAP_HEIGHTS: [f64; 2] = [200.0, 640.0];
/// Radius of the circle that an ellipse is made of, units of the page.
const CIRCLE: f64 = 10.0;
/// Points of all curves of a chart together, and of one of them at least and at
/// most.
const ALL_POINTS: usize = 4000;
const POINTS: [usize; 2] = [250, 1000];

/// What is drawn of a run.
pub(super) struct Figures {
    pub map: String,
    pub errors: [String; 2],
    /// `None` where there is nothing to compare.
    pub nees: Option<String>,
    /// What the page's script needs.
    pub data: String,
    /// Index of the stop that is shown at first, and its words.
    pub shown: usize,
    pub now: String,
    /// Whether a believed path leaves the map.
    pub left_map: bool,
    /// What is said of beliefs below the map, and of those shown at first; empty
    /// where there are none.
    pub possible: String,
    pub possible_now: String,
}

/// Where something lies that shows the chosen tick; nowhere where it is not
/// known.
fn placed(layer: Layer, place: Option<([f64; 4], Px)>) -> Layer {
    match place {
        Some((matrix, to)) => layer.moved(matrix, to),
        None => Layer { class: format!("{} gone", layer.class), ..layer },
    }
}

/// A turn by the heading of a pose, and its place on the page.
fn turned(axes: &Axes, pose: &SE2) -> ([f64; 4], Px) {
    let (s, c) = trig::sin_cos(pose.theta());
    ([c, -s, s, c], axes.px(place_m(pose)))
}

impl Figures {
    pub fn of(trace: &RunTrace) -> Self {
        let time = Timeline::of(trace);
        // The end, as far as the truth is known.
        let known = trace.stops.iter().rposition(|stop| stop.truth.is_some());
        let shown = known.unwrap_or(trace.stops.len().saturating_sub(1));
        let scans = Scans::of(trace);
        let (axes, _) = map_axes(trace);
        let beliefs = Beliefs::of(trace);
        let (map, left_map) = draw_map(trace, &time, &axes, (&scans, &beliefs), shown);
        let at_s = trace.stops.get(shown).and_then(|stop| time.place_s(stop.time_s));
        let chart = |kind| draw_chart(trace, &time, kind, at_s);
        let errors = [chart(Kind::Position), chart(Kind::Heading)].map(|(text, _)| text);
        let nees = chart(Kind::Nees);
        Self {
            map,
            errors,
            nees: (!nees.1).then_some(nees.0),
            data: data::json(trace, &time, &axes, (&scans, &beliefs), chart_frame()),
            shown,
            now: data::now(trace, &time, shown),
            left_map,
            possible: beliefs.caption(),
            possible_now: beliefs.now(trace.stops.get(shown).map_or(0, |stop| stop.tick)),
        }
    }
}

/// The axes of a map of the run, and the size of the drawing around it.
pub(super) fn map_axes(trace: &RunTrace) -> (Axes, (f64, f64)) {
    let view = View::of(trace);
    let width = MAP_WIDTH - 78.0;
    let height = (width * view.aspect()).clamp(MAP_HEIGHTS[0], MAP_HEIGHTS[1]).round();
    let frame = Rect { left: 62.0, top: 10.0, right: MAP_WIDTH - 16.0, bottom: 10.0 + height };
    (view.axes(frame), (MAP_WIDTH, frame.bottom + 50.0))
}

fn draw_map(
    trace: &RunTrace,
    time: &Timeline,
    axes: &Axes,
    (scans, beliefs): (&Scans, &Beliefs<'_>),
    shown: usize,
) -> (String, bool) {
    let frame = axes.frame;
    let stop = trace.stops.get(shown);
    let mut drawing = Drawing::new((MAP_WIDTH, frame.bottom + 50.0), "map");
    drawing.layer(&Layer::of("ground"), |canvas| map::draw_ground(canvas, axes, trace));
    for i in (0..trace.names.len()).filter(|&i| trace.reports_covariance(i)) {
        draw_ellipse(&mut drawing, axes, stop, (i, trace.names.len()));
    }
    beliefs.draw(&mut drawing, axes, stop.map_or(0, |stop| stop.tick));
    drawing.layer(&Layer::of("scan").within(frame), |canvas| {
        let nowhere = [-1000.0; 2];
        scans
            .points_px(trace, axes, shown)
            .into_iter()
            .for_each(|at| map::draw_echo(canvas, at.unwrap_or(nowhere)))
    });
    let mut left_map = false;
    for i in 0..trace.names.len() {
        drawing.layer(&Layer::of(format!("e e{i}")).within(frame), |canvas| {
            left_map |= map::draw_believed(canvas, axes, trace, i);
            map::draw_marks(canvas, axes, (trace, time), i)
        });
    }
    drawing.layer(&Layer::of("start").within(frame), |canvas| {
        if let Some(pose) = (0..trace.tick_count()).find_map(|tick| trace.true_pose(tick)) {
            draw_robot(canvas, axes.px(place_m(&pose)), pose.theta(), true);
        }
    });
    let truth = stop.and_then(|stop| stop.truth).map(|pose| turned(axes, &pose));
    let robot = placed(Layer::of("robot").within(frame), truth);
    drawing.layer(&robot, |canvas| draw_robot(canvas, [0.0; 2], 0.0, false));
    for i in 0..trace.names.len() {
        draw_estimate(&mut drawing, axes, stop, (i, trace.names.len()));
    }
    let who = trace.names.join(", ");
    let text = format!("The floor seen from above, with the true path and those of: {who}");
    (drawing.finish("Map of the run", &text, ""), left_map)
}

/// The ellipse at the chosen tick: what a circle becomes.
fn draw_ellipse(
    drawing: &mut Drawing,
    axes: &Axes,
    stop: Option<&Stop>,
    (i, count): (usize, usize),
) {
    let look = Look::of(i, count);
    let place = stop.and_then(|stop| stop.estimate(i)).and_then(|estimate| {
        let [xx, yx, yy] = bands::ellipse_m(estimate)?.map(|m| m * units_per_m(axes) / CIRCLE);
        Some(([xx, -yx, 0.0, yy], axes.px(place_m(&estimate.pose_in_world))))
    });
    let layer = placed(Layer::of(format!("e e{i} ellipse")).within(axes.frame), place);
    drawing.layer(&layer, |canvas| {
        let around = circle([0.0; 2], CIRCLE);
        canvas.wash(&around, &look.ink, 0.18);
        canvas.line(&around, &look.ink, 1.6)
    })
}

/// The estimate at the chosen tick: which way it looks, and its mark.
fn draw_estimate(
    drawing: &mut Drawing,
    axes: &Axes,
    stop: Option<&Stop>,
    (i, count): (usize, usize),
) {
    let look = Look::of(i, count);
    let place = stop
        .and_then(|stop| stop.estimate(i))
        .map(|estimate| turned(axes, &estimate.pose_in_world));
    let layer = |what: &str| Layer::of(format!("e e{i} {what}")).within(axes.frame);
    drawing.layer(&placed(layer("nose"), place), |canvas| {
        let nose = [[0.0, 0.0], [17.0, 0.0]];
        canvas.line(&nose, &WHITE, 5.0);
        canvas.line(&nose, &look.ink, 2.6)
    });
    // A mark keeps upright, or one could be taken for another.
    let upright = place.map(|(_, at)| ([1.0, 0.0, 0.0, 1.0], at));
    drawing.layer(&placed(layer("mark"), upright), |canvas| look.mark(canvas, [0.0; 2], 6.2))
}

/// Where a chart's data lie on it.
fn chart_frame() -> Rect {
    Rect { left: 62.0, top: 28.0, right: CHART.0 - 12.0, bottom: CHART.1 - 48.0 }
}

/// A chart, and whether there is nothing on it.
fn draw_chart(trace: &RunTrace, time: &Timeline, kind: Kind, at_s: Option<f64>) -> (String, bool) {
    let count = trace.names.len();
    let points = (ALL_POINTS / count.max(1)).clamp(POINTS[0], POINTS[1]);
    let frame = chart_frame();
    let chart = Chart::new(kind, frame, (trace, time), points, 8.0);
    let (id, title) = match kind {
        Kind::Position => ("position", "Position error over time"),
        Kind::Heading => ("heading", "Heading error over time"),
        Kind::Nees => ("nees", "Normalised squared error over time"),
    };
    let mut drawing = Drawing::new(CHART, id);
    drawing.layer(&Layer::of("ground"), |canvas| chart.draw_ground(canvas, true));
    for i in 0..count {
        let layer = Layer::of(format!("e e{i}")).within(frame);
        drawing.layer(&layer, |canvas| chart.draw_band(canvas, i));
    }
    for i in 0..count {
        // Marks may reach over the frame.
        drawing.layer(&Layer::of(format!("e e{i}")), |canvas| chart.draw_curve(canvas, i));
    }
    let share = |at_s: f64| (at_s - time.range_s[0]) / time.span_s();
    let place = at_s.map(|at_s| [frame.left + share(at_s) * frame.width(), 0.0]);
    let cursor = placed(Layer::of("cursor"), place.map(|at| ([1.0, 0.0, 0.0, 1.0], at)));
    drawing
        .layer(&cursor, |canvas| canvas.line(&[[0.0, frame.top], [0.0, frame.bottom]], &INK, 1.2));
    let text = format!("{} of: {}", kind.title(), trace.names.join(", "));
    (drawing.finish(title, &text, "class=\"chart\""), chart.is_empty())
}
