//! The fan: the paths of all seeds on the floor.
//!
//! Believed paths have the colour of their estimator, true ones are dark; in
//! front lies what spreads less. Where the robot is driven blindly (open loop)
//! the belief is nearly one line and the truth fans out; where it is steered on
//! the truth, the truth is nearly one line and the beliefs fan out. An ellipse
//! holds 95 % of a normal distribution with the mean and covariance of the last
//! places; what the places do that it does not is what a Gaussian cannot say.

use std::collections::BTreeSet;

use rusty_geometry::trig;
use rusty_plot::ellipse::{ellipse, outline};
use rusty_plot::floor::{Extent, draw_robot, draw_walls};
use rusty_plot::page::{Legend, draw_title};
use rusty_plot::style::{INK, Look, RGBColor, SOFT_INK, WHITE};
use rusty_plot::{Anchor, Axes, Canvas, Px, Rect, paint, shortened};

use super::super::lines::setting;
use super::super::plan::SAMPLES;
use super::super::{Cell, Sample, Swept, Track};
use super::seeds_of;
use crate::page::{MARGIN_LEFT, MARGIN_RIGHT, TOP, WIDTH};
use rusty_metrics::Moments;

/// Most panels; the rest of the cells is left out, and the page says so.
const MOST_PANELS: usize = 6;
/// Most paths of an estimator in a panel.
const MOST_PATHS: usize = 150;
/// Heights of a panel: at least, at most.
const HEIGHTS: [f64; 2] = [150.0, 460.0];
const GAP_X: f64 = 74.0;
const GAP_Y: f64 = 84.0;
/// Height of the legend, of one line.
const LEGEND: f64 = 30.0;

/// Draws the fan of a sweep as the text of an SVG file.
pub fn fan(swept: &Swept) -> String {
    let with_tracks: BTreeSet<usize> = swept.tracks.iter().map(|t| t.cell).collect();
    let mut panels: Vec<usize> = with_tracks.into_iter().collect();
    let left_out = panels.len().saturating_sub(MOST_PANELS);
    panels.truncate(MOST_PANELS);
    let estimators = names(&swept.tracks);
    let view = view_of(&swept.tracks, &panels);
    let legend = legend(&estimators);
    let layout = Layout::of(panels.len().max(1), legend_height(&legend), &view);
    let title = match swept.cells.first() {
        Some(cell) => format!("Fan of {}", shortened(&cell.config.scenario, 48)),
        None => "Fan of nothing".to_owned(),
    };
    let details = details(swept, left_out);
    paint((WIDTH, layout.height()), &title, |canvas| {
        draw_title(canvas, MARGIN_LEFT, &title, &details);
        draw_legend(canvas, &legend, estimators.len());
        for (place, &cell) in panels.iter().enumerate() {
            let axes = Axes::equal(layout.frame(place), view.x(), view.y(), 10.0);
            let panel = Panel { axes, swept, cell, estimators: &estimators };
            panel.draw(canvas, panels.len() > 1);
        }
        if panels.is_empty() {
            let middle = [0.5 * WIDTH, TOP + layout.legend + 60.0];
            canvas.text(middle, Anchor::Middle, 14.0, &SOFT_INK, "no run has a track");
        }
    })
}

fn details(swept: &Swept, left_out: usize) -> String {
    let mut parts = vec![seeds_of(&swept.tracks)];
    if let Some(config) = swept.cells.first().map(|c| &c.config) {
        parts.push(format!("{:.1} s", config.ticks as f64 * config.dt_s));
        parts.push(format!("world {}", shortened(&config.world.name, 40)));
    }
    let per_cell = |cell| swept.tracks.iter().filter(|t| t.cell == cell).count();
    if (0..swept.cells.len()).any(|cell| per_cell(cell) > MOST_PATHS * names(&swept.tracks).len()) {
        parts.push(format!("{MOST_PATHS} of the paths drawn, every end"));
    }
    if left_out > 0 {
        parts.push(format!("{left_out} more settings not shown"));
    }
    parts.join(" · ")
}

/// The estimators, in the order in which they come.
fn names(tracks: &[Track]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for track in tracks {
        if !names.iter().any(|n| **n == *track.estimator) {
            names.push(track.estimator.to_string());
        }
    }
    names
}

