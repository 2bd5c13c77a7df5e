//! A comparison, drawn: the differences seed by seed, and both distributions.
//!
//! Left, each seed is a bar from zero to B − A, in the colour of the better of the
//! two, sorted; the mean is a line and its interval a band. Right, the share of the
//! runs with at most a figure.

use rusty_plot::page::{Legend, draw_title};
use rusty_plot::style::{INK, Look, SOFT_INK};
use rusty_plot::{Axes, Axis, Canvas, Rect, paint, shortened};

use super::Versus;
use super::contest::{Contest, Outcome};
use crate::page::{Distribution, MARGIN_LEFT, TOP, WIDTH, draw_distributions, draw_empty, frame};

/// Most rows; the rest is left out, and the page says so.
const MOST_ROWS: usize = 12;
const HEIGHT: f64 = 200.0;
const ROW: f64 = HEIGHT + 92.0;

/// Draws a comparison as the text of an SVG file.
#[must_use]
pub fn drawing(versus: &Versus) -> String {
    let contests = versus.settings.iter();
    let mut rows: Vec<(&Contest, &Outcome)> =
        contests.flat_map(|c| c.outcomes.iter().map(move |outcome| (c, outcome))).collect();
    rows.retain(|(_, outcome)| outcome.paired.pairs > 0 || outcome.one_sided != [0, 0]);
    let left_out = rows.len().saturating_sub(MOST_ROWS);
    let names = [&versus.a, &versus.b].map(|who| match versus.a.table == versus.b.table {
        true => who.name.clone(),
        false => format!("{} of {}", who.name, who.table),
    });
    let names = names.map(|name| shortened(&name, 48));
    let title = format!("{} and {}, seed by seed", names[0], names[1]);
    let mut details = format!("band: {} % interval of the mean difference", 100.0 * versus.level);
    if left_out > 0 {
        details.push_str(&format!(" · {left_out} more rows not shown"));
    }
    let top = TOP + 44.0;
    let count = rows.len().clamp(1, MOST_ROWS) as f64;
    paint((WIDTH, top + ROW * count - 24.0), &title, |canvas| {
        draw_title(canvas, MARGIN_LEFT, &title, &details);
        let mut legend = Legend { at: [MARGIN_LEFT, TOP + 2.0] };
        for (side, (name, letter)) in names.iter().zip(["A", "B"]).enumerate() {
            legend.estimator(canvas, &format!("{letter}: {name}"), &Look::of(side, 2));
        }
        for (k, (contest, outcome)) in rows.iter().take(MOST_ROWS).enumerate() {
            draw_row(canvas, top + ROW * k as f64, contest, outcome);
        }
    })
}

fn draw_row(canvas: &mut Canvas, top: f64, contest: &Contest, outcome: &Outcome) {
    let metric = outcome.metric;
    let unit = match metric.shown_unit().trim() {
        "" => String::new(),
        unit => format!(" ({unit})"),
    };
    let title = match &*contest.setting {
        "" => metric.words().to_owned(),
        setting => format!("{}, {}", metric.words(), shortened(setting, 40)),
    };
    let differences = format!("{title}, B − A{unit}");
    draw_differences(canvas, frame(0, 2, top, HEIGHT), outcome, &differences);
    let side = |side: usize| {
        let own = outcome.figures.values().map(|both| both[side].unwrap_or(f64::NAN));
        let values = own.map(|value| metric.scale() * value).collect();
        Distribution { look: Look::of(side, 2), values }
    };
    let titles = (&*format!("{title}{unit}"), "");
    draw_distributions(canvas, frame(1, 2, top, HEIGHT), &[side(0), side(1)], titles);
}

fn draw_differences(canvas: &mut Canvas, frame: Rect, outcome: &Outcome, title: &str) {
    let scale = outcome.metric.scale();
    let both = outcome.figures.values().filter_map(|[a, b]| Some(scale * ((*b)? - (*a)?)));
    let mut differences: Vec<f64> = both.filter(|d| d.is_finite()).collect();
    differences.sort_by(f64::total_cmp);
    if differences.is_empty() {
        return draw_empty(canvas, frame, title, "no seed has both figures");
    }
    let count = differences.len() as f64;
    let interval = outcome.interval.map(|edge| scale * edge);
    let all = || differences.iter().copied().chain(interval).filter(|v| v.is_finite());
    let (low, high) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let air = (0.06 * (high - low)).max(1e-9);
    let (x, y) = (Axis::linear([0.0, count], 8.0), Axis::linear([low - air, high + air], 6.0));
    let axes = Axes { frame, x, y };
    axes.draw_grid(canvas);
    if interval.iter().all(|edge| edge.is_finite()) {
        let [low, high] = interval;
        let corners = [[0.0, low], [count, low], [count, high], [0.0, high]];
        canvas.wash(&corners.map(|at| axes.px(at)), &SOFT_INK, 0.22);
    }
    for (k, difference) in differences.iter().enumerate() {
        // Less is better: below zero it is B.
        let better = Look::of(usize::from(*difference < 0.0), 2);
        let (left, right) = (k as f64 + 0.15, k as f64 + 0.85);
        let corners = [[left, 0.0], [right, 0.0], [right, *difference], [left, *difference]];
        canvas.polygon(&corners.map(|at| axes.px(at)), &better.ink);
    }
    let mean = scale * outcome.paired.difference;
    canvas.line(&[[0.0, 0.0], [count, 0.0]].map(|at| axes.px(at)), &INK, 1.0);
    if mean.is_finite() {
        canvas.dashes(&[[0.0, mean], [count, mean]].map(|at| axes.px(at)), &INK, 2.0, 6.0);
    }
    axes.draw_frame(canvas, true);
    axes.draw_titles(canvas, title, "seeds, sorted", "");
}
