//! Colours, widths and marks of the picture.
//!
//! Source of the colours: M. Okabe and K. Ito, *Color Universal Design* (2008),
//! a set that people with any of the usual colour deficiencies tell apart. A
//! colour is never alone: every estimator also has a separate mark.

pub use crate::canvas::RGBColor;

use crate::canvas::{Canvas, Px};

/// Text and frames.
pub const INK: RGBColor = RGBColor(26, 26, 26);
/// Lesser text.
pub const SOFT_INK: RGBColor = RGBColor(85, 85, 85);
/// Lines of the grid.
pub const GRID: RGBColor = RGBColor(232, 232, 232);
/// The line of no error.
pub const ZERO: RGBColor = RGBColor(150, 150, 150);
/// Where values are that are as they should be.
pub const BAND: RGBColor = RGBColor(226, 241, 232);
/// Background and rims.
pub const WHITE: RGBColor = RGBColor(255, 255, 255);
/// The true path.
pub const TRUTH: RGBColor = RGBColor(158, 158, 158);
/// Width of the true path.
pub const TRUTH_WIDTH: f64 = 7.0;
/// Points of a scan: dark rim, light heart.
pub const SCAN: RGBColor = RGBColor(240, 228, 66);

const VERMILLION: RGBColor = RGBColor(213, 94, 0);
const BLUE: RGBColor = RGBColor(0, 114, 178);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const PURPLE: RGBColor = RGBColor(204, 121, 167);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const SKY: RGBColor = RGBColor(86, 180, 233);

/// Ink and width of opaque walls.
pub const WALL: (RGBColor, f64) = (RGBColor(40, 40, 40), 3.0);
/// Ink and width of glass.
pub const GLASS: (RGBColor, f64) = (SKY, 4.0);
/// Ink and width of doors.
pub const DOOR: (RGBColor, f64) = (ORANGE, 5.0);

/// The estimators' colours; the colours of doors and glass come last.
const COLOURS: [RGBColor; 6] = [VERMILLION, BLUE, GREEN, PURPLE, ORANGE, SKY];

/// Every ink of a drawing with the one that takes its place on dark ground: as
/// bright there as it is dark on white, and as far from the others.
pub const ON_DARK: [(RGBColor, RGBColor); 15] = [
    (INK, RGBColor(230, 230, 230)),
    (SOFT_INK, RGBColor(168, 172, 178)),
    (GRID, RGBColor(48, 52, 58)),
    (ZERO, RGBColor(110, 114, 120)),
    (WHITE, RGBColor(22, 24, 28)),
    (TRUTH, RGBColor(122, 126, 132)),
    (WALL.0, RGBColor(205, 207, 210)),
    (SCAN, RGBColor(214, 200, 40)),
    (VERMILLION, RGBColor(242, 122, 46)),
    (BLUE, RGBColor(64, 150, 222)),
    (GREEN, RGBColor(24, 190, 142)),
    (PURPLE, RGBColor(222, 148, 188)),
    (ORANGE, RGBColor(240, 182, 54)),
    (SKY, RGBColor(150, 216, 255)),
    (BAND, RGBColor(38, 62, 52)),
];

/// How one estimator is drawn, everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Its colour.
    pub ink: RGBColor,
    /// Width of its lines on the map. Later ones are thinner, so that two
    /// estimators in one place are both seen.
    pub width: f64,
    index: usize,
}

impl Look {
    /// The look of estimator `index` of `count`.
    #[must_use]
    pub fn of(index: usize, count: usize) -> Self {
        let rank = index as f64 / count.saturating_sub(1).max(1) as f64;
        let width = if count < 2 { 2.2 } else { 3.2 - 1.8 * rank };
        Self { ink: COLOURS[index % COLOURS.len()], width, index }
    }

    /// Its colours on light and on dark ground.
    #[must_use]
    pub fn inks(&self) -> [RGBColor; 2] {
        let dark = ON_DARK.iter().find(|(light, _)| *light == self.ink);
        [self.ink, dark.map_or(self.ink, |(_, dark)| *dark)]
    }

