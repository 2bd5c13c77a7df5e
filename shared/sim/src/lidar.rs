//! The LiDAR: one scan of the world from a true pose.
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, Algorithm
//! `raycast_scan`. The sensor stands at T = x ∘ T_lidar; per beam k, with z* the
//! exact distance to the first wall along bearing φ_k, capped at z_max, and with
//! u ~ U[0, 1) and ε ~ N(0, σ_r²):
//!
//! z = z_max if u < p_drop or z* ≥ z_max, else z = clamp(z* + ε, 0, z_max).
//!
//! Three figures of a real LiDAR may be added, all off by default: noise that grows
//! with the range, σ_r² = σ_0² + (κ·z*)², for two independent errors, as data sheets
//! state them (the Hokuyo URG-04LX: 30 mm up to 1 m, 3 % beyond); glass that a beam may
//! pass, see `lidar/glass.rs`; and mixed pixels at edges, see `lidar/footprint.rs`.
//!
//! Departures: the sine and cosine of every φ_k are taken once, and a scan turns
//! them by the heading, so that it costs one sine and one cosine in all; the
//! beams are cast together, see [`rusty_geometry::scan`], with the bits of one
//! ray at a time; the draws are placed, not consumed, see [`crate::noise`].

mod footprint;
mod glass;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use nalgebra::Point2;
use rusty_contract::LidarConfig;
use rusty_geometry::{Disc, Hit, Material, SE2, Scan, World, trig};

use self::footprint::Footprint;
use self::glass::{Glass, Rays};

use crate::noise::LidarNoise;
use crate::scene::Scene;

/// A planar LiDAR.
#[derive(Clone, Debug)]
pub struct Lidar {
    scan: Scan,
    range_max_m: f64,
    range_std_m: f64,
    range_std_per_m: f64,
    dropout: f64,
    sensor_in_body: SE2,
    glass: Option<Glass>,
    footprint: Option<Footprint>,
}

impl Lidar {
    /// The sensor that `config` describes. The configuration must be checked,
    /// see [`LidarConfig::check`].
    #[must_use]
    pub fn new(config: &LidarConfig) -> Self {
        Self {
            scan: Scan::new(config.fan()),
            range_max_m: config.range_max_m,
            range_std_m: config.range_std_m,
            range_std_per_m: config.range_std_per_m,
            dropout: config.dropout,
            sensor_in_body: config.sensor_in_body,
            glass: Glass::new(config),
            footprint: Footprint::new(config),
        }
    }

    /// Number of beams n.
    #[must_use]
    pub fn beams(&self) -> usize {
        self.scan.fan().beams as usize
    }

