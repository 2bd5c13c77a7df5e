//! The ways to scan that are compared.
//!
//! Each has made beforehand whatever does not depend on the pose, and each
//! writes one range per beam, from a sensor pose in the world, m.

use nalgebra::{Point2, Vector2};
use parry2d_f64::math::Vector;
use parry2d_f64::query::{Ray, RayCast};
use parry2d_f64::shape::Polyline;
use rusty_contract::LidarConfig;
use rusty_geometry::{SE2, Scan, World, trig};
use rusty_sim::Lidar;
use rusty_sim::noise::LidarNoise;

/// The laboratory's own: a scan as one problem.
pub(super) fn kernel(world: &World, config: &LidarConfig) -> impl FnMut(&SE2, &mut [f64]) {
    let (mut scan, range_max_m) = (Scan::new(config.fan()), config.range_max_m);
    move |sensor_in_world, ranges_m| {
        scan.take(world, sensor_in_world, range_max_m);
        scan.write_distances_m(ranges_m);
    }
}

/// The reference: a ray for each beam through parry's tree, by the formula of
/// [`rusty_geometry::wall`].
pub(super) fn rays(world: &World, config: &LidarConfig) -> impl FnMut(&SE2, &mut [f64]) {
    let beams = Beams::new(config);
    move |sensor_in_world, ranges_m| {
        let origin = Point2::from(sensor_in_world.translation());
        for (range_m, along) in ranges_m.iter_mut().zip(beams.turned(sensor_in_world)) {
            *range_m = world.raycast_dir(origin, along, beams.range_max_m).distance_m;
        }
    }
}

/// The usual alternative: a ray for each beam, cast by parry on a polyline with
/// parry's tree and formula.
pub(super) fn parry(world: &World, config: &LidarConfig) -> impl FnMut(&SE2, &mut [f64]) {
    let ends = world.walls().iter().flat_map(|wall| [wall.a, wall.b]);
    let points: Vec<Vector> = ends.map(|end| Vector::new(end.x, end.y)).collect();
    let pairs = (0..world.walls().len() as u32).map(|k| [2 * k, 2 * k + 1]).collect();
    let (walls, beams) = (Polyline::new(points, Some(pairs)), Beams::new(config));
    move |sensor_in_world, ranges_m| {
        let origin = sensor_in_world.translation();
        let origin = Vector::new(origin.x, origin.y);
        let max_m = beams.range_max_m;
        for (range_m, along) in ranges_m.iter_mut().zip(beams.turned(sensor_in_world)) {
            let ray = Ray::new(origin, Vector::new(along.x, along.y));
            *range_m = walls.cast_local_ray(&ray, max_m, true).unwrap_or(max_m);
        }
    }
}

/// The whole sensor: the kernel, then noise and dropout, tick by tick.
pub(super) fn noisy(world: &World, config: &LidarConfig) -> impl FnMut(&SE2, &mut [f64]) {
    let (mut lidar, mut noise, mut tick) = (Lidar::new(config), LidarNoise::new(1), 0);
    move |sensor_in_world, ranges_m| {
        // The sensor is at the centre of the body.
        lidar.scan(world, sensor_in_world, &mut noise, tick, ranges_m);
        tick += 1;
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
