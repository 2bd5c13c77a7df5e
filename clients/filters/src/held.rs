//! Wheels that turn while something holds the robot: a person in its way, or a wall.
//!
//! Table 5.6 has no such error: a filter goes where the wheels went, and after a few scans
//! it is lost. So the scan is asked first. Where it says that the robot came no further
//! than half of the way, `ekf` predicts that; of the particles of `mcl` every second one
//! goes as far as the scan says, and the scan weighs both halves.
//!
//! Source: N. de Freitas, R. Dearden, F. Hutter, R. Morales-Menéndez, J. Mutch, D. Poole,
//! *Diagnosis by a waiter and a Mars explorer* (Proceedings of the IEEE 92(3), 2004): a
//! particle filter whose motions have discrete faults, and which looks one step ahead,
//! because none of its particles would draw a fault as rare as these.
//!
//! Departures, and why:
//! * A fault is only believed where the scan is better by its odds, and the weights
//!   are not divided by how often it is drawn: a scan says more than that.
//! * A way of few centimetres changes few beams. So the way is that since the last scan that
//!   was sure, up to 20 cm.
//! * A heading that is a little off makes a scan fit where the wheels went as badly as a way
//!   that is too long. So it is compared with the best of some headings there.
//! * How far the robot came is one of three shares of the way, from the estimate of the filter,
//!   and so unsure that the wheels are right by two deviations.
//! * A robot that is held is as likely to be held at the next scan as not, and until then it is
//!   believed to be.

use nalgebra::Vector3;
use rusty_geometry::SE2;

use crate::Motion;

/// The shares of the way that the robot may have come.
const SHARES: [f64; 3] = [0.0, 0.25, 0.5];
/// Errors of the odometry's heading that are tried where nothing holds the robot, rad.
const HEADING_ERRORS_RAD: [f64; 9] = [0.0, -0.01, 0.01, -0.02, 0.02, -0.03, 0.03, -0.04, 0.04];
/// The poses that a scan is asked for: those of `SHARES`, then those of `HEADING_ERRORS_RAD`.
pub(crate) const POSES: usize = SHARES.len() + HEADING_ERRORS_RAD.len();
/// The pose where the wheels say that the robot is.
pub(crate) const MOVED: usize = SHARES.len();
/// How unsure a share is, of the way from there to where the wheels went, one deviation.
const UNSURE: f64 = 0.5;
/// A shorter way, m, and a smaller turn, rad, cannot be told from none.
const LEAST_M: f64 = 0.02;
const LEAST_RAD: f64 = 0.1;
/// After a longer way, m, or turn, rad, other places of a room may fit as well.
const MOST_M: f64 = 0.2;
const MOST_RAD: f64 = 0.4;
/// It begins in one of a thousand scans: ln of the odds against it.
const ODDS: f64 = 7.0;
/// ln of the odds that a robot which was held is not any more: about even. In doubt the wheels
/// are right.
const ODDS_AGAIN: f64 = 0.5;
/// The most independent beams that a scan is worth here.
const BEAMS_WORTH: f64 = 70.0;

/// What the scans said of the way that the wheels went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Holding {
    /// By the wheels, the pose at the last scan, seen from the last one that was sure.
    last_in_sure: SE2,
    /// The share of the way that the robot came, if it was held at the last scan.
    share: Option<f64>,
}

