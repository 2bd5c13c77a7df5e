//! The map and the charts over time, as they are without a script: the whole run. The
//! player draws the map of a tick in place of it, and moves the cursors of the charts.
//!
//! Classes: `e` and `eK` is what belongs to estimator K; `cursor` shows the chosen tick on
//! a chart.

use rusty_contract::log::LogHeader;
use rusty_plot::style::INK;
use rusty_plot::{Axes, Drawing, Layer, Rect};

use super::beliefs::Beliefs;
use super::data;
use crate::scoring::chart::{Chart, Kind};
use crate::scoring::map::{self, View};
use crate::scoring::timeline::Timeline;
use crate::scoring::trace::RunTrace;

/// Narrow enough that what is written can be read on a phone.
const MAP_WIDTH: f64 = 560.0;
const CHART: (f64, f64) = (480.0, 236.0);
/// Heights of the map: at least, at most.
const MAP_HEIGHTS: [f64; 2] = [200.0, 640.0];
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
    /// Width and height of what the map shows, m.
    pub size_m: [f64; 2],
    /// Whether a believed path leaves the map.
    pub left_map: bool,
    /// What is said of beliefs below the map, and of those shown at first; empty
    /// where there are none.
    pub possible: String,
    pub possible_now: String,
}

impl Figures {
    pub fn of(header: &LogHeader, trace: &RunTrace) -> Self {
        let time = Timeline::of(trace);
        // The end, as far as the truth is known.
        let known = trace.stops.iter().rposition(|stop| stop.truth.is_some());
        let shown = known.unwrap_or(trace.stops.len().saturating_sub(1));
        let view = View::of(trace);
        let beliefs = Beliefs::of(trace);
        let (map, left_map) = draw_map(trace, &time, &view);
        let at_s = trace.stops.get(shown).and_then(|stop| time.place_s(stop.time_s));
        let chart = |kind| draw_chart(trace, &time, kind, at_s);
        let errors = [chart(Kind::Position), chart(Kind::Heading)].map(|(text, _)| text);
        let nees = chart(Kind::Nees);
        let bounds_m = view.bounds_m();
        Self {
            map,
            errors,
            nees: (!nees.1).then_some(nees.0),
            data: data::json(header, trace, &time, (bounds_m, &beliefs), chart_frame()),
            shown,
            now: data::now(trace, &time, shown),
            size_m: [bounds_m[2] - bounds_m[0], bounds_m[3] - bounds_m[1]],
            left_map,
            possible: beliefs.caption(),
            possible_now: beliefs.now(trace.stops.get(shown).map_or(0, |stop| stop.tick)),
        }
    }
}

/// The axes of a map, and the size of the drawing around it.
pub(super) fn map_axes(view: &View) -> (Axes, (f64, f64)) {
    let width = MAP_WIDTH - 78.0;
    let height = (width * view.aspect()).clamp(MAP_HEIGHTS[0], MAP_HEIGHTS[1]).round();
    let frame = Rect { left: 62.0, top: 10.0, right: MAP_WIDTH - 16.0, bottom: 10.0 + height };
    (view.axes(frame), (MAP_WIDTH, frame.bottom + 50.0))
}

/// The map of the whole run, and whether an estimate leaves it.
fn draw_map(trace: &RunTrace, time: &Timeline, view: &View) -> (String, bool) {
    let (axes, size) = map_axes(view);
    let frame = axes.frame;
    let mut drawing = Drawing::new(size, "whole");
    drawing.layer(&Layer::of("ground"), |canvas| map::draw_ground(canvas, &axes, trace));
    drawing.layer(&Layer::of("belief").within(frame), |canvas| {
        map::draw_beliefs(canvas, &axes, trace)
    });
    drawing.layer(&Layer::of("scan"), |canvas| view.draw_scan(canvas, &axes));
    let mut left_map = false;
    for i in 0..trace.names.len() {
        drawing.layer(&Layer::of(format!("e e{i}")).within(frame), |canvas| {
            left_map |= map::draw_believed(canvas, &axes, trace, i);
        });
    }
    drawing.layer(&Layer::of("ends"), |canvas| map::draw_ends(canvas, &axes, trace));
    for i in 0..trace.names.len() {
        drawing.layer(&Layer::of(format!("e e{i}")).within(frame), |canvas| {
            map::draw_marks(canvas, &axes, (trace, time), i)
        });
    }
    let who = trace.names.join(", ");
    let text = format!("The floor seen from above, with the true path and those of: {who}");
    (drawing.finish("Map of the run", &text, ""), left_map)
}

/// Where a chart's data lie on it.
fn chart_frame() -> Rect {
    Rect { left: 62.0, top: 28.0, right: CHART.0 - 22.0, bottom: CHART.1 - 48.0 }
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
    let cursor = match place {
        Some(at) => Layer::of("cursor").moved([1.0, 0.0, 0.0, 1.0], at),
        None => Layer::of("cursor gone"),
    };
    drawing
        .layer(&cursor, |canvas| canvas.line(&[[0.0, frame.top], [0.0, frame.bottom]], &INK, 1.2));
    let text = format!("{} of: {}", kind.title(), trace.names.join(", "));
    (drawing.finish(title, &text, "class=\"chart\""), chart.is_empty())
}
