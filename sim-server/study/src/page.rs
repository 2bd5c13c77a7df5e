//! What the pages of sweeps and comparisons share: margins, frames side by side,
//! and the distribution of a figure over the runs.

use rusty_plot::style::{Look, SOFT_INK};
use rusty_plot::{Anchor, Axes, Axis, Canvas, Rect};

/// Width of a page, CSS pixels.
pub(crate) const WIDTH: f64 = 1200.0;
pub(crate) const MARGIN_LEFT: f64 = 72.0;
pub(crate) const MARGIN_RIGHT: f64 = 28.0;
/// Where the first thing below title and details may begin.
pub(crate) const TOP: f64 = 84.0;
/// Between frames side by side.
const GAP: f64 = 78.0;
/// From this ratio of the greatest to the least on, an axis is logarithmic.
const WIDE: f64 = 30.0;

/// The frame in the column `place` of `columns`, CSS pixels.
pub(crate) fn frame(place: usize, columns: usize, top: f64, height: f64) -> Rect {
    let room = WIDTH - MARGIN_LEFT - MARGIN_RIGHT - GAP * (columns - 1) as f64;
    let width = room / columns as f64;
    let left = MARGIN_LEFT + (width + GAP) * place as f64;
    Rect { left, top, right: left + width, bottom: top + height }
}

/// Draws a frame in which there is nothing to see, and why.
pub(crate) fn draw_empty(canvas: &mut Canvas, frame: Rect, title: &str, why: &str) {
    let axes = Axes { frame, x: Axis::plain([0.0, 1.0]), y: Axis::plain([0.0, 1.0]) };
    axes.draw_frame(canvas, false);
    axes.draw_titles(canvas, title, "", "");
    canvas.text(axes.px([0.5, 0.5]), Anchor::Middle, 13.0, &SOFT_INK, why);
}

/// A figure of many runs. What is not finite was not reached: it counts as a run, and
/// the curve stays below 1.
pub(crate) struct Distribution {
    pub look: Look,
    pub values: Vec<f64>,
}

/// Draws the share of the runs with at most a figure, over the figure (the empirical
/// distribution function).
pub(crate) fn draw_distributions(
    canvas: &mut Canvas,
    frame: Rect,
    all: &[Distribution],
    (title, x_title): (&str, &str),
) {
    let finite = || all.iter().flat_map(|d| &d.values).copied().filter(|v| v.is_finite());
    let (Some(low), Some(high)) = (finite().reduce(f64::min), finite().reduce(f64::max)) else {
        return draw_empty(canvas, frame, title, "no run has this figure");
    };
    let x = if low > 0.0 && high > WIDE * low {
        Axis::log([low / 1.1, high * 1.1])
    } else {
        let air = (0.04 * (high - low)).max(1e-9);
        Axis::linear([(low - air).min(0.0), high + air], 6.0)
    };
    let axes = Axes { frame, x, y: Axis::linear([0.0, 1.0], 6.0) };
    axes.draw_grid(canvas);
    for distribution in all {
        let mut values = distribution.values.clone();
        let runs = values.len() as f64;
        values.retain(|v| v.is_finite());
        values.sort_by(f64::total_cmp);
        let steps = values.iter().enumerate().flat_map(|(k, v)| {
            let below = k as f64 / runs;
            [[*v, below], [*v, (k + 1) as f64 / runs]]
        });
        let last = [axes.x.range[1], values.len() as f64 / runs];
        let line: Vec<[f64; 2]> = steps.chain([last]).collect();
        for part in axes.seen(&line) {
            canvas.line(&part, &distribution.look.ink, 2.0);
        }
        if let Some(middle) = values.get(values.len() / 2) {
            let share = (values.len() / 2) as f64 / runs;
            distribution.look.mark(canvas, axes.px([*middle, share]), 4.0);
        }
    }
    axes.draw_frame(canvas, true);
    axes.draw_titles(canvas, title, x_title, "share of the runs");
}
