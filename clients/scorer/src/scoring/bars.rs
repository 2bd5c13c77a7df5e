//! Bars of a histogram along a corridor: cells in one or two rows, one for each way
//! that the robot may face. Bars of the first way go up, those of the other down.
//! `shared/plot/page/draw.js` draws the same.

use rusty_contract::BeliefKind;
use rusty_geometry::trig;

use super::beliefs::{BeliefMoment, Mark};

/// Height of the bar of the heaviest cell, m.
const HIGHEST_M: f64 = 1.0;
/// Cells of a row are this close to a line, m.
const STRAIGHT_M: f64 = 0.05;
/// Part of a cell's length that its bar takes.
const PART: f64 = 0.85;

/// A cell on the line: its place along and across, m, and whether it faces along.
struct Cell {
    along_m: f64,
    across_m: f64,
    is_ahead: bool,
}

/// Returns corners of a bar for each mark of a belief, m, world frame; `None` where it is
/// no histogram along a line.
pub(crate) fn bars(belief: &BeliefMoment) -> Option<Vec<[[f64; 2]; 4]>> {
    (belief.kind == BeliefKind::Histogram).then(|| along_a_line(&belief.marks)).flatten()
}

/// The same of marks; `None` where they are not cells along a line.
fn along_a_line(marks: &[Mark]) -> Option<Vec<[[f64; 2]; 4]>> {
    let (first, rest) = marks.split_first()?;
    let turn = |mark: &Mark, theta_rad: f64| f64::from(mark.theta_rad) - theta_rad;
    let faces = |theta_rad: f64| move |mark: &&Mark| trig::sin_cos(turn(mark, theta_rad)).1 > 0.0;
    let last = rest.iter().rfind(faces(f64::from(first.theta_rad)))?;
    let (dx, dy) = (f64::from(last.x_m - first.x_m), f64::from(last.y_m - first.y_m));
    // Up is the side of greater y, or of lesser x.
    let turned = if dx < 0.0 || (dx == 0.0 && dy < 0.0) { -1.0 } else { 1.0 };
    let length_m = turned * trig::hypot(dx, dy);
    let (c, s) = (dx / length_m, dy / length_m);
    let axis_rad = trig::atan2(s, c);
    let place = |mark: &Mark| {
        let [x, y] = [mark.x_m, mark.y_m].map(f64::from);
        let is_ahead = faces(axis_rad)(&mark);
        Cell { along_m: c * x + s * y, across_m: c * y - s * x, is_ahead }
    };
    let cells: Vec<Cell> = marks.iter().map(place).collect();
    let parallel = |mark: &Mark| trig::sin_cos(turn(mark, axis_rad)).0.abs() < 0.5;
    let rows = [true, false].map(|is_ahead| {
        let row = || cells.iter().filter(move |cell| cell.is_ahead == is_ahead);
        let least = row().map(|cell| cell.across_m).fold(f64::INFINITY, f64::min);
        let greatest = row().map(|cell| cell.across_m).fold(f64::NEG_INFINITY, f64::max);
        [least, greatest]
    });
    let known = || rows.iter().filter(|[least, greatest]| least <= greatest);
    let is_straight = known().all(|[least, greatest]| greatest - least < STRAIGHT_M);
    if !(length_m.abs() > 0.0 && is_straight && marks.iter().all(parallel)) {
        return None;
    }
    let middle_m = known().map(|row| row[0]).sum::<f64>() / known().count() as f64;
    let gaps = cells.windows(2).filter(|pair| pair[0].is_ahead == pair[1].is_ahead);
    let gaps = gaps.map(|pair| (pair[1].along_m - pair[0].along_m).abs());
    let half_m = 0.5 * PART * gaps.filter(|gap| *gap > 1e-3).fold(f64::INFINITY, f64::min).min(1.0);
    let bar = |(cell, mark): (&Cell, &Mark)| {
        let up_m = HIGHEST_M * f64::from(mark.share) * if cell.is_ahead { 1.0 } else { -1.0 };
        [(-half_m, 0.0), (half_m, 0.0), (half_m, up_m), (-half_m, up_m)].map(|(along, up)| {
            let (u, v) = (cell.along_m + along, middle_m + up);
            [c * u - s * v, s * u + c * v]
        })
    };
    Some(cells.iter().zip(marks).map(bar).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(x_m: f32, y_m: f32, theta_rad: f32, share: f32) -> Mark {
        Mark { x_m, y_m, theta_rad, share }
    }

    #[test]
    fn two_ways_of_a_corridor_have_bars_up_and_down() {
        let (east, west) = (0.1, std::f32::consts::PI + 0.1);
        let marks = [
            cell(1.0, 0.2, east, 0.5),
            cell(1.5, 0.2, east, 1.0),
            cell(2.0, 1.4, west, 0.25),
            cell(1.5, 1.4, west, 0.75),
        ];
        let bars = along_a_line(&marks).unwrap();
        let middle = 0.5 * (0.2 + 1.4);
        for (bar, (x, up)) in bars.iter().zip([(1.0, 0.5), (1.5, 1.0), (2.0, -0.25), (1.5, -0.75)])
        {
            let half = 0.5 * 0.5 * PART;
            let expected = [
                [x - half, middle],
                [x + half, middle],
                [x + half, middle + up],
                [x - half, middle + up],
            ];
            for (corner, expected) in bar.iter().zip(expected) {
                let off = trig::hypot(corner[0] - expected[0], corner[1] - expected[1]);
                assert!(off < 1e-6, "{bars:?}");
            }
        }
    }

    #[test]
    fn particles_on_a_line_are_particles() {
        let marks = vec![cell(0.0, 0.0, 0.0, 0.5), cell(0.01, 0.0, 0.0, 0.5)];
        let of =
            |kind| BeliefMoment { tick: 0, kind, whole: 2, marks: marks.clone(), observable: None };
        assert_eq!(bars(&of(BeliefKind::Particles)), None);
        assert_eq!(bars(&of(BeliefKind::Histogram)).map(|bars| bars.len()), Some(2));
    }

    #[test]
    fn cells_all_over_a_floor_have_none() {
        let grid = [cell(0.0, 0.0, 0.0, 1.0), cell(1.0, 0.0, 0.0, 1.0), cell(0.0, 1.0, 0.0, 1.0)];
        assert_eq!(along_a_line(&grid), None);
        let turned = [cell(0.0, 0.0, 0.0, 1.0), cell(1.0, 0.0, 0.0, 1.0), cell(0.5, 0.0, 1.6, 1.0)];
        assert_eq!(along_a_line(&turned), None);
        for few in [&grid[..0], &grid[..1], &[grid[0], grid[0]]] {
            assert_eq!(along_a_line(few), None);
        }
    }
}
