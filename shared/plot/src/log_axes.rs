//! A frame with logarithmic axes: a power law is a straight line in it.

use rusty_geometry::trig;

use crate::axes::Axes;
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
        for (value, _) in numbers(self.x, MULTIPLES[2]) {
            let at = self.px([value, self.y[0]])[0];
            canvas.line(&[[at, f.top], [at, f.bottom]], &GRID, 1.0)?;
        }
        for (value, _) in numbers(self.y, MULTIPLES[2]) {
            let at = self.px([self.x[0], value])[1];
            canvas.line(&[[f.left, at], [f.right, at]], &GRID, 1.0)?;
        }
        Ok(())
    }

    /// Draws the frame, and numbers along its left and lower edge.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_frame(&self, canvas: &mut Canvas<'_>) -> Result<(), PlotError> {
        let f = &self.frame;
        let corners = [[f.left, f.top], [f.left, f.bottom], [f.right, f.bottom], [f.right, f.top]];
        canvas.line(&[&corners[..], &corners[..2]].concat(), &SOFT_INK, 1.0)?;
        for (value, text) in labels(self.y) {
            let at = self.px([self.x[0], value])[1];
            canvas.line(&[[f.left - 5.0, at], [f.left, at]], &SOFT_INK, 1.0)?;
            canvas.text([f.left - 9.0, at + 4.2], Anchor::End, NUMBER_SIZE, &INK, &text)?;
        }
        for (value, text) in labels(self.x) {
            let at = self.px([value, self.y[0]])[0];
            canvas.line(&[[at, f.bottom], [at, f.bottom + 5.0]], &SOFT_INK, 1.0)?;
            canvas.text([at, f.bottom + 18.0], Anchor::Middle, NUMBER_SIZE, &INK, &text)?;
        }
        Ok(())
    }
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
        0..=5 => format!("{multiple}{}", "0".repeat(exponent as usize)),
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
        assert!(texts([f64::NAN, 1.0]).is_empty());
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
