//! The check of a floor plan: gaps, loose ends, overlaps and openings.

use core::fmt;
use std::collections::BTreeMap;

use nalgebra::Point2;
use rusty_geometry::gap::GAP_M;
use rusty_geometry::{Gap, Wall, World, WorldError, WorldSpec, trig};
use serde::Serialize;

use crate::openings::{Floor, find_openings};
use crate::snap::join_ends;

/// Most gaps, most ends and most overlaps that are named.
pub const MAX_NAMED: usize = 1000;

/// Farther than this from a line a wall is not on it, m.
const ON_LINE_M: f64 = 1e-6;

/// Kind of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// An end that touches no wall, and stops within 5 cm of one: the world is
    /// invalid.
    Gap,
    /// Another end that touches no wall: next to a door opening, or a slip.
    LooseEnd,
    /// Two walls on one line that cover each other.
    Overlap,
    /// A place where the floor is open to the outside.
    Opening,
}

/// A finding in a floor plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Its kind.
    pub kind: Kind,
    /// Its place, world frame, m.
    pub at_m: [f64; 2],
    /// Indices of the walls that it concerns, from 0.
    pub walls: Vec<usize>,
    /// Distance to the nearest wall, length of the overlap, or width of the opening, m.
    pub length_m: f64,
    /// Description with a remedy.
    pub text: String,
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the world.
    pub world: String,
    /// A point on the floor that was searched for openings, m; `None` if no floor is
    /// enclosed.
    pub floor_m: Option<[f64; 2]>,
    /// Openings narrower than this may not be found, m.
    pub resolution_m: f64,
    /// The findings, by kind and wall.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Number of findings that need a remedy: all but loose ends, which may be meant.
    #[must_use]
    pub fn problems(&self) -> usize {
        self.findings.len() - self.count(Kind::LooseEnd)
    }

    fn count(&self, kind: Kind) -> usize {
        self.findings.iter().filter(|found| found.kind == kind).count()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Finding { kind, at_m: [x, y], text, .. } in &self.findings {
            let kind = match kind {
                Kind::Gap => "gap",
                Kind::LooseEnd => "loose end",
                Kind::Overlap => "overlap",
                Kind::Opening => "opening",
            };
            writeln!(f, "{kind} at ({x:.3}, {y:.3}) m: {text}")?;
        }
        let openings = self.count(Kind::Opening);
        match self.floor_m {
            None => writeln!(f, "no floor is enclosed")?,
            Some([x, y]) => {
                let state = if openings == 0 { "closed" } else { "open to the outside" };
                let least = self.resolution_m;
                writeln!(
                    f,
                    "the floor at ({x:.3}, {y:.3}) m is {state}; openings narrower than \
                     {least:.3} m may not be found"
                )?;
            }
        }
        let loose = self.count(Kind::LooseEnd);
        let is_cut = |kind| self.count(kind) == MAX_NAMED;
        let at_least = |is_cut| if is_cut { "at least " } else { "" };
        let problems = at_least(is_cut(Kind::Gap) || is_cut(Kind::Overlap));
        let (world, loose_ends) = (&self.world, at_least(is_cut(Kind::LooseEnd)));
        let found = self.problems();
        write!(f, "{world}: {problems}{found} problems, {loose_ends}{loose} loose ends")
    }
}

/// Checks a floor plan: its walls, and whether the floor at `start_m` (world frame,
/// m; `None`: the floor that is enclosed best) is closed.
///
/// # Errors
/// [`WorldError`] for a world that is invalid by more than its gaps.
pub fn check(spec: &WorldSpec, start_m: Option<[f64; 2]>) -> Result<Report, WorldError> {
    let world = match World::new(spec.clone()) {
        Err(WorldError::Gap { .. }) => {
            // Openings are searched as if the gaps were closed.
            let mut joined = spec.clone();
            join_ends(&mut joined, GAP_M);
            World::new(joined).ok()
        }
        other => Some(other?),
    };
    let gaps = spec.ends_near(GAP_M, MAX_NAMED)?;
    let mut findings: Vec<Finding> = gaps.iter().map(|gap| of_end(Kind::Gap, gap)).collect();
    let ends = spec.ends_near(f64::INFINITY, MAX_NAMED)?;
    let loose = ends.iter().filter(|end| end.distance_m >= GAP_M);
    findings.extend(loose.map(|end| of_end(Kind::LooseEnd, end)));
    findings.extend(overlaps(&spec.to_walls()));
    let floor = world.filter(|world| !world.is_open()).map(|w| find_openings(&w, start_m));
    let none = Floor { at_m: None, resolution_m: 0.0, openings: Vec::new() };
    let Floor { at_m: floor_m, resolution_m, openings } = floor.unwrap_or(none);
    findings.extend(openings.into_iter().map(|opening| Finding {
        kind: Kind::Opening,
        at_m: opening.at_m,
        walls: Vec::new(),
        length_m: opening.width_m,
        text: format!(
            "the floor is open to the outside, about {:.2} m wide; draw a wall or a door across \
             it, or leave it open if no robot and no beam gets there",
            opening.width_m
        ),
    }));
    if let (Some(at_m), None) = (start_m, floor_m) {
        let text = "no floor is enclosed here; give a point of the floor, or close its walls";
        let (kind, text) = (Kind::Opening, text.to_owned());
        findings.push(Finding { kind, at_m, walls: Vec::new(), length_m: 0.0, text });
    }
    Ok(Report { world: spec.name.clone(), floor_m, resolution_m, findings })
}

