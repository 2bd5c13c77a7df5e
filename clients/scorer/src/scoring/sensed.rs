//! What the small sensors of a run read, as far as it is drawn: a bounded number of
//! points, and sums.

use nalgebra::Point2;
use rusty_contract::config::sensors::{BumperConfig, ImuConfig};
use rusty_contract::{Readings, RunConfig};
use rusty_geometry::{SE2, trig, wrap_angle};
use rusty_metrics::Allan;

/// Most points of one sensor that are kept. When there are more, every second one goes.
const MOST_POINTS: usize = 4096;

/// Points of the floor, world frame, m: evenly many over the run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Points {
    pub at_m: Vec<[f64; 2]>,
    seen: u64,
    stride: u64,
}

impl Points {
    /// None yet; with room for all if `has_sensor`, so that no tick allocates.
    fn new(has_sensor: bool) -> Self {
        let at_m = Vec::with_capacity(if has_sensor { MOST_POINTS } else { 0 });
        Self { at_m, seen: 0, stride: 1 }
    }

    fn push(&mut self, at: Point2<f64>) {
        if self.seen.is_multiple_of(self.stride) && at.x.is_finite() && at.y.is_finite() {
            if self.at_m.len() == MOST_POINTS {
                let mut index = 0;
                self.at_m.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.stride *= 2;
            }
            self.at_m.push([at.x, at.y]);
        }
        self.seen += 1;
    }
}

/// What the small sensors of a run read.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensed {
    mounts: Vec<SE2>,
    sonar_max_m: f64,
    body_radius_m: f64,
    bumper: Option<BumperConfig>,
    dt_s: f64,
    /// Ticks in which the robot is put elsewhere, which is no turn.
    carried_at: Vec<u64>,
    /// The true pose a tick ago, where known.
    before: Option<SE2>,
    /// Echoes of sonars, each on the axis of its cone.
    pub(crate) echoes: Points,
    /// Readings of landmarks.
    pub(crate) landmarks: Points,
    /// Where the body touched something: the middle of the sector.
    pub(crate) contacts: Points,
    /// Where the robot was when a door was reported.
    pub(crate) doors: Points,
    /// The IMU, and the error of its yaw rate, °/h.
    pub(crate) imu: Option<(ImuConfig, Allan)>,
}

impl Sensed {
    /// Nothing read yet, in a run with this configuration.
    #[must_use]
    pub fn new(config: &RunConfig) -> Self {
        let sonar = config.sensors.sonar.as_ref();
        Self {
            mounts: sonar.map_or_else(Vec::new, |sonar| sonar.mounts.clone()),
            sonar_max_m: sonar.map_or(0.0, |sonar| sonar.range_max_m),
            body_radius_m: config.robot.body_radius_m,
            bumper: config.sensors.bumper,
            dt_s: config.dt_s,
            carried_at: config.kidnappings.iter().map(|k| k.tick).collect(),
            before: Some(config.start),
            echoes: Points::new(sonar.is_some()),
            landmarks: Points::new(config.sensors.landmarks.is_some()),
            contacts: Points::new(config.sensors.bumper.is_some()),
            doors: Points::new(config.sensors.doors.is_some()),
            imu: config.sensors.imu.map(|imu| (imu, Allan::new(config.dt_s))),
        }
    }

    /// Takes the readings of a tick, and where the robot truly was at its end.
    pub fn push(&mut self, tick: u64, readings: &Readings<'_>, truth: Option<SE2>) {
        let before = std::mem::replace(&mut self.before, truth.filter(SE2::is_finite));
        let Some(body_in_world) = self.before else { return };
        let in_world = |p: [f64; 2]| body_in_world.transform_point(&Point2::from(p));
        let at = |range_m: f64, bearing_rad: f64| {
            let (s, c) = trig::sin_cos(bearing_rad);
            [range_m * c, range_m * s]
        };
        let ranges_m = readings.sonar_ranges_m().unwrap_or_default();
        for (mount, &range_m) in self.mounts.iter().zip(ranges_m) {
            if range_m < self.sonar_max_m {
                let echo = mount.transform_point(&Point2::new(range_m, 0.0));
                self.echoes.push(in_world(echo.coords.into()));
            }
        }
        for seen in readings.landmarks().unwrap_or_default() {
            self.landmarks.push(in_world(at(seen.range_m, seen.bearing_rad)));
        }
        if let (Some(bumper), Some(set)) = (&self.bumper, readings.bumper()) {
            for k in (0..bumper.sectors).filter(|k| set >> k & 1 == 1) {
                let share = (f64::from(k) + 0.5) / f64::from(bumper.sectors);
                let bearing_rad = bumper.first_bearing_rad + bumper.fov_rad * share;
                self.contacts.push(in_world(at(self.body_radius_m, bearing_rad)));
            }
        }
        if readings.doors().is_some_and(|doors| !doors.is_empty()) {
            self.doors.push(in_world([0.0, 0.0]));
        }
        let before = before.filter(|_| !self.carried_at.contains(&tick));
        if let (Some((_, allan)), Some(imu), Some(before)) = (&mut self.imu, readings.imu(), before)
        {
            let turned_rad = wrap_angle(body_in_world.theta() - before.theta());
            let error_rad_s = imu.yaw_rate_rad_s - turned_rad / self.dt_s;
            allan.push(error_rad_s.to_degrees() * 3600.0);
        }
    }