/// What the panels show, the same for all: every true path, and beliefs as far
/// as they stay within as much again.
fn view_of(tracks: &[Track], panels: &[usize]) -> Extent {
    let shown = || tracks.iter().filter(|t| panels.contains(&t.cell)).flat_map(|t| &t.samples);
    let mut core = Extent::default();
    shown().for_each(|s| core.include([s.truth.x(), s.truth.y()]));
    if core.is_empty() {
        core.include([0.0, 0.0]);
    }
    let near_by = core.grown(core.size().max(1.0));
    let mut whole = core;
    shown().filter(|s| s.estimate.is_finite()).for_each(|s| {
        whole.include(near_by.nearest([s.estimate.x(), s.estimate.y()]));
    });
    whole.grown((0.06 * whole.size()).max(0.12))
}

/// Where the panels are on the page.
struct Layout {
    columns: usize,
    rows: usize,
    width: f64,
    panel_height: f64,
    /// Height of the legend above the panels.
    legend: f64,
}

impl Layout {
    fn of(count: usize, legend: f64, view: &Extent) -> Self {
        let aspect = (view.y()[1] - view.y()[0]) / (view.x()[1] - view.x()[0]);
        // Wide scenes stand below each other, others side by side.
        let columns = match count {
            1 => 1,
            2 | 4 if aspect > 0.25 => 2,
            2..=4 => 1,
            _ if aspect > 0.5 => 3,
            _ => 2,
        };
        let room = WIDTH - MARGIN_LEFT - MARGIN_RIGHT - GAP_X * (columns - 1) as f64;
        let width = room / columns as f64;
        let panel_height = (width * aspect).clamp(HEIGHTS[0], HEIGHTS[1]).round();
        Self { columns, rows: count.div_ceil(columns), width, panel_height, legend }
    }

    fn frame(&self, place: usize) -> Rect {
        let left = MARGIN_LEFT + (self.width + GAP_X) * (place % self.columns) as f64;
        let down = (self.panel_height + GAP_Y) * (place / self.columns) as f64;
        let top = TOP + self.legend + 24.0 + down;
        Rect { left, top, right: left + self.width, bottom: top + self.panel_height }
    }

    fn height(&self) -> f64 {
        TOP + self.legend + 24.0 + (self.panel_height + GAP_Y) * self.rows as f64 - GAP_Y + 56.0
    }
}

/// What the legend names, each with its place.
fn legend(estimators: &[String]) -> Vec<(String, Legend)> {
    let believed = estimators.iter().map(|name| format!("believed by {}", shortened(name, 28)));
    let first = ["start", "true paths and their ends"].map(str::to_owned);
    let last = "95 % if the ends were normal".to_owned();
    let names: Vec<String> = first.into_iter().chain(believed).chain([last]).collect();
    let at = [MARGIN_LEFT, TOP + 2.0];
    let places = Legend::wrapped(names.iter().map(|name| &**name), at, WIDTH);
    let places: Vec<Legend> = places.collect();
    names.into_iter().zip(places).collect()
}

fn legend_height(legend: &[(String, Legend)]) -> f64 {
    let last = legend.last().map_or(TOP + 2.0, |(_, place)| place.at[1]);
    LEGEND + last - TOP - 2.0
}

fn draw_legend(canvas: &mut Canvas, legend: &[(String, Legend)], estimators: usize) {
    let path = |canvas: &mut Canvas, [x, y]: Px, ink: &RGBColor| {
        let end = [x + Legend::SWATCH, y];
        canvas.line(&[[x, y], end], ink, 2.0);
        draw_end(canvas, end, ink);
    };
    for (i, (name, place)) in legend.iter().enumerate() {
        let mut place = *place;
        place.entry(canvas, name, |c, [x, y]| match i {
            0 => draw_robot(c, [x + 12.0, y], 0.0, true),
            1 => path(c, [x, y], &INK),
            _ if i - 2 < estimators => path(c, [x, y], &Look::of(i - 2, estimators).ink),
            _ => c.dashes(&[[x, y], [x + Legend::SWATCH, y]], &SOFT_INK, 1.4, 5.0),
        });
    }
}

/// The end of a path.
fn draw_end(canvas: &mut Canvas, at: Px, ink: &RGBColor) {
    canvas.disc(at, 2.7, &WHITE);
    canvas.disc(at, 1.9, ink)
}

