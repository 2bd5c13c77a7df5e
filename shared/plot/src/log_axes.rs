//! Frames with logarithmic axes, both of them or one: a power law is a straight
//! line in the first, and in the other what differs by powers of ten is seen at
//! once over time.

use rusty_geometry::trig;

use crate::axes::{Axes, Step};
use crate::canvas::{Anchor, Canvas, Px, Rect};
use crate::error::PlotError;
use crate::style::{GRID, INK, SOFT_INK};

/// Size of the numbers along an edge.
const NUMBER_SIZE: f64 = 12.0;
/// Fewest numbers along an edge, where there can be as many.
const FEWEST: usize = 3;
/// Which multiples of a power of ten have a number; the first list that gives
/// enough of them is taken.
const MULTIPLES: [&[u8]; 3] = [&[1], &[1, 2, 5], &[1, 2, 3, 4, 5, 6, 7, 8, 9]];

/// Data coordinates above zero (x right, y up), by their logarithms, in a
/// rectangle of the page.
#[derive(Clone, Copy, Debug)]
pub struct LogAxes {
    /// Where on the page.
    pub frame: Rect,
    /// Least and greatest x, units of the data, above zero.
    pub x: [f64; 2],
    /// Least and greatest y, units of the data, above zero.
    pub y: [f64; 2],
}

impl LogAxes {
    /// The place of a point of the data on the page. What is not above zero has
    /// none: its place is not finite.
    #[must_use]
    pub fn px(&self, at: [f64; 2]) -> Px {
        self.linear().px([trig::ln(at[0]), trig::ln(at[1])])
    }

    /// The same frame in the logarithms of the data.
    fn linear(&self) -> Axes {
        Axes { frame: self.frame, x: self.x.map(trig::ln), y: self.y.map(trig::ln) }
    }

    /// Draws a line for every multiple of a power of ten; data go on top of it.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_grid(&self, canvas: &mut Canvas<'_>) -> Result<(), PlotError> {
        let f = &self.frame;
        self.draw_columns(canvas)?;
        for (value, _) in numbers(self.y, MULTIPLES[2]) {
            let at = self.px([self.x[0], value])[1];
            canvas.line(&[[f.left, at], [f.right, at]], &GRID, 1.0)?;
        }
        Ok(())
    }

    /// Draws the lines of the grid that stand on x alone.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_columns(&self, canvas: &mut Canvas<'_>) -> Result<(), PlotError> {
        let f = &self.frame;
        for (value, _) in numbers(self.x, MULTIPLES[2]) {
            let at = self.px([value, self.y[0]])[0];
            canvas.line(&[[at, f.top], [at, f.bottom]], &GRID, 1.0)?;
        }
        Ok(())
    }

    /// Draws the frame, and numbers along its left and lower edge.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_frame(&self, canvas: &mut Canvas<'_>) -> Result<(), PlotError> {
        draw_left_numbers(canvas, &self.frame, self.y, |y| self.px([self.x[0], y])[1])?;
        self.draw_base(canvas)
    }

    /// Draws the frame with the numbers of x alone.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_base(&self, canvas: &mut Canvas<'_>) -> Result<(), PlotError> {
        let f = &self.frame;
        self.linear().draw_frame(canvas, None, None)?;
        for (value, text) in labels(self.x) {
            let at = self.px([value, self.y[0]])[0];
            canvas.line(&[[at, f.bottom], [at, f.bottom + 5.0]], &SOFT_INK, 1.0)?;
            canvas.text([at, f.bottom + 18.0], Anchor::Middle, NUMBER_SIZE, &INK, &text)?;
        }
        Ok(())
    }
}

/// Data coordinates in a rectangle of the page: x as it is, y above zero and by
/// its logarithm.
#[derive(Clone, Copy, Debug)]
pub struct SemiLogAxes {
    /// Where on the page.
    pub frame: Rect,
    /// Least and greatest x, units of the data.
    pub x: [f64; 2],
    /// Least and greatest y, units of the data, above zero.
    pub y: [f64; 2],
}

impl SemiLogAxes {
    /// The place of a point of the data on the page. One that is not above zero
    /// has none: its place is not finite.
    #[must_use]
    pub fn px(&self, at: [f64; 2]) -> Px {
        self.linear().px([at[0], trig::ln(at[1])])
    }

    /// The same frame with the logarithms of y.
    fn linear(&self) -> Axes {
        Axes { frame: self.frame, x: self.x, y: self.y.map(trig::ln) }
    }

