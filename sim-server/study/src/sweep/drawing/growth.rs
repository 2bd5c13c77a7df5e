//! The growth: the spread of the errors over the distance driven.
//!
//! Logarithmic axes, on which a power is a straight line: measured spreads as
//! marks, the fitted power as a line over the range it was fitted on, and the
//! slope that white slip has on a straight track as dashes to compare with.

use rusty_contract::score::{degrees, metres};
use rusty_plot::page::{Rows, draw_title};
use rusty_plot::style::{Look, SOFT_INK};
use rusty_plot::{Anchor, Axes, Axis, Canvas, Px, Rect, paint, shortened};

use super::super::Swept;
use super::super::growth::{Exponent, Growth, Spread, growth as spreads};
use super::{name_of, seeds_of};
use crate::page::{MARGIN_LEFT, MARGIN_RIGHT, TOP, WIDTH, draw_empty, frame};

/// Most lines of the table, and curves in a plot.
const MOST_CURVES: usize = 8;
const PLOT_HEIGHT: f64 = 330.0;
const ROW: f64 = 24.0;
/// A spread below this cannot be told from rounding, and is not drawn.
const LEAST: f64 = 1e-9;
/// Distance between marks, units of the page.
const MARK_EVERY: f64 = 11.0;
/// Decades below the greatest spread that are shown.
const MOST_DECADES: f64 = 1e4;

/// One of the three plots.
#[derive(Clone, Copy)]
struct Plot {
    title: &'static str,
    /// The exponent of white slip on a straight track, and how it is written.
    guide: (f64, &'static str),
    of: fn(&Spread) -> f64,
    exponent: fn(&Growth) -> Option<Exponent>,
    /// From the unit of the fit to that of the plot.
    scale: f64,
}

const PLOTS: [Plot; 3] = [
    Plot {
        title: "spread across, log coordinates (m)",
        guide: (1.5, "slope 1.5"),
        of: |s| s.log_across_m.standard_deviation,
        exponent: |g| g.exponents.log_across,
        scale: 1.0,
    },
    Plot {
        title: "spread along, log coordinates (m)",
        guide: (0.5, "slope 0.5"),
        of: |s| s.log_along_m.standard_deviation,
        exponent: |g| g.exponents.log_along,
        scale: 1.0,
    },
    Plot {
        title: "spread of the heading (deg)",
        guide: (0.5, "slope 0.5"),
        of: |s| s.heading_rad.standard_deviation,
        exponent: |g| g.exponents.heading,
        scale: 180.0 / core::f64::consts::PI,
    },
];

/// Draws the growth of a sweep as the text of an SVG file.
pub fn growth(swept: &Swept) -> String {
    let mut curves = spreads(&swept.tracks);
    let left_out = curves.len().saturating_sub(MOST_CURVES);
    curves.truncate(MOST_CURVES);
    let title = match swept.cells.first() {
        Some(cell) => format!("How {} comes apart", shortened(&cell.config.scenario, 48)),
        None => "How nothing comes apart".to_owned(),
    };
    let mut details = format!(
        "{} · standard deviation over the seeds of log(truth⁻¹ estimate)",
        seeds_of(&swept.tracks)
    );
    if left_out > 0 {
        details.push_str(&format!(" · {left_out} more not shown"));
    }
    let frame = |place: usize| frame(place, PLOTS.len(), TOP + 24.0, PLOT_HEIGHT);
    let table_top = TOP + 24.0 + PLOT_HEIGHT + 84.0;
    let height = table_top + ROW * curves.len().max(1) as f64 + 44.0;
    paint((WIDTH, height), &title, |canvas| {
        draw_title(canvas, MARGIN_LEFT, &title, &details);
        for (place, plot) in PLOTS.iter().enumerate() {
            draw_plot(canvas, frame(place), plot, &curves);
        }
        draw_table(canvas, table_top, swept, &curves)
    })
}

fn draw_plot(canvas: &mut Canvas, frame: Rect, plot: &Plot, curves: &[Growth]) {
    let points: Vec<Vec<[f64; 2]>> = curves.iter().map(|curve| points_of(plot, curve)).collect();
    let Some(axes) = axes_of(frame, &points) else {
        return draw_empty(canvas, frame, plot.title, "the same on every seed");
    };
    axes.draw_grid(canvas);
    draw_guide(canvas, &axes, plot);
    for (i, curve) in curves.iter().enumerate() {
        let look = Look::of(i, curves.len());
        if let Some(exponent) = (plot.exponent)(curve) {
            let law = exponent.law;
            let line = law.range.map(|x| [x, plot.scale * law.at(x)]);
            for part in axes.seen(&line) {
                canvas.line(&part, &look.ink, 1.8);
            }
        }
        let turn = (i as f64 + 0.5) / curves.len() as f64;
        for px in marks(&axes, &points[i], turn) {
            look.mark(canvas, px, 3.0);
        }
    }
    axes.draw_frame(canvas, true);
    axes.draw_titles(canvas, plot.title, "distance driven (m)", "");
}

/// The places of the marks: points far enough apart to be told from each other,
/// beginning at a `turn` (0 to 1) of that distance, so that curves that agree do
/// not hide each other.
fn marks(axes: &Axes, points: &[[f64; 2]], turn: f64) -> Vec<Px> {
    let mut due = axes.frame.left + turn * MARK_EVERY;
    let mut places = Vec::new();
    for px in points.iter().map(|&at| axes.px(at)).filter(|&px| axes.holds(px)) {
        if px[0] >= due {
            places.push(px);
            due += ((px[0] - due) / MARK_EVERY).floor() * MARK_EVERY + MARK_EVERY;
        }
    }
    places
}

/// Distance and spread, in the units of the plot, where there is one; where the
/// robot stands the way does not grow, and the last of its samples stays.
fn points_of(plot: &Plot, curve: &Growth) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    for s in curve.samples.iter().filter(|s| (plot.of)(s) > LEAST && s.distance_m > 0.0) {
        let point = [s.distance_m, plot.scale * (plot.of)(s)];
        match points.last_mut() {
            Some(last) if point[0] - last[0] < 1e-6 * point[0] => *last = point,
            _ => points.push(point),
        }
    }
    points
}