impl Holding {
    /// The motion since the last scan, if this one says that something holds the robot.
    ///
    /// `last` is the pose at the last scan, and `motion` what the wheels say of the way since.
    /// `look` gives ln p of the scan at each of some poses, and of how many beams, or nothing
    /// where no other of them can be better than [`MOVED`] by the odds that it is given.
    pub fn ask(
        &mut self,
        last: &SE2,
        motion: &Motion,
        look: impl FnOnce(&[SE2; POSES], f64) -> Option<([f64; POSES], f64)>,
    ) -> Option<Motion> {
        let mut now_in_sure = self.last_in_sure.compose(&motion.now_in_then);
        if is_long(&now_in_sure.log()) {
            *self = Self::default();
            now_in_sure = motion.now_in_then;
        }
        let before = std::mem::replace(&mut self.last_in_sure, now_in_sure);
        let way = now_in_sure.log();
        if is_long(&way) {
            *self = Self::default();
            return None;
        }
        if way.xy().norm() < LEAST_M && way.z.abs() < LEAST_RAD {
            return None;
        }
        let (sure, moved) = (last.compose(&before.inverse()), last.compose(&motion.now_in_then));
        let pose = |k: usize| match k.checked_sub(SHARES.len()) {
            None => sure.boxplus(&(way * SHARES[k])),
            Some(k) => moved.boxplus(&Vector3::new(0.0, 0.0, HEADING_ERRORS_RAD[k])),
        };
        let against = if self.share.is_some() { ODDS_AGAIN } else { ODDS };
        let (logs, beams) = look(&std::array::from_fn(pose), against)?;
        let (share, better) = best(&logs);
        let odds = better * (BEAMS_WORTH / beams).min(1.0);
        if odds <= -against {
            *self = Self::default();
        }
        if odds < against {
            return None;
        }
        *self = Self { share: Some(share), ..Self::default() };
        let came = part(&Motion { now_in_then: now_in_sure, ..*motion }, share);
        let now_in_then = before.inverse().compose(&came.now_in_then);
        Some(Motion { now_in_then, ..came })
    }

    /// What is believed until the next scan of a robot that was held, where `wheels` gives the
    /// motion since the last one.
    pub fn until_next(&self, wheels: impl FnOnce() -> Motion) -> Option<Motion> {
        self.share.map(|share| part(&wheels(), share))
    }
}

/// Whether other places of a room may fit as well at its end.
fn is_long(way: &Vector3<f64>) -> bool {
    way.xy().norm() > MOST_M || way.z.abs() > MOST_RAD
}

/// The likeliest share of the way, and by how much (ln p) it is likelier than the whole.
fn best(logs: &[f64; POSES]) -> (f64, f64) {
    let (held, moved) = logs.split_at(SHARES.len());
    let moved = moved.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mut share, mut best) = (SHARES[0], held[0]);
    for (other, log) in SHARES.iter().zip(held) {
        if *log > best {
            (share, best) = (*other, *log);
        }
    }
    (share, best - moved)
}

