//! A frame with a grid, round numbers along its edges, linear or logarithmic, and
//! the way from data to the page.

use rusty_geometry::trig;

use crate::canvas::{Anchor, Canvas, Px, Rect};
use crate::polyline;
use crate::style::{GRID, INK, SOFT_INK};

/// Size of the numbers along an edge.
const NUMBER_SIZE: f64 = 12.0;
/// Size of titles.
const TITLE_SIZE: f64 = 13.0;
/// Fewest numbers along a logarithmic edge, where there can be as many.
const FEWEST: usize = 3;
/// Least distance between the lines of a logarithmic grid, units of the page.
const CLOSEST: f64 = 8.0;
/// Which multiples of a power of ten have a number; the first list that gives
/// enough of them is taken.
const MULTIPLES: [&[u8]; 3] = [&[1], &[1, 2, 5], &[1, 2, 3, 4, 5, 6, 7, 8, 9]];

/// Data coordinates (x right, y up) in a rectangle of the page.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// Where on the page.
    pub frame: Rect,
    /// Along the lower edge.
    pub x: Axis,
    /// Along the left edge.
    pub y: Axis,
}

/// What an edge of a frame shows.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Least and greatest value, units of the data; above zero if logarithmic.
    pub range: [f64; 2],
    numbers: Numbers,
}

#[derive(Clone, Copy, Debug)]
enum Numbers {
    /// None at all.
    None,
    /// Multiples of a step.
    Every(Step),
    /// Multiples of powers of ten, by their logarithms.
    Powers,
}

/// The round numbers k · mantissa · 10^exponent along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    mantissa: f64,
    exponent: i32,
}

impl Axis {
    /// A linear axis with at most about `most` numbers.
    #[must_use]
    pub fn linear(range: [f64; 2], most: f64) -> Self {
        Self { range, numbers: Numbers::Every(Step::of(range[1] - range[0], most)) }
    }

    /// As [`Axis::linear`], for degrees: quarters of a turn where the range is wide.
    #[must_use]
    pub fn degrees(range: [f64; 2], most: f64) -> Self {
        let quarters = Step { mantissa: 9.0, exponent: 1 };
        match range[1] - range[0] > 180.0 {
            true => Self { range, numbers: Numbers::Every(quarters) },
            false => Self::linear(range, most),
        }
    }

    /// A logarithmic axis: equal ratios are equally long.
    #[must_use]
    pub fn log(range: [f64; 2]) -> Self {
        Self { range, numbers: Numbers::Powers }
    }

    /// An axis without numbers and grid.
    #[must_use]
    pub fn plain(range: [f64; 2]) -> Self {
        Self { range, numbers: Numbers::None }
    }

    /// How far along the axis a value lies, 0 to 1 within its range. What is not
    /// above zero has no place on a logarithmic axis: it is not finite.
    fn share(&self, value: f64) -> f64 {
        let scale = |v: f64| match self.numbers {
            Numbers::Powers => trig::ln(v),
            _ => v,
        };
        let [low, high] = self.range.map(scale);
        (scale(value) - low) / (high - low)
    }

    /// The numbers to be read, with their texts.
    fn numbers(&self) -> Vec<(f64, String)> {
        match self.numbers {
            Numbers::None => Vec::new(),
            Numbers::Every(step) => step.numbers(self.range).collect(),
            Numbers::Powers => labels(self.range),
        }
    }

    /// The lines of the grid: at every number, and of a logarithmic axis at all
    /// multiples that `length` units of the page leave room for.
    fn lines(&self, length: f64) -> Vec<(f64, String)> {
        let fine = match self.numbers {
            Numbers::Powers => multiples(self.range, MULTIPLES[2]),
            _ => Vec::new(),
        };
        let crowded = fine.len() as f64 * CLOSEST > length;
        if fine.is_empty() || crowded { self.numbers() } else { fine }
    }
}

