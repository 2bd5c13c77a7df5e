//! A floor seen from above: walls, paths, robots.

use rusty_geometry::{Material, WallSpec, trig};

use crate::axes::Axes;
use crate::canvas::{Canvas, Px};
use crate::style::{DOOR, GLASS, INK, RGBColor, WALL, WHITE};

/// Draws walls, glass and doors, as far as they are in the frame.
pub fn draw_walls(canvas: &mut Canvas, axes: &Axes, walls: &[WallSpec]) {
    // Doors last: a door often shares its ends with a wall.
    for order in 0..3 {
        for wall in walls {
            let (rank, (ink, width)) = match wall.material {
                Material::Wall => (0, WALL),
                Material::Glass => (1, GLASS),
                Material::Door(_) => (2, DOOR),
            };
            if rank == order {
                draw_line(canvas, axes, &[wall.a, wall.b], (&ink, width));
            }
        }
    }
}

/// Draws a line through points of the data, thinned to what can be seen and cut
/// at the frame.
pub fn draw_line(
    canvas: &mut Canvas,
    axes: &Axes,
    line: &[[f64; 2]],
    (ink, width): (&RGBColor, f64),
) {
    for part in axes.seen(line) {
        canvas.line(&part, ink, width);
    }
}

/// Draws a robot at `at` that looks along `heading_rad`: where it started, or
/// where it stopped.
pub fn draw_robot(canvas: &mut Canvas, at: Px, heading_rad: f64, started: bool) {
    let (s, c) = trig::sin_cos(heading_rad);
    // The end is the larger: the last estimates often lie on top of it.
    let radius = if started { 7.0 } else { 9.5 };
    let nose = [at[0] + 2.0 * radius * c, at[1] - 2.0 * radius * s];
    canvas.line(&[at, nose], &WHITE, 5.5);
    canvas.disc(at, radius + 1.5, &WHITE);
    canvas.line(&[at, nose], &INK, 2.5);
    canvas.disc(at, radius, &INK);
    if started {
        canvas.disc(at, radius - 2.4, &WHITE);
    }
}

/// A box around points, units of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Least x and y; +∞ around nothing.
    pub low: [f64; 2],
    /// Greatest x and y; −∞ around nothing.
    pub high: [f64; 2],
}

impl Default for Extent {
    /// Around nothing.
    fn default() -> Self {
        Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] }
    }
}

impl Extent {
    /// Widens the box to hold `at`, if both its numbers are finite.
    pub fn include(&mut self, at: [f64; 2]) {
        if !(at[0].is_finite() && at[1].is_finite()) {
            return;
        }
        self.low = [self.low[0].min(at[0]), self.low[1].min(at[1])];
        self.high = [self.high[0].max(at[0]), self.high[1].max(at[1])];
    }

    /// Whether it holds nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }

    /// The longer side.
    #[must_use]
    pub fn size(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1])
    }

    /// The box with `by` more on every side.
    #[must_use]
    pub fn grown(&self, by: f64) -> Self {
        Self { low: self.low.map(|v| v - by), high: self.high.map(|v| v + by) }
    }

    /// The place in the box that is nearest to `at`.
    #[must_use]
    pub fn nearest(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| at[axis].max(self.low[axis]).min(self.high[axis]))
    }

    /// Least and greatest x.
    #[must_use]
    pub fn x(&self) -> [f64; 2] {
        [self.low[0], self.high[0]]
    }

    /// Least and greatest y.
    #[must_use]
    pub fn y(&self) -> [f64; 2] {
        [self.low[1], self.high[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_holds_what_is_finite() {
        let mut extent = Extent::default();
        assert!(extent.is_empty());
        extent.include([f64::NAN, 1.0]);
        extent.include([1.0, f64::INFINITY]);
        assert!(extent.is_empty());
        extent.include([1.0, 2.0]);
        extent.include([4.0, 1.0]);
        assert!(!extent.is_empty());
        assert_eq!((extent.x(), extent.y(), extent.size()), ([1.0, 4.0], [1.0, 2.0], 3.0));
        assert_eq!(extent.grown(1.0).nearest([9.0, 1.5]), [5.0, 1.5]);
    }
}
