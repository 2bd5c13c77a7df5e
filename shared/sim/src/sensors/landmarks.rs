//! Range, bearing and identity of landmarks.
//!
//! Source: S. Thrun, W. Burgard and D. Fox, *Probabilistic Robotics* (2005), section
//! 6.6, Table 6.4: r = |m − x| + ε_r, φ = atan2(m − x) − θ + ε_φ, the signature is the
//! landmark's number. ε_r ~ N(0, σ_r²), ε_φ ~ N(0, σ_φ²).
//!
//! Departures: a landmark is measured only within range and field of view and with
//! nothing before it; of more than 64 the nearest are; a negative range is 0. Without
//! identity, readings are in the order of their bearings, so that their order tells
//! nothing.

use nalgebra::Point2;
use rusty_contract::LandmarkReading;
use rusty_contract::config::sensors::{Identity, LandmarkSensorConfig};
use rusty_contract::readings::MAX_LANDMARKS;
use rusty_geometry::{SE2, World, trig, wrap_angle};

use crate::noise::TickNoise;
use crate::scene::Scene;

/// How much nearer than what it hides a wall must be, m.
const BEFORE_M: f64 = 1e-6;

/// Distance and bearing of a point from a body, where it is within range, within
/// half of `fov_rad` to each side of straight ahead, and nothing is before it.
pub(super) fn in_view(
    scene: &Scene<'_>,
    body_in_world: &SE2,
    point: &Point2<f64>,
    range_max_m: f64,
    fov_rad: f64,
) -> Option<(f64, f64)> {
    let to = point - Point2::from(body_in_world.translation());
    let distance_m = trig::hypot(to.x, to.y);
    if distance_m > range_max_m {
        return None;
    }
    if distance_m == 0.0 {
        return Some((0.0, 0.0));
    }
    let bearing_rad = wrap_angle(trig::atan2(to.y, to.x) - body_in_world.theta());
    if bearing_rad.abs() > 0.5 * fov_rad {
        return None;
    }
    let origin = Point2::from(body_in_world.translation());
    let hidden = scene.hides(origin, to / distance_m, distance_m - BEFORE_M);
    (!hidden).then_some((distance_m, bearing_rad))
}

/// A sensor of landmarks.
#[derive(Clone, Debug)]
pub struct LandmarkSensor {
    config: LandmarkSensorConfig,
    noise: TickNoise,
    /// Room for all that are in view: distance, bearing, index of the landmark.
    in_view: Vec<(f64, f64, usize)>,
    readings: Vec<LandmarkReading>,
}

impl LandmarkSensor {
    /// The sensor that `config` describes, in `world`.
    #[must_use]
    pub fn new(config: &LandmarkSensorConfig, world: &World, seed: u64) -> Self {
        Self {
            config: *config,
            noise: TickNoise::landmarks(seed),
            in_view: Vec::with_capacity(world.spec().landmarks.len()),
            readings: Vec::with_capacity(MAX_LANDMARKS),
        }
    }

    /// Goes on with the noise of another seed.
    pub fn reseed(&mut self, seed: u64) {
        self.noise = TickNoise::landmarks(seed);
    }