/// One cell.
struct Panel<'a> {
    axes: Axes,
    swept: &'a Swept,
    cell: usize,
    estimators: &'a [String],
}

impl Panel<'_> {
    fn draw(&self, canvas: &mut Canvas, titled: bool) {
        let axes = &self.axes;
        axes.draw_grid(canvas);
        let cell: Option<&Cell> = self.swept.cells.get(self.cell);
        if let Some(cell) = cell {
            draw_walls(canvas, axes, &cell.config.world.walls);
        }
        if self.truth_spreads_less() {
            self.draw_beliefs(canvas, 1.8);
            self.draw_truths(canvas, 2.0);
        } else {
            self.draw_truths(canvas, 1.4);
            self.draw_beliefs(canvas, 2.4);
        }
        if let Some(start) = cell.map(|c| c.config.start) {
            let at = axes.px([start.x(), start.y()]);
            if axes.holds(at) {
                draw_robot(canvas, at, start.theta(), true);
            }
        }
        axes.draw_frame(canvas, true);
        let parameters = cell.map(|c| setting(&c.parameters));
        let text = parameters.filter(|text| titled || text != "–").unwrap_or_default();
        let most = (axes.frame.width() / 7.4) as usize;
        axes.draw_titles(canvas, &shortened(&text, most), "x (m)", "y (m)");
    }

    fn draw_beliefs(&self, canvas: &mut Canvas, width: f64) {
        let most_apart_s = self.most_apart_s();
        for (i, name) in self.estimators.iter().enumerate() {
            let look = Look::of(i, self.estimators.len());
            self.draw_paths(canvas, name, (&look.ink, width), (believed, most_apart_s));
            self.draw_ends(canvas, name, &look.ink, believed);
        }
    }

    /// The truth is the same for every estimator of a seed.
    fn draw_truths(&self, canvas: &mut Canvas, width: f64) {
        let Some(first) = self.estimators.first() else { return };
        // The robot drove on where the estimator abstained.
        self.draw_paths(canvas, first, (&INK, width), (true_place, f64::INFINITY));
        self.draw_ends(canvas, first, &INK, true_place)
    }

    fn truth_spreads_less(&self) -> bool {
        let Some(first) = self.estimators.first() else { return true };
        let spread = |place: fn(&Sample) -> [f64; 2]| {
            let ends: Vec<[f64; 2]> =
                self.tracks(first).filter_map(|t| t.samples.last()).map(place).collect();
            let of = |axis: usize| {
                Moments::of(&ends.iter().map(|p| p[axis]).collect::<Vec<f64>>()).standard_deviation
            };
            trig::hypot(of(0), of(1))
        };
        // NaN, from an invalid belief, is no reason to put it in front.
        let (truth, belief) = (spread(true_place), spread(believed));
        belief.is_nan() || truth <= belief
    }

    fn tracks<'b>(&'b self, estimator: &'b str) -> impl Iterator<Item = &'b Track> {
        let is_it = move |t: &&Track| t.cell == self.cell && *t.estimator == *estimator;
        self.swept.tracks.iter().filter(is_it)
    }

    fn draw_paths(
        &self,
        canvas: &mut Canvas,
        estimator: &str,
        (ink, width): (&RGBColor, f64),
        (place, most_apart_s): (fn(&Sample) -> [f64; 2], f64),
    ) {
        let count = self.tracks(estimator).count().min(MOST_PATHS);
        let opacity = (2.4 / (count as f64).sqrt()).clamp(0.16, 0.95);
        let start = self.swept.cells.get(self.cell).map(|c| c.config.start);
        for track in self.tracks(estimator).take(MOST_PATHS) {
            // The first sample is some ticks into the run. A path ends where samples are
            // farther apart in time.
            let goes_on = |a: &Sample, b: &Sample| b.time_s - a.time_s <= most_apart_s;
            for (k, answered) in track.samples.chunk_by(goes_on).enumerate() {
                let is_first = k == 0 && answered[0].time_s <= most_apart_s;
                let start = start.filter(|_| is_first).map(|s| [s.x(), s.y()]);
                let places = start.into_iter().chain(answered.iter().map(place));
                for part in self.axes.seen(&places.collect::<Vec<_>>()) {
                    canvas.veil(&part, ink, width, opacity);
                }
            }
        }
    }

    /// The longest time between two samples with none left out between them, s: samples
    /// are at whole ticks.
    fn most_apart_s(&self) -> f64 {
        self.swept.cells.get(self.cell).map_or(f64::INFINITY, |Cell { config, .. }| {
            let step_s = config.ticks as f64 * config.dt_s / SAMPLES.min(config.ticks) as f64;
            step_s + (0.5 * step_s).max(0.99 * config.dt_s)
        })
    }

    fn draw_ends(
        &self,
        canvas: &mut Canvas,
        estimator: &str,
        ink: &RGBColor,
        place: fn(&Sample) -> [f64; 2],
    ) {
        let ends: Vec<[f64; 2]> =
            self.tracks(estimator).filter_map(|t| t.samples.last()).map(place).collect();
        for px in ends.iter().map(|&end| self.axes.px(end)).filter(|&px| self.axes.holds(px)) {
            draw_end(canvas, px, ink);
        }
        for part in self.axes.seen(&ellipse_of(&ends)) {
            canvas.dashes(&part, &SOFT_INK, 1.4, 5.0);
        }
    }
}