fn of_end(kind: Kind, gap: &Gap) -> Finding {
    let Gap { wall, end, point, other, distance_m } = *gap;
    let text = match kind {
        Kind::Gap => gap.to_string(),
        _ => format!(
            "wall {wall}, end `{end}` touches no wall; the nearest is wall {other} at \
             {distance_m:.3} m; extend the wall if it should meet it"
        ),
    };
    Finding { kind, at_m: point, walls: vec![wall, other], length_m: distance_m, text }
}

/// Pairs of walls on one line that cover each other: each wall with the one before it
/// on the line that reaches farthest. At most [`MAX_NAMED`].
fn overlaps(walls: &[Wall]) -> Vec<Finding> {
    // Walls of nearly one line are in one of three neighbouring classes of angles.
    let mut lines: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    for (index, wall) in walls.iter().enumerate() {
        let ([angle, offset], spread) = (line_of(wall), [-1, 0, 1]);
        for (da, dr) in spread.iter().flat_map(|a| spread.map(|r| (*a, r))) {
            lines.entry((angle + da, offset + dr)).or_default().push(index);
        }
    }
    let mut pairs = BTreeMap::new();
    for on_line in lines.values().filter(|walls| walls.len() > 1) {
        let along = walls[on_line[0]].b - walls[on_line[0]].a;
        let reach = |wall: usize| {
            let [a, b] = [walls[wall].a, walls[wall].b].map(|p| p.coords.dot(&along));
            (a.min(b), a.max(b))
        };
        let mut sorted = on_line.clone();
        sorted.sort_by(|p, q| reach(*p).0.total_cmp(&reach(*q).0).then(p.cmp(q)));
        let mut farthest = sorted[0];
        for &wall in &sorted[1..] {
            if let Some((at, length_m)) = common(&walls[farthest], &walls[wall]) {
                pairs.insert((farthest.min(wall), farthest.max(wall)), (at, length_m));
            }
            if reach(wall).1 > reach(farthest).1 {
                farthest = wall;
            }
        }
    }
    let finding = |((first, second), (at, length_m)): ((usize, usize), (Point2<f64>, f64))| {
        let text = format!(
            "walls {first} and {second} cover each other over {length_m:.3} m, and wall {first} \
             is hit; cut one of them there, or remove it"
        );
        let (at_m, walls) = ([at.x, at.y], vec![first, second]);
        Finding { kind: Kind::Overlap, at_m, walls, length_m, text }
    };
    pairs.into_iter().take(MAX_NAMED).map(finding).collect()
}

/// Angle and offset of the line of a wall, in classes.
fn line_of(wall: &Wall) -> [i64; 2] {
    let (a, e) = (wall.a, wall.b - wall.a);
    // A line has no direction: the angle is from 0 to π, and π is 0.
    let e = if e.y < 0.0 || (e.y == 0.0 && e.x < 0.0) { -e } else { e };
    let angle = trig::atan2(e.y, e.x);
    let is_flat = core::f64::consts::PI - angle < 1e-5;
    let (angle, e) = if is_flat { (0.0, -e) } else { (angle, e) };
    let offset = (a.x * e.y - a.y * e.x) / e.norm();
    [(angle / 1e-5).round() as i64, (offset / 1e-3).round() as i64]
}

/// Middle and length, m, of what two walls on one line have in common.
fn common(p: &Wall, q: &Wall) -> Option<(Point2<f64>, f64)> {
    let (long, short) = if p.length_m() >= q.length_m() { (p, q) } else { (q, p) };
    let length_m = long.length_m();
    let unit = (long.b - long.a) / length_m;
    let (mut ends, mut off) = ([0.0; 2], 0.0_f64);
    for (end, point) in ends.iter_mut().zip([short.a, short.b]) {
        let from_a = point - long.a;
        *end = from_a.dot(&unit);
        off = off.max((from_a.x * unit.y - from_a.y * unit.x).abs());
    }
    let from = ends[0].min(ends[1]).max(0.0);
    let to = ends[0].max(ends[1]).min(length_m);
    let covers = off <= ON_LINE_M && to - from > ON_LINE_M;
    covers.then(|| (long.a + unit * (0.5 * (from + to)), to - from))
}