impl Axes {
    /// Axes in which a unit of x is as long as one of y and that show all of
    /// `x` and `y`; the shorter of the two is widened to fill the frame. Both
    /// have the same step, at most about `most` times along the longer: the cells
    /// of the grid are square.
    #[must_use]
    pub fn equal(frame: Rect, x: [f64; 2], y: [f64; 2], most: f64) -> Self {
        let per_unit = ((x[1] - x[0]) / frame.width()).max((y[1] - y[0]) / frame.height());
        let around = |range: [f64; 2], length: f64| {
            let (middle, half) = (0.5 * (range[0] + range[1]), 0.5 * per_unit * length);
            [middle - half, middle + half]
        };
        let [x, y] = [around(x, frame.width()), around(y, frame.height())];
        let step = Step::of((x[1] - x[0]).max(y[1] - y[0]), most);
        let axis = |range| Axis { range, numbers: Numbers::Every(step) };
        Self { frame, x: axis(x), y: axis(y) }
    }

    /// The place of a point of the data on the page.
    #[must_use]
    pub fn px(&self, at: [f64; 2]) -> Px {
        let f = &self.frame;
        let [right, up] = [self.x.share(at[0]), self.y.share(at[1])];
        [f.left + right * f.width(), f.bottom - up * f.height()]
    }

    /// Whether a place is in the frame.
    #[must_use]
    pub fn holds(&self, [x, y]: Px) -> bool {
        let f = &self.frame;
        (f.left..=f.right).contains(&x) && (f.top..=f.bottom).contains(&y)
    }

    /// The parts of a line through points of the data that are seen: thinned to
    /// what can be told apart and cut at the frame.
    #[must_use]
    pub fn seen(&self, line: &[[f64; 2]]) -> Vec<Vec<Px>> {
        let line: Vec<Px> = line.iter().map(|&at| self.px(at)).collect();
        polyline::clip(&polyline::thin(&line), &self.frame)
    }

    /// Draws the grid; data go on top of it.
    pub fn draw_grid(&self, canvas: &mut Canvas) {
        let f = &self.frame;
        for (value, _) in self.x.lines(f.width()) {
            let at = self.px([value, self.y.range[0]])[0];
            canvas.line(&[[at, f.top], [at, f.bottom]], &GRID, 1.0);
        }
        for (value, _) in self.y.lines(f.height()) {
            let at = self.px([self.x.range[0], value])[1];
            canvas.line(&[[f.left, at], [f.right, at]], &GRID, 1.0);
        }
    }

    /// Draws the frame, the numbers along its left and, if `below`, those along
    /// its lower edge.
    pub fn draw_frame(&self, canvas: &mut Canvas, below: bool) {
        let f = &self.frame;
        let corners = [[f.left, f.top], [f.left, f.bottom], [f.right, f.bottom], [f.right, f.top]];
        canvas.line(&[&corners[..], &corners[..2]].concat(), &SOFT_INK, 1.0);
        for (value, text) in self.y.numbers() {
            let at = self.px([self.x.range[0], value])[1];
            canvas.line(&[[f.left - 5.0, at], [f.left, at]], &SOFT_INK, 1.0);
            canvas.text([f.left - 9.0, at + 4.2], Anchor::End, NUMBER_SIZE, &INK, &text);
        }
        for (value, text) in self.x.numbers().into_iter().filter(|_| below) {
            let at = self.px([value, self.y.range[0]])[0];
            canvas.line(&[[at, f.bottom], [at, f.bottom + 5.0]], &SOFT_INK, 1.0);
            canvas.text([at, f.bottom + 18.0], Anchor::Middle, NUMBER_SIZE, &INK, &text);
        }
    }

    /// Writes titles: above the frame, below it, and along its left edge.
    pub fn draw_titles(&self, canvas: &mut Canvas, above: &str, x: &str, y: &str) {
        let f = &self.frame;
        let [across, down] = [0.5 * (f.left + f.right), 0.5 * (f.top + f.bottom)];
        for (at, anchor, text) in [
            ([f.left, f.top - 8.0], Anchor::Start, above),
            ([across, f.bottom + 37.0], Anchor::Middle, x),
            ([f.left - 40.0, down], Anchor::Upwards, y),
        ] {
            if !text.is_empty() {
                canvas.text(at, anchor, TITLE_SIZE, &INK, text);
            }
        }
    }
}

