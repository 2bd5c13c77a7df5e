//! The shortest curve between two poses for a robot that turns on circles of a
//! least radius, forwards and in reverse.
//!
//! Source: J. A. Reeds and L. A. Shepp, *Optimal paths for a car that goes both
//! forwards and backwards* (Pacific Journal of Mathematics 145(2), 1990): one of 48
//! words is the shortest. A word is a sequence of arcs of the least radius, to the
//! left (L) or right (R), and straight lines (S).
//!
//! Departures, and why:
//! * The paper has formulas for each word. Here one equation solves all. Every word
//!   begins and ends with an arc. The pieces between them fix the distance between
//!   the centres of the first and the last circle, so that the distance gives their
//!   lengths; the direction between the centres gives the first arc and the
//!   heading at the goal gives the last.
//! * The paper prescribes the direction of every piece. Here the first and the last
//!   arc take whichever direction is shorter: less than half a turn. This unites
//!   C|C|C, CC|C and C|CC. It adds words to the 48, all of which lead to the goal,
//!   so that the shortest one stays the same.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector2;
use rusty_geometry::{SE2, trig, wrap_angle};

use super::curve::{Curve, Piece};

/// A curve to the goal; pieces of length 0 fill the array.
pub type Word = [Piece; 5];

/// Turn (left 1, straight 0, right −1) and length in radii.
type Letter = (f64, f64);

/// The pieces between the first and the last arc.
type Middle = [Letter; 3];

const L: f64 = 1.0;
const S: f64 = 0.0;
const R: f64 = -1.0;

/// No piece.
const NONE: Letter = (S, 0.0);

/// An argument so far out of the range of a function, in radii, is on its edge: two
/// circles that touch, but for rounding.
const ROUNDING: f64 = 1e-12;

/// Returns the shortest curve. `radius_m` > 0.
pub fn reeds_shepp(from: &SE2, to: &SE2, radius_m: f64) -> Curve {
    let shortest = words(from, to, radius_m).min_by(|a, b| length_m(a).total_cmp(&length_m(b)));
    Curve::new(*from, shortest.into_iter().flatten())
}

/// Returns the length of the shortest curve, m.
pub fn reeds_shepp_m(from: &SE2, to: &SE2, radius_m: f64) -> f64 {
    words(from, to, radius_m).map(|word| length_m(&word)).fold(f64::INFINITY, f64::min)
}

fn length_m(word: &Word) -> f64 {
    word.iter().map(|piece| piece.length_m.abs()).sum()
}

/// Returns a curve for each word that leads from one pose to the other.
pub fn words(from: &SE2, to: &SE2, radius_m: f64) -> impl Iterator<Item = Word> + use<> {
    let goal = from.inverse().compose(to);
    let (x, y, phi_rad) = (goal.x() / radius_m, goal.y() / radius_m, goal.theta());
    let (sin, cos) = trig::sin_cos(phi_rad);
    // The first arc is to the left; in a mirror, to the right.
    let ends = [(L, L), (L, R), (R, L), (R, R)];
    ends.into_iter().flat_map(move |(mirror, last)| {
        // From the centre of the first circle to that of the last.
        let between = Vector2::new(x - last * mirror * sin, mirror * y - 1.0 + last * cos);
        let direction_rad = angle_rad(between);
        let piece = move |(turn, length): Letter| Piece {
            curvature_per_m: mirror * turn / radius_m,
            length_m: length * radius_m,
        };
        middles(last, between.norm()).into_iter().flat_map(move |middle| {
            let (straight_rad, turn_rad) = centres(&middle, last);
            // With all signs of the middle changed, the centres are mirrored.
            let both = [(1.0, straight_rad), (-1.0, PI - straight_rad)];
            both.into_iter().filter_map(move |(sign, straight_rad)| {
                let first = arc(direction_rad - straight_rad);
                let end = arc(last * (mirror * phi_rad - first - sign * turn_rad));
                let [a, b, c] = middle.map(|(turn, length)| (turn, sign * length));
                let exists = first.is_finite() && end.is_finite();
                exists.then(|| [(L, first), a, b, c, (last, end)].map(piece))
            })
        })
    })
}

/// Returns what can be between a left arc and an arc to `last`, for centres that are
/// `rho` radii apart. The same with the signs of all lengths changed (the paper's time
/// flip) is also possible. Lengths are NaN where a word does not exist.
fn middles(last: f64, rho: f64) -> [Middle; 6] {
    let tangent = root(rho * rho - 4.0);
    let quarter = (R, -FRAC_PI_2);
    if last == L {
        let straight = (S, 2.0 - tangent);
        return [
            // CSC, C C C, C|C S C and C S C|C.
            [(S, rho), NONE, NONE],
            [(R, 2.0 * trig::asin(in_range(0.25 * rho))), NONE, NONE],
            [quarter, straight, NONE],
            [straight, quarter, NONE],
            [(S, f64::NAN); 3],
            [(S, f64::NAN); 3],
        ];
    }
    let straight = (S, 2.0 - rho);
    // The two arcs in the middle are equally long: C Cu|Cu C and C|Cu Cu|C.
    let cusp = trig::acos(in_range(0.25 * (2.0 + rho)));
    let smooth = trig::acos(in_range((20.0 - rho * rho) / 16.0));
    [
        // CSC, the two of four arcs, C|C S C, C S C|C and C|C S C|C.
        [(S, tangent), NONE, NONE],
        [(R, cusp), (L, -cusp), NONE],
        [(R, smooth), (L, smooth), NONE],
        [quarter, straight, NONE],
        [straight, (L, -FRAC_PI_2), NONE],
        [quarter, (S, 4.0 - tangent), (L, -FRAC_PI_2)],
    ]
}

/// Returns the root, 0 for that of a number that is negative by rounding.
fn root(square: f64) -> f64 {
    if square > -ROUNDING { square.max(0.0).sqrt() } else { f64::NAN }
}

/// Returns the number in [−1, 1]; NaN where it is out of it by more than rounding.
fn in_range(x: f64) -> f64 {
    if x.abs() < 1.0 + ROUNDING { x.clamp(-1.0, 1.0) } else { f64::NAN }
}

/// Returns the direction from the centre of the first circle to that of the last if
/// the first arc ended with heading 0, and the turn of the middle, rad.
fn centres(middle: &Middle, last: f64) -> (f64, f64) {
    // A circle's centre is on the normal of the heading, `turn` radii to the left.
    let (mut between, mut heading_rad) = (Vector2::new(0.0, -L), 0.0);
    let (mut sin, mut cos) = (0.0, 1.0);
    for (turn, length) in middle {
        if *turn == S {
            between += Vector2::new(cos, sin) * *length;
        } else {
            between += Vector2::new(-sin, cos) * *turn;
            heading_rad += turn * length;
            (sin, cos) = trig::sin_cos(heading_rad);
            between -= Vector2::new(-sin, cos) * *turn;
        }
    }
    (angle_rad(between + Vector2::new(-sin, cos) * last), heading_rad)
}

fn angle_rad(vector: Vector2<f64>) -> f64 {
    trig::atan2(vector.y, vector.x)
}

/// Returns the shorter of the two arcs with this turn; 0 for one that is 0 but for
/// rounding.
fn arc(turn_rad: f64) -> f64 {
    let turn_rad = wrap_angle(turn_rad);
    if turn_rad.abs() < ROUNDING { 0.0 } else { turn_rad }
}

#[cfg(test)]
#[path = "reeds_shepp_tests.rs"]
mod tests;
