//! Charts over time: the errors of position and heading with the bands that the
//! reported covariances promise, and the normalised squared error.

use rusty_plot::style::{BAND, Look, SOFT_INK, ZERO};
use rusty_plot::{Anchor, Axes, Axis, Canvas, Px, Rect, polyline};

use super::bands;
use super::scored::{Scored, scored};
use super::stops::Stop;
use super::timeline::Timeline;
use super::trace::RunTrace;

/// Errors beyond this are drawn as if they were this, m: arithmetic on them
/// stays finite.
const LARGEST_M: f64 = 1e12;
/// The least that an axis spans, so that rounding does not look like drift.
const LEAST_M: f64 = 1e-3;
const LEAST_DEG: f64 = 0.05;
/// A band may make an axis this many times as long as the errors do.
const BAND_SHARE: f64 = 3.0;
/// What a NEES axis spans at least and at most.
const NEES_LEAST: [f64; 2] = [0.1, 20.0];
const NEES_MOST: [f64; 2] = [1e-2, 1e6];
/// How much of the colour of a band is its own, inside and at its edge.
const BAND_OPACITIES: [f64; 2] = [0.13, 0.5];

/// What is drawn over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Position,
    Heading,
    Nees,
}

impl Kind {
    pub fn title(self) -> &'static str {
        match self {
            Self::Position => "position error (m)",
            Self::Heading => "heading error, estimate − truth (deg)",
            Self::Nees => "NEES, 3 degrees of freedom",
        }
    }

    /// The error of a scored tick, in the unit of the chart.
    fn of(self, scored: &Scored) -> f64 {
        match self {
            Self::Position => scored.position_error_m().min(LARGEST_M),
            _ => scored.heading_error_rad().to_degrees(),
        }
    }

    /// How far the error may reach by the reported covariance, with 95 %.
    fn reach(self, covariance: &[f64; 9]) -> Option<f64> {
        match self {
            Self::Position => bands::position_radius_m(covariance).map(|r| r.min(LARGEST_M)),
            Self::Heading => bands::heading_reach_rad(covariance).map(f64::to_degrees),
            Self::Nees => None,
        }
    }

    /// The range to show, given the least and the greatest value and how far
    /// the bands reach.
    fn range(self, least: f64, greatest: f64, reach: f64) -> [f64; 2] {
        match self {
            Self::Position => {
                let most = greatest.max(LEAST_M);
                [0.0, 1.06 * most.max(reach.min(BAND_SHARE * most))]
            }
            Self::Heading => {
                let (low, high) = (least.min(-LEAST_DEG), greatest.max(LEAST_DEG));
                let reach = reach.min(BAND_SHARE * high.max(-low));
                let (low, high) = (low.min(-reach), high.max(reach));
                let room = 0.06 * (high - low);
                [(low - room).max(-180.0), (high + room).min(180.0)]
            }
            Self::Nees => {
                let low = (0.7 * least).clamp(NEES_MOST[0], NEES_LEAST[0]);
                [low, (1.4 * greatest).clamp(NEES_LEAST[1], NEES_MOST[1])]
            }
        }
    }
}

/// A curve: ticks, and [time s, value] at them.
type Curve = Vec<(usize, [f64; 2])>;

/// A chart, ready to be drawn.
pub(crate) struct Chart<'a> {
    kind: Kind,
    trace: &'a RunTrace,
    time: &'a Timeline,
    axes: Axes,
    /// One per estimator, and how far its band reaches.
    curves: Vec<Curve>,
    reaches: Vec<Curve>,
    /// Most points of a line.
    points: usize,
}