fn believed(sample: &Sample) -> [f64; 2] {
    [sample.estimate.x(), sample.estimate.y()]
}

fn true_place(sample: &Sample) -> [f64; 2] {
    [sample.truth.x(), sample.truth.y()]
}

/// The ellipse that holds 95 % of a normal distribution with the mean and the
/// covariance of `places`; none of fewer than five places, or of places too
/// close together to be seen apart.
fn ellipse_of(places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = places.len() as f64;
    let mean = [0, 1].map(|axis| places.iter().map(|p| p[axis]).sum::<f64>() / n);
    let covariance = |a: usize, b: usize| {
        places.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b])).sum::<f64>() / (n - 1.0)
    };
    let found = [covariance(0, 0), covariance(0, 1), covariance(1, 1)];
    let is_seen = places.len() >= 5 && found[0] + found[2] > 1e-6;
    ellipse(found).filter(|_| is_seen).map_or_else(Vec::new, |by| outline(mean, by))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_plot::ellipse::NINETY_FIVE;

    #[test]
    fn an_ellipse_has_the_axes_of_the_covariance() {
        // Along (1, 1) with variance 8/5·…, nothing across.
        let line: Vec<[f64; 2]> = (-2..=2).map(|k| [f64::from(k), f64::from(k)]).collect();
        let found = ellipse_of(&line);
        let far = found.iter().map(|p| trig::hypot(p[0], p[1])).fold(0.0, f64::max);
        // Variance along: 2 · 2.5.
        assert!((far - (5.0 * NINETY_FIVE).sqrt()).abs() < 1e-2, "{far}");
        assert!(found.iter().all(|p| (p[0] - p[1]).abs() < 1e-7));
        assert!(ellipse_of(&line[..4]).is_empty());
        assert!(ellipse_of(&[[1.0, 1.0]; 9]).is_empty());
        assert!(ellipse_of(&[[f64::NAN, 1.0]; 9]).is_empty());
    }

    #[test]
    fn every_name_of_the_legend_lies_on_the_page() {
        for count in 0..12 {
            let names: Vec<String> = (0..count).map(|k| format!("an estimator {k}")).collect();
            let legend = legend(&names);
            assert_eq!(legend.len(), count + 3);
            for (name, place) in &legend {
                assert!(place.at[0] + Legend::width(name) <= WIDTH, "{count}: {name} {place:?}");
                assert!(place.at[1] < TOP + legend_height(&legend), "{count}: {name} {place:?}");
            }
        }
    }

    #[test]
    fn every_panel_lies_on_the_page() {
        for count in 1..=MOST_PANELS {
            for (x, y) in [(10.0, 1.0), (4.0, 4.0), (1.0, 10.0)] {
                let mut view = Extent::default();
                view.include([0.0, 0.0]);
                view.include([x, y]);
                let layout = Layout::of(count, LEGEND, &view);
                let last = layout.frame(count - 1);
                assert!(last.right <= WIDTH - MARGIN_RIGHT + 1e-9, "{count}: {last:?}");
                assert!(last.bottom + 40.0 <= layout.height(), "{count}: {last:?}");
            }
        }
    }
}