    /// What is measured in tick `tick`; `None` in a tick without a reading.
    pub fn read<'a>(
        &mut self,
        scene: impl Into<Scene<'a>>,
        body_in_world: &SE2,
        tick: u64,
    ) -> Option<&[LandmarkReading]> {
        let scene = scene.into();
        let config = &self.config;
        super::due(tick, config.every)?;
        let landmarks = &scene.world.spec().landmarks;
        self.in_view.clear();
        self.in_view.extend(landmarks.iter().enumerate().filter_map(|(index, landmark)| {
            let at = Point2::from(landmark.at);
            in_view(&scene, body_in_world, &at, config.range_max_m, config.fov_rad)
                .map(|(distance_m, bearing_rad)| (distance_m, bearing_rad, index))
        }));
        if self.in_view.len() > MAX_LANDMARKS {
            let nearer = |a: &(f64, f64, usize), b: &(f64, f64, usize)| {
                a.0.total_cmp(&b.0).then(a.2.cmp(&b.2))
            };
            self.in_view.select_nth_unstable_by(MAX_LANDMARKS, nearer);
            self.in_view.truncate(MAX_LANDMARKS);
            self.in_view.sort_unstable_by_key(|seen| seen.2);
        }
        self.readings.clear();
        for &(distance_m, bearing_rad, index) in &self.in_view {
            let (u, [z_range, z_bearing]) = self.noise.uniform_and_normals_at(tick, index);
            if u < config.dropout {
                continue;
            }
            let range_m = distance_m + config.range_std_m * z_range;
            let bearing_rad = wrap_angle(bearing_rad + config.bearing_std_rad * z_bearing);
            let id = (config.identity == Identity::Given).then_some(landmarks[index].id);
            let range_m = if range_m > 0.0 { range_m } else { 0.0 };
            self.readings.push(LandmarkReading::new(id, range_m, bearing_rad));
        }
        if config.identity == Identity::Hidden {
            let by_bearing =
                |a: &LandmarkReading, b: &LandmarkReading| a.bearing_rad.total_cmp(&b.bearing_rad);
            self.readings.sort_unstable_by(by_bearing);
        }
        Some(&self.readings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{Landmark, WorldSpec, apartment};

    /// The apartment with posts all over it.
    fn world(every_m: f64) -> World {
        let spec = apartment().spec().clone();
        let [x_min, y_min, x_max, y_max] = spec.bounds;
        let mut landmarks = Vec::new();
        let mut y = y_min + 0.3;
        while y < y_max {
            let mut x = x_min + 0.3;
            while x < x_max {
                landmarks.push(Landmark { id: 100 + landmarks.len() as u32, at: [x, y] });
                x += every_m;
            }
            y += every_m;
        }
        World::new(WorldSpec { landmarks, ..spec }).unwrap()
    }

    fn square(x: f64) -> f64 {
        x * x
    }

    fn exact() -> LandmarkSensorConfig {
        LandmarkSensorConfig {
            range_std_m: 0.0,
            bearing_std_rad: 0.0,
            ..LandmarkSensorConfig::default()
        }
    }

    const POSE: [f64; 3] = [4.9, 2.84, 1.0];

    fn read(config: &LandmarkSensorConfig, world: &World, tick: u64) -> Vec<LandmarkReading> {
        let [x, y, theta] = POSE;
        let mut sensor = LandmarkSensor::new(config, world, 5);
        sensor.read(world, &SE2::new(x, y, theta), tick).unwrap().to_vec()
    }

    #[test]
    fn without_noise_a_reading_leads_to_its_landmark() {
        let world = world(1.0);
        let [x, y, theta] = POSE;
        let readings = read(&exact(), &world, 0);
        assert!(readings.len() > 5);
        for reading in &readings {
            let bearing_rad = theta + reading.bearing_rad;
            let at = [
                x + reading.range_m * trig::cos(bearing_rad),
                y + reading.range_m * trig::sin(bearing_rad),
            ];
            let landmark = world.spec().landmarks.iter().find(|l| Some(l.id) == reading.id());
            let wanted = landmark.unwrap().at;
            assert!((at[0] - wanted[0]).abs() < 1e-9 && (at[1] - wanted[1]).abs() < 1e-9);
            assert!(reading.range_m <= 5.0);
        }
        // What is within range and missing is behind a wall.
        let near = |l: &&Landmark| trig::hypot(l.at[0] - x, l.at[1] - y) < 5.0;
        let all = world.spec().landmarks.iter().filter(near).count();
        assert!(readings.len() < all, "{} of {all}", readings.len());
    }

    #[test]
    fn of_too_many_the_nearest_are_read() {
        let world = world(0.17);
        let readings = read(&exact(), &world, 0);
        assert_eq!(readings.len(), MAX_LANDMARKS);
        let farthest_m = readings.iter().map(|r| r.range_m).fold(0.0, f64::max);
        let mut sensor = LandmarkSensor::new(&exact(), &world, 5);
        let [x, y, theta] = POSE;
        let _ = sensor.read(&world, &SE2::new(x, y, theta), 0);
        let ids: Vec<_> = readings.iter().map(|r| r.id().unwrap()).collect();
        assert!(ids.is_sorted());
        let nearer = world.spec().landmarks.iter().filter(|l| {
            let pose = SE2::new(x, y, theta);
            let seen = in_view(&(&world).into(), &pose, &Point2::from(l.at), 5.0, 7.0);
            seen.is_some_and(|(distance_m, _)| distance_m < farthest_m)
        });
        assert_eq!(nearer.count(), MAX_LANDMARKS - 1);
    }

    #[test]
    fn hidden_identities_are_not_told_by_the_order() {
        let config = LandmarkSensorConfig { identity: Identity::Hidden, ..exact() };
        let readings = read(&config, &world(1.0), 0);
        assert!(readings.iter().all(|r| r.id().is_none()));
        assert!(readings.is_sorted_by(|a, b| a.bearing_rad <= b.bearing_rad));
    }

    #[test]
    fn noise_has_its_size_and_belongs_to_a_landmark() {
        let world = world(1.0);
        let config = LandmarkSensorConfig { every: 1, ..LandmarkSensorConfig::default() };
        let wanted = read(&exact(), &world, 0);
        let (mut sum, mut n) = ([0.0; 2], 0.0);
        for tick in 0..400 {
            for (a, b) in read(&config, &world, tick).iter().zip(&wanted) {
                assert_eq!(a.id(), b.id());
                sum[0] += square((a.range_m - b.range_m) / 0.05);
                sum[1] += square(wrap_angle(a.bearing_rad - b.bearing_rad) / 0.035);
                n += 1.0;
            }
        }
        assert!(sum.iter().all(|s| (s / n - 1.0).abs() < 0.06), "{sum:?} of {n}");
        // Fewer landmarks in view leave the noise of the others as it was.
        let narrow = LandmarkSensorConfig { fov_rad: 1.0, ..config };
        let all = read(&config, &world, 3);
        let few = read(&narrow, &world, 3);
        assert!(!few.is_empty() && few.len() < all.len());
        assert!(few.iter().all(|r| all.contains(r)));
    }

    #[test]
    fn dropout_takes_its_share() {
        let world = world(1.0);
        let config = LandmarkSensorConfig { dropout: 0.25, every: 1, ..exact() };
        let all = read(&exact(), &world, 0).len() as f64;
        let seen: usize = (0..400).map(|tick| read(&config, &world, tick).len()).sum();
        let rate = seen as f64 / (400.0 * all);
        assert!((rate - 0.75).abs() < 0.03, "{rate}");
    }
}
