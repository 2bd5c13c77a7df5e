//! Which beams a wall can matter to, and from what distance on.
//!
//! Everything here errs on the side of more beams and shorter distances: a beam
//! too many costs nanoseconds, a beam too few would cost the guarantee.
//!
//! Coordinates come as f64, relative to the sensor; from there on f32 will do.
//!
//! **Bearings.** Exactly, a beam meets a wall only if it points between the
//! bearings of the wall's ends. The formula of [`crate::wall`] in f64 decides by
//! the signs of s_a and s_b, which are right unless the beam is within 1e-15 rad
//! of an end or of its opposite (where p has the wrong sign for a hit). A sector
//! reaches [`BEARING_ERROR_RAD`] beyond both ends. Where "between" has no side,
//! because the sensor stands on the wall or at an end of it, the sector is the
//! whole circle.
//!
//! **Distances.** The formula's t is within a relative 1e-9 of the exact
//! distance unless the wall's line passes the sensor at less than 1e-6 of L, the
//! sum of the ends' coordinates; then t still lies between p_a and p_b. The
//! distance d to the nearest point of the wall is computed here with an error of
//! less than 1e-6·L. So t is not below (1 − 1e-6)·d − 4e-6·L.

use core::f32::consts::{FRAC_PI_2, PI, TAU};

use super::lanes::{Rough, WALLS};

/// How wrong [`rough_bearings_rad`] may be: twice what it is, and some more for
/// the arithmetic that follows.
const BEARING_ERROR_RAD: f32 = 3e-5;

/// Bearings of the vectors (x, y), rad in [−π, π], wrong by at most
/// [`BEARING_ERROR_RAD`] (anything for the zero vector). For deciding which
/// beams to try, never for a result.
///
/// Source: M. Abramowitz, I. Stegun, *Handbook of Mathematical Functions*,
/// 4.4.49: a polynomial for arctan on [0, 1] with an error of 1e-5.
#[inline(always)]
fn rough_bearings_rad<F: Rough>(x: F, y: F) -> F {
    let token = x.token();
    let zero = F::all(token, 0.0);
    let (w, h) = (x.abs(), y.abs());
    let slope = w.min(h) / w.max(h);
    let q = slope * slope;
    let mut sum = F::all(token, 0.020_835_1);
    for coefficient in [-0.085_133, 0.180_141, -0.330_299_5, 0.999_866] {
        sum = sum * q + F::all(token, coefficient);
    }
    let arc = sum * slope;
    let arc = F::choose(w.lt(h), F::all(token, FRAC_PI_2) - arc, arc);
    let arc = F::choose(x.lt(zero), F::all(token, PI) - arc, arc);
    F::choose(y.lt(zero), zero - arc, arc)
}

/// Groups of beams: those of `from..to`, and where the range goes on beyond
/// beam 0, those of `0..again`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub from: u32,
    pub to: u32,
    pub again: u32,
}

/// Eight of them.
#[derive(Clone, Copy)]
pub(super) struct Spans {
    from: [i32; WALLS],
    to: [i32; WALLS],
    again: [i32; WALLS],
}

impl Spans {
    /// That of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Span {
        let (from, to, again) = (self.from[lane], self.to[lane], self.again[lane]);
        Span { from: from as u32, to: to as u32, again: again as u32 }
    }
}

/// Where the beams of a scan point, as far as sectors are concerned.
#[derive(Clone, Copy)]
pub(super) struct Bearings {
    /// Bearing of beam 0 in the world, rad in [0, 2π).
    pub base_rad: f32,
    /// Groups of beams per radian.
    pub groups_per_rad: f32,
    /// How many groups there are.
    pub groups: f32,
}