impl Step {
    /// The finest of 1, 2, 5 times a power of ten that goes into `span` at most
    /// `most` times.
    #[must_use]
    pub fn of(span: f64, most: f64) -> Self {
        let wanted = span / most;
        if !(wanted.is_finite() && wanted > 0.0) {
            return Self { mantissa: 1.0, exponent: 0 };
        }
        let (mut rest, mut exponent) = (wanted, 0);
        while rest >= 10.0 {
            rest /= 10.0;
            exponent += 1;
        }
        while rest < 1.0 {
            rest *= 10.0;
            exponent -= 1;
        }
        let mantissa = [1.0, 2.0, 5.0].into_iter().find(|&m| rest <= m * (1.0 + 1e-9));
        match mantissa {
            Some(mantissa) => Self { mantissa, exponent },
            None => Self { mantissa: 1.0, exponent: exponent + 1 },
        }
    }

    /// The step itself.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.multiple(1.0)
    }

    /// k steps: whole numbers scaled once, so that 3 · 0.1 is 0.3.
    fn multiple(&self, k: f64) -> f64 {
        let power = (0..self.exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
        let whole = k * self.mantissa;
        if self.exponent < 0 { whole / power } else { whole * power }
    }

    /// The round numbers in `range` with their texts.
    pub fn numbers(self, range: [f64; 2]) -> impl Iterator<Item = (f64, String)> {
        let slack = 1e-9 * (range[1] - range[0]);
        let first = ((range[0] - slack) / self.size()).ceil();
        let last = ((range[1] + slack) / self.size()).floor();
        // Ranges so narrow or far out that numbers no longer differ show none.
        let count = if last - first < 100.0 { (last - first + 1.0) as u32 } else { 0 };
        (0..count).map(move |i| {
            let k = first + f64::from(i);
            (self.multiple(k), self.text(k))
        })
    }

    fn text(&self, k: f64) -> String {
        let value = self.multiple(k);
        let text = if value.abs() >= 1e6 || (self.exponent < -6 && k != 0.0) {
            format!("{value:e}")
        } else {
            let decimals = usize::try_from(-self.exponent).unwrap_or(0);
            format!("{:.*}", decimals, value + 0.0)
        };
        text.replace('-', "−")
    }
}

/// The numbers to be read along a logarithmic axis, with their texts.
fn labels(range: [f64; 2]) -> Vec<(f64, String)> {
    let lists = MULTIPLES.map(|list| multiples(range, list));
    let [coarse, middle, fine] = lists;
    [coarse, middle].into_iter().find(|list| list.len() >= FEWEST).unwrap_or(fine)
}

/// The multiples in `list` of powers of ten in `range`.
fn multiples(range: [f64; 2], list: &[u8]) -> Vec<(f64, String)> {
    let [low, high] = range;
    let mut found = Vec::new();
    for exponent in -30..=30_i32 {
        let power = (0..exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
        for &multiple in list {
            let whole = f64::from(multiple);
            let value = if exponent < 0 { whole / power } else { whole * power };
            if value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9) {
                found.push((value, text(multiple, exponent)));
            }
        }
    }
    found
}

