//! The errors over time: of the position, and of the heading.

use rusty_plot::style::{INK, Look, SOFT_INK, ZERO};
use rusty_plot::{Anchor, Axes, Canvas, PlotError, Px, Rect, Step, polyline};

use super::metrics::{Scored, scored};
use super::trace::RunTrace;

/// Errors beyond this are drawn as if they were this, m: arithmetic on them
/// stays finite.
const LARGEST_M: f64 = 1e12;
/// The least that an axis spans, so that rounding does not look like drift.
const LEAST_M: f64 = 1e-3;
const LEAST_DEG: f64 = 0.05;

/// The time axis: what its zero is, and how far it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Timeline {
    /// Time of the run at the axis' zero, s: 0, or the first tick's for
    /// recordings that carry the time of day.
    pub origin_s: f64,
    /// First and last second on the axis.
    pub range_s: [f64; 2],
    /// Time between two marks of an estimator, s.
    pub mark_every_s: f64,
}

impl Timeline {
    /// The time axis of a run.
    pub fn of(trace: &RunTrace) -> Self {
        let finite = || trace.time_s.iter().copied().filter(|t| t.is_finite());
        let first_s = finite().reduce(f64::min).unwrap_or(0.0);
        let last_s = finite().reduce(f64::max).unwrap_or(1.0);
        let span_s = last_s - first_s;
        let origin_s = if first_s.abs() <= span_s.max(1.0) { 0.0 } else { first_s };
        let start_s = (first_s - origin_s).min(0.0);
        let end_s = last_s - origin_s;
        let end_s = if end_s > start_s { end_s } else { start_s + 1.0 };
        let mark_every_s = Step::of(end_s - start_s, 8.0).size();
        Self { origin_s, range_s: [start_s, end_s], mark_every_s }
    }

    /// Length of the run, s.
    pub fn span_s(&self) -> f64 {
        self.range_s[1] - self.range_s[0]
    }

    /// Place of a tick on the axis, s, if its time is a number.
    fn at_s(&self, trace: &RunTrace, tick: usize) -> Option<f64> {
        Some(trace.time_s.get(tick)? - self.origin_s).filter(|t| t.is_finite())
    }

    /// The ticks that are marked on an estimator's lines, the same on the map
    /// and on the errors. Estimators are marked in turn, so that marks of those
    /// that agree do not hide each other.
    pub fn marks(&self, trace: &RunTrace, estimator: usize) -> Vec<usize> {
        let mut ticks: Vec<usize> = scored(trace, estimator).map(|s| s.tick).collect();
        if ticks.is_empty() {
            let given = |&tick: &usize| trace.estimate(estimator, tick).is_some();
            ticks = (0..trace.ticks()).filter(given).collect();
        }
        let turn = (estimator as f64 + 0.5) / trace.names.len().max(1) as f64;
        let mut due_s = self.range_s[0] + turn * self.mark_every_s;
        let mut marks = Vec::new();
        for tick in ticks {
            let Some(at_s) = self.at_s(trace, tick).filter(|&at_s| at_s >= due_s) else {
                continue;
            };
            marks.push(tick);
            let periods = ((at_s - due_s) / self.mark_every_s).floor() + 1.0;
            due_s += periods * self.mark_every_s;
        }
        marks
    }
}

/// One of the two errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Position,
    Heading,
}

impl Kind {
    fn of(self, scored: &Scored) -> f64 {
        match self {
            Self::Position => scored.position_error_m().min(LARGEST_M),
            Self::Heading => scored.heading_error_rad().to_degrees(),
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Position => "position error (m)",
            Self::Heading => "heading error, estimate − truth (deg)",
        }
    }

    /// The range to show, given the least and the greatest error.
    fn range(self, least: f64, greatest: f64) -> [f64; 2] {
        match self {
            Self::Position => [0.0, 1.06 * greatest.max(LEAST_M)],
            Self::Heading => {
                let (low, high) = (least.min(-LEAST_DEG), greatest.max(LEAST_DEG));
                let room = 0.06 * (high - low);
                [(low - room).max(-180.0), (high + room).min(180.0)]
            }
        }
    }

