//! Parts that pages have in common: title, legend, and rows of figures.

use crate::canvas::{Anchor, Canvas, Px, shortened};
use crate::style::{GRID, INK, Look, SOFT_INK};

/// Writes the title of a page, and its details in a line below.
pub fn draw_title(canvas: &mut Canvas, left: f64, title: &str, details: &str) {
    canvas.text([left, 36.0], Anchor::Start, 23.0, &INK, title);
    canvas.text([left, 60.0], Anchor::Start, 14.0, &SOFT_INK, details);
}

/// A line of names, each after what it is drawn as.
#[derive(Clone, Copy, Debug)]
pub struct Legend {
    /// Where the next entry begins, on its middle line.
    pub at: Px,
}

impl Legend {
    /// Width of what stands before a name.
    pub const SWATCH: f64 = 32.0;

    /// Returns the width of an entry.
    #[must_use]
    pub fn width(name: &str) -> f64 {
        Self::SWATCH + 26.0 + 6.8 * name.chars().count() as f64
    }

    /// Height of a line of entries.
    pub const LINE: f64 = 22.0;

    /// The legends of these names, one each, in lines from `at` to the edge at `right`.
    pub fn wrapped<'n>(
        names: impl IntoIterator<Item = &'n str>,
        at: Px,
        right: f64,
    ) -> impl Iterator<Item = Self> {
        let mut next = Self { at };
        names.into_iter().map(move |name| {
            let width = Self::width(name);
            if next.at[0] + width > right && next.at[0] > at[0] {
                next.at = [at[0], next.at[1] + Self::LINE];
            }
            let place = next;
            next.at[0] += width;
            place
        })
    }

    /// Adds an entry. `draw` is given the left end of its middle line.
    pub fn entry(&mut self, canvas: &mut Canvas, name: &str, draw: impl FnOnce(&mut Canvas, Px)) {
        let [x, y] = self.at;
        draw(canvas, [x, y]);
        canvas.text([x + Self::SWATCH + 8.0, y + 4.0], Anchor::Start, 13.0, &INK, name);
        self.at[0] += Self::width(name);
    }

    /// Adds an estimator: its line with its mark.
    pub fn estimator(&mut self, canvas: &mut Canvas, name: &str, look: &Look) {
        self.entry(canvas, name, |canvas, at| look.swatch(canvas, at, Self::SWATCH, 4.0));
    }
}

/// Rows of figures: what something is drawn as, its name, and its figures in
/// columns that end at the same places.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// From where to where.
    pub x: [f64; 2],
    /// Right edges of the columns.
    pub columns: &'a [f64],
    /// Height of a row.
    pub height: f64,
}

impl Rows<'_> {
    /// Writes what stands above the columns, and a line below it at `y`; each
    /// head has one or more lines.
    pub fn draw_head(&self, canvas: &mut Canvas, y: f64, heads: &[&[&str]]) {
        for (x, lines) in self.columns.iter().zip(heads) {
            for (k, line) in lines.iter().rev().enumerate() {
                let at = [*x, y - 7.0 - 15.0 * k as f64];
                canvas.text(at, Anchor::End, 12.0, &SOFT_INK, line);
            }
        }
        canvas.line(&[[self.x[0], y], [self.x[1], y]], &SOFT_INK, 1.0);
    }

    /// Draws a row about `y`, with a line below it.
    pub fn draw(&self, canvas: &mut Canvas, y: f64, (look, name): (&Look, &str), row: &[String]) {
        let ([left, right], below) = (self.x, y + 0.5 * self.height);
        look.swatch(canvas, [left, y], 28.0, 4.2);
        let widest = row.first().map_or(0, |figure| figure.chars().count().max(6));
        let room = self.columns.first().map_or(right, |x| x - 7.0 * widest as f64) - left - 36.0;
        // A letter is about 0.55 of its size wide in the wider ones of usual fonts.
        let name = shortened(name, (room / (0.55 * 7.0)) as usize);
        let size = (room / (0.55 * name.chars().count().max(1) as f64)).min(13.0);
        canvas.text([left + 36.0, y + 4.5], Anchor::Start, size, &INK, &name);
        for (x, figure) in self.columns.iter().zip(row) {
            canvas.text([*x, y + 4.5], Anchor::End, 13.0, &INK, &figure.replace('-', "−"));
        }
        canvas.line(&[[left, below], [right, below]], &GRID, 1.0);
    }
}
