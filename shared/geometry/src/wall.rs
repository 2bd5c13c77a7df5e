//! A wall, and the one formula by which a ray meets it.
//!
//! Every range sensor of the laboratory goes through [`Wall::cast`], and any
//! faster way of casting must return its bits; so it is stated here in full.
//! With the ray from o along the unit vector d, and for a wall's ends a and b:
//!
//! ```text
//! s = d × (end − o)   on which side of the ray's line an end lies, in metres
//! p = d · (end − o)   how far along the ray an end lies, in metres
//! ```
//!
//! 1. s_a and s_b both > 0 or both < 0: the line of the ray passes by; no hit.
//! 2. s_a = s_b = 0, the wall lies along the ray: the nearer of p_a, p_b if both
//!    are ≥ 0, 0 if their signs differ (o is on the wall), no hit if both are < 0.
//! 3. One of them is 0, the ray meets that end exactly: t = p of that end, a hit
//!    if t ≥ 0.
//! 4. Otherwise t = (p_a |s_b| + p_b |s_a|) / (|s_a| + |s_b|), the mean of p
//!    weighted by the opposite sides. p_a, p_b ≥ 0: a hit. Both < 0: none. Signs
//!    differ, so o is next to the wall: c = (a − o) × (b − o) tells which way
//!    the wall lies; c = 0 is o on the wall, t = 0; a hit if c and s_b − s_a have
//!    the same sign.
//!
//! **Watertight.** s and p of an end depend on that end, o and d only, never on
//! the wall they belong to. Two walls that share an end therefore agree, to the
//! last bit, about the side on which the ray passes it: whatever rounding does, a
//! ray cannot slip between them, and if it meets the end exactly both report the
//! same t. (Two walls that meet in a T share no end; there the through-going wall
//! alone has to stop the ray, and does.)
//!
//! **Accurate.** The weights in 4 have one sign, so nothing cancels: t lies
//! between p_a and p_b, and its error is the rounding of the coordinate
//! differences, magnified only by the cotangent of the grazing angle. Swapping a
//! and b leaves every bit of t as it was.
//!
//! **Ties.** Among several walls the nearest counts; at equal t the one with the
//! lowest index.

use nalgebra::{Point2, Vector2};

use crate::material::Material;

/// A straight piece of wall in the world frame, without thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// One end, metres.
    pub a: Point2<f64>,
    /// The other end, metres.
    pub b: Point2<f64>,
    /// What it is made of.
    pub material: Material,
}

impl Wall {
    /// Distance in metres from `origin` along `unit_dir` to this wall, or `None`
    /// if the ray passes it; never negative, never −0.0. The formula, its rules
    /// at the ends and its promises are in the [module documentation](self).
    ///
    /// `unit_dir` has length 1 up to rounding; both arguments are finite.
    #[inline]
    #[must_use]
    pub fn cast(&self, origin: &Point2<f64>, unit_dir: &Vector2<f64>) -> Option<f64> {
        let (ax, ay) = (self.a.x - origin.x, self.a.y - origin.y);
        let (bx, by) = (self.b.x - origin.x, self.b.y - origin.y);
        let s_a = unit_dir.x * ay - unit_dir.y * ax;
        let s_b = unit_dir.x * by - unit_dir.y * bx;
        if (s_a > 0.0 && s_b > 0.0) || (s_a < 0.0 && s_b < 0.0) {
            return None;
        }
        let p_a = unit_dir.x * ax + unit_dir.y * ay;
        let p_b = unit_dir.x * bx + unit_dir.y * by;
        if s_a == 0.0 || s_b == 0.0 {
            return cast_at_end(s_a, s_b, p_a, p_b);
        }
        let (w_a, w_b) = (s_a.abs(), s_b.abs());
        let t = (p_a * w_b + p_b * w_a) / (w_a + w_b);
        if p_a >= 0.0 && p_b >= 0.0 {
            return Some(without_sign(t));
        }
        if p_a < 0.0 && p_b < 0.0 {
            return None;
        }
        let c = ax * by - ay * bx;
        if c == 0.0 {
            return Some(0.0);
        }
        let in_front = (c > 0.0 && s_b > s_a) || (c < 0.0 && s_b < s_a);
        in_front.then(|| without_sign(t))
    }