    /// Draws the grid: of y one line for every power of ten, or for each number
    /// that is written. Data go on top of it.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_grid(&self, canvas: &mut Canvas<'_>, x: Step) -> Result<(), PlotError> {
        let f = &self.frame;
        for (value, _) in x.numbers(self.x) {
            let at = self.px([value, self.y[0]])[0];
            canvas.line(&[[at, f.top], [at, f.bottom]], &GRID, 1.0)?;
        }
        for (value, _) in labels(self.y) {
            let at = self.px([self.x[0], value])[1];
            canvas.line(&[[f.left, at], [f.right, at]], &GRID, 1.0)?;
        }
        Ok(())
    }

    /// Draws the frame, and numbers along its left and, if wanted, lower edge.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_frame(&self, canvas: &mut Canvas<'_>, x: Option<Step>) -> Result<(), PlotError> {
        self.linear().draw_frame(canvas, x, None)?;
        draw_left_numbers(canvas, &self.frame, self.y, |y| self.px([self.x[0], y])[1])
    }
}

/// Writes the numbers of a logarithmic y along the left edge.
fn draw_left_numbers(
    canvas: &mut Canvas<'_>,
    frame: &Rect,
    y: [f64; 2],
    px_of: impl Fn(f64) -> f64,
) -> Result<(), PlotError> {
    for (value, text) in labels(y) {
        let at = px_of(value);
        canvas.line(&[[frame.left - 5.0, at], [frame.left, at]], &SOFT_INK, 1.0)?;
        canvas.text([frame.left - 9.0, at + 4.2], Anchor::End, NUMBER_SIZE, &INK, &text)?;
    }
    Ok(())
}

/// The numbers to be read along an axis, with their texts.
fn labels(range: [f64; 2]) -> Vec<(f64, String)> {
    let lists = MULTIPLES.map(|multiples| numbers(range, multiples));
    let [coarse, middle, fine] = lists;
    [coarse, middle].into_iter().find(|list| list.len() >= FEWEST).unwrap_or(fine)
}

/// The `multiples` of powers of ten in `range`.
fn numbers(range: [f64; 2], multiples: &[u8]) -> Vec<(f64, String)> {
    let [low, high] = range;
    let mut found = Vec::new();
    for exponent in -30..=30_i32 {
        let power = (0..exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
        for &multiple in multiples {
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
        // Six digits do not fit beside a chart where its letters are large.
        0..=4 => format!("{multiple}{}", "0".repeat(exponent as usize)),
        _ => format!("{multiple}e{exponent}").replace('-', "−"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(range: [f64; 2]) -> Vec<String> {
        labels(range).into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn there_are_enough_numbers_and_not_too_many() {
        assert_eq!(texts([0.01, 100.0]), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(texts([0.05, 3.0]), ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(texts([2.0, 4.5]), ["2", "3", "4"]);
        assert_eq!(texts([1e-7, 1e-5]), ["1e−7", "1e−6", "0.00001"]);
        assert_eq!(texts([1e2, 1e6]), ["100", "1000", "10000", "1e5", "1e6"]);
        assert!(texts([f64::NAN, 1.0]).is_empty());
    }

    #[test]
    fn one_axis_may_be_logarithmic() {
        let frame = Rect { left: 0.0, top: 0.0, right: 200.0, bottom: 100.0 };
        let axes = SemiLogAxes { frame, x: [0.0, 10.0], y: [0.1, 10.0] };
        let px = axes.px([5.0, 1.0]);
        assert!((px[0] - 100.0).abs() < 1e-9 && (px[1] - 50.0).abs() < 1e-9);
        assert!(!axes.px([0.0, 0.0])[1].is_finite());
        let svg = crate::paint((200.0, 100.0), "", |canvas| {
            axes.draw_grid(canvas, Step::of(10.0, 5.0))?;
            axes.draw_frame(canvas, Some(Step::of(10.0, 5.0)))
        });
        let svg = svg.unwrap();
        for number in ["\n0.1\n", "\n1\n", "\n10\n", "\n4\n"] {
            assert!(svg.contains(number), "{number:?} is missing");
        }
    }

    #[test]
    fn a_decade_is_as_long_as_the_next() {
        let frame = Rect { left: 0.0, top: 0.0, right: 200.0, bottom: 100.0 };
        let axes = LogAxes { frame, x: [0.1, 10.0], y: [1.0, 100.0] };
        for (at, expected) in [([0.1, 1.0], [0.0, 100.0]), ([1.0, 10.0], [100.0, 50.0])] {
            let px = axes.px(at);
            assert!((px[0] - expected[0]).abs() < 1e-9 && (px[1] - expected[1]).abs() < 1e-9);
        }
        assert!(!axes.px([0.0, 1.0])[0].is_finite());
    }
}
