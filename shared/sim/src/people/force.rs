//! The social force on a person.
//!
//! Source: D. Helbing and P. Molnár, "Social force model for pedestrian dynamics",
//! Physical Review E 51 (1995) 4282, equations 2 to 10 and the parameters of section
//! III: a person accelerates towards the speed and direction that they like within
//! τ = 0.5 s, away from others by the potential 2.1 m²/s²·exp(−b/0.3 m), where b is the
//! half minor axis of the ellipse around the other's next two seconds, and away from the
//! nearest wall by 10 m²/s²·exp(−r/0.2 m). What is not within 100° of the direction
//! liked counts half (c = 0.5).
//!
//! Departures: attraction and fluctuations are left out, others with b > 3 m (where the
//! force is below 10⁻³ m/s²) are not looked at, nor walls farther than 1.5 m, and the
//! robot counts as one that stands.

use nalgebra::{Point2, Vector2};
use rusty_geometry::trig;

/// Relaxation time τ, s.
const RELAXATION_S: f64 = 0.5;
/// V⁰ and σ of the repulsion between people, m²/s² and m.
const PERSON: (f64, f64) = (2.1, 0.3);
/// U⁰ and R of the repulsion of walls, m²/s² and m.
const WALL: (f64, f64) = (10.0, 0.2);
/// How far ahead a person thinks of others' steps, s.
const FORESIGHT_S: f64 = 2.0;
/// Cosine of half the angle of sight, 100°, and the weight of what is outside.
const SIGHT: (f64, f64) = (-0.173_648_177_666_930_3, 0.5);
/// Others whose ellipse is farther than this are not looked at, m.
const FAR_M: f64 = 3.0;
/// Distances below this count as this, m.
const NEAR_M: f64 = 1e-3;

/// A body that a person keeps away from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Other {
    pub at: Point2<f64>,
    pub velocity_m_s: Vector2<f64>,
}

/// Acceleration towards the velocity that a person likes, m/s².
pub(super) fn drive(liked_m_s: Vector2<f64>, velocity_m_s: Vector2<f64>) -> Vector2<f64> {
    (liked_m_s - velocity_m_s) / RELAXATION_S
}

/// Acceleration of a person at `at` who likes to walk along `liked` away from another,
/// m/s².
pub(super) fn away_from(at: Point2<f64>, liked: Vector2<f64>, other: &Other) -> Vector2<f64> {
    let apart = at - other.at;
    let square = apart.x * apart.x + apart.y * apart.y;
    let step = other.velocity_m_s * FORESIGHT_S;
    let step_m = length(&step);
    // Farther, b is above FAR_M.
    let far_m = FAR_M + step_m;
    if square > far_m * far_m {
        return Vector2::zeros();
    }
    let after = apart - step;
    let (d1, d2) = (length(&apart).max(NEAR_M), length(&after).max(NEAR_M));
    let sum = d1 + d2;
    let b = 0.5 * (sum * sum - step_m * step_m).max(4.0 * NEAR_M * NEAR_M).sqrt();
    let gradient_of_b = (apart / d1 + after / d2) * (sum / (4.0 * b));
    let force = gradient_of_b * (PERSON.0 / PERSON.1 * trig::exp(-b / PERSON.1));
    // −f is where the other is: seen, if that is within the angle of sight.
    let seen = liked.dot(&-force) >= length(&force) * SIGHT.0;
    force * if seen { 1.0 } else { SIGHT.1 }
}

/// Acceleration away from the nearest point of a wall, m/s².
pub(super) fn away_from_wall(at: Point2<f64>, wall: Point2<f64>) -> Vector2<f64> {
    let apart = at - wall;
    let distance_m = length(&apart).max(NEAR_M);
    apart / distance_m * (WALL.0 / WALL.1 * trig::exp(-distance_m / WALL.1))
}

pub(super) fn length(v: &Vector2<f64>) -> f64 {
    (v.x * v.x + v.y * v.y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AHEAD: Vector2<f64> = Vector2::new(1.0, 0.0);

    /// The potential whose gradient the force is.
    fn potential(at: Point2<f64>, other: &Other) -> f64 {
        let apart = at - other.at;
        let step = other.velocity_m_s * 2.0;
        let sum = length(&apart) + length(&(apart - step));
        let b = 0.5 * (sum * sum - step.dot(&step)).sqrt();
        2.1 * trig::exp(-b / 0.3)
    }

    #[test]
    fn the_force_is_the_slope_of_the_potential() {
        let other = Other { at: Point2::new(1.0, 0.3), velocity_m_s: Vector2::new(-0.7, 0.2) };
        for at in [Point2::new(0.0, 0.0), Point2::new(0.2, 0.9), Point2::new(0.5, -0.4)] {
            let force = away_from(at, AHEAD, &other);
            let h = 1e-6;
            let slope = |d: Vector2<f64>| {
                (potential(at + d * h, &other) - potential(at - d * h, &other)) / (2.0 * h)
            };
            let expected = -Vector2::new(slope(Vector2::x()), slope(Vector2::y()));
            let error = length(&(force - expected));
            assert!(error < 1e-6 * (1.0 + length(&expected)), "{force} {expected}");
        }
    }

    #[test]
    fn who_is_behind_counts_half() {
        let still = |x| Other { at: Point2::new(x, 0.0), velocity_m_s: Vector2::zeros() };
        let ahead = away_from(Point2::origin(), AHEAD, &still(0.5));
        let behind = away_from(Point2::origin(), AHEAD, &still(-0.5));
        assert!(ahead.x < 0.0 && behind.x > 0.0);
        assert!((behind.x + 0.5 * ahead.x).abs() < 1e-12);
        // At half a metre: 7 m/s² · exp(−0.5/0.3).
        assert!((ahead.x + 7.0 * trig::exp(-0.5 / 0.3)).abs() < 1e-12);
    }

    #[test]
    fn walls_and_wishes_pull_as_in_the_paper() {
        let wall = away_from_wall(Point2::new(0.2, 0.0), Point2::origin());
        assert!((wall.x - 50.0 * trig::exp(-1.0)).abs() < 1e-12 && wall.y == 0.0);
        assert_eq!(drive(AHEAD * 1.34, Vector2::zeros()), AHEAD * 2.68);
        let far = Other { at: Point2::new(5.1, 0.0), velocity_m_s: AHEAD };
        assert_eq!(away_from(Point2::origin(), AHEAD, &far), Vector2::zeros());
    }
}
