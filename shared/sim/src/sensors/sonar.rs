//! Sonars: the first echo out of a cone.
//!
//! Two models, both exact on the segments of the world, with no fan of rays:
//!
//! * **nearest**: the nearest point of any wall within the cone. The usual model of a
//!   sonar in grid mapping (A. Elfes 1987; *Probabilistic Robotics*, section 9.2: the
//!   range is that of *some* point on the arc).
//! * **specular**: at 49 kHz a wall is a mirror. It answers only along its perpendicular:
//!   where the foot of the perpendicular from the sensor lies on the wall and in the
//!   cone. A concave right-angled corner sends every pulse back to where it came from,
//!   so it answers from any place between its walls (B. Barshan and R. Kuc 1990; R. Kuc
//!   and M. W. Siegel 1987: planes and corners). What stands before the echo hides it.
//!
//! As with the LiDAR, with z* the exact range, u ~ U[0, 1) and ε ~ N(0, σ²):
//! z = z_max if u < p_drop or z* ≥ z_max, else z = clamp(z* + ε, 0, z_max).
//!
//! Departures from a real one: the echo of a wall does not weaken with range or angle
//! within the cone, free ends and convex corners do not answer in the specular model, a
//! range is not lengthened off the axis, and sonars do not hear each other.

use nalgebra::Point2;
use rusty_contract::config::sensors::{SonarConfig, SonarModel};
use rusty_contract::readings::MAX_SONARS;
use rusty_geometry::{Disc, SE2, Wall, World, trig};

use crate::lidar::measured_m;
use crate::noise::TickNoise;
use crate::scene::Scene;

/// How much nearer than an echo a wall must be to hide it, m.
const BEFORE_M: f64 = 1e-6;
/// Ends within this distance meet, m.
const MEETS_M: f64 = 1e-9;
/// A corner answers if its angle is a right one to within this cosine (5°).
const RIGHT_ANGLE_COSINE: f64 = 0.0872;

/// Ultrasonic range sensors.
#[derive(Clone, Debug)]
pub struct Sonars {
    config: SonarConfig,
    /// Sine and cosine of half the aperture.
    half_aperture: (f64, f64),
    /// For the specular model.
    corners: Vec<Corner>,
    noise: TickNoise,
    ranges_m: [f64; MAX_SONARS],
}

/// Two walls that meet at a right angle, seen from between them.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: Point2<f64>,
    /// Where the two walls go from there.
    along: [nalgebra::Vector2<f64>; 2],
}

impl Sonars {
    /// The sonars that `config` describes, in `world`.
    #[must_use]
    pub fn new(config: &SonarConfig, world: &World, seed: u64) -> Self {
        let corners = match config.model {
            SonarModel::Nearest => Vec::new(),
            SonarModel::Specular => corners(world),
        };
        Self {
            half_aperture: trig::sin_cos(0.5 * config.aperture_rad),
            config: config.clone(),
            corners,
            noise: TickNoise::sonars(seed),
            ranges_m: [0.0; MAX_SONARS],
        }
    }

    /// Goes on with the noise of another seed.
    pub fn reseed(&mut self, seed: u64) {
        self.noise = TickNoise::sonars(seed);
    }

    /// The range of each sonar in tick `tick`, m; `None` in a tick without a reading.
    pub fn read<'a>(
        &mut self,
        scene: impl Into<Scene<'a>>,
        body_in_world: &SE2,
        tick: u64,
    ) -> Option<&[f64]> {
        let scene = scene.into();
        super::due(tick, self.config.every)?;
        let draws = self.noise.pairs::<MAX_SONARS>(tick);
        let SonarConfig { range_max_m, range_std_m, dropout, .. } = self.config;
        let sensors_in_world = body_in_world.compose_each(&self.config.mounts);
        for (k, (sensor_in_world, (u, z))) in sensors_in_world.zip(draws).enumerate() {
            self.ranges_m[k] = if u < dropout {
                range_max_m
            } else {
                let exact_m = self.exact_m(scene, &sensor_in_world);
                measured_m(exact_m, range_std_m * z, range_max_m)
            };
        }
        Some(&self.ranges_m[..self.config.mounts.len()])
    }

    /// The range without noise from a *sensor* pose: z_max where nothing answers.
    #[must_use]
    pub fn exact_m<'a>(&self, scene: impl Into<Scene<'a>>, sensor_in_world: &SE2) -> f64 {
        let scene = scene.into();
        let cone = Cone::new(sensor_in_world, self.half_aperture);
        let most = self.config.range_max_m * self.config.range_max_m;
        let squared = match self.config.model {
            SonarModel::Nearest => {
                scene.world.least_squared_in_wedge(cone.apex, &cone.sides, most, |wall| {
                    cone.nearest_squared(wall)
                })
            }
            SonarModel::Specular => {
                let visible = |echo: Point2<f64>| {
                    let to = echo - cone.apex;
                    let distance_m = trig::hypot(to.x, to.y);
                    let before_m = distance_m - BEFORE_M;
                    let hidden =
                        before_m > 0.0 && scene.hides(cone.apex, to / distance_m, before_m);
                    (!hidden).then_some(distance_m * distance_m)
                };
                let wall =
                    scene.world.least_squared_in_wedge(cone.apex, &cone.sides, most, |wall| {
                        cone.foot(wall).filter(|foot| cone.holds(foot)).and_then(visible)
                    });
                let seen = self.corners.iter().filter(|c| c.faces(&cone.apex) && cone.holds(&c.at));
                seen.filter_map(|corner| visible(corner.at)).fold(wall, f64::min)
            }
        };
        // A round mirror answers along the line to its middle, if nothing is before it.
        let specular = self.config.model == SonarModel::Specular;
        let echo_m = |body: &Disc| {
            let echo_m = cone.nearest_of(body)?;
            let to = body.centre - cone.apex;
            let hears = !specular
                || echo_m <= BEFORE_M
                || (cone.holds(&body.centre)
                    && !scene.hides(cone.apex, to / trig::hypot(to.x, to.y), echo_m - BEFORE_M));
            hears.then_some(echo_m)
        };
        scene.bodies.iter().filter_map(echo_m).fold(squared.sqrt(), f64::min)
    }

    /// The walls are others from now on.
    pub fn walls_changed(&mut self, world: &World) {
        if self.config.model == SonarModel::Specular {
            self.corners = corners(world);
        }
    }
}

