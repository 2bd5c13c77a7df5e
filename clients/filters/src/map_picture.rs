//! A picture of a grid: how probable each cell is to be occupied, the path of
//! the robot on it, and metres along its edges.

use rusty_plot::floor::draw_line;
use rusty_plot::style::{INK, Look, RGBColor};
use rusty_plot::{Anchor, Axes, Canvas, Rect, paint};

use crate::{GridFrame, OccupancyGrid};

/// Longest side of the map on the page, units of the page.
const LONGEST: f64 = 1000.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 40.0;
const RIGHT: f64 = 20.0;
const BOTTOM: f64 = 40.0;
/// Levels of grey; one more is for what is not known.
const LEVELS: usize = 8;
const UNKNOWN: RGBColor = RGBColor(198, 204, 212);

/// Draws the part of a grid that is known, and a path (world frame, m) on it, as
/// the text of an SVG file.
#[must_use]
pub fn svg(
    grid: &OccupancyGrid,
    (corner, frame): ([usize; 2], GridFrame),
    title: &str,
    path: &[[f64; 2]],
) -> String {
    // Of a large map several cells are one square; a square is a whole number of
    // pixels, of which a unit of the page has two.
    let side = frame.width.max(frame.height) as f64;
    let cells = (side / (2.0 * LONGEST)).ceil().max(1.0) as usize;
    let px = (2.0 * LONGEST * cells as f64 / side).floor().clamp(1.0, 40.0) * 0.5;
    let [columns, rows] = [frame.width, frame.height].map(|n| n.div_ceil(cells));
    let (width, height) = (columns as f64 * px, rows as f64 * px);
    let rect = Rect { left: LEFT, top: TOP, right: LEFT + width, bottom: TOP + height };
    let metres = |n: usize| (n * cells) as f64 * frame.cell_m;
    let (x0, y0) = (frame.origin_m.x, frame.origin_m.y);
    let axes = Axes::equal(rect, [x0, x0 + metres(columns)], [y0, y0 + metres(rows)], 12.0);
    let squares = Squares { grid, corner, frame, cells };
    paint((width + LEFT + RIGHT, height + TOP + BOTTOM), title, |canvas| {
        canvas.text([LEFT, TOP - 14.0], Anchor::Start, 15.0, &INK, title);
        canvas.rectangle(&rect, &UNKNOWN);
        for row in 0..rows {
            squares.draw_row(canvas, &rect, (row, columns), px);
        }
        draw_line(canvas, &axes, path, (&Look::of(0, 1).ink, 1.5));
        axes.draw_frame(canvas, true);
    })
}

/// The grid in squares of several cells each.
struct Squares<'a> {
    grid: &'a OccupancyGrid,
    corner: [usize; 2],
    frame: GridFrame,
    cells: usize,
}

impl Squares<'_> {
    /// Draws a row of squares, as many of one grey at once as there are.
    fn draw_row(&self, canvas: &mut Canvas, rect: &Rect, (row, columns): (usize, usize), px: f64) {
        let greys: Vec<Option<usize>> = (0..columns).map(|column| self.grey(column, row)).collect();
        let bottom = rect.bottom - row as f64 * px;
        let mut from = 0;
        for run in greys.chunk_by(|a, b| a == b) {
            if let Some(level) = run[0] {
                let value = 255 - (level * 255 / (LEVELS - 1)) as u8;
                let left = rect.left + from as f64 * px;
                let right = left + run.len() as f64 * px;
                let square = Rect { left, top: bottom - px, right, bottom };
                canvas.rectangle(&square, &RGBColor(value, value, value));
            }
            from += run.len();
        }
    }

    /// How dark a square is: as its cell that is occupied most probably; `None`
    /// if none of them is known.
    fn grey(&self, column: usize, row: usize) -> Option<usize> {
        let mut most: Option<usize> = None;
        for y in (row * self.cells..(row + 1) * self.cells).take_while(|y| *y < self.frame.height) {
            for x in (column * self.cells..(column + 1) * self.cells)
                .take_while(|x| *x < self.frame.width)
            {
                let cell = (y + self.corner[1]) * self.grid.frame().width + x + self.corner[0];
                let odds = self.grid.log_odds(cell);
                if odds != 0.0 && most.is_none_or(|most| odds > self.grid.log_odds(most)) {
                    most = Some(cell);
                }
            }
        }
        let p = self.grid.probability(most?);
        Some((p * LEVELS as f64).floor().clamp(0.0, (LEVELS - 1) as f64) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Beams;
    use crate::occupancy_grid::InverseModel;
    use rusty_contract::LidarConfig;
    use rusty_geometry::SE2;

    #[test]
    fn walls_are_dark_and_floors_are_light() {
        let lidar = LidarConfig::default();
        let (beams, mut grid) = (Beams::new(&lidar), OccupancyGrid::new(InverseModel::default()));
        assert!(grid.known().is_none());
        for _ in 0..10 {
            grid.add(&SE2::identity(), &[1.0; 180], &beams).unwrap();
        }
        let path = [[0.0, 0.0], [0.5, 0.5]];
        let drawn = svg(&grid, grid.known().unwrap(), "a <round> room", &path);
        assert!(drawn.contains("a &lt;round&gt; room") && drawn.contains("#000000"));
        assert!(rusty_plot::png(&drawn).unwrap().starts_with(b"\x89PNG"));
    }
}
