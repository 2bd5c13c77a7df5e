//! Straight walls in a scan: split and merge.
//!
//! The ends of the beams, in order, are split where they are farthest from the
//! chord until each piece is explained by a line; then neighbours that one line
//! explains are merged, the longest first. What is long enough is a wall.
//!
//! Source: R. Siegwart, I. Nourbakhsh, *Introduction to Autonomous Mobile
//! Robots* (2004), §4.3.1.2, for what segmentation is (it merges by clustering);
//! V. Nguyen et al., *A comparison of line extraction algorithms using 2D laser
//! rangefinder for indoor mobile robotics* (IROS 2005), algorithm 1, for splitting and
//! merging.
//!
//! Departures, and why:
//! * "Explained" means that no range is farther from the line's than a few
//!   standard deviations of the laser, along the beam. A distance across the
//!   line, as in the sources, lets through what lies next to a wall that is seen
//!   at a grazing angle.
//! * Beams that met nothing are left out before; so a dropout ends no wall.
//! * Near the corner of two walls a range fits both. Where the two lines predict
//!   nearly the same range, it is left to neither: a point of the one in the fit of
//!   the other would bend it, always in the same direction.
//! * What ends a piece may be too short to have a line, a door post of two points;
//!   so the last two points at each end are left out of the fit. In the Apartment's
//!   corridor the squared errors of lines are 1.017 times what they say with one
//!   left out, 1.006 with two, and 0.999 with three, which makes a third of the
//!   lines that one leaves too short.

use nalgebra::Point2;
use rusty_geometry::SE2;

use crate::Beams;
use crate::line_fit::{Line, Ray};

/// A range farther than this many standard deviations from a line is not its.
const WORST_SIGMAS: f64 = 4.0;
/// Where two neighbouring lines tell ranges that differ by less than this many
/// standard deviations, a point belongs to no line.
const CORNER_SIGMAS: f64 = 7.0;

/// Points that are left out at each end of a piece.
const END_POINTS: usize = 2;

/// What a piece of wall must have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extraction {
    /// Standard deviation of a range, m.
    pub range_std_m: f64,
    /// The fewest points of a wall.
    pub min_points: usize,
    /// The shortest wall, m.
    pub min_length_m: f64,
}

/// A piece of straight wall, in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The line it lies on. Its ρ may be negative where the sensor is not at the
    /// body's centre.
    pub line: Line,
    /// Where the first of its points is on the line, counter-clockwise, m.
    pub from: Point2<f64>,
    /// Where the last is, m.
    pub to: Point2<f64>,
    /// How many points it has.
    pub points: usize,
}

impl Segment {
    /// Distance between its ends, m.
    pub fn length_m(&self) -> f64 {
        (self.to - self.from).norm()
    }
}

impl Extraction {
    /// The straight walls of a scan, in the order of the beams.
    pub fn segments(&self, beams: &Beams, ranges_m: &[f64]) -> Vec<Segment> {
        let (mut rays, mut pieces) = (rays(beams, ranges_m), Vec::new());
        self.split(&rays, 0, rays.len(), &mut pieces);
        self.merge(&rays, &mut pieces);
        let closed = is_full_circle(beams) && pieces.len() > 2;
        if closed {
            self.close(&mut rays, &mut pieces);
        }
        let cut = self.without_corners(&rays, &pieces, closed);
        let inner = cut.iter().filter(|(from, to)| to - from > 2 * END_POINTS);
        let found =
            inner.filter_map(|(from, to)| self.segment(&rays[from + END_POINTS..to - END_POINTS]));
        found.map(|segment| seen_from(&segment, &beams.sensor_in_body)).collect()
    }

    /// The line of some rays, if it explains them.
    fn explain(&self, rays: &[Ray]) -> Option<Line> {
        let line = Line::fit(rays, self.range_std_m)?;
        (line.worst_m(rays) <= WORST_SIGMAS * self.range_std_m).then_some(line)
    }

    fn split(&self, rays: &[Ray], from: usize, to: usize, pieces: &mut Vec<(usize, usize)>) {
        if to <= from {
            return;
        }
        if to - from < 3 || self.explain(&rays[from..to]).is_some() {
            pieces.push((from, to));
            return;
        }
        let at = from + farthest_from_chord(&rays[from..to]);
        self.split(rays, from, at, pieces);
        self.split(rays, at, to, pieces);
    }

    /// Merges neighbours as long as a line explains two; those first that have
    /// the most points together.
    fn merge(&self, rays: &[Ray], pieces: &mut Vec<(usize, usize)>) {
        let together = |a: (usize, usize), b: (usize, usize)| {
            let fits = b.1 - a.0 < 3 || self.explain(&rays[a.0..b.1]).is_some();
            fits.then_some(b.1 - a.0)
        };
        let pairs = pieces.windows(2).map(|pair| together(pair[0], pair[1]));
        let mut merged: Vec<Option<usize>> = pairs.collect();
        while let Some(i) = (0..merged.len()).rev().max_by_key(|&i| merged[i])
            && merged[i].is_some()
        {
            pieces[i].1 = pieces[i + 1].1;
            pieces.remove(i + 1);
            merged.remove(i);
            if i > 0 {
                merged[i - 1] = together(pieces[i - 1], pieces[i]);
            }
            if i < merged.len() {
                merged[i] = together(pieces[i], pieces[i + 1]);
            }
        }
    }

