//! Walls of a map of cells: the boundary of the occupied cells, simplified.
//!
//! The boundary runs along the edges of the cells, in closed outlines. Occupied
//! cells that meet at a corner are one region: no beam passes between them. Each
//! outline is simplified by the algorithm of Ramer (1972) and of Douglas and
//! Peucker (1973), which keeps every corner farther than a tolerance from the
//! chord that would replace it.
//!
//! Departure: where a kept corner is one end of a short edge at which the outline
//! turns back (the end of a wall one or two cells thick), the other end is kept,
//! too. Without it such a wall would become a wedge, or a line.
//!
//! Corners have whole numbers of cells, so outlines stay closed to the bit.

use std::collections::BTreeSet;

use nalgebra::Point2;
use rusty_contract::FieldError;
use rusty_geometry::world_spec::MAX_WALLS;
use rusty_geometry::{Material, SE2, WallSpec, WorldSpec};

use crate::map_server::{Cell, RosMap};
use crate::{bounds_of, rounded};

/// Greatest deviation of the walls from the edges of the cells, cells: the corners of
/// a straight line of cells are in a band that wide, whatever its slope.
pub const TOLERANCE_CELLS: f64 = core::f64::consts::SQRT_2;

/// Edges at which an outline turns back keep both ends up to this length, cells: the
/// corners of a longer one are too far from the chord between the others.
const MAX_END_CELLS: i32 = 2;

/// Most comparisons of a corner with a chord: some seconds.
const MAX_STEPS: usize = 1 << 30;

/// A corner of a cell: column and row.
type Corner = [i32; 2];

/// Directions along the edges of the cells, each a left turn from the one before.
const DIRECTIONS: [Corner; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// The walls of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// The walls as a world, which is not checked.
    pub world: WorldSpec,
    /// Number of occupied cells.
    pub occupied_cells: usize,
    /// Number of closed outlines.
    pub outlines: usize,
    /// Number of corners of the outlines before simplification; after it there are
    /// as many corners as walls.
    pub cell_corners: usize,
    /// Greatest distance of a corner from the wall that replaces it, cells.
    pub max_deviation_cells: f64,
}

/// Traces the occupied cells of a map into walls.
///
/// # Errors
/// [`FieldError`] for a map without occupied cells, or with too many outlines.
pub fn trace(map: &RosMap, name: &str) -> Result<Traced, FieldError> {
    let grid = Occupied { map, height: map.cells.len() / map.width };
    let mut traced = Traced {
        world: WorldSpec {
            name: name.to_owned(),
            bounds: [0.0; 4],
            walls: Vec::new(),
            landmarks: Vec::new(),
        },
        occupied_cells: map.cells.iter().filter(|cell| **cell == Cell::Occupied).count(),
        outlines: 0,
        cell_corners: 0,
        max_deviation_cells: 0.0,
    };
    if traced.occupied_cells == 0 {
        let remedy = "check `negate` and `occupied_thresh` in the map's page";
        return Err(FieldError::new("occupied cells", 0, "make no wall", remedy));
    }
    let frame_in_world = SE2::new(map.origin_m[0], map.origin_m[1], map.yaw_rad);
    let mut steps = MAX_STEPS;
    let mut seen = vec![false; map.cells.len()];
    for first in 0..map.cells.len() {
        let (column, row) = ((first % map.width) as i32, (first / map.width) as i32);
        if seen[first] || !grid.at(column, row) || grid.at(column, row - 1) {
            continue;
        }
        let outline = grid.outline([column, row], &mut seen);
        let (kept, deviation) =
            simplified(&outline, &mut steps).ok_or_else(|| too_intricate(traced.outlines))?;
        traced.outlines += 1;
        traced.cell_corners += outline.len();
        traced.max_deviation_cells = traced.max_deviation_cells.max(deviation);
        let point = |corner: usize| {
            let [x, y] = outline[corner].map(|v| map.cell_m * f64::from(v));
            let point = frame_in_world.transform_point(&Point2::new(x, y));
            [point.x, point.y].map(rounded)
        };
        let next = kept.iter().cycle().skip(1);
        traced.world.walls.extend(kept.iter().zip(next).map(|(a, b)| WallSpec {
            a: point(*a),
            b: point(*b),
            material: Material::Wall,
        }));
        if traced.world.walls.len() > MAX_WALLS {
            return Err(too_intricate(traced.outlines));
        }
    }
    traced.world.bounds = bounds_of(&traced.world.walls);
    Ok(traced)
}

fn too_intricate(outlines: usize) -> FieldError {
    let problem = format!("make more than {MAX_WALLS} walls, or take too long to simplify");
    let remedy = "crop the picture, or remove its noise";
    FieldError::new("outlines", outlines, problem, remedy)
}

/// The occupied cells of a map; beyond its edge there are none.
struct Occupied<'a> {
    map: &'a RosMap,
    height: usize,
}