    /// The scan of tick `tick` from the body pose `pose_in_world`: writes the
    /// range of beam k, in metres, to `ranges_m[k]`. Of a slice that is not
    /// [`beams`](Self::beams) long, the part that both have is written.
    ///
    /// The draws depend on seed, tick and beam alone: not on what other scans
    /// were taken, nor on what the beams hit.
    pub fn scan<'a>(
        &mut self,
        scene: impl Into<Scene<'a>>,
        pose_in_world: &SE2,
        noise: &mut LidarNoise,
        tick: u64,
        ranges_m: &mut [f64],
    ) {
        let sensor_in_world = pose_in_world.compose(&self.sensor_in_body);
        let scene = scene.into();
        self.scan.take(scene.world, &sensor_in_world, self.range_max_m);
        self.scan.write_distances_m(ranges_m);
        if self.glass.is_some() || self.footprint.is_some() {
            let origin = Point2::from(sensor_in_world.translation());
            let (max_m, glass) = (self.range_max_m, self.glass);
            self.refine(Rays { world: scene.world, origin, max_m, glass, noise, tick }, ranges_m);
        }
        for body in scene.bodies {
            self.shorten(body, &sensor_in_world, ranges_m);
        }
        if self.range_std_per_m == 0.0 {
            self.add_noise(noise, tick, ranges_m, |_| self.range_std_m);
        } else {
            let std_m = |range_m| trig::hypot(self.range_std_m, self.range_std_per_m * range_m);
            self.add_noise(noise, tick, ranges_m, std_m);
        }
    }

    /// Casts the beams that meet glass, or have a footprint, one by one.
    #[cold]
    #[inline(never)]
    fn refine(&self, mut rays: Rays<'_>, ranges_m: &mut [f64]) {
        let hits = self.scan.distances_and_walls().enumerate();
        for (range_m, (k, (distance_m, wall))) in ranges_m.iter_mut().zip(hits) {
            let is_glass = |wall: usize| rays.world.walls()[wall].material == Material::Glass;
            if self.footprint.is_none() && !wall.is_some_and(is_glass) {
                continue;
            }
            let unit_dir = self.scan.direction(k);
            let middle = wall.and_then(|wall| rays.through_glass(k, unit_dir, (distance_m, wall)));
            let found_m = match &self.footprint {
                Some(footprint) => footprint.range_m(&mut rays, k, unit_dir, middle),
                None => middle.map(|(distance_m, _)| distance_m),
            };
            *range_m = found_m.unwrap_or(self.range_max_m);
        }
    }

    /// Adds dropout and range noise to exact ranges, with the standard deviation
    /// `std_m` of each.
    #[inline(always)]
    fn add_noise(
        &self,
        noise: &mut LidarNoise,
        tick: u64,
        ranges_m: &mut [f64],
        std_m: impl Fn(f64) -> f64,
    ) {
        for (range_m, draw) in ranges_m.iter_mut().zip(noise.at(tick, self.beams())) {
            *range_m = if draw.u < self.dropout {
                self.range_max_m
            } else {
                measured_m(*range_m, std_m(*range_m) * draw.z, self.range_max_m)
            };
        }
    }

    /// Shortens the beams that meet a body before a wall. Of the beams, only those
    /// that may meet it are tried.
    fn shorten(&self, body: &Disc, sensor_in_world: &SE2, ranges_m: &mut [f64]) {
        let origin = Point2::from(sensor_in_world.translation());
        let to = body.centre - origin;
        let square = to.x * to.x + to.y * to.y;
        let (fan, reach_m) = (self.scan.fan(), self.range_max_m + body.radius_m);
        if square > reach_m * reach_m {
            return;
        }
        // sin α = R/d, and α ≤ π/2·sin α; from inside the body, all around.
        let sine = body.radius_m / square.sqrt();
        let half_rad = if sine < 1.0 { FRAC_PI_2 * sine + ROUGH_RAD } else { TAU };
        // No beam meets it before this, with room for rounding.
        let least_m = square.sqrt() * (1.0 - 1e-9) - body.radius_m;
        let bearing_rad = roughly_atan2(to.y, to.x) - sensor_in_world.theta();
        // In beams: the middle of the body, half its width, and a whole turn.
        let per_rad = f64::from(fan.beams) / fan.fov_rad;
        let middle = (bearing_rad - fan.first_bearing_rad) * per_rad;
        let (half, turn) = (half_rad * per_rad, TAU * per_rad);
        for turns in -2..=3 {
            let middle = middle + turn * f64::from(turns);
            if middle + half < 0.0 || middle - half > f64::from(fan.beams) {
                continue;
            }
            // A beam more on each side, for rounding. What is negative counts as 0.
            let first = (middle - half - 1.0) as usize;
            let end = ((middle + half + 2.0) as usize).min(self.beams()).min(ranges_m.len());
            let first = first.min(end);
            for (range_m, k) in ranges_m[first..end].iter_mut().zip(first..) {
                if *range_m < least_m {
                    continue;
                }
                let met_m = body.cast(&origin, &self.scan.direction(k));
                *range_m = met_m.filter(|met_m| met_m < range_m).unwrap_or(*range_m);
            }
        }
    }

    /// What the beams meet from the *sensor* pose `sensor_in_world`, without
    /// noise or dropout: distance (z_max where nothing is met) and material of
    /// beam k to `hits[k]`. For drawings and tests.
    pub fn ranges_and_materials(&mut self, world: &World, sensor_in_world: &SE2, hits: &mut [Hit]) {
        self.scan.take(world, sensor_in_world, self.range_max_m);
        for (place, hit) in hits.iter_mut().zip(self.scan.hits(world)) {
            *place = hit;
        }
    }
}