    /// Merges the last piece of a full circle with the first, where one line
    /// explains them: the circle began within a wall.
    fn close(&self, rays: &mut [Ray], pieces: &mut Vec<(usize, usize)>) {
        let (Some(&(_, first)), Some(&(from, to))) = (pieces.first(), pieces.last()) else {
            return;
        };
        let last = to - from;
        rays.rotate_right(last);
        if self.explain(&rays[..last + first]).is_none() {
            rays.rotate_left(last);
            return;
        }
        pieces.pop();
        pieces.iter_mut().for_each(|piece| *piece = (piece.0 + last, piece.1 + last));
        pieces[0].0 = 0;
    }

    /// The pieces without the points near their corners; in a closed circle the
    /// first comes after the last.
    fn without_corners(
        &self,
        rays: &[Ray],
        pieces: &[(usize, usize)],
        closed: bool,
    ) -> Vec<(usize, usize)> {
        let margin_m = CORNER_SIGMAS * self.range_std_m;
        let mut cut = pieces.to_vec();
        for i in usize::from(!closed)..pieces.len() {
            let before_i = if i == 0 { pieces.len() - 1 } else { i - 1 };
            let (a, b) = (pieces[before_i], pieces[i]);
            let lines = (self.long(&rays[a.0..a.1]), self.long(&rays[b.0..b.1]));
            let (Some(before), Some(after)) = lines else { continue };
            // Two pieces of one wall have no corner.
            if before.normal().perp(&after.normal()).abs() < 0.1 {
                continue;
            }
            // By what the lines say, not by what was measured: the noise of a range
            // does not decide whether it is used.
            let is_nobodys = |ray: &Ray| {
                let [here, there] = [&before, &after].map(|line| line.range_m(&ray.direction));
                here.zip(there).is_some_and(|(here, there)| (here - there).abs() < margin_m)
            };
            while cut[before_i].1 > cut[before_i].0 && is_nobodys(&rays[cut[before_i].1 - 1]) {
                cut[before_i].1 -= 1;
            }
            while cut[i].0 < cut[i].1 && is_nobodys(&rays[cut[i].0]) {
                cut[i].0 += 1;
            }
        }
        cut
    }

    /// The line of a piece that is long enough to have corners, by its inner
    /// points where there are some.
    fn long(&self, rays: &[Ray]) -> Option<Line> {
        let skip = if rays.len() > 2 * END_POINTS + 2 { END_POINTS } else { 0 };
        let inner = &rays[skip..rays.len() - skip];
        if inner.len() < 3 { None } else { Line::fit(inner, self.range_std_m) }
    }

    /// A wall in the sensor frame, if it is one.
    fn segment(&self, rays: &[Ray]) -> Option<Segment> {
        let [first, .., last] = rays else { return None };
        let line = Line::fit(rays, self.range_std_m)?;
        let on = |ray: &Ray| {
            line.range_m(&ray.direction).map(|range_m| Point2::from(ray.direction * range_m))
        };
        let (from, to, points) = (on(first)?, on(last)?, rays.len());
        let segment = Segment { line, from, to, points };
        (points >= self.min_points && segment.length_m() >= self.min_length_m).then_some(segment)
    }
}

/// The beams that met something. Those of a full circle begin behind the longest
/// way from an end to the next: there is a jump, or at worst a wall in two pieces.
fn rays(beams: &Beams, ranges_m: &[f64]) -> Vec<Ray> {
    let hits = beams.endpoints(ranges_m);
    let mut rays: Vec<Ray> = hits
        .map(|hit| Ray { direction: beams.direction(hit.beam), range_m: hit.range_m })
        .collect();
    if is_full_circle(beams) && rays.len() > 2 {
        let gap_m =
            |i: &usize| (rays[*i].end() - rays[(i + rays.len() - 1) % rays.len()].end()).norm();
        let longest = (0..rays.len()).max_by(|a, b| gap_m(a).total_cmp(&gap_m(b)));
        rays.rotate_left(longest.unwrap_or(0));
    }
    rays
}

/// Whether the first beam comes after the last as the second after the first.
fn is_full_circle(beams: &Beams) -> bool {
    let last = beams.count().saturating_sub(1);
    let next_to = |a, b| beams.direction(a).dot(&beams.direction(b));
    last > 2 && (next_to(last, 0) - next_to(0, 1)).abs() < 1e-9
}

/// The point farthest from the chord of a row of three or more; never the first.
fn farthest_from_chord(rays: &[Ray]) -> usize {
    let (a, b) = (rays[0].end(), rays[rays.len() - 1].end());
    let chord = b - a;
    let across = |ray: &Ray| chord.perp(&(ray.end() - a)).abs();
    let inner = 1..rays.len() - 1;
    let farthest = inner.max_by(|&i, &j| across(&rays[i]).total_cmp(&across(&rays[j])));
    farthest.unwrap_or(1)
}

fn seen_from(segment: &Segment, sensor_in_body: &SE2) -> Segment {
    Segment {
        line: segment.line.seen_from(sensor_in_body),
        from: sensor_in_body.transform_point(&segment.from),
        to: sensor_in_body.transform_point(&segment.to),
        points: segment.points,
    }
}

#[cfg(test)]
#[path = "lines_tests.rs"]
mod tests;