impl Bearings {
    /// The groups of beams between the bearings of a and b, counter-clockwise;
    /// all of them where `all` is set.
    #[inline(always)]
    fn between<F: Rough>(&self, a: (F, F), b: (F, F), all: F::Mask) -> Spans {
        let token = a.0.token();
        let (zero, circle, base_rad) =
            (F::all(token, 0.0), F::all(token, TAU), F::all(token, self.base_rad));
        let in_circle = |rad: F| F::choose(rad.lt(zero), rad + circle, rad);
        // From (−3π, π] to [0, 2π].
        let turned = |rad: F| in_circle(in_circle(rad - base_rad));
        let from = turned(rough_bearings_rad(a.0, a.1));
        let width = in_circle(turned(rough_bearings_rad(b.0, b.1)) - from);
        // Something seen from its end: the bearings are equal but for their error.
        let width = F::choose(F::all(token, 1.5 * PI).lt(width), zero, width);
        let from = in_circle(from - F::all(token, BEARING_ERROR_RAD));
        let from = F::choose(all, zero, from);
        let to = F::choose(all, circle, from + width + F::all(token, 2.0 * BEARING_ERROR_RAD));
        let (groups_per_rad, groups) =
            (F::all(token, self.groups_per_rad), F::all(token, self.groups));
        let end = |rad: F| (rad * groups_per_rad + F::all(token, 1.0)).min(groups);
        Spans {
            from: (from * groups_per_rad).min(groups).whole(),
            to: end(to).whole(),
            again: F::choose(to.lt(circle), zero, end(to - circle)).whole(),
        }
    }
}

/// Eight walls as the sensor sees them, relative to it, world axes.
pub(super) struct EightWalls<F: Rough> {
    a_x: F,
    a_y: F,
    b_x: F,
    b_y: F,
    /// Whether b is to the left of a, as far as one can tell.
    left: F::Mask,
    /// Whether the wall passes through the sensor, as far as one can tell.
    pub here: F::Mask,
    /// No beam meets the wall nearer than this, m. NaN where there is no wall.
    pub bound: F,
}

impl<F: Rough> EightWalls<F> {
    /// The ends are relative to the sensor.
    #[inline(always)]
    pub fn new(a_x: F, a_y: F, b_x: F, b_y: F) -> Self {
        let token = a_x.token();
        let (zero, one, tiny) = (F::all(token, 0.0), F::all(token, 1.0), F::all(token, 1e-25));
        let turn = a_x * b_y - a_y * b_x;
        let dot = a_x * b_x + a_y * b_y;
        let (a, b) = (a_x * a_x + a_y * a_y, b_x * b_x + b_y * b_y);
        let straight = (turn * turn).le(F::all(token, 1e-10) * (a * b)) & dot.le(zero);
        // Below `tiny`, products of coordinates lose digits or vanish.
        let here = straight | a.lt(tiny) | b.lt(tiny);

        let (e_x, e_y) = (b_x - a_x, b_y - a_y);
        let u = (zero - (a_x * e_x + a_y * e_y)) / (e_x * e_x + e_y * e_y);
        let u = u.max(zero).min(one);
        let (x, y) = (a_x + u * e_x, a_y + u * e_y);
        let reach = a_x.abs() + a_y.abs() + b_x.abs() + b_y.abs();
        let bound = lower((x * x + y * y).sqrt(), reach);
        Self { a_x, a_y, b_x, b_y, left: zero.lt(turn), here, bound }
    }

    /// The beams that can meet each.
    #[inline(always)]
    pub fn spans(&self, bearings: &Bearings) -> Spans {
        let pick = |yes, no| F::choose(self.left, yes, no);
        let from = (pick(self.a_x, self.b_x), pick(self.a_y, self.b_y));
        let to = (pick(self.b_x, self.a_x), pick(self.b_y, self.a_y));
        bearings.between(from, to, self.here)
    }
}

/// Eight boxes as the sensor sees them.
pub(super) struct EightBoxes<F: Rough> {
    x_lo: F,
    y_lo: F,
    x_hi: F,
    y_hi: F,
    /// No beam meets a wall in the box nearer than this, m. NaN where there is
    /// no box.
    pub bound: F,
    /// Whether the box is too near to be sure that it takes up less than half
    /// the circle.
    near: F::Mask,
}

impl<F: Rough> EightBoxes<F> {
    /// The corners are relative to the sensor.
    #[inline(always)]
    pub fn new(x_lo: F, y_lo: F, x_hi: F, y_hi: F) -> Self {
        let token = x_lo.token();
        let zero = F::all(token, 0.0);
        // In this order, NaN stays NaN.
        let dx = zero.max(x_lo.max(zero - x_hi));
        let dy = zero.max(y_lo.max(zero - y_hi));
        let distance_squared = dx * dx + dy * dy;
        let size = (x_hi - x_lo) + (y_hi - y_lo);
        let near = distance_squared.le(F::all(token, 1e-5) * (size * size));
        // Twice the farthest corner is no less than both ends of any wall.
        let reach = x_lo.abs() + x_hi.abs() + y_lo.abs() + y_hi.abs();
        let bound = lower(distance_squared.sqrt(), reach + reach);
        Self { x_lo, y_lo, x_hi, y_hi, bound, near }
    }

