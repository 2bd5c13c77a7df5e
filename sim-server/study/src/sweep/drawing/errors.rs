//! The errors: how far off the estimators are as time goes on, and how the runs differ.
//!
//! A line is the median over the seeds, its band holds the middle 80 % of them. The
//! last frame has the share of the runs with at most an error.

use rusty_geometry::trig;
use rusty_metrics::percentile;
use rusty_plot::page::{Legend, draw_title};
use rusty_plot::style::Look;
use rusty_plot::{Axes, Axis, Canvas, Rect, paint, shortened};

use std::collections::BTreeMap;

use super::super::lines::in_order;
use super::super::{Sample, Swept, Track};
use super::{name_of, seeds_of};
use crate::page::{Distribution, MARGIN_LEFT, TOP, WIDTH, draw_distributions, draw_empty, frame};

/// Most curves in a frame.
const MOST_CURVES: usize = 8;
const HEIGHT: f64 = 330.0;
/// The band: from this share of the seeds to this.
const BAND: [f64; 2] = [0.1, 0.9];

/// An error of a sample, in the unit that is drawn.
type Error = fn(&Sample) -> f64;

const PLOTS: [(&str, Error); 2] = [
    ("position error (m)", |s| {
        let off = s.estimate.translation() - s.truth.translation();
        trig::hypot(off.x, off.y)
    }),
    ("heading error (deg)", |s| s.estimate.boxminus(&s.truth).z.abs().to_degrees()),
];

/// An estimator in a cell.
struct Curve<'a> {
    look: Look,
    name: String,
    cell: usize,
    estimator: &'a str,
    tracks: Vec<&'a Track>,
}

impl<'a> Curve<'a> {
    fn of(swept: &'a Swept, (cell, estimator): (usize, &'a str), look: Look) -> Self {
        let is_it = |t: &&Track| t.cell == cell && *t.estimator == *estimator;
        let name = name_of(swept, cell, estimator);
        let tracks = swept.tracks.iter().filter(is_it).collect();
        Self { look, name: shortened(&name, 60), cell, estimator, tracks }
    }
}

/// Draws the errors of a sweep as the text of an SVG file.
pub fn errors(swept: &Swept) -> String {
    let all = in_order(swept.tracks.iter().map(|track| (track.cell, &*track.estimator)));
    let count = all.len().min(MOST_CURVES);
    let shown = all.iter().take(MOST_CURVES).enumerate();
    let curves: Vec<Curve<'_>> =
        shown.map(|(i, who)| Curve::of(swept, *who, Look::of(i, count))).collect();
    let title = match swept.cells.first() {
        Some(cell) => format!("Errors in {}", shortened(&cell.config.scenario, 48)),
        None => "Errors of nothing".to_owned(),
    };
    let mut details =
        format!("{} · median over the seeds, and the middle 80 %", seeds_of(&swept.tracks));
    if all.len() > curves.len() {
        details.push_str(&format!(" · {} more not shown", all.len() - curves.len()));
    }
    let top = below(&curves) + 24.0;
    paint((WIDTH, top + HEIGHT + 60.0), &title, |canvas| {
        draw_title(canvas, MARGIN_LEFT, &title, &details);
        draw_names(canvas, &curves);
        for (place, plot) in PLOTS.iter().enumerate() {
            draw_over_time(canvas, frame(place, 3, top, HEIGHT), *plot, &curves);
        }
        let rows = |curve: &Curve<'_>| {
            let own = swept.rows.iter();
            let own = own.filter(|r| r.cell == curve.cell && *r.estimator == *curve.estimator);
            Distribution { look: curve.look, values: own.map(|r| r.ate_rmse_m).collect() }
        };
        let rows: Vec<Distribution> = curves.iter().map(rows).collect();
        let titles = ("position rmse of a run", "rmse (m)");
        draw_distributions(canvas, frame(2, 3, top, HEIGHT), &rows, titles);
    })
}

/// The legend of each name.
fn legends<'c>(curves: &'c [Curve<'_>]) -> impl Iterator<Item = Legend> + 'c {
    let names = curves.iter().map(|curve| &*curve.name);
    Legend::wrapped(names, [MARGIN_LEFT, TOP + 2.0], WIDTH)
}

/// Where the legends end.
fn below(curves: &[Curve<'_>]) -> f64 {
    legends(curves).last().map_or(TOP, |legend| legend.at[1] - 2.0 + Legend::LINE)
}

fn draw_names(canvas: &mut Canvas, curves: &[Curve<'_>]) {
    for (curve, mut legend) in curves.iter().zip(legends(curves)) {
        legend.estimator(canvas, &curve.name, &curve.look);
    }
}

/// Time, s, with the shares of [`BAND`] and between them the median.
type Quantiles = (f64, [f64; 3]);

/// Of samples at the same times; an error that is not finite is left out.
fn quantiles(tracks: &[&Track], error: Error) -> Vec<Quantiles> {
    let mut by_time: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for sample in tracks.iter().flat_map(|track| &track.samples) {
        let found = error(sample);
        if found.is_finite() {
            by_time.entry(sample.time_s.abs().to_bits()).or_default().push(found);
        }
    }
    let of = |(time, mut errors): (u64, Vec<f64>)| {
        let [low, high] = BAND;
        let shares = [low, 0.5, high].map(|share| percentile(&mut errors, share));
        let [Some(low), Some(middle), Some(high)] = shares else { return None };
        Some((f64::from_bits(time), [low, middle, high]))
    };
    by_time.into_iter().filter_map(of).collect()
}

fn draw_over_time(
    canvas: &mut Canvas,
    frame: Rect,
    (title, error): (&str, Error),
    curves: &[Curve<'_>],
) {
    let found: Vec<Vec<Quantiles>> = curves.iter().map(|c| quantiles(&c.tracks, error)).collect();
    let last_s = found.iter().flatten().map(|(time_s, _)| *time_s).fold(0.0, f64::max);
    // An estimate that is beyond all measure does not decide for the others.
    let highest = found.iter().flatten().map(|(_, [.., high])| *high).filter(|h| *h < 1e6);
    let highest = highest.fold(0.0, f64::max);
    if last_s <= 0.0 {
        return draw_empty(canvas, frame, title, "no run has a track");
    }
    let (x, y) = (Axis::linear([0.0, last_s], 6.0), [0.0, (1.06 * highest).max(1e-6)]);
    let axes = Axes { frame, x, y: Axis::linear(y, 6.0) };
    axes.draw_grid(canvas);
    for (curve, found) in curves.iter().zip(&found) {
        let edge =
            |k: usize| found.iter().map(move |(time_s, shares)| [*time_s, shares[k].min(y[1])]);
        let lower: Vec<[f64; 2]> = edge(0).collect();
        let band: Vec<_> = edge(2).chain(lower.into_iter().rev()).map(|p| axes.px(p)).collect();
        canvas.wash(&band, &curve.look.ink, 0.16);
    }
    for (curve, found) in curves.iter().zip(&found) {
        let line: Vec<[f64; 2]> =
            found.iter().map(|(time_s, shares)| [*time_s, shares[1]]).collect();
        for part in axes.seen(&line) {
            canvas.line(&part, &curve.look.ink, 2.0);
        }
        if let Some(end) = line.last().map(|end| axes.px(*end)).filter(|px| axes.holds(*px)) {
            curve.look.mark(canvas, end, 4.0);
        }
    }
    axes.draw_frame(canvas, true);
    axes.draw_titles(canvas, title, "time (s)", "");
}
