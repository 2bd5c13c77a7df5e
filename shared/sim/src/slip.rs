//! The slip of each wheel: the figures of the floor under it, and the draws.
//!
//! A wheel has the figures of its robot, or those of the last patch of floor that its
//! contact point is on at the beginning of the tick. Its slip is ε = σ·z with z ~ N(0, 1),
//! and k times as much with probability p; see
//! [`SlipFigures`] for law and source.
//!
//! Slots do not depend on any of it: z has its slots in the stream `slip`, the choice of
//! outliers in the stream `slip-outliers`. A patch or a rate changes the slip of those
//! wheels and ticks that it concerns, and no other.

use nalgebra::Point2;
use rusty_contract::RobotConfig;
use rusty_contract::config::{PatchConfig, SlipFigures};
use rusty_geometry::SE2;

use crate::noise::TickNoise;

/// The slip of a robot's wheels.
#[derive(Clone, Debug)]
pub struct Slip {
    noise: TickNoise,
    /// σ, `[left, right]`, off all patches.
    stds: [f64; 2],
    /// Boxed: few runs have any.
    more: Option<Box<More>>,
}

/// All beyond one σ for each wheel.
#[derive(Clone, Debug)]
struct More {
    outliers: TickNoise,
    wheels: [SlipFigures; 2],
    patches: Vec<PatchConfig>,
    /// Contact points in the body frame, `[left, right]`.
    contacts: [Point2<f64>; 2],
}

impl Slip {
    /// The slip of `robot` on a floor with `patches`, both of which must be checked.
    #[must_use]
    pub fn new(robot: &RobotConfig, patches: &[PatchConfig], seed: u64) -> Self {
        let wheels = robot.slip_figures();
        let half_m = 0.5 * robot.track_m * (1.0 + robot.track_bias);
        let has_more = !patches.is_empty() || wheels[0].outlier_rate > 0.0;
        let more = has_more.then(|| More {
            outliers: TickNoise::slip_outliers(seed),
            wheels,
            patches: patches.to_vec(),
            contacts: [Point2::new(0.0, half_m), Point2::new(0.0, -half_m)],
        });
        Self {
            noise: TickNoise::slip(seed),
            stds: wheels.map(|figures| figures.std),
            more: more.map(Box::new),
        }
    }

    /// Goes on with the noise of another seed. Allocates nothing.
    pub fn reseed(&mut self, seed: u64) {
        self.noise = TickNoise::slip(seed);
        if let Some(more) = &mut self.more {
            more.outliers = TickNoise::slip_outliers(seed);
        }
    }

    /// ε of both wheels, `[left, right]`, in tick `tick` of a robot that is at
    /// `body_in_world` when it begins. Any tick may be asked for, in any order.
    #[must_use]
    pub fn at(&mut self, tick: u64, body_in_world: &SE2) -> [f64; 2] {
        let [z_left, z_right] = self.noise.normals(tick);
        match &mut self.more {
            None => [self.stds[0] * z_left, self.stds[1] * z_right],
            Some(more) => more.at(tick, body_in_world, [z_left, z_right]),
        }
    }
}

impl More {
    #[inline(never)]
    fn at(&mut self, tick: u64, body_in_world: &SE2, z: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|wheel| {
            let contact = body_in_world.transform_point(&self.contacts[wheel]);
            let patch = self.patches.iter().rev().find(|patch| holds(&patch.corners, &contact));
            let figures = patch.map_or(self.wheels[wheel], PatchConfig::figures);
            let slip = figures.std * z[wheel];
            let is_outlier = figures.outlier_rate > 0.0
                && self.outliers.uniform_at(tick, wheel as u64) < figures.outlier_rate;
            if is_outlier { figures.outlier_factor * slip } else { slip }
        })
    }
}

/// Whether a polygon holds a point: a ray from it to the right crosses an odd number of
/// edges. Of two polygons with a common edge, exactly one holds a point of it.
///
/// Source: W. R. Franklin, *PNPOLY: point inclusion in polygon test* (1994).
fn holds(corners: &[[f64; 2]], point: &Point2<f64>) -> bool {
    let before = corners.iter().cycle().skip(corners.len().saturating_sub(1));
    corners.iter().zip(before).fold(false, |is_in, ([x_a, y_a], [x_b, y_b])| {
        let spans = (*y_a > point.y) != (*y_b > point.y);
        is_in ^ (spans && point.x < (x_b - x_a) * (point.y - y_a) / (y_b - y_a) + x_a)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_holds_what_is_inside_and_each_point_of_an_edge_once() {
        let arrow = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5], [0.0, 2.0]];
        for (x, y, inside) in [
            (0.2, 0.2, true),
            (1.0, 0.4, true),
            (1.0, 0.6, false),
            (1.9, 1.7, true),
            (2.1, 1.0, false),
        ] {
            assert_eq!(holds(&arrow, &Point2::new(x, y)), inside, "({x}, {y})");
            let turned: Vec<_> = arrow.iter().rev().copied().collect();
            assert_eq!(holds(&turned, &Point2::new(x, y)), inside, "({x}, {y}), clockwise");
        }
        let tile = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
        for k in 0..20 {
            let point = Point2::new(1.0, 0.05 * f64::from(k));
            assert!(holds(&tile(0.0), &point) != holds(&tile(1.0), &point), "{point}");
        }
        assert!(!holds(&[], &Point2::origin()));
    }
}