/// By how much [`roughly_atan2`] may be off, rad.
const ROUGH_RAD: f64 = 0.004;

/// The bearing of (x, y) to within [`ROUGH_RAD`], rad: to tell which beams to try.
/// With q = min/max of |x| and |y|, atan q ≈ q·(π/4 + 0.273·(1 − q)).
///
/// Source: S. Rajan et al., *Efficient approximations for the arctangent function*, IEEE
/// Signal Processing Magazine 23(3), 2006, equation 8.
fn roughly_atan2(y: f64, x: f64) -> f64 {
    let (along, across) = (x.abs(), y.abs());
    let is_steep = across > along;
    let (less, more) = if is_steep { (along, across) } else { (across, along) };
    let q = if more > 0.0 { less / more } else { 0.0 };
    let octant_rad = q * (FRAC_PI_4 + 0.273 * (1.0 - q));
    let quadrant_rad = if is_steep { FRAC_PI_2 - octant_rad } else { octant_rad };
    let half_rad = if x < 0.0 { PI - quadrant_rad } else { quadrant_rad };
    if y < 0.0 { -half_rad } else { half_rad }
}

/// A range that did not drop out, with its error, between 0 and `range_max_m`. Written
/// with comparisons: `f64::max` may return either zero for two zeros of unlike sign.
pub(crate) fn measured_m(exact_m: f64, error_m: f64, range_max_m: f64) -> f64 {
    let range_m = exact_m + error_m;
    if exact_m >= range_max_m || range_m >= range_max_m {
        range_max_m
    } else if range_m <= 0.0 {
        0.0
    } else {
        range_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{Material, apartment, open};

    const NOTHING: Hit = Hit { distance_m: f64::NAN, material: None };

    fn scan(config: &LidarConfig, world: &World, tick: u64) -> Vec<f64> {
        let mut lidar = Lidar::new(config);
        let mut ranges_m = vec![f64::NAN; lidar.beams()];
        let pose = SE2::new(4.9, 2.84, 1.0);
        lidar.scan(world, &pose, &mut LidarNoise::new(3), tick, &mut ranges_m);
        ranges_m
    }

    #[test]
    fn a_rough_bearing_is_as_near_as_it_says() {
        for k in -18_000..=18_000 {
            let bearing_rad = f64::from(k) * PI / 18_000.0;
            let (s, c) = trig::sin_cos(bearing_rad);
            let error_rad =
                rusty_geometry::wrap_angle(roughly_atan2(7.0 * s, 7.0 * c) - bearing_rad);
            assert!(error_rad.abs() < ROUGH_RAD, "{bearing_rad}: {error_rad}");
        }
        assert_eq!(roughly_atan2(0.0, 0.0), 0.0);
    }

    #[test]
    fn an_open_world_returns_the_greatest_range_whatever_the_noise() {
        let config = LidarConfig { range_std_m: 1.0, ..LidarConfig::default() };
        assert!(scan(&config, &open(), 0).iter().all(|r| *r == 8.0));
    }

    #[test]
    fn ranges_stay_within_their_limits() {
        let config = LidarConfig { range_std_m: 10.0, ..LidarConfig::default() };
        let ranges_m = scan(&config, &apartment(), 0);
        assert!(ranges_m.iter().all(|r| (0.0..=8.0).contains(r)));
        assert!(ranges_m.iter().any(|r| r.to_bits() == 0) && ranges_m.contains(&8.0));
    }

    #[test]
    fn certain_dropout_leaves_nothing() {
        let config = LidarConfig { dropout: 1.0, ..LidarConfig::default() };
        assert!(scan(&config, &apartment(), 0).iter().all(|r| *r == 8.0));
    }

    #[test]
    fn without_noise_a_scan_is_what_the_beams_meet() {
        let config = LidarConfig {
            range_std_m: 0.0,
            sensor_in_body: SE2::new(0.05, -0.02, 0.3),
            ..LidarConfig::default()
        };
        let mut lidar = Lidar::new(&config);
        let mut hits = vec![NOTHING; lidar.beams()];
        let sensor = SE2::new(4.9, 2.84, 1.0).compose(&config.sensor_in_body);
        lidar.ranges_and_materials(&apartment(), &sensor, &mut hits);
        let ranges_m = scan(&config, &apartment(), 0);
        assert!(ranges_m.iter().zip(&hits).all(|(r, h)| *r == h.distance_m));
        assert!(hits.iter().any(|h| h.material == Some(Material::Wall)));
    }

    #[test]
    fn a_turned_table_is_as_good_as_a_table_of_turned_bearings() {
        let config = LidarConfig::default();
        let mut lidar = Lidar::new(&config);
        let sensor = SE2::new(4.9, 2.84, 0.7);
        let mut hits = vec![NOTHING; lidar.beams()];
        lidar.ranges_and_materials(&apartment(), &sensor, &mut hits);
        let origin = Point2::new(4.9, 2.84);
        for (k, hit) in hits.iter().enumerate() {
            let bearing_rad = 0.7 + config.bearing_rad(k as u32);
            let direct = apartment().raycast(origin, bearing_rad, 8.0);
            assert!((hit.distance_m - direct.distance_m).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn bodies_shorten_the_beams_that_meet_them_and_no_others() {
        let world = open();
        for (fov_rad, first_bearing_rad) in [(TAU, -3.1), (TAU, 6.2), (4.1, -2.0), (1.0, -6.2)] {
            let beams = 331;
            let fan = LidarConfig { beams, fov_rad, first_bearing_rad, ..LidarConfig::default() };
            let mut lidar = Lidar::new(&LidarConfig { range_std_m: 0.0, ..fan });
            for k in 0..60u32 {
                let (distance_m, bearing_rad) = (0.1 + 0.13 * f64::from(k), 0.7 * f64::from(k));
                let (s, c) = trig::sin_cos(bearing_rad);
                let centre = Point2::new(1.0 + distance_m * c, 2.0 + distance_m * s);
                let bodies = [Disc { centre, radius_m: 0.25 }];
                let pose = SE2::new(1.0, 2.0, 0.1 * f64::from(k));
                let mut ranges_m = vec![0.0; beams as usize];
                let scene = Scene { world: &world, bodies: &bodies };
                lidar.scan(scene, &pose, &mut LidarNoise::new(3), 0, &mut ranges_m);
                for (beam, range_m) in ranges_m.iter().enumerate() {
                    let (s, c) = trig::sin_cos(pose.theta() + fan.bearing_rad(beam as u32));
                    let along = nalgebra::Vector2::new(c, s);
                    let origin = Point2::from(pose.translation());
                    let met_m = bodies[0].cast(&origin, &along).unwrap_or(8.0).min(8.0);
                    // Along the rim, rounding decides.
                    let at_rim = (along.x * (centre.y - 2.0) - along.y * (centre.x - 1.0)).abs();
                    let at_rim = (at_rim - 0.25).abs() < 1e-9;
                    assert!(
                        at_rim || (range_m - met_m).abs() < 1e-9,
                        "{k} {beam}: {range_m} {met_m}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_short_slice_takes_the_first_beams() {
        let mut lidar = Lidar::new(&LidarConfig::default());
        let pose = SE2::new(4.9, 2.84, 1.0);
        let mut few_m = [0.0; 7];
        let mut noise = LidarNoise::new(3);
        lidar.scan(&apartment(), &pose, &mut noise, 2, &mut few_m);
        let all_m = scan(&LidarConfig::default(), &apartment(), 2);
        assert_eq!(few_m, all_m[..7]);
    }
}
