//! A frame with a grid, round numbers along its edges, and the way from data to
//! the page.

use crate::canvas::{Anchor, Canvas, Px, Rect};
use crate::error::PlotError;
use crate::style::{GRID, INK, SOFT_INK};

/// Size of the numbers along an edge.
const NUMBER_SIZE: f64 = 12.0;

/// Data coordinates (x right, y up) in a rectangle of the page.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// Where on the page.
    pub frame: Rect,
    /// Least and greatest x, units of the data.
    pub x: [f64; 2],
    /// Least and greatest y, units of the data.
    pub y: [f64; 2],
}

/// The round numbers k · mantissa · 10^exponent along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    mantissa: f64,
    exponent: i32,
}

impl Axes {
    /// Axes in which a unit of x is as long as one of y and that show all of
    /// `x` and `y`; the shorter of the two is widened to fill the frame.
    #[must_use]
    pub fn equal(frame: Rect, x: [f64; 2], y: [f64; 2]) -> Self {
        let per_unit = ((x[1] - x[0]) / frame.width()).max((y[1] - y[0]) / frame.height());
        let around = |range: [f64; 2], length: f64| {
            let (middle, half) = (0.5 * (range[0] + range[1]), 0.5 * per_unit * length);
            [middle - half, middle + half]
        };
        Self { frame, x: around(x, frame.width()), y: around(y, frame.height()) }
    }

    /// The place of a point of the data on the page.
    #[must_use]
    pub fn px(&self, at: [f64; 2]) -> Px {
        let right = (at[0] - self.x[0]) / (self.x[1] - self.x[0]);
        let up = (at[1] - self.y[0]) / (self.y[1] - self.y[0]);
        let f = &self.frame;
        [f.left + right * f.width(), f.bottom - up * f.height()]
    }

    /// Whether a place lies in the frame.
    #[must_use]
    pub fn holds(&self, [x, y]: Px) -> bool {
        let f = &self.frame;
        (f.left..=f.right).contains(&x) && (f.top..=f.bottom).contains(&y)
    }

    /// Draws the grid; data go on top of it.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_grid(&self, canvas: &mut Canvas<'_>, x: Step, y: Step) -> Result<(), PlotError> {
        let f = &self.frame;
        for (value, _) in x.numbers(self.x) {
            let at = self.px([value, self.y[0]])[0];
            canvas.line(&[[at, f.top], [at, f.bottom]], &GRID, 1.0)?;
        }
        for (value, _) in y.numbers(self.y) {
            let at = self.px([self.x[0], value])[1];
            canvas.line(&[[f.left, at], [f.right, at]], &GRID, 1.0)?;
        }
        Ok(())
    }

    /// Draws the frame, and, where wanted, the numbers along its lower and its
    /// left edge.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn draw_frame(
        &self,
        canvas: &mut Canvas<'_>,
        x: Option<Step>,
        y: impl Into<Option<Step>>,
    ) -> Result<(), PlotError> {
        let f = &self.frame;
        let corners = [[f.left, f.top], [f.left, f.bottom], [f.right, f.bottom], [f.right, f.top]];
        canvas.line(&[&corners[..], &corners[..2]].concat(), &SOFT_INK, 1.0)?;
        for (value, text) in y.into().into_iter().flat_map(|step| step.numbers(self.y)) {
            let at = self.px([self.x[0], value])[1];
            canvas.line(&[[f.left - 5.0, at], [f.left, at]], &SOFT_INK, 1.0)?;
            canvas.text([f.left - 9.0, at + 4.2], Anchor::End, NUMBER_SIZE, &INK, &text)?;
        }
        for (value, text) in x.into_iter().flat_map(|step| step.numbers(self.x)) {
            let at = self.px([value, self.y[0]])[0];
            canvas.line(&[[at, f.bottom], [at, f.bottom + 5.0]], &SOFT_INK, 1.0)?;
            canvas.text([at, f.bottom + 18.0], Anchor::Middle, NUMBER_SIZE, &INK, &text)?;
        }
        Ok(())
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

    /// As [`Step::of`], for degrees: quarters of a turn where the span is wide.
    #[must_use]
    pub fn of_degrees(span: f64, most: f64) -> Self {
        if span > 180.0 { Self { mantissa: 9.0, exponent: 1 } } else { Self::of(span, most) }
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
        let turn = Step::of_degrees(360.0, 5.0);
        let marks: Vec<f64> = turn.numbers([-180.0, 180.0]).map(|(v, _)| v).collect();
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
        let axes = Axes::equal(frame, [0.0, 4.0], [0.0, 4.0]);
        assert_eq!((axes.x, axes.y), ([-2.0, 6.0], [0.0, 4.0]));
        assert_eq!(axes.px([0.0, 0.0]), [60.0, 120.0]);
        assert_eq!(axes.px([4.0, 4.0]), [160.0, 20.0]);
        assert!(axes.holds([60.0, 120.0]) && !axes.holds([60.0, 121.0]));
    }
}