    /// Draws its mark, `size` units in radius, with a white rim.
    pub fn mark(&self, canvas: &mut Canvas, at: Px, size: f64) {
        // After all colours are used up the shapes move on by one, so that no
        // two of the sixteen possible estimators share both.
        let shape = (self.index + self.index / COLOURS.len()) % (SHAPES.len() + 1);
        if shape == 0 {
            canvas.disc(at, size + 1.2, &WHITE);
            return canvas.disc(at, size, &self.ink);
        }
        let corners = SHAPES[shape - 1];
        let place = |radius: f64| -> Vec<Px> {
            corners.iter().map(|[x, y]| [at[0] + radius * x, at[1] + radius * y]).collect()
        };
        canvas.polygon(&place(size + 1.8), &WHITE);
        canvas.polygon(&place(size), &self.ink);
    }

    /// Draws what stands before its name: `length` of its line to the right of
    /// `at`, with its mark in the middle.
    pub fn swatch(&self, canvas: &mut Canvas, at: Px, length: f64, size: f64) {
        canvas.line(&[at, [at[0] + length, at[1]]], &self.ink, self.width);
        self.mark(canvas, [at[0] + 0.5 * length, at[1]], size);
    }
}

/// Corners of square, two triangles, diamond and plus, about radius 1.
const SHAPES: [&[[f64; 2]]; 5] = [
    &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
    &[[0.0, -1.25], [1.15, 0.8], [-1.15, 0.8]],
    &[[0.0, -1.3], [1.0, 0.0], [0.0, 1.3], [-1.0, 0.0]],
    &[[0.0, 1.25], [1.15, -0.8], [-1.15, -0.8]],
    &[
        [-0.4, -1.2],
        [0.4, -1.2],
        [0.4, -0.4],
        [1.2, -0.4],
        [1.2, 0.4],
        [0.4, 0.4],
        [0.4, 1.2],
        [-0.4, 1.2],
        [-0.4, 0.4],
        [-1.2, 0.4],
        [-1.2, -0.4],
        [-0.4, -0.4],
    ],
];

/// A number for the table, about four digits; an en dash where there is none.
#[must_use]
pub fn figure(value: Option<f64>) -> String {
    match value {
        None => "–".to_owned(),
        Some(v) if !v.is_finite() => "∞".to_owned(),
        Some(v) if v.abs() < 10.0 => format!("{v:.3}"),
        Some(v) if v.abs() < 100.0 => format!("{v:.2}"),
        Some(v) if v.abs() < 1e5 => format!("{v:.0}"),
        Some(v) => format!("{v:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_estimators_have_sixteen_looks() {
        let look = |index| {
            crate::canvas::paint((20.0, 20.0), "", |canvas| {
                Look::of(index, 16).mark(canvas, [10.0, 10.0], 5.0)
            })
        };
        let looks: std::collections::BTreeSet<String> = (0..16).map(look).collect();
        assert_eq!(looks.len(), 16);
    }

    #[test]
    fn every_ink_has_one_for_dark_ground_and_no_two_share_it() {
        let inks = [INK, SOFT_INK, GRID, ZERO, WHITE, TRUTH, SCAN, BAND, WALL.0, GLASS.0, DOOR.0];
        for ink in inks.into_iter().chain(COLOURS) {
            assert_eq!(ON_DARK.iter().filter(|(light, _)| *light == ink).count(), 1, "{ink:?}");
        }
        let dark: std::collections::BTreeSet<String> =
            ON_DARK.iter().map(|(_, dark)| dark.to_string()).collect();
        assert_eq!(dark.len(), ON_DARK.len());
        // As the backend writes it, or no rule would find it.
        let svg = crate::canvas::paint((9.0, 9.0), "", |c| c.disc([1.0, 1.0], 1.0, &SCAN));
        assert!(svg.contains(&format!("fill=\"{}\"", SCAN)), "{svg}");
    }

    #[test]
    fn figures_stay_short() {
        for (value, text) in [
            (None, "–"),
            (Some(0.012_345), "0.012"),
            (Some(12.345), "12.35"),
            (Some(1234.5), "1234"),
            (Some(1.25e9), "1.2e9"),
            (Some(f64::INFINITY), "∞"),
        ] {
            assert_eq!(figure(value), text);
        }
    }
}