    /// Whether there is anything to be drawn on the floor.
    pub(crate) fn has_points(&self) -> bool {
        let all = [&self.echoes, &self.landmarks, &self.contacts, &self.doors];
        all.iter().any(|points| !points.at_m.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::super::trace::tests::header;
    use super::*;
    use rusty_contract::Present;
    use rusty_contract::config::sensors::SonarConfig;
    use std::f64::consts::FRAC_PI_2;

    fn config() -> RunConfig {
        let mut config = header().config;
        config.start = SE2::new(1.0, 2.0, FRAC_PI_2);
        config.sensors.sonar = Some(SonarConfig::default());
        config.sensors.bumper = Some(BumperConfig::default());
        config.sensors.imu = Some(ImuConfig::default());
        config
    }

    fn near(found: &Points, expected: &[[f64; 2]]) {
        assert_eq!(found.at_m.len(), expected.len(), "{found:?}");
        for (a, b) in found.at_m.iter().zip(expected) {
            assert!((a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-12, "{a:?} {b:?}");
        }
    }

    #[test]
    fn readings_are_put_where_they_were_made() {
        let mut sensed = Sensed::new(&config());
        assert!(!sensed.has_points());
        // Bumper sector 2 of 5 is ahead; one sonar 0.1 m ahead of the centre; a landmark
        // 3 m to the left.
        let present =
            Present { bumper: true, sonars: Some(1), landmarks: Some(1), ..Present::default() };
        let numbers = [4.0, 0.4, 4.0, 3.0, FRAC_PI_2];
        let readings = Readings::new(present, &numbers);
        sensed.push(0, &readings, Some(SE2::new(1.0, 2.0, FRAC_PI_2)));
        sensed.push(1, &readings, None);
        near(&sensed.contacts, &[[1.0, 2.11]]);
        near(&sensed.echoes, &[[1.0, 2.5]]);
        near(&sensed.landmarks, &[[-2.0, 2.0]]);
        near(&sensed.doors, &[]);
        assert!(sensed.has_points());
        // A sonar that nothing answers has no echo.
        let nothing = [0.0, SonarConfig::default().range_max_m, 0.0, 0.0, 0.0];
        let before = sensed.echoes.clone();
        sensed.push(2, &Readings::new(present, &nothing), Some(SE2::identity()));
        assert_eq!(sensed.echoes, before);
    }

    #[test]
    fn the_error_of_the_yaw_rate_leaves_out_turns_and_kidnappings() {
        let mut config = config();
        config.kidnappings =
            vec![rusty_contract::config::Kidnapping { tick: 5, to: SE2::identity() }];
        let mut sensed = Sensed::new(&config);
        let present = Present { imu: true, ..Present::default() };
        let mut heading_rad = FRAC_PI_2;
        for tick in 0..20 {
            let turn_rad = 0.01 * tick as f64;
            heading_rad = if tick == 5 { 0.0 } else { heading_rad + turn_rad };
            // Too large by 1 °/s.
            let numbers = [turn_rad / config.dt_s + 1f64.to_radians(), 0.0, 0.0];
            let truth = SE2::new(0.0, 0.0, heading_rad);
            sensed.push(tick, &Readings::new(present, &numbers), Some(truth));
        }
        let (_, allan) = sensed.imu.unwrap();
        let first = allan.deviations().next().unwrap();
        assert!(first.deviation < 1e-6 && first.differences == 18, "{first:?}");
    }

    #[test]
    fn points_are_bounded_and_spread_over_the_run() {
        let mut points = Points::new(true);
        let room = points.at_m.capacity();
        (0..100_000).for_each(|k| points.push(Point2::new(f64::from(k), 0.0)));
        let count = points.at_m.len();
        assert!((MOST_POINTS / 2..=MOST_POINTS).contains(&count), "{count}");
        assert_eq!(points.at_m.capacity(), room);
        let step = points.at_m[1][0];
        assert!(points.at_m.windows(2).all(|w| w[1][0] - w[0][0] == step));
        assert!(points.at_m.last().unwrap()[0] > 99_000.0);
    }
}