    /// The beams that can meet anything in each: those between the two corners
    /// that stand out to the right and to the left.
    #[inline(always)]
    pub fn spans(&self, bearings: &Bearings) -> Spans {
        let zero = F::all(self.bound.token(), 0.0);
        let Self { x_lo, x_hi, y_lo, y_hi, near, .. } = *self;
        let (above, below) = (zero.lt(y_lo), y_hi.lt(zero));
        let (east, west) = (zero.lt(x_lo), x_hi.lt(zero));
        let pick = F::choose;
        // Between two sides the nearer edge is seen from end to end.
        let (x_side, y_side) = (pick(east, x_lo, x_hi), pick(above, y_lo, y_hi));
        let right_x = pick(above, x_hi, pick(below, x_lo, x_side));
        let right_y = pick(east, y_lo, pick(west, y_hi, y_side));
        let left_x = pick(above, x_lo, pick(below, x_hi, x_side));
        let left_y = pick(east, y_hi, pick(west, y_lo, y_side));
        bearings.between((right_x, right_y), (left_x, left_y), near)
    }
}

/// No hit of anything at `distance_m` or farther, with coordinates that sum up
/// to `reach_m`, is computed to be nearer than this.
#[inline(always)]
fn lower<F: Rough>(distance_m: F, reach_m: F) -> F {
    let token = reach_m.token();
    distance_m * F::all(token, 1.0 - 1e-6) - F::all(token, 4e-6) * reach_m
}

#[cfg(test)]
mod tests {
    use super::super::lanes::{Pack as _, Way};
    use super::super::plain::Plain;
    use super::*;
    use crate::trig;

    type Numbers = <Plain as Way>::Rough;

    #[test]
    fn rough_bearings_are_as_good_as_they_say() {
        for k in 0..100_000 {
            let bearing_rad = -core::f64::consts::PI + f64::from(k) * 6.283e-5;
            let (s, c) = trig::sin_cos(bearing_rad);
            for length_m in [1e-12, 1.0, 1e9] {
                let number = |x: f64| Numbers::all(Plain, (length_m * x) as f32);
                let found = rough_bearings_rad(number(c), number(s)).store();
                let error_rad = (f64::from(found[1]) - bearing_rad).abs();
                assert!(error_rad < 1.3e-5, "{bearing_rad}: {error_rad}");
            }
        }
    }

    #[test]
    fn the_corners_that_stand_out_enclose_the_box() {
        let bearings = Bearings { base_rad: 0.0, groups_per_rad: 1e4, groups: TAU * 1e4 };
        // A box on each side and beyond each corner.
        for (x, y) in [(3, 0), (3, 3), (0, 3), (-3, 3), (-3, 0), (-3, -3), (0, -3), (3, -3)] {
            let at = |x: i32| Numbers::all(Plain, x as f32);
            let boxes = EightBoxes::new(at(x - 1), at(y - 1), at(x + 1), at(y + 1));
            let span = boxes.spans(&bearings).get(2);
            let around = |y: i32, x: i32| {
                trig::atan2(f64::from(y), f64::from(x)).rem_euclid(core::f64::consts::TAU)
            };
            let mut far_apart_rad = 0.0;
            for (dx, dy) in [(-1, -1), (1, -1), (1, 1), (-1, 1)] {
                let bearing_rad = around(y + dy, x + dx);
                let group = (bearing_rad * 1e4) as u32;
                let inside = (span.from..span.to).contains(&group) || group < span.again;
                assert!(inside, "({x}, {y}): {bearing_rad} {span:?}");
                let apart_rad = (bearing_rad - around(y, x)).abs();
                far_apart_rad =
                    f64::max(far_apart_rad, apart_rad.min(core::f64::consts::TAU - apart_rad));
            }
            let wide_rad = f64::from(span.to - span.from + span.again) / 1e4;
            assert!(wide_rad < 2.0 * far_apart_rad + 2e-3, "({x}, {y}): {span:?}");
        }
    }
}
