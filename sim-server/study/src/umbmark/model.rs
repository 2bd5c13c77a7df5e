//! The square, driven by a robot that is wrong about itself, without noise.

use rusty_geometry::{DiffDrive, SE2};

use super::factors::Factors;
use super::lap::Way;

/// Where a robot ends that believes to drive a perfect square of sides
/// `side_m`: x and y of its true pose less the believed one, m. Sides and
/// corners are exact arcs; `track_m` is the believed wheelbase.
///
/// On a side both wheels roll `side_m` by belief, in truth c_L and c_R times as
/// much; on a corner ∓ and ± π/4 · track by belief. The mean of c_L and c_R is 1,
/// see [`Factors::of`].
#[must_use]
pub fn returned_m(factors: &Factors, side_m: f64, track_m: f64, way: Way) -> [f64; 2] {
    let [left, right] = factors.wheels();
    let truth =
        DiffDrive { wheel_radius_m: 1.0, track_m: factors.wheelbase * track_m, ticks_per_rev: 1 };
    let corner_m = way.sign() * core::f64::consts::FRAC_PI_4 * track_m;
    let side = truth.tangent(left * side_m, right * side_m);
    let corner = truth.tangent(-left * corner_m, right * corner_m);
    let mut pose = SE2::identity();
    for _ in 0..4 {
        pose = pose.boxplus(&side).boxplus(&corner);
    }
    [pose.x(), pose.y()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(wheelbase: f64, diameters: f64, way: Way) -> [f64; 2] {
        returned_m(&Factors { wheelbase, diameters }, 4.0, 0.34, way)
    }

    #[test]
    fn who_is_right_comes_back() {
        for way in Way::BOTH {
            let [x, y] = at(1.0, 1.0, way);
            assert!(x.abs() < 1e-14 && y.abs() < 1e-14, "{x} {y}");
        }
    }

    #[test]
    fn small_errors_are_those_of_the_paper() {
        // Type A, α = 90° (1 − 1/E_b): (−2Lα, ∓2Lα) with − for clockwise.
        let alpha = core::f64::consts::FRAC_PI_2 * (1.0 - 1.0 / 1.0001);
        let near = |found: [f64; 2], expected: [f64; 2]| {
            for (f, e) in found.into_iter().zip(expected) {
                assert!((f - e).abs() < 2e-3 * e.abs(), "{found:?} {expected:?}");
            }
        };
        let off = 8.0 * alpha;
        near(at(1.0001, 1.0, Way::Clockwise), [-off, -off]);
        near(at(1.0001, 1.0, Way::CounterClockwise), [-off, off]);
        // Type B, β = L/R with R = b/2 · (E_d + 1)/(E_d − 1): (∓2Lβ, −2Lβ), but
        // for the corners, which move the centre by 10⁻⁴ of the wheelbase.
        let beta = 4.0 * 2e-5 / 2.00001 / 0.34;
        let off = 8.0 * beta;
        near(at(1.0, 1.00001, Way::Clockwise), [-off, -off]);
        near(at(1.0, 1.00001, Way::CounterClockwise), [off, -off]);
    }
}