/// A multiple of a power of ten, in full where that is short.
fn text(multiple: u8, exponent: i32) -> String {
    match exponent {
        -5..=-1 => format!("0.{}{multiple}", "0".repeat((-exponent - 1) as usize)),
        // Six digits do not fit next to a chart where its letters are large.
        0..=4 => format!("{multiple}{}", "0".repeat(exponent as usize)),
        _ => format!("{multiple}e{exponent}").replace('-', "−"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(range: [f64; 2], most: f64) -> Vec<String> {
        let step = Step::of(range[1] - range[0], most);
        step.numbers(range).map(|(_, text)| text).collect()
    }

    #[test]
    fn numbers_are_round_and_short() {
        assert_eq!(texts([0.0, 30.0], 8.0), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(texts([-0.3, 0.35], 8.0), ["−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(texts([0.0, 0.001], 2.0), ["0.0000", "0.0005", "0.0010"]);
        assert_eq!(texts([0.0, 2e7], 2.0), ["0", "1e7", "2e7"]);
        assert_eq!(texts([0.0, 1e300], 1.0).len(), 2);
        assert_eq!(texts([999_990.0, 1_000_000.0], 2.0), ["999990", "999995", "1e6"]);
        let turn = Axis::degrees([-180.0, 180.0], 5.0).numbers();
        let marks: Vec<f64> = turn.into_iter().map(|(v, _)| v).collect();
        assert_eq!(marks, [-180.0, -90.0, 0.0, 90.0, 180.0]);
    }

    #[test]
    fn a_range_that_is_none_does_no_harm() {
        for range in [[0.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [1.0, -1.0]] {
            assert!(texts(range, 5.0).len() < 10, "{range:?}");
        }
    }

    #[test]
    fn a_metre_is_a_metre_both_ways() {
        let frame = Rect { left: 10.0, top: 20.0, right: 210.0, bottom: 120.0 };
        let axes = Axes::equal(frame, [0.0, 4.0], [0.0, 4.0], 9.0);
        assert_eq!((axes.x.range, axes.y.range), ([-2.0, 6.0], [0.0, 4.0]));
        assert_eq!(axes.px([0.0, 0.0]), [60.0, 120.0]);
        assert_eq!(axes.px([4.0, 4.0]), [160.0, 20.0]);
        assert!(axes.holds([60.0, 120.0]) && !axes.holds([60.0, 121.0]));
    }

    fn powers(range: [f64; 2]) -> Vec<String> {
        labels(range).into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn there_are_enough_numbers_and_not_too_many() {
        assert_eq!(powers([0.01, 100.0]), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(powers([0.05, 3.0]), ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(powers([2.0, 4.5]), ["2", "3", "4"]);
        assert_eq!(powers([1e-7, 1e-5]), ["1e−7", "1e−6", "0.00001"]);
        assert_eq!(powers([1e2, 1e6]), ["100", "1000", "10000", "1e5", "1e6"]);
        assert!(powers([f64::NAN, 1.0]).is_empty());
    }

    #[test]
    fn one_axis_may_be_logarithmic() {
        let frame = Rect { left: 0.0, top: 0.0, right: 200.0, bottom: 100.0 };
        let axes = Axes { frame, x: Axis::linear([0.0, 10.0], 5.0), y: Axis::log([0.1, 10.0]) };
        let px = axes.px([5.0, 1.0]);
        assert!((px[0] - 100.0).abs() < 1e-9 && (px[1] - 50.0).abs() < 1e-9);
        assert!(!axes.px([0.0, 0.0])[1].is_finite());
        let svg = crate::paint((200.0, 100.0), "", |canvas| {
            axes.draw_grid(canvas);
            axes.draw_frame(canvas, true);
        });
        for number in ["\n0.1\n", "\n1\n", "\n10\n", "\n4\n"] {
            assert!(svg.contains(number), "{number:?} is missing");
        }
    }

    #[test]
    fn a_decade_is_as_long_as_the_next() {
        let frame = Rect { left: 0.0, top: 0.0, right: 200.0, bottom: 100.0 };
        let axes = Axes { frame, x: Axis::log([0.1, 10.0]), y: Axis::log([1.0, 100.0]) };
        for (at, expected) in [([0.1, 1.0], [0.0, 100.0]), ([1.0, 10.0], [100.0, 50.0])] {
            let px = axes.px(at);
            assert!((px[0] - expected[0]).abs() < 1e-9 && (px[1] - expected[1]).abs() < 1e-9);
        }
        assert!(!axes.px([0.0, 1.0])[0].is_finite());
    }
}
