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
use rusty_plot::floor::{Extent, draw_robot, draw_walls};
use rusty_plot::style::{INK, Look, RGBColor, SOFT_INK, WHITE};
use rusty_plot::{Anchor, Axes, Canvas, PlotError, Px, Rect, Step, paint, polyline};

use super::super::lines::setting;
use super::super::{Cell, Sample, Swept, Track};
use super::{MARGIN_LEFT, MARGIN_RIGHT, TOP, WIDTH, draw_title, seeds_of, shortened};
use rusty_metrics::Moments;

/// Most panels; the rest of the cells is left out, and the page says so.
const MOST_PANELS: usize = 6;
/// Most paths of an estimator in a panel.
const MOST_PATHS: usize = 150;
/// Heights of a panel: at least, at most.
const HEIGHTS: [f64; 2] = [150.0, 460.0];
const GAP_X: f64 = 74.0;
const GAP_Y: f64 = 84.0;
/// Height of the row that says what is what.
const LEGEND: f64 = 30.0;
/// √ of the 0.95 quantile of χ² with two degrees of freedom.
const NINETY_FIVE: f64 = 2.447_746_830_680_816;
/// Corners of a drawn ellipse.
const CORNERS: u32 = 72;

/// Draws the fan of a sweep as the text of an SVG file.
///
/// # Errors
/// [`PlotError::Draw`] if the drawing backend refuses; it writes to memory only
/// and is not known to.
pub fn fan(swept: &Swept) -> Result<String, PlotError> {
    let with_tracks: BTreeSet<usize> = swept.tracks.iter().map(|t| t.cell).collect();
    let mut panels: Vec<usize> = with_tracks.into_iter().collect();
    let left_out = panels.len().saturating_sub(MOST_PANELS);
    panels.truncate(MOST_PANELS);
    let estimators = names(&swept.tracks);
    let view = view_of(&swept.tracks, &panels);
    let layout = Layout::of(panels.len().max(1), &view);
    let title = match swept.cells.first() {
        Some(cell) => format!("Fan of {}", shortened(&cell.config.scenario, 48)),
        None => "Fan of nothing".to_owned(),
    };
    let details = details(swept, left_out);
    paint((WIDTH, layout.height()), &title, |canvas| {
        draw_title(canvas, &title, &details)?;
        draw_legend(canvas, &estimators)?;
        for (place, &cell) in panels.iter().enumerate() {
            let axes = Axes::equal(layout.frame(place), view.x(), view.y());
            let panel = Panel { axes, swept, cell, estimators: &estimators };
            panel.draw(canvas, panels.len() > 1)?;
        }
        if panels.is_empty() {
            let middle = [0.5 * WIDTH, TOP + LEGEND + 60.0];
            canvas.text(middle, Anchor::Middle, 14.0, &SOFT_INK, "no run has a track")?;
        }
        Ok(())
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
}

impl Layout {
    fn of(count: usize, view: &Extent) -> Self {
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
        Self { columns, rows: count.div_ceil(columns), width, panel_height }
    }

    fn frame(&self, place: usize) -> Rect {
        let left = MARGIN_LEFT + (self.width + GAP_X) * (place % self.columns) as f64;
        let down = (self.panel_height + GAP_Y) * (place / self.columns) as f64;
        let top = TOP + LEGEND + 24.0 + down;
        Rect { left, top, right: left + self.width, bottom: top + self.panel_height }
    }

    fn height(&self) -> f64 {
        TOP + LEGEND + 24.0 + (self.panel_height + GAP_Y) * self.rows as f64 - GAP_Y + 56.0
    }
}

fn draw_legend(canvas: &mut Canvas<'_>, estimators: &[String]) -> Result<(), PlotError> {
    let (mut x, y) = (MARGIN_LEFT, TOP + 6.0);
    let mut entry =
        |canvas: &mut Canvas<'_>,
         text: &str,
         drawn: &dyn Fn(&mut Canvas<'_>, Px) -> Result<(), PlotError>| {
            drawn(canvas, [x, y - 4.0])?;
            canvas.text([x + 40.0, y], Anchor::Start, 13.0, &INK, text)?;
            x += 62.0 + 6.5 * text.chars().count() as f64;
            Ok(())
        };
    entry(canvas, "start", &|c, at| draw_robot(c, [at[0] + 12.0, at[1]], 0.0, true))?;
    entry(canvas, "true paths and their ends", &|c, at| {
        c.line(&[at, [at[0] + 32.0, at[1]]], &INK, 1.6)?;
        draw_end(c, [at[0] + 32.0, at[1]], &INK)
    })?;
    for (i, name) in estimators.iter().enumerate() {
        let look = Look::of(i, estimators.len());
        let text = format!("believed by {}", shortened(name, 28));
        entry(canvas, &text, &|c, at| {
            c.line(&[at, [at[0] + 32.0, at[1]]], &look.ink, 2.0)?;
            draw_end(c, [at[0] + 32.0, at[1]], &look.ink)
        })?;
    }
    entry(canvas, "95 % if the ends were normal", &|c, at| {
        c.dashes(&[at, [at[0] + 32.0, at[1]]], &SOFT_INK, 1.4, 5.0)
    })
}

/// The end of a path.
fn draw_end(canvas: &mut Canvas<'_>, at: Px, ink: &RGBColor) -> Result<(), PlotError> {
    canvas.disc(at, 2.7, &WHITE)?;
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
    fn draw(&self, canvas: &mut Canvas<'_>, titled: bool) -> Result<(), PlotError> {
        let (axes, frame) = (&self.axes, self.axes.frame);
        let x_step = Step::of(axes.x[1] - axes.x[0], (frame.width() / 90.0).max(3.0));
        let y_step = Step::of(axes.y[1] - axes.y[0], (frame.height() / 40.0).max(3.0));
        axes.draw_grid(canvas, x_step, y_step)?;
        let cell: Option<&Cell> = self.swept.cells.get(self.cell);
        if let Some(cell) = cell {
            draw_walls(canvas, axes, &cell.config.world.walls)?;
        }
        if self.truth_spreads_less() {
            self.draw_beliefs(canvas, 1.8)?;
            self.draw_truths(canvas, 2.0)?;
        } else {
            self.draw_truths(canvas, 1.4)?;
            self.draw_beliefs(canvas, 2.4)?;
        }
        if let Some(start) = cell.map(|c| c.config.start) {
            let at = axes.px([start.x(), start.y()]);
            if axes.holds(at) {
                draw_robot(canvas, at, start.theta(), true)?;
            }
        }
        axes.draw_frame(canvas, Some(x_step), y_step)?;
        self.draw_labels(canvas, titled)
    }

    fn draw_beliefs(&self, canvas: &mut Canvas<'_>, width: f64) -> Result<(), PlotError> {
        for (i, name) in self.estimators.iter().enumerate() {
            let look = Look::of(i, self.estimators.len());
            self.draw_paths(canvas, name, (&look.ink, width), believed)?;
            self.draw_ends(canvas, name, &look.ink, believed)?;
        }
        Ok(())
    }

    /// The truth is the same for every estimator of a seed.
    fn draw_truths(&self, canvas: &mut Canvas<'_>, width: f64) -> Result<(), PlotError> {
        let Some(first) = self.estimators.first() else { return Ok(()) };
        self.draw_paths(canvas, first, (&INK, width), true_place)?;
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
        // NaN, from a belief that is none, is no reason to put it in front.
        let (truth, belief) = (spread(true_place), spread(believed));
        belief.is_nan() || truth <= belief
    }

    fn draw_labels(&self, canvas: &mut Canvas<'_>, titled: bool) -> Result<(), PlotError> {
        let frame = self.axes.frame;
        let [across, down] = [0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom)];
        canvas.text([across, frame.bottom + 36.0], Anchor::Middle, 13.0, &INK, "x (m)")?;
        canvas.text([frame.left - 44.0, down], Anchor::Upwards, 13.0, &INK, "y (m)")?;
        let parameters = self.swept.cells.get(self.cell).map(|c| setting(&c.parameters));
        let text = parameters.filter(|text| titled || text != "–").unwrap_or_default();
        let most = (frame.width() / 7.4) as usize;
        let at = [frame.left, frame.top - 8.0];
        canvas.text(at, Anchor::Start, 13.0, &INK, &shortened(&text, most))
    }

    fn tracks<'b>(&'b self, estimator: &'b str) -> impl Iterator<Item = &'b Track> {
        let is_it = move |t: &&Track| t.cell == self.cell && *t.estimator == *estimator;
        self.swept.tracks.iter().filter(is_it)
    }

    fn draw_paths(
        &self,
        canvas: &mut Canvas<'_>,
        estimator: &str,
        (ink, width): (&RGBColor, f64),
        place: fn(&Sample) -> [f64; 2],
    ) -> Result<(), PlotError> {
        let count = self.tracks(estimator).count().min(MOST_PATHS);
        let opacity = (2.4 / (count as f64).sqrt()).clamp(0.16, 0.95);
        let start = self.swept.cells.get(self.cell).map(|c| c.config.start);
        for track in self.tracks(estimator).take(MOST_PATHS) {
            // The first sample is some ticks into the run.
            let places = start.map(|s| [s.x(), s.y()]).into_iter();
            let places = places.chain(track.samples.iter().map(place));
            let line: Vec<Px> = places.map(|at| self.axes.px(at)).collect();
            for part in polyline::clip(&polyline::thin(&line), &self.axes.frame) {
                canvas.veil(&part, ink, width, opacity)?;
            }
        }
        Ok(())
    }

    fn draw_ends(
        &self,
        canvas: &mut Canvas<'_>,
        estimator: &str,
        ink: &RGBColor,
        place: fn(&Sample) -> [f64; 2],
    ) -> Result<(), PlotError> {
        let ends: Vec<[f64; 2]> =
            self.tracks(estimator).filter_map(|t| t.samples.last()).map(place).collect();
        for px in ends.iter().map(|&end| self.axes.px(end)).filter(|&px| self.axes.holds(px)) {
            draw_end(canvas, px, ink)?;
        }
        let outline: Vec<Px> = ellipse(&ends).into_iter().map(|at| self.axes.px(at)).collect();
        for part in polyline::clip(&outline, &self.axes.frame) {
            canvas.dashes(&part, &SOFT_INK, 1.4, 5.0)?;
        }
        Ok(())
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
fn ellipse(places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = places.len() as f64;
    let mean = |axis: usize| places.iter().map(|p| p[axis]).sum::<f64>() / n;
    let (x0, y0) = (mean(0), mean(1));
    let sum = |f: &dyn Fn(f64, f64) -> f64| {
        places.iter().map(|p| f(p[0] - x0, p[1] - y0)).sum::<f64>() / (n - 1.0)
    };
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    let (middle, apart) = (0.5 * (xx + yy), trig::hypot(0.5 * (xx - yy), xy));
    if places.len() < 5 || !middle.is_finite() || middle + apart <= 1e-6 {
        return Vec::new();
    }
    let long = NINETY_FIVE * (middle + apart).sqrt();
    let short = NINETY_FIVE * (middle - apart).max(0.0).sqrt();
    let (s, c) = trig::sin_cos(0.5 * trig::atan2(2.0 * xy, xx - yy));
    (0..=CORNERS)
        .map(|k| {
            let turn = core::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
            let (v, u) = trig::sin_cos(turn);
            [x0 + long * u * c - short * v * s, y0 + long * u * s + short * v * c]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipse_has_the_axes_of_the_covariance() {
        // Along (1, 1) with variance 8/5·…, nothing across.
        let line: Vec<[f64; 2]> = (-2..=2).map(|k| [f64::from(k), f64::from(k)]).collect();
        let found = ellipse(&line);
        let far = found.iter().map(|p| trig::hypot(p[0], p[1])).fold(0.0, f64::max);
        // Variance along: 2 · 2.5.
        assert!((far - NINETY_FIVE * 5.0_f64.sqrt()).abs() < 1e-9, "{far}");
        assert!(found.iter().all(|p| (p[0] - p[1]).abs() < 1e-7));
        assert!(ellipse(&line[..4]).is_empty());
        assert!(ellipse(&[[1.0, 1.0]; 9]).is_empty());
        assert!(ellipse(&[[f64::NAN, 1.0]; 9]).is_empty());
    }

    #[test]
    fn every_panel_lies_on_the_page() {
        for count in 1..=MOST_PANELS {
            for (x, y) in [(10.0, 1.0), (4.0, 4.0), (1.0, 10.0)] {
                let mut view = Extent::default();
                view.include([0.0, 0.0]);
                view.include([x, y]);
                let layout = Layout::of(count, &view);
                let last = layout.frame(count - 1);
                assert!(last.right <= WIDTH - MARGIN_RIGHT + 1e-9, "{count}: {last:?}");
                assert!(last.bottom + 40.0 <= layout.height(), "{count}: {last:?}");
            }
        }
    }
}
