//! The ways to scan that are compared.
//!
//! Each has made beforehand whatever does not depend on the pose, and each
//! writes one range per beam.

use nalgebra::{Point2, Vector2};
use parry2d_f64::math::Vector;
use parry2d_f64::query::{Ray, RayCast};
use parry2d_f64::shape::Polyline;
use rusty_contract::LidarConfig;
use rusty_geometry::{SE2, Scan, World, trig};
use rusty_sim::Lidar;
use rusty_sim::noise::LidarNoise;

/// A way to scan.
pub trait Way {
    /// The range of each beam from a sensor pose in the world, m.
    fn scan(&mut self, sensor_in_world: &SE2, ranges_m: &mut [f64]);
}

/// The laboratory's own: a scan as one problem.
pub struct Kernel<'a> {
    world: &'a World,
    scan: Scan,
    range_max_m: f64,
}

impl<'a> Kernel<'a> {
    /// In this world, with this sensor's beams.
    #[must_use]
    pub fn new(world: &'a World, config: &LidarConfig) -> Self {
        Self { world, scan: Scan::new(config.fan()), range_max_m: config.range_max_m }
    }
}

impl Way for Kernel<'_> {
    fn scan(&mut self, sensor_in_world: &SE2, ranges_m: &mut [f64]) {
        self.scan.take(self.world, sensor_in_world, self.range_max_m);
        self.scan.write_distances_m(ranges_m);
    }
}

/// The reference: a ray for each beam through parry's tree, by the formula of
/// [`rusty_geometry::wall`].
pub struct Rays<'a> {
    world: &'a World,
    beams: Beams,
}

impl<'a> Rays<'a> {
    /// In this world, with this sensor's beams.
    #[must_use]
    pub fn new(world: &'a World, config: &LidarConfig) -> Self {
        Self { world, beams: Beams::new(config) }
    }
}

impl Way for Rays<'_> {
    fn scan(&mut self, sensor_in_world: &SE2, ranges_m: &mut [f64]) {
        let origin = Point2::from(sensor_in_world.translation());
        let max_m = self.beams.range_max_m;
        for (range_m, along) in ranges_m.iter_mut().zip(self.beams.turned(sensor_in_world)) {
            *range_m = self.world.raycast_dir(origin, along, max_m).distance_m;
        }
    }
}

/// What people would use instead: a ray for each beam, cast by parry on a
/// polyline with parry's tree and formula.
pub struct Parry {
    walls: Polyline,
    beams: Beams,
}

impl Parry {
    /// In this world, with this sensor's beams.
    #[must_use]
    pub fn new(world: &World, config: &LidarConfig) -> Self {
        let ends = world.walls().iter().flat_map(|wall| [wall.a, wall.b]);
        let points: Vec<Vector> = ends.map(|end| Vector::new(end.x, end.y)).collect();
        let pairs = (0..world.walls().len() as u32).map(|k| [2 * k, 2 * k + 1]).collect();
        Self { walls: Polyline::new(points, Some(pairs)), beams: Beams::new(config) }
    }
}

impl Way for Parry {
    fn scan(&mut self, sensor_in_world: &SE2, ranges_m: &mut [f64]) {
        let origin = sensor_in_world.translation();
        let origin = Vector::new(origin.x, origin.y);
        let max_m = self.beams.range_max_m;
        for (range_m, along) in ranges_m.iter_mut().zip(self.beams.turned(sensor_in_world)) {
            let ray = Ray::new(origin, Vector::new(along.x, along.y));
            *range_m = self.walls.cast_local_ray(&ray, max_m, true).unwrap_or(max_m);
        }
    }
}

/// The whole sensor: the kernel, then noise and dropout, tick by tick.
pub struct Noisy<'a> {
    world: &'a World,
    lidar: Lidar,
    noise: LidarNoise,
    tick: u64,
}

impl<'a> Noisy<'a> {
    /// In this world, this sensor.
    #[must_use]
    pub fn new(world: &'a World, config: &LidarConfig) -> Self {
        Self { world, lidar: Lidar::new(config), noise: LidarNoise::new(1), tick: 0 }
    }
}

impl Way for Noisy<'_> {
    fn scan(&mut self, sensor_in_world: &SE2, ranges_m: &mut [f64]) {
        // The sensor sits at the centre of the body.
        self.lidar.scan(self.world, sensor_in_world, &mut self.noise, self.tick, ranges_m);
        self.tick += 1;
    }
}

/// Directions of beams, made once.
struct Beams {
    in_sensor: Vec<Vector2<f64>>,
    range_max_m: f64,
}

impl Beams {
    fn new(config: &LidarConfig) -> Self {
        let fan = config.fan();
        let in_sensor = (0..fan.beams).map(|k| fan.direction(k)).collect();
        Self { in_sensor, range_max_m: config.range_max_m }
    }

    /// In the world, from this pose.
    fn turned(&self, sensor_in_world: &SE2) -> impl Iterator<Item = Vector2<f64>> {
        let (s, c) = trig::sin_cos(sensor_in_world.theta());
        let turn = move |b: &Vector2<f64>| Vector2::new(c * b.x - s * b.y, s * b.x + c * b.y);
        self.in_sensor.iter().map(turn)
    }
}