    fn step(self, span: f64) -> Step {
        match self {
            Self::Position => Step::of(span, 5.0),
            Self::Heading => Step::of_degrees(span, 5.0),
        }
    }
}

/// Draws both errors over a common time axis, the position's above.
pub(super) fn draw(
    canvas: &mut Canvas<'_>,
    position: Rect,
    heading: Rect,
    trace: &RunTrace,
    time: &Timeline,
) -> Result<(), PlotError> {
    draw_legend(canvas, &position, trace)?;
    draw_plot(canvas, position, Kind::Position, trace, time)?;
    draw_plot(canvas, heading, Kind::Heading, trace, time)?;
    let title = if time.origin_s == 0.0 { "time (s)" } else { "time since the first tick (s)" };
    let middle = 0.5 * (heading.left + heading.right);
    canvas.text([middle, heading.bottom + 37.0], Anchor::Middle, 13.0, &INK, title)
}

fn draw_plot(
    canvas: &mut Canvas<'_>,
    frame: Rect,
    kind: Kind,
    trace: &RunTrace,
    time: &Timeline,
) -> Result<(), PlotError> {
    let count = trace.names.len();
    let curves: Vec<Vec<(usize, [f64; 2])>> =
        (0..count).map(|i| curve(trace, time, i, kind)).collect();
    let errors = || curves.iter().flatten().map(|(_, at)| at[1]);
    let y = kind.range(errors().fold(0.0, f64::min), errors().fold(0.0, f64::max));
    let axes = Axes { frame, x: time.range_s, y };
    let x_step = Step::of(time.span_s(), 12.0);
    let y_step = kind.step(y[1] - y[0]);
    axes.draw_grid(canvas, x_step, y_step)?;
    let zero = axes.px([0.0, 0.0])[1];
    canvas.line(&[[frame.left, zero], [frame.right, zero]], &ZERO, 1.0)?;
    for (i, curve) in curves.iter().enumerate() {
        draw_curve(canvas, &axes, curve, &Look::of(i, count), kind)?;
    }
    let below = (kind == Kind::Heading).then_some(x_step);
    axes.draw_frame(canvas, below, y_step)?;
    for (i, curve) in curves.iter().enumerate() {
        draw_marks(canvas, &axes, curve, &time.marks(trace, i), &Look::of(i, count))?;
    }
    if curves.iter().all(Vec::is_empty) {
        let middle = [0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom) - 12.0];
        let text = "no tick has both an estimate and a truth";
        canvas.text(middle, Anchor::Middle, 13.0, &SOFT_INK, text)?;
    }
    canvas.text([frame.left, frame.top - 8.0], Anchor::Start, 13.0, &INK, kind.title())
}

/// The errors of an estimator as (tick, [time s, error]).
fn curve(
    trace: &RunTrace,
    time: &Timeline,
    estimator: usize,
    kind: Kind,
) -> Vec<(usize, [f64; 2])> {
    let point = |s: Scored| Some((s.tick, [time.at_s(trace, s.tick)?, kind.of(&s)]));
    let finite = |(_, at): &(usize, [f64; 2])| at[1].is_finite();
    scored(trace, estimator).filter_map(point).filter(finite).collect()
}

fn draw_curve(
    canvas: &mut Canvas<'_>,
    axes: &Axes,
    curve: &[(usize, [f64; 2])],
    look: &Look,
    kind: Kind,
) -> Result<(), PlotError> {
    // Two points of every bucket stay.
    let bucket = (2 * curve.len()).div_ceil(polyline::MOST_POINTS);
    let width = 0.75 * look.width;
    for line in polyline::runs(curve) {
        // An error that passes ±180° goes on at the other edge, not through zero.
        for part in line.chunk_by(|a, b| kind == Kind::Position || (a[1] - b[1]).abs() <= 180.0) {
            let line: Vec<Px> =
                polyline::envelope(part, bucket).into_iter().map(|at| axes.px(at)).collect();
            match line[..] {
                [at] => canvas.disc(at, 1.5, &look.ink)?,
                _ => canvas.line(&line, &look.ink, width)?,
            }
        }
    }
    Ok(())
}

