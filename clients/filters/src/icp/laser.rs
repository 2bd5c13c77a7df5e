//! A laser as matching needs it: rays in the body frame, and the beam that
//! would look at a point.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};
use rusty_contract::config::LidarConfig;
use rusty_geometry::{SE2, trig};

use crate::Beams;

/// A beam that met something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Which beam.
    pub beam: usize,
    /// Where it ended, body frame, m.
    pub point: Point2<f64>,
    /// Where it points, body frame, length 1: the direction of its range error.
    pub direction: Vector2<f64>,
}

/// A laser: its rays, its noise, and how its beams are spread.
#[derive(Clone, Debug)]
pub struct Laser {
    beams: Beams,
    view: View,
    /// Standard deviation of a range, m.
    pub range_std_m: f64,
}

/// From where a scan looked, and how its beams are spread.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    body_in_sensor: SE2,
    /// The sensor's place in the body frame, m.
    pub(super) viewpoint: Point2<f64>,
    first_bearing_rad: f64,
    /// Angle between two beams, rad.
    pub(super) step_rad: f64,
    /// How many beams.
    pub(super) beams: usize,
    /// Whether the last beam has the first one for a neighbour.
    pub(super) wraps: bool,
}

impl Laser {
    /// The laser of a robot. A deviation of less than a tenth of a millimetre is
    /// taken for that much: weights are its inverse square.
    pub fn new(lidar: &LidarConfig) -> Self {
        let fan = lidar.fan();
        let view = View {
            body_in_sensor: lidar.sensor_in_body.inverse(),
            viewpoint: Point2::from(lidar.sensor_in_body.translation()),
            first_bearing_rad: fan.first_bearing_rad,
            step_rad: fan.fov_rad / f64::from(fan.beams.max(1)),
            beams: fan.beams as usize,
            wraps: fan.fov_rad > TAU - 1e-6,
        };
        Self { beams: Beams::new(lidar), view, range_std_m: lidar.range_std_m.max(1e-4) }
    }

    /// What a scan met, in the order of the beams.
    pub fn rays(&self, ranges_m: &[f64]) -> Vec<Ray> {
        let from = self.view.viewpoint;
        let met = self.beams.endpoints(ranges_m);
        met.map(|end| Ray {
            beam: end.beam,
            point: end.in_body,
            direction: (end.in_body - from) / end.range_m,
        })
        .collect()
    }

    /// How many beams it has.
    pub fn beams(&self) -> usize {
        self.view.beams
    }

    /// How far a point of the body frame is from the sensor, m.
    pub fn distance_m(&self, point: &Point2<f64>) -> f64 {
        self.view.distance_m(point)
    }

    /// The beam that looks at a point of the body frame and its neighbours; none where
    /// no beam does.
    pub fn beams_towards(&self, point: &Point2<f64>) -> impl Iterator<Item = usize> + use<> {
        let beam = self.view.beam_towards(point);
        let around = self.view.has(beam).then(|| self.view.around(beam, 1));
        around.into_iter().flatten()
    }

    pub(super) fn view(&self) -> View {
        self.view
    }
}

impl View {
    /// How far a point of the body frame is from the sensor, m.
    pub(super) fn distance_m(&self, point: &Point2<f64>) -> f64 {
        (point - self.viewpoint).norm()
    }

    /// The beam, in fractions of one, that looks at a point of the body frame:
    /// from 0 to the number of beams where they go round, any number otherwise.
    pub(super) fn beam_towards(&self, point: &Point2<f64>) -> f64 {
        let in_sensor = self.body_in_sensor.transform_point(point);
        let bearing_rad = trig::atan2(in_sensor.y, in_sensor.x);
        (bearing_rad - self.first_bearing_rad).rem_euclid(TAU) / self.step_rad
    }

    /// Whether a beam of that number, which may be a fraction, exists.
    pub(super) fn has(&self, beam: f64) -> bool {
        self.wraps || beam <= self.beams as f64
    }

    /// The beams no farther than `reach` from `beam`, in ascending order around it.
    pub(super) fn around(&self, beam: f64, reach: usize) -> impl Iterator<Item = usize> + use<> {
        let (count, wraps) = (self.beams as i64, self.wraps);
        // Just before the first beam of a half circle is just below a full turn.
        let turn = TAU / self.step_rad;
        let beam = if !wraps && beam > 0.5 * (turn + count as f64) { beam - turn } else { beam };
        let nearest = beam.round() as i64;
        let reach = (reach as i64).min(if wraps { (count - 1) / 2 } else { count });
        (nearest - reach..=nearest + reach).filter_map(move |k| {
            let k = if wraps { k.rem_euclid(count) } else { k };
            (0..count).contains(&k).then_some(k as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn beams_look_at_their_own_ends() {
        let sensor_in_body = SE2::new(0.2, -0.1, 0.4);
        for (first_bearing_rad, fov_rad) in [(-PI, TAU), (-0.5 * PI, PI)] {
            let lidar = LidarConfig {
                beams: 60,
                first_bearing_rad,
                fov_rad,
                sensor_in_body,
                ..LidarConfig::default()
            };
            let laser = Laser::new(&lidar);
            for ray in laser.rays(&[2.0; 60]) {
                let beam = laser.view.beam_towards(&ray.point);
                let apart = (beam - ray.beam as f64).rem_euclid(TAU / laser.view.step_rad);
                assert!(apart.min(TAU / laser.view.step_rad - apart) < 1e-9, "{ray:?}: {beam}");
                let expected =
                    sensor_in_body * SE2::new(0.0, 0.0, lidar.bearing_rad(ray.beam as u32));
                let (s, c) = trig::sin_cos(expected.theta());
                assert!((ray.direction - Vector2::new(c, s)).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn neighbours_go_round_where_the_beams_do() {
        let full = Laser::new(&LidarConfig { beams: 10, ..LidarConfig::default() }).view;
        assert_eq!(full.around(0.4, 2).collect::<Vec<_>>(), [8, 9, 0, 1, 2]);
        assert_eq!(full.around(0.4, 99).count(), 9);
        let half = LidarConfig { beams: 10, fov_rad: PI, ..LidarConfig::default() };
        let half = Laser::new(&half).view;
        assert_eq!(half.around(9.0, 2).collect::<Vec<_>>(), [7, 8, 9]);
        assert_eq!(half.around(19.0, 2).collect::<Vec<_>>(), [0, 1]);
        assert!(half.has(9.7) && !half.has(14.0) && full.has(9.7));
    }
}
