//! A run on one page: map, legend, scores, and the errors over time; next to
//! them what the covariances promised, where any were reported.
//!
//! A white card with dark ink, 1200 units wide and up to about 1250 high; wide
//! worlds make a lower map. Lengths are in metres and equal along both axes of
//! the map, times in seconds, headings in degrees. Text asks for "sans-serif".
//!
//! A path has at most about 2000 points, however long the run, and a curve 1000: those
//! that are needed to see no difference, and of an error its peaks. Of a run of
//! more than 131,072 ticks not all are here to be drawn ([`super::keeper`]): the
//! line below the title says how many, and a peak between two of them is not
//! seen. Ellipses, bands and NEES are drawn of at most 1536 ticks
//! ([`super::stops`]).

use rusty_contract::score::Score;
use rusty_plot::page::{Legend, draw_title};
use rusty_plot::{Canvas, Look, Rect, paint, shortened};

use super::chart::{Chart, Kind};
use super::map::{self, View};
use super::panel::Panel;
use super::timeline::Timeline;
use super::trace::{RunTrace, Whole};

const WIDTH: f64 = 1200.0;
const MARGIN_LEFT: f64 = 72.0;
const MARGIN_RIGHT: f64 = 24.0;
const MAP_TOP: f64 = 78.0;
const MAP_RIGHT: f64 = 772.0;
const PANEL_LEFT: f64 = 800.0;
/// Heights of the map: at least, at most.
const MAP_HEIGHTS: [f64; 2] = [300.0, 540.0];
const PLOT_HEIGHT: f64 = 150.0;
/// Most points of a curve, for some 1100 units of width.
const MOST_POINTS: usize = 1000;
/// Longest text of a title, characters.
const LONGEST_TITLE: usize = 72;

/// Draws a run as the text of an SVG file. `scores` are those of
/// [`score`](super::score), found by name; an estimator without one has dashes
/// in the table.
///
/// Any trace can be drawn: without walls, truth, estimates or ticks, and with
/// numbers that are none. An estimate that runs far off the map is cut at its
/// edge, and the picture says so.
pub fn svg(trace: &RunTrace, scores: &[Score]) -> String {
    let time = Timeline::of(trace);
    let view = View::of(trace);
    let panel = Panel::new(trace, scores, &view, &time);
    let [least, most] = MAP_HEIGHTS;
    let width = MAP_RIGHT - MARGIN_LEFT;
    let map_height = (width * view.aspect()).min(most).max(least).max(panel.height());
    let map = Rect {
        left: MARGIN_LEFT,
        top: MAP_TOP,
        right: MAP_RIGHT,
        bottom: MAP_TOP + map_height.round(),
    };
    let beside = Rect { left: PANEL_LEFT, right: WIDTH - MARGIN_RIGHT, ..map };
    let plot = |top: f64| Rect {
        left: MARGIN_LEFT,
        top,
        right: WIDTH - MARGIN_RIGHT,
        bottom: top + PLOT_HEIGHT,
    };
    let charts = charts(trace, &time, map.bottom + 76.0, plot);
    let bottom = charts.last().map_or(map.bottom, |(frame, _)| frame.bottom);
    let title = headline(trace);
    paint((WIDTH, bottom + 50.0), &title, |canvas| {
        draw_title(canvas, MARGIN_LEFT, &title, &details(trace, &time));
        let left_map = draw_map(canvas, &view, map, (trace, &time));
        panel.draw(canvas, &beside, &time, left_map);
        draw_charts(canvas, &charts, trace);
    })
}

/// The charts below the map, from `top` on, with their frames.
fn charts<'a>(
    trace: &'a RunTrace,
    time: &'a Timeline,
    mut top: f64,
    plot: impl Fn(f64) -> Rect,
) -> Vec<(Rect, Chart<'a>)> {
    let kinds: &[Kind] = match trace.has_covariances() && trace.ticks_with_truth() > 0 {
        true => &[Kind::Position, Kind::Heading, Kind::Nees],
        false => &[Kind::Position, Kind::Heading],
    };
    let mut charts = Vec::new();
    for &kind in kinds {
        let frame = plot(top);
        charts.push((frame, Chart::new(kind, frame, (trace, time), MOST_POINTS, 12.0)));
        top = frame.bottom + 34.0;
    }
    charts
}

fn draw_map(
    canvas: &mut Canvas,
    view: &View,
    frame: Rect,
    (trace, time): (&RunTrace, &Timeline),
) -> bool {
    let axes = view.axes(frame);
    map::draw_ground(canvas, &axes, trace);
    map::draw_beliefs(canvas, &axes, trace);
    view.draw_scan(canvas, &axes);
    let mut left = false;
    for i in 0..trace.names.len() {
        left |= map::draw_believed(canvas, &axes, trace, i);
    }
    map::draw_ends(canvas, &axes, trace);
    for i in 0..trace.names.len() {
        map::draw_marks(canvas, &axes, (trace, time), i);
    }
    left
}

/// Draws the charts, the time below the last of them.
fn draw_charts(canvas: &mut Canvas, charts: &[(Rect, Chart<'_>)], trace: &RunTrace) {
    for (k, (frame, chart)) in charts.iter().enumerate() {
        chart.draw_ground(canvas, k + 1 == charts.len());
        for i in 0..trace.names.len() {
            chart.draw_band(canvas, i);
        }
        for i in 0..trace.names.len() {
            chart.draw_curve(canvas, i);
        }
        if k == 0 {
            draw_legend(canvas, frame, trace);
        }
    }
}

/// Names and marks in the line above a plot, from its right edge, as long as
/// they leave room for the title; the table next to the map has them all.
fn draw_legend(canvas: &mut Canvas, frame: &Rect, trace: &RunTrace) {
    let total: f64 = trace.names.iter().map(|name| Legend::width(name)).sum();
    if total > frame.width() - 200.0 {
        return;
    }
    let mut legend = Legend { at: [frame.right - total, frame.top - 12.0] };
    for (i, name) in trace.names.iter().enumerate() {
        legend.estimator(canvas, name, &Look::of(i, trace.names.len()));
    }
}

/// Scenario, and what identifies the run.
fn headline(trace: &RunTrace) -> String {
    let mut title = shortened(&trace.scenario, LONGEST_TITLE - 24);
    if let Some(seed) = trace.seed {
        title.push_str(&format!(" · seed {seed}"));
    }
    if !trace.digest.is_empty() {
        title.push_str(" · digest ");
        title.extend(trace.digest.chars().take(12));
    }
    title
}

fn details(trace: &RunTrace, time: &Timeline) -> String {
    let Whole { ticks, ticks_with_truth, driven_m } = trace.whole();
    let mut parts = vec![format!("{ticks} tick{}", if ticks == 1 { "" } else { "s" })];
    if ticks_with_truth < ticks {
        parts.push(format!("{ticks_with_truth} with a known truth"));
    }
    if trace.thinned_from.is_some() {
        parts.push(format!("{} drawn", trace.tick_count()));
    }
    if ticks > 1 && !trace.is_in_ticks {
        parts.push(format!("{:.1} s", time.span_s()));
    }
    if ticks_with_truth > 1 {
        parts.push(format!("{driven_m:.1} m driven"));
    }
    if !trace.world.name.is_empty() {
        parts.push(format!("world {}", shortened(&trace.world.name, 40)));
    }
    parts.join(" · ")
}

#[cfg(test)]
#[path = "picture_tests.rs"]
mod tests;