impl Occupied<'_> {
    fn at(&self, column: i32, row: i32) -> bool {
        let inside = |v: i32, size: usize| usize::try_from(v).ok().filter(|v| *v < size);
        match (inside(column, self.map.width), inside(row, self.height)) {
            (Some(x), Some(y)) => self.map.cells[y * self.map.width + x] == Cell::Occupied,
            _ => false,
        }
    }

    /// The cell ahead of a corner, on the left of a direction or on its right.
    fn ahead(&self, [x, y]: Corner, direction: usize, is_left: bool) -> bool {
        // The cell whose lower left corner this is lies ahead on the left of 0.
        let cells = [[0, 0], [-1, 0], [-1, -1], [0, -1]];
        let [dx, dy] = cells[(direction + if is_left { 0 } else { 3 }) % 4];
        self.at(x + dx, y + dy)
    }

    /// Walks around a region from the lower left corner of one of its cells, with
    /// the region on the left, and returns the corners at which the way turns. Marks
    /// the cells whose lower edge was walked along.
    fn outline(&self, start: Corner, seen: &mut [bool]) -> Vec<Corner> {
        let (mut at, mut direction, mut corners) = (start, 0, Vec::new());
        loop {
            if direction == 0 {
                seen[at[1] as usize * self.map.width + at[0] as usize] = true;
            }
            let [dx, dy] = DIRECTIONS[direction];
            at = [at[0] + dx, at[1] + dy];
            let turned = match self.ahead(at, direction, false) {
                true => direction + 3,
                false if self.ahead(at, direction, true) => direction,
                false => direction + 1,
            } % 4;
            if turned != direction {
                corners.push(at);
            }
            direction = turned;
            if at == start && direction == 0 {
                return corners;
            }
        }
    }
}

/// The corners of an outline that are kept, in order, and the greatest distance of
/// another corner from its chord, cells; `None` if that takes more than `steps`.
fn simplified(outline: &[Corner], steps: &mut usize) -> Option<(BTreeSet<usize>, f64)> {
    let count = outline.len();
    let far_from = |corner: usize| farthest(outline, corner, corner + count).0 % count;
    let end = far_from(0);
    let mut kept = BTreeSet::from([end, far_from(end)]);
    loop {
        let before = kept.len();
        let partners: Vec<usize> = kept.iter().flat_map(|k| partners(outline, *k)).collect();
        kept.extend(partners);
        if kept.len() > before {
            continue;
        }
        let mut deviation = 0.0_f64;
        let ends: Vec<usize> = kept.iter().copied().collect();
        let next = ends.iter().skip(1).copied().chain([ends[0] + count]);
        let mut chords: Vec<(usize, usize)> = ends.iter().copied().zip(next).collect();
        while let Some((from, to)) = chords.pop() {
            *steps = steps.checked_sub(to - from)?;
            let (corner, distance) = farthest(outline, from, to);
            if distance > TOLERANCE_CELLS {
                kept.insert(corner % count);
                chords.extend([(from, corner), (corner, to)]);
            } else {
                deviation = deviation.max(distance);
            }
        }
        if kept.len() == before {
            return Some((kept, deviation));
        }
    }
}

/// The corner of an outline between two others that is farthest from their chord,
/// and its distance, cells. Indices beyond the last corner begin again.
fn farthest(outline: &[Corner], from: usize, to: usize) -> (usize, f64) {
    let place = |k: usize| outline[k % outline.len()].map(f64::from);
    let ([ax, ay], [bx, by]) = (place(from), place(to));
    let (ex, ey) = (bx - ax, by - ay);
    let squared = ex * ex + ey * ey;
    let distance = |k: usize| {
        let [x, y] = place(k);
        let (px, py) = (x - ax, y - ay);
        let along = px * ex + py * ey;
        // As far as the chord goes; a chord of no length is a point.
        let t = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
        let (dx, dy) = (px - t * ex, py - t * ey);
        dx * dx + dy * dy
    };
    let mut found = (from, 0.0);
    for k in from + 1..to {
        let squared = distance(k);
        if squared > found.1 {
            found = (k, squared);
        }
    }
    (found.0, found.1.sqrt())
}

/// The other ends of the short edges at a corner at which the outline turns back.
fn partners(outline: &[Corner], corner: usize) -> impl Iterator<Item = usize> {
    let count = outline.len();
    let at = move |k: usize| outline[(corner + count + k) % count];
    // From two corners before this one to two after it.
    let [a, b, c, d, e] = [count - 2, count - 1, 0, 1, 2].map(at);
    let step = |p: Corner, q: Corner| [q[0] - p[0], q[1] - p[1]];
    let turns_back = move |before: Corner, from: Corner, to: Corner, after: Corner| {
        let ([x, y], edge, [u, v]) = (step(before, from), step(from, to), step(to, after));
        let is_short = edge[0].abs() + edge[1].abs() <= MAX_END_CELLS;
        // Two turns to the same side reverse the direction.
        is_short && x.signum() == -u.signum() && y.signum() == -v.signum()
    };
    let before = turns_back(a, b, c, d).then_some((corner + count - 1) % count);
    let after = turns_back(b, c, d, e).then_some((corner + 1) % count);
    before.into_iter().chain(after)
}

#[cfg(test)]
mod tests;
