//! A laser as matching needs it: rays in the body frame, and the beam that
//! would look at a point.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Point2, Vector2};
use rusty_contract::config::LidarConfig;
use rusty_geometry::{SE2, trig};

use crate::Beams;

/// About the angle between matched beams of a dense laser, rad: 0.5°. A wall that is fitted to
/// beams within centimetres has a normal of noise, and errors of normals bias the turn between
/// two scans towards zero.
const STEP_RAD: f64 = PI / 360.0;
/// At least this number of beams is matched, if there are as many.
const FEWEST_BEAMS: usize = 36;
/// A field of view (rad) or a range (m) below these sees little.
const LITTLE_RAD: f64 = FRAC_PI_2;
const LITTLE_M: f64 = 2.0;

/// A beam that met something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Which one of those that are matched.
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
    /// Every `stride`-th beam is matched, beginning with beam 0.
    stride: usize,
    fov_rad: f64,
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
    /// Where the view ends, in beams from the first.
    end: f64,
    /// Whether the last beam has the first one for a neighbour.
    pub(super) wraps: bool,
}

impl Laser {
    /// The laser of a robot. A deviation of less than a tenth of a millimetre is
    /// taken for that much: weights are its inverse square.
    pub fn new(lidar: &LidarConfig) -> Self {
        let fan = lidar.fan();
        let beams = fan.beams as usize;
        let step_rad = fan.fov_rad / beams.max(1) as f64;
        let stride = stride(beams, step_rad);
        let view = View {
            body_in_sensor: lidar.sensor_in_body.inverse(),
            viewpoint: Point2::from(lidar.sensor_in_body.translation()),
            first_bearing_rad: fan.first_bearing_rad,
            step_rad: step_rad * stride as f64,
            beams: beams.div_ceil(stride),
            end: beams as f64 / stride as f64,
            wraps: fan.fov_rad > TAU - 1e-6,
        };
        let range_std_m = lidar.range_std_m.max(1e-4);
        Self { beams: Beams::new(lidar), stride, fov_rad: fan.fov_rad, view, range_std_m }
    }

    /// What a scan met, in the order of the beams, without those in between.
    pub fn rays(&self, ranges_m: &[f64]) -> Vec<Ray> {
        let from = self.view.viewpoint;
        let met = self.beams.every(self.stride, ranges_m);
        met.map(|end| Ray {
            beam: end.beam / self.stride,
            point: end.in_body,
            direction: (end.in_body - from) / end.range_m,
        })
        .collect()
    }

    /// Returns the number of matched beams.
    pub fn beams(&self) -> usize {
        self.view.beams
    }

    /// Returns whether the field of view is below 90° or the range below 2 m.
    pub fn sees_little(&self) -> bool {
        self.fov_rad < LITTLE_RAD || self.beams.range_max_m < LITTLE_M
    }

    /// Its field of view, rad.
    pub fn fov_rad(&self) -> f64 {
        self.fov_rad
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

/// Returns the stride for beams that are `step_rad` apart: more than 1 below a third of a degree.
/// A laser that sees all round has at most 1080 beams, and a stride of 1.
fn stride(beams: usize, step_rad: f64) -> usize {
    let wanted = (STEP_RAD / step_rad - 1e-6).round() as usize;
    wanted.min(beams / FEWEST_BEAMS).max(1)
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
        self.wraps || beam <= self.end
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
    fn of_a_dense_laser_some_beams_are_matched() {
        for (beams, fov_rad, matched) in [
            (180, TAU, 180),
            (361, PI, 361),
            (720, PI, 360),
            (1080, 1.5 * PI, 540),
            (1080, TAU, 1080),
            (181, 0.35, 37),
            (180, 0.1, 36),
            (20, 0.1, 20),
        ] {
            let lidar = LidarConfig { beams, fov_rad, ..LidarConfig::default() };
            let laser = Laser::new(&lidar);
            assert_eq!(laser.beams(), matched, "{beams} beams over {fov_rad} rad");
            let rays = laser.rays(&vec![3.0; beams as usize]);
            assert_eq!(rays.len(), matched);
            for ray in &rays[1..] {
                let beam = laser.view.beam_towards(&ray.point);
                assert!((beam - ray.beam as f64).abs() < 1e-6, "{ray:?}: {beam}");
            }
            // The view ends where it did.
            let step_rad = fov_rad / f64::from(beams);
            let at = |beam: f64| {
                let (s, c) = trig::sin_cos(lidar.first_bearing_rad + step_rad * beam);
                laser.view.has(laser.view.beam_towards(&Point2::new(c, s)))
            };
            assert!(at(f64::from(beams) - 0.1));
            assert_eq!(at(f64::from(beams) + 0.1), laser.view.wraps);
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
