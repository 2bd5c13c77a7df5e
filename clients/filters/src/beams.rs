//! Where the beams of a scan point, and where they ended.

use nalgebra::{Point2, Vector2};
use rusty_contract::Start;
use rusty_contract::config::LidarConfig;
use rusty_geometry::SE2;

/// The geometry of a laser on its robot.
#[derive(Clone, Debug)]
pub struct Beams {
    /// Pose of the sensor in the body frame.
    pub sensor_in_body: SE2,
    /// The longest range the laser tells, m.
    pub range_max_m: f64,
    /// Unit directions in the sensor frame, one a beam.
    directions: Vec<Vector2<f64>>,
}

/// A beam that met something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Endpoint {
    /// Which beam.
    pub beam: usize,
    /// How far, m.
    pub range_m: f64,
    /// Where, in the body frame, m.
    pub in_body: Point2<f64>,
}

/// σ of a range that a filter assumes where it is not told one, m: that of a cheap
/// laser (Hokuyo URG-04LX, 30 mm up to 1 m).
pub const ASSUMED_RANGE_STD_M: f64 = 0.03;

/// Share of beams without a return that a filter assumes where it is not told one.
pub const ASSUMED_DROPOUT: f64 = 0.02;

/// The laser that a filter believes in: what it is told, and the assumed figures where
/// it is told none.
pub fn believed_lidar(start: &Start) -> LidarConfig {
    start.lidar.believed(&LidarConfig {
        range_std_m: ASSUMED_RANGE_STD_M,
        dropout: ASSUMED_DROPOUT,
        ..LidarConfig::default()
    })
}

impl Beams {
    /// The beams of this laser.
    pub fn new(lidar: &LidarConfig) -> Self {
        let fan = lidar.fan();
        Self {
            sensor_in_body: lidar.sensor_in_body,
            range_max_m: lidar.range_max_m,
            directions: (0..fan.beams).map(|k| fan.direction(k)).collect(),
        }
    }

    /// Direction of beam `k` in the sensor frame, of length 1.
    pub fn direction(&self, k: usize) -> Vector2<f64> {
        self.directions[k]
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.directions.len()
    }

    /// Whether a range is one: neither the longest, which means that nothing came
    /// back, nor a number that no distance has.
    pub fn is_hit(&self, range_m: f64) -> bool {
        range_m > 0.0 && range_m < self.range_max_m
    }

    /// The beams that met something, in order. Ranges beyond those of the laser's
    /// beams are left out.
    pub fn endpoints<'a>(&'a self, ranges_m: &'a [f64]) -> impl Iterator<Item = Endpoint> + 'a {
        let beams = self.directions.iter().zip(ranges_m).enumerate();
        beams.filter(|(_, (_, range_m))| self.is_hit(**range_m)).map(
            |(beam, (direction, &range_m))| {
                let in_sensor = Point2::from(direction * range_m);
                Endpoint { beam, range_m, in_body: self.sensor_in_body.transform_point(&in_sensor) }
            },
        )
    }

    /// The same of every `stride`th beam only.
    pub fn every<'a>(
        &'a self,
        stride: usize,
        ranges_m: &'a [f64],
    ) -> impl Iterator<Item = Endpoint> + 'a {
        self.endpoints(ranges_m).filter(move |end| end.beam.is_multiple_of(stride))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_are_where_the_beams_met_something() {
        let sensor_in_body = SE2::new(0.1, 0.0, 0.0);
        let lidar = LidarConfig { beams: 4, sensor_in_body, ..LidarConfig::default() };
        let beams = Beams::new(&lidar);
        let ranges_m = [8.0, 1.0, 2.0, f64::NAN, 3.0];
        let found: Vec<Endpoint> = beams.endpoints(&ranges_m).collect();
        assert_eq!(found.iter().map(|e| e.beam).collect::<Vec<_>>(), [1, 2]);
        // Beam 1 of 4 points to the right, beam 2 straight ahead.
        assert!((found[0].in_body - Point2::new(0.1, -1.0)).norm() < 1e-15, "{found:?}");
        assert!((found[1].in_body - Point2::new(2.1, 0.0)).norm() < 1e-15, "{found:?}");
    }
}