    /// Distance in metres from `point` to the nearest point of this wall.
    #[inline]
    #[must_use]
    pub fn distance(&self, point: &Point2<f64>) -> f64 {
        self.distance_squared(point).sqrt()
    }

    /// The square of [`Wall::distance`], in square metres.
    #[inline]
    #[must_use]
    pub fn distance_squared(&self, point: &Point2<f64>) -> f64 {
        let offset = self.offset_from(point);
        offset.x * offset.x + offset.y * offset.y
    }

    /// The point of this wall that is nearest to `point`.
    #[must_use]
    pub fn nearest(&self, point: &Point2<f64>) -> Point2<f64> {
        *point - self.offset_from(point)
    }

    /// From the nearest point of this wall to `point`.
    #[inline]
    fn offset_from(&self, point: &Point2<f64>) -> Vector2<f64> {
        let (ex, ey) = (self.b.x - self.a.x, self.b.y - self.a.y);
        let (ax, ay) = (point.x - self.a.x, point.y - self.a.y);
        let along = ax * ex + ay * ey;
        let whole = ex * ex + ey * ey;
        let (dx, dy) = if along <= 0.0 {
            (ax, ay)
        } else if along >= whole {
            (point.x - self.b.x, point.y - self.b.y)
        } else {
            let u = along / whole;
            (ax - u * ex, ay - u * ey)
        };
        Vector2::new(dx, dy)
    }

    /// Points from one end to the other, equally far apart and at most `step_m`.
    pub fn points(&self, step_m: f64) -> impl Iterator<Item = Point2<f64>> + use<> {
        let (from, along) = (self.a, self.b - self.a);
        let steps = (along.norm() / step_m).ceil().max(1.0);
        (0..=steps as usize).map(move |k| from + along * (k as f64 / steps))
    }

    /// Length in metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        let (ex, ey) = (self.b.x - self.a.x, self.b.y - self.a.y);
        (ex * ex + ey * ey).sqrt()
    }
}

/// Rules 2 and 3: at least one end lies exactly on the ray's line.
fn cast_at_end(s_a: f64, s_b: f64, p_a: f64, p_b: f64) -> Option<f64> {
    let t = if s_a != 0.0 {
        p_b
    } else if s_b != 0.0 {
        p_a
    } else if (p_a < 0.0) == (p_b < 0.0) {
        if p_a < p_b { p_a } else { p_b }
    } else {
        0.0
    };
    (t >= 0.0).then(|| without_sign(t))
}