/// Axes around all points, with some air; `None` without points.
fn axes_of(frame: Rect, points: &[Vec<[f64; 2]>]) -> Option<Axes> {
    let range = |axis: usize| {
        let all = || points.iter().flatten().map(|p| p[axis]).filter(|v| v.is_finite());
        let high = all().reduce(f64::max)?;
        let low = all().reduce(f64::min)?.max(high / MOST_DECADES);
        // At least a factor of two, or numbers along the axis would be few.
        let low = low.min(0.5 * high);
        Some(Axis::log([low / 1.25, high * 1.25]))
    };
    Some(Axes { frame, x: range(0)?, y: range(1)? })
}

/// Dashes of the known slope through the lower left, apart from the marks.
fn draw_guide(canvas: &mut Canvas, axes: &Axes, plot: &Plot) {
    let (slope, text) = plot.guide;
    let [x, y] = [axes.x.range, axes.y.range];
    // From the middle of the lower edge up to the right edge, in the data.
    let power = |ratio: f64| rusty_geometry::trig::exp(slope * rusty_geometry::trig::ln(ratio));
    let (left, right, base) = ((x[0] * x[1]).sqrt(), x[1], y[0] * 1.12);
    for part in axes.seen(&[[left, base], [right, base * power(right / left)]]) {
        canvas.dashes(&part, &SOFT_INK, 1.2, 5.0);
    }
    let at = axes.px([left, base]);
    canvas.text([at[0] - 8.0, at[1] - 4.0], Anchor::End, 12.0, &SOFT_INK, text)
}

/// Right edges of the table's columns of figures.
const COLUMNS: [f64; 4] = [680.0, 830.0, 980.0, 1172.0];

fn draw_table(canvas: &mut Canvas, top: f64, swept: &Swept, curves: &[Growth]) {
    let heads = ["exponent across", "along", "heading", "mean error at the end"];
    let x = [MARGIN_LEFT, WIDTH - MARGIN_RIGHT];
    let rows = Rows { x, columns: &COLUMNS, height: ROW };
    rows.draw_head(canvas, top - 4.0, &heads.each_ref().map(std::slice::from_ref));
    for (i, curve) in curves.iter().enumerate() {
        let y = top + ROW * (i as f64 + 0.5);
        let look = Look::of(i, curves.len());
        let name = name_of(swept, curve.cell, &curve.estimator);
        let [across, along, heading] = PLOTS.map(|plot| exponent_text((plot.exponent)(curve)));
        let end = curve.samples.last().map_or_else(
            || "–".to_owned(),
            |s| {
                let heading_deg = s.heading_rad.mean.to_degrees();
                format!("{} m, {} °", metres(s.mean_error_m), degrees(heading_deg))
            },
        );
        rows.draw(canvas, y, (&look, &name), &[across, along, heading, end]);
    }
    let note = "Exponent: of the spread against the distance, fitted over the line drawn; \
                ± its standard error, by the jackknife over seeds. Heading: estimate − truth.";
    let at = [MARGIN_LEFT, top + ROW * curves.len().max(1) as f64 + 22.0];
    canvas.text(at, Anchor::Start, 12.0, &SOFT_INK, note)
}

fn exponent_text(exponent: Option<Exponent>) -> String {
    exponent.map_or_else(|| "–".to_owned(), |exponent| exponent.to_string())
}