/// Where a sonar hears: everything between two rays from its apex.
struct Cone {
    apex: Point2<f64>,
    /// Inward normals of the two sides.
    sides: [nalgebra::Vector2<f64>; 2],
}

impl Cone {
    fn new(sensor_in_world: &SE2, (sine, cosine): (f64, f64)) -> Self {
        let (s, c) = trig::sin_cos(sensor_in_world.theta());
        let turned = |x: f64, y: f64| nalgebra::Vector2::new(c * x - s * y, s * x + c * y);
        let apex = Point2::from(sensor_in_world.translation());
        Self { apex, sides: [turned(sine, -cosine), turned(sine, cosine)] }
    }

    fn holds(&self, point: &Point2<f64>) -> bool {
        let to = point - self.apex;
        self.sides.iter().all(|side| side.dot(&to) >= 0.0)
    }

    /// Squared distance from the apex to the nearest point of what the cone cuts out of
    /// a wall; `None` where that is nothing.
    fn nearest_squared(&self, wall: &Wall) -> Option<f64> {
        let (a, b) = (wall.a - self.apex, wall.b - self.apex);
        let (mut from, mut to) = (0.0, 1.0);
        for side in &self.sides {
            let (at_a, at_b) = (side.dot(&a), side.dot(&b));
            if at_a < 0.0 && at_b < 0.0 {
                return None;
            }
            let cut = at_a / (at_a - at_b);
            if at_a < 0.0 {
                from = if cut > from { cut } else { from };
            } else if at_b < 0.0 {
                to = if cut < to { cut } else { to };
            }
        }
        if from > to {
            return None;
        }
        let along = b - a;
        let foot = -a.dot(&along) / along.dot(&along);
        let at = a + along * foot.clamp(from, to);
        Some(at.dot(&at))
    }

    /// Distance from the apex to the nearest point of a body within the cone, m.
    fn nearest_of(&self, body: &Disc) -> Option<f64> {
        let to = body.centre - self.apex;
        let distance_m = trig::hypot(to.x, to.y);
        if distance_m <= body.radius_m {
            return Some(0.0);
        }
        if self.holds(&body.centre) {
            return Some(distance_m - body.radius_m);
        }
        // Its middle is outside: the nearest point is on a side of the cone.
        let along = |side: &nalgebra::Vector2<f64>, turn: f64| {
            body.cast(&self.apex, &nalgebra::Vector2::new(side.y * turn, -side.x * turn))
        };
        let met = [along(&self.sides[0], -1.0), along(&self.sides[1], 1.0)];
        met.into_iter().flatten().reduce(f64::min)
    }

    /// The foot of the perpendicular from the apex, where it lies on the wall.
    fn foot(&self, wall: &Wall) -> Option<Point2<f64>> {
        let along = wall.b - wall.a;
        let share = (self.apex - wall.a).dot(&along) / along.dot(&along);
        (0.0..=1.0).contains(&share).then(|| wall.a + along * share)
    }
}

impl Corner {
    /// Whether a point is between the two walls.
    fn faces(&self, point: &Point2<f64>) -> bool {
        let to = point - self.at;
        self.along.iter().all(|along| along.dot(&to) > 0.0)
    }
}

/// All places where an end of a wall meets another wall at a right angle. At an end
/// that meets the middle of another wall there are two.
fn corners(world: &World) -> Vec<Corner> {
    let mut found = Vec::new();
    for (i, wall) in world.walls().iter().enumerate() {
        for (end, other_end) in [(wall.a, wall.b), (wall.b, wall.a)] {
            let along = (other_end - end).normalize();
            world.visit_near(end, MEETS_M, |j, other| {
                if i == j || other.distance(&end) > MEETS_M {
                    return;
                }
                for (far, near) in [(other.a, other.b), (other.b, other.a)] {
                    // Where two ends meet, the second wall finds this corner again.
                    let is_end = nalgebra::distance(&near, &end) <= MEETS_M;
                    if nalgebra::distance(&far, &end) <= MEETS_M || (is_end && j < i) {
                        continue;
                    }
                    let other_along = (far - end).normalize();
                    if along.dot(&other_along).abs() <= RIGHT_ANGLE_COSINE {
                        found.push(Corner { at: end, along: [along, other_along] });
                    }
                }
            });
        }
    }
    found
}

#[cfg(test)]
mod tests;