/// Zero for anything not above it: a weighted mean of numbers around zero may
/// round to a hair below, and −0.0 must not reach a log.
fn without_sign(t: f64) -> f64 {
    if t > 0.0 { t } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trig;
    use proptest::prelude::*;

    fn wall(a: [f64; 2], b: [f64; 2]) -> Wall {
        Wall { a: Point2::from(a), b: Point2::from(b), material: Material::Wall }
    }

    fn cast(wall: &Wall, origin: [f64; 2], dir: [f64; 2]) -> Option<f64> {
        wall.cast(&Point2::from(origin), &Vector2::from(dir))
    }

    #[test]
    fn in_front_behind_and_beside() {
        let across = wall([2.0, -1.0], [2.0, 3.0]);
        assert_eq!(cast(&across, [0.0, 0.0], [1.0, 0.0]), Some(2.0));
        assert_eq!(cast(&across, [0.0, 0.0], [-1.0, 0.0]), None);
        assert_eq!(cast(&across, [0.0, 0.0], [0.0, 1.0]), None);
        assert_eq!(cast(&across, [0.0, 3.0], [1.0, 0.0]), Some(2.0));
        assert_eq!(cast(&across, [0.0, 3.5], [1.0, 0.0]), None);
    }

    #[test]
    fn along_the_ray_the_nearest_end_counts() {
        for along in [wall([2.0, 0.0], [5.0, 0.0]), wall([5.0, 0.0], [2.0, 0.0])] {
            assert_eq!(cast(&along, [0.0, 0.0], [1.0, 0.0]), Some(2.0));
            assert_eq!(cast(&along, [7.0, 0.0], [-1.0, 0.0]), Some(2.0));
            assert_eq!(cast(&along, [7.0, 0.0], [1.0, 0.0]), None);
            for on_it in [2.0, 3.0, 5.0] {
                assert_eq!(cast(&along, [on_it, 0.0], [1.0, 0.0]), Some(0.0));
            }
        }
    }

    #[test]
    fn on_the_wall_every_direction_reads_zero() {
        let level = wall([0.0, 0.7], [12.0, 0.7]);
        for k in 0..360 {
            let (s, c) = trig::sin_cos(f64::from(k) * 0.017_453);
            for x in [0.0, 5.1, 12.0] {
                let t = cast(&level, [x, 0.7], [c, s]);
                assert_eq!(t.map(f64::to_bits), Some(0.0_f64.to_bits()), "{k} {x}");
            }
        }
    }

    #[test]
    fn not_a_number_hits_nothing() {
        let across = wall([2.0, -1.0], [2.0, 3.0]);
        assert_eq!(cast(&across, [f64::NAN, 0.0], [1.0, 0.0]), None);
        assert_eq!(cast(&across, [0.0, 0.0], [f64::NAN, 0.0]), None);
    }

    #[test]
    fn distance_to_a_point() {
        let level = wall([1.0, 1.0], [3.0, 1.0]);
        assert_eq!(level.distance(&Point2::new(2.0, 4.0)), 3.0);
        assert_eq!(level.distance(&Point2::new(-3.0, 4.0)), 5.0);
        assert_eq!(level.distance(&Point2::new(6.0, -3.0)), 5.0);
        assert_eq!(level.distance(&Point2::new(1.5, 1.0)), 0.0);
        assert_eq!(level.length_m(), 2.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn the_hit_point_is_on_the_wall_and_ends_may_be_swapped(
            a in prop::array::uniform2(-9.0_f64..9.0),
            b in prop::array::uniform2(-9.0_f64..9.0),
            origin in prop::array::uniform2(-9.0_f64..9.0),
            angle_rad in -3.2_f64..3.2,
        ) {
            let (s, c) = trig::sin_cos(angle_rad);
            let t = cast(&wall(a, b), origin, [c, s]);
            let swapped = cast(&wall(b, a), origin, [c, s]);
            prop_assert_eq!(t.map(f64::to_bits), swapped.map(f64::to_bits));
            if let Some(t) = t {
                prop_assert!(t >= 0.0);
                let hit = Point2::new(origin[0] + t * c, origin[1] + t * s);
                prop_assert!(wall(a, b).distance(&hit) < 1e-13);
            }
        }

        #[test]
        fn a_ray_at_a_shared_end_hits_one_of_the_two(
            end in prop::array::uniform2(-9.0_f64..9.0),
            origin in prop::array::uniform2(-9.0_f64..9.0),
            spread_rad in 0.05_f64..1.5,
            ulps in -3_i32..=3,
        ) {
            // A roof over the ray: both walls run from `end` to either side.
            let to_end = Vector2::new(end[0] - origin[0], end[1] - origin[1]);
            let length_m = trig::hypot(to_end.x, to_end.y);
            prop_assume!(length_m > 1e-3);
            let bearing_rad = trig::atan2(to_end.y, to_end.x);
            let roof = |turn_rad: f64| {
                let (s, c) = trig::sin_cos(bearing_rad + turn_rad);
                wall(end, [origin[0] + 0.8 * length_m * c, origin[1] + 0.8 * length_m * s])
            };
            let (s, c) = trig::sin_cos(bearing_rad + f64::from(ulps) * 2e-16);
            let left = cast(&roof(spread_rad), origin, [c, s]);
            let right = cast(&roof(-spread_rad), origin, [c, s]);
            prop_assert!(left.is_some() || right.is_some());
            for t in left.iter().chain(&right) {
                prop_assert!((t - length_m).abs() < 1e-12 / spread_rad * length_m.max(1.0));
            }
        }
    }
}