impl<'a> Chart<'a> {
    /// A chart in `frame`, its lines of at most about `points` points and with
    /// at most `numbers` numbers along the time axis.
    pub fn new(
        kind: Kind,
        frame: Rect,
        (trace, time): (&'a RunTrace, &'a Timeline),
        points: usize,
        numbers: f64,
    ) -> Self {
        let each = || 0..trace.names.len();
        let curves: Vec<Curve> = match kind {
            Kind::Nees => each().map(|i| nees(trace, time, i)).collect(),
            _ => each().map(|i| curve(trace, time, i, kind)).collect(),
        };
        let reaches: Vec<Curve> = each().map(|i| reach(trace, time, i, kind)).collect();
        let values = || curves.iter().flatten().map(|(_, at)| at[1]);
        let (least, greatest) =
            (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        let reach = reaches.iter().flatten().map(|(_, at)| at[1]).fold(0.0, f64::max);
        let y = kind.range(least, greatest, reach);
        let y = match kind {
            Kind::Position => Axis::linear(y, 5.0),
            Kind::Heading => Axis::degrees(y, 5.0),
            Kind::Nees => Axis::log(y),
        };
        let axes = Axes { frame, x: Axis::linear(time.range_s, numbers), y };
        Self { kind, trace, time, axes, curves, reaches, points }
    }

    /// Whether there is anything to be seen of an estimator.
    pub fn is_empty(&self) -> bool {
        self.curves.iter().all(Vec::is_empty)
    }

    fn px(&self, [x, y]: [f64; 2]) -> Px {
        let [low, high] = self.axes.y.range;
        self.axes.px([x, y.clamp(low, high)])
    }

    /// The points of a line on the page that are needed to see no difference.
    fn thin(&self, line: impl Iterator<Item = [f64; 2]>) -> Vec<Px> {
        polyline::thin(&line.map(|at| self.px(at)).collect::<Vec<_>>())
    }

    /// Draws what the curves lie on, frame and numbers included; the numbers
    /// and the title of the time axis if wanted.
    pub fn draw_ground(&self, canvas: &mut Canvas, below: bool) {
        let (axes, f) = (&self.axes, self.axes.frame);
        let mut expected = 0.0;
        if self.kind == Kind::Nees {
            let [bottom, top] = bands::NEES_BAND.map(|y| self.px([0.0, y])[1]);
            canvas.rectangle(&Rect { top, bottom, ..f }, &BAND);
            expected = 3.0;
        }
        axes.draw_grid(canvas);
        let at = self.px([0.0, expected])[1];
        canvas.line(&[[f.left, at], [f.right, at]], &ZERO, 1.0);
        axes.draw_frame(canvas, below);
        for at in self.kidnappings_px() {
            canvas.dashes(&[[at, f.top], [at, f.bottom]], &SOFT_INK, 1.2, 4.0);
        }
        if self.is_empty() {
            let middle = [0.5 * (f.left + f.right), 0.5 * (f.top + f.bottom) - 12.0];
            let text = "no tick has both an estimate and a truth";
            canvas.text(middle, Anchor::Middle, 13.0, &SOFT_INK, text);
        }
        axes.draw_titles(canvas, self.kind.title(), if below { self.time.title() } else { "" }, "");
    }

    /// Where on the page the robot was put elsewhere, as far as that was seen.
    fn kidnappings_px(&self) -> impl Iterator<Item = f64> {
        self.trace.kidnapped_at.iter().filter_map(|&tick| {
            let next = self.trace.stops.iter().find(|stop| stop.tick >= tick)?;
            Some(self.px([self.time.place_s(next.time_s)?, 1.0])[0])
        })
    }

    /// Draws how far an estimator's errors may reach by its covariances.
    pub fn draw_band(&self, canvas: &mut Canvas, estimator: usize) {
        let look = Look::of(estimator, self.trace.names.len());
        let reaches = &self.reaches[estimator];
        // Above and below, each with as many points as a curve.
        let bucket = (2 * reaches.len()).div_ceil(self.points);
        for line in polyline::runs(reaches) {
            let line = polyline::envelope(&line, bucket);
            let upper = self.thin(line.iter().copied());
            let lower: Vec<Px> = match self.kind {
                Kind::Heading => self.thin(line.iter().map(|&[t, reach]| [t, -reach])),
                // An area needs no more than the ends of a straight edge.
                _ => [line[0], line[line.len() - 1]].map(|[t, _]| self.px([t, 0.0])).to_vec(),
            };
            if upper.len() > 1 {
                let around: Vec<Px> = upper.iter().chain(lower.iter().rev()).copied().collect();
                canvas.band(&around, &look.ink, BAND_OPACITIES);
            }
        }
    }

    /// Draws an estimator's curve and its marks.
    pub fn draw_curve(&self, canvas: &mut Canvas, estimator: usize) {
        let look = Look::of(estimator, self.trace.names.len());
        let curve = &self.curves[estimator];
        // Two points of every bucket stay.
        let bucket = (2 * curve.len()).div_ceil(self.points);
        let width = 0.75 * look.width;
        for line in polyline::runs(curve) {
            // An error that passes ±180° goes on at the other edge, not through zero.
            let joined = |a: &[f64; 2], b: &[f64; 2]| {
                self.kind != Kind::Heading || (a[1] - b[1]).abs() <= 180.0
            };
            for part in line.chunk_by(joined) {
                let line = polyline::envelope(part, bucket);
                let line = self.thin(line.into_iter());
                match line[..] {
                    [at] => canvas.disc(at, 1.5, &look.ink),
                    _ => canvas.line(&line, &look.ink, width),
                }
            }
        }
        let marks = self.time.marks(self.trace, estimator);
        let marks = marks.into_iter().filter_map(|tick| self.time.at_s(self.trace, tick));
        let marked = marks.filter_map(|at_s| {
            let next = curve.partition_point(|(_, at)| at[0] < at_s);
            Some((curve.get(next)?.1, 3.6))
        });
        for (at, size) in marked.chain(curve.last().map(|&(_, at)| (at, 5.0))) {
            look.mark(canvas, self.px(at), size);
        }
    }
}

/// The errors of an estimator.
fn curve(trace: &RunTrace, time: &Timeline, estimator: usize, kind: Kind) -> Curve {
    let point = |s: Scored| Some((s.tick, [time.at_s(trace, s.tick)?, kind.of(&s)]));
    let finite = |(_, at): &(usize, [f64; 2])| at[1].is_finite();
    scored(trace, estimator).filter_map(point).filter(finite).collect()
}

/// The normalised squared errors of an estimator, where its covariances have
/// full rank.
fn nees(trace: &RunTrace, time: &Timeline, estimator: usize) -> Curve {
    let point = |stop: &Stop| {
        let nees = bands::nees(&stop.truth?, stop.estimate(estimator)?, &trace.reference)?;
        Some((stop.tick as usize, [time.place_s(stop.time_s)?, nees]))
    };
    trace.stops.iter().filter_map(point).collect()
}

/// How far an estimator says that it may be off.
fn reach(trace: &RunTrace, time: &Timeline, estimator: usize, kind: Kind) -> Curve {
    let point = |stop: &Stop| {
        let covariance = stop.estimate(estimator)?.covariance.as_ref()?;
        Some((stop.tick as usize, [time.place_s(stop.time_s)?, kind.reach(covariance)?]))
    };
    trace.stops.iter().filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_every_error_and_are_never_empty() {
        assert_eq!(Kind::Position.range(0.0, 0.0, 0.0), [0.0, 1.06 * LEAST_M]);
        assert_eq!(Kind::Heading.range(-180.0, 180.0, 0.0), [-180.0, 180.0]);
        assert_eq!(Kind::Heading.range(-10.0, 40.0, 0.0), [-13.0, 43.0]);
        let [low, high] = Kind::Heading.range(0.0, 0.0, 0.0);
        assert!(low < -0.05 && high > 0.05);
        assert_eq!(Kind::Nees.range(f64::INFINITY, 0.0, 0.0), NEES_LEAST);
        assert_eq!(Kind::Nees.range(0.0, 1e300, 0.0), NEES_MOST);
    }

    #[test]
    fn a_band_is_seen_whole_unless_it_would_flatten_the_errors() {
        assert_eq!(Kind::Position.range(0.0, 1.0, 2.0), [0.0, 2.12]);
        assert_eq!(Kind::Position.range(0.0, 1.0, 1e9), [0.0, 1.06 * BAND_SHARE]);
        assert_eq!(Kind::Heading.range(-1.0, 2.0, 5.0)[1], 5.6);
        assert_eq!(Kind::Heading.range(-1.0, 2.0, 180.0)[1], 6.72);
    }
}