fn draw_marks(
    canvas: &mut Canvas<'_>,
    axes: &Axes,
    curve: &[(usize, [f64; 2])],
    marks: &[usize],
    look: &Look,
) -> Result<(), PlotError> {
    let marked = marks.iter().filter_map(|tick| {
        let index = curve.binary_search_by_key(tick, |(tick, _)| *tick).ok()?;
        Some((curve[index].1, 3.6))
    });
    for (at, size) in marked.chain(curve.last().map(|&(_, at)| (at, 5.0))) {
        look.mark(canvas, axes.px(at), size)?;
    }
    Ok(())
}

/// Names and marks in the line above the plot, from its right edge, as long as
/// they leave room for the title; the table beside the map has them all.
fn draw_legend(canvas: &mut Canvas<'_>, frame: &Rect, trace: &RunTrace) -> Result<(), PlotError> {
    let count = trace.names.len();
    let width = |name: &String| 46.0 + 7.0 * name.chars().count() as f64;
    let total: f64 = trace.names.iter().map(width).sum();
    if total > frame.width() - 200.0 {
        return Ok(());
    }
    let (mut x, y) = (frame.right - total, frame.top - 8.0);
    for (i, name) in trace.names.iter().enumerate() {
        let look = Look::of(i, count);
        canvas.line(&[[x + 8.0, y - 4.0], [x + 36.0, y - 4.0]], &look.ink, look.width)?;
        look.mark(canvas, [x + 22.0, y - 4.0], 3.6)?;
        canvas.text([x + 42.0, y], Anchor::Start, 12.0, &INK, name)?;
        x += width(name);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::trace::tests::empty;
    use super::*;
    use rusty_geometry::SE2;

    fn standing(times_s: impl Iterator<Item = f64>) -> RunTrace {
        let mut trace = empty(&["a", "b"]);
        let here = Some(SE2::identity());
        times_s.for_each(|t| trace.push(t, here, None, [here, here].into_iter()));
        trace
    }

    #[test]
    fn time_starts_at_zero_or_with_a_recording() {
        let simulated = Timeline::of(&standing((1..=1500).map(|k| f64::from(k) * 0.02)));
        assert_eq!((simulated.origin_s, simulated.range_s), (0.0, [0.0, 30.0]));
        assert_eq!(simulated.mark_every_s, 5.0);
        let recorded = Timeline::of(&standing((0..100).map(|k| 1.2e9 + f64::from(k))));
        assert_eq!((recorded.origin_s, recorded.range_s), (1.2e9, [0.0, 99.0]));
        for odd in [vec![], vec![f64::NAN], vec![0.02], vec![7e8, f64::INFINITY]] {
            let time = Timeline::of(&standing(odd.into_iter()));
            assert!(time.span_s() > 0.0 && time.mark_every_s > 0.0, "{time:?}");
        }
    }

    #[test]
    fn marks_take_turns() {
        let trace = standing((1..=1500).map(|k| f64::from(k) * 0.02));
        let time = Timeline::of(&trace);
        // Every 5 s is every 250 ticks; due at 1.25 s and 3.75 s.
        assert_eq!(time.marks(&trace, 0), [62, 312, 562, 812, 1062, 1312]);
        assert_eq!(time.marks(&trace, 1), [187, 437, 687, 937, 1187, 1437]);
    }

    #[test]
    fn ranges_hold_every_error_and_are_never_empty() {
        assert_eq!(Kind::Position.range(0.0, 0.0), [0.0, 1.06 * LEAST_M]);
        assert_eq!(Kind::Heading.range(-180.0, 180.0), [-180.0, 180.0]);
        assert_eq!(Kind::Heading.range(-10.0, 40.0), [-13.0, 43.0]);
        let [low, high] = Kind::Heading.range(0.0, 0.0);
        assert!(low < -0.05 && high > 0.05);
    }
}