/// A share of a motion.
fn part(motion: &Motion, share: f64) -> Motion {
    let way = motion.now_in_then.log();
    let along = way * (UNSURE * (1.0 - share));
    let covariance = motion.covariance + along * along.transpose();
    Motion { now_in_then: SE2::exp(&(way * share)), covariance }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcl::sensor::{Sensor, Use};
    use crate::scan_match::tests::world_of;
    use crate::{BeamModel, Beams, Random};
    use nalgebra::Matrix3;
    use rusty_contract::config::LidarConfig;
    use rusty_geometry::{Scan, World, apartment};

    /// What is believed of a robot that is at `at` and whose wheels went `way` from `from`, by
    /// a scan of `beams` beams.
    fn held_at(
        world: &World,
        from: SE2,
        way: Vector3<f64>,
        at: &SE2,
        beams: u32,
    ) -> Option<Motion> {
        let lidar = LidarConfig { beams, ..LidarConfig::default() };
        let model = BeamModel::of_lidar(&lidar);
        let how = Use { skip: 1, exponent: 1.0, rays: false };
        let scan = || Scan::new(lidar.fan());
        let mut sensor = Sensor::of_world(world, model, Beams::new(&lidar), scan(), how);
        let (mut scan, mut ranges_m) = (scan(), vec![0.0; beams as usize]);
        scan.take(world, at, lidar.range_max_m);
        scan.write_distances_m(&mut ranges_m);
        let mut random = Random::new(3, 1);
        ranges_m.iter_mut().for_each(|range_m| *range_m += 0.02 * random.normal());
        let covariance = Matrix3::from_diagonal_element(1e-6);
        let motion = Motion { now_in_then: SE2::exp(&way), covariance };
        Holding::default().ask(&from, &motion, |poses, _| sensor.look_at(&ranges_m, poses))
    }

    #[test]
    fn a_robot_that_is_held_comes_as_far_as_its_scan_says() {
        let (from, way) = (SE2::new(9.6, 3.0, 0.4), Vector3::new(0.06, 0.0, 0.02));
        let world = apartment();
        for beams in [36, 180, 1080] {
            for (share, expected) in [(0.0, 0.0), (0.3, 0.25), (0.45, 0.5)] {
                let at = from.boxplus(&(way * share));
                let motion = held_at(&world, from, way, &at, beams).unwrap();
                let came_m = motion.now_in_then.log().x;
                assert!((came_m - 0.06 * expected).abs() < 1e-12, "{beams}, {share}: {came_m}");
                // By hand: 1e-6 and half of the rest of 6 cm.
                let std_m = 0.03 * (1.0 - expected);
                assert!((motion.covariance[(0, 0)] - 1e-6 - std_m * std_m).abs() < 1e-12);
            }
            for share in [0.9, 1.0] {
                let at = from.boxplus(&(way * share));
                assert_eq!(held_at(&world, from, way, &at, beams), None, "{beams}, {share}");
            }
            for off_rad in [-0.04, 0.025] {
                let at = from.boxplus(&way).boxplus(&Vector3::new(0.0, 0.0, off_rad));
                assert_eq!(held_at(&world, from, way, &at, beams), None, "{beams}, {off_rad}");
            }
        }
    }

    /// Scans of constant ln p at the poses of the shares and at those where the wheels went.
    fn scan(holding: &mut Holding, way_m: f64, held: f64, moved: f64) -> Option<f64> {
        let now_in_then = SE2::new(way_m, 0.0, 0.0);
        let motion = Motion { now_in_then, ..Motion::default() };
        let logs = std::array::from_fn(|k| if k < SHARES.len() { held - k as f64 } else { moved });
        let motion = holding.ask(&SE2::identity(), &motion, |_, _| Some((logs, 50.0)));
        motion.map(|motion| motion.now_in_then.x())
    }

    #[test]
    fn the_way_is_that_since_the_last_scan_that_was_sure() {
        let mut holding = Holding::default();
        assert_eq!(scan(&mut holding, 0.03, 5.0, 0.0), None);
        assert_eq!(scan(&mut holding, 0.04, 6.0, 0.0), None);
        // Back to where it was before the first one.
        let back_m = scan(&mut holding, 0.05, 8.0, 0.0).unwrap();
        assert!((back_m + 0.07).abs() < 1e-12, "{back_m}");
        assert_eq!(holding, Holding { share: Some(0.0), ..Holding::default() });
        // One that was sure that the robot moved, and one after too long a way.
        for (way_m, moved) in [(0.05, 20.0), (0.17, 0.0)] {
            let mut holding = Holding::default();
            assert_eq!(scan(&mut holding, 0.05, 0.0, moved), None);
            let back_m = scan(&mut holding, way_m, 8.0, 0.0).unwrap();
            assert!(back_m.abs() < 1e-12, "{back_m}");
        }
        assert_eq!(scan(&mut Holding::default(), 0.21, 50.0, 0.0), None);
    }

    #[test]
    fn a_robot_that_was_held_is_held_again_at_about_even_odds() {
        let mut holding = Holding::default();
        assert_eq!(scan(&mut holding, 0.05, 6.0, 0.0), None);
        assert!(scan(&mut holding, 0.05, 8.0, 0.0).is_some());
        assert!(scan(&mut holding, 0.05, 0.6, 0.0).is_some());
        let covariance = Matrix3::from_diagonal_element(1e-6);
        let motion = Motion { now_in_then: SE2::new(0.02, 0.0, 0.0), covariance };
        let until_next = holding.until_next(|| motion).unwrap();
        assert_eq!(until_next.now_in_then, SE2::identity());
        // By hand: half of 2 cm.
        assert!((until_next.covariance[(0, 0)] - 1e-6 - 1e-4).abs() < 1e-12);
        assert_eq!(scan(&mut holding, 0.05, 0.0, 0.6), None);
        assert_eq!(holding.until_next(|| motion), None);
        assert_eq!(scan(&mut holding, 0.05, 6.0, 0.0), None);
    }

    #[test]
    fn along_a_single_wall_no_robot_is_held() {
        let world = world_of([0.0, 0.0, 20.0, 20.0], &[[0.0, 0.0, 20.0, 0.0]]);
        let (from, way) = (SE2::new(10.0, 2.0, 0.0), Vector3::new(0.06, 0.0, 0.0));
        for share in [0.0, 0.5, 1.0] {
            let at = from.boxplus(&(way * share));
            assert_eq!(held_at(&world, from, way, &at, 180), None, "{share}");
        }
    }
}
