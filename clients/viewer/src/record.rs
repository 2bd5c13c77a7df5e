//! A tick and a belief in bytes, as the page reads them.
//!
//! A message to the page is one record after the other. All numbers are little-endian,
//! lengths in metres, angles in radians, times in seconds; a number that is not known is
//! NaN. Every record begins with its kind (u32) and its length in words of 8 bytes (u32).
//!
//! | kind | words | content |
//! |---|---|---|
//! | 1 | 1 to 10 | tick, time, true x, y, heading, command v, ω (f64), number of estimators and of beams (u32), run digest (16 bytes) |
//! | | 11 for each estimator | pose x, y, heading, ellipse (3), position error, heading error, NEES, compute time reported and observed (f64) |
//! | | rest | ranges (f32) |
//! | 2 | 1 to 3 | tick (f64), index of the estimator, kind of the belief, number of poses that follow and of all poses (u32) |
//! | | rest | x, y, heading, weight of each pose (f32) |
//! | 3 | as 1 | a tick without ranges, for charts and paths |
//! | 4 | 1 to 2 | tick (f64), sectors of the bumper that touch something as bits, or all 32 bits without a bumper reading, number of sonars (u32); before the record of its tick |
//! | | rest | range of each sonar (f32) |
//!
//! The ellipse holds 95 % and is what a unit circle becomes: x by x, y by x, y by y.

use rusty_contract::{BeliefKind, Estimate, OwnedReadings, WeightedPose};
use rusty_geometry::{EncoderCounts, SE2, Twist};
use rusty_metrics::{heading_error_rad, nees, position_error_m};
use rusty_plot::ellipse::of_pose;

/// Words of a tick before its estimators.
const HEAD_WORDS: usize = 11;
/// Words of an estimator.
const ESTIMATOR_WORDS: usize = 11;
/// Kind of a tick without ranges.
const HISTORY: u32 = 3;
/// Kind of the readings of bumper and sonars, and what stands for no bumper reading.
const READINGS: u32 = 4;
const NO_BUMPER: u32 = u32::MAX;
/// Most poses of a belief that go to a page.
const MOST_POSES: usize = 3000;

/// One complete tick.
#[derive(Clone, Debug, Default)]
pub struct Moment {
    /// Index of the tick.
    pub tick: u64,
    /// Time at its end, s.
    pub time_s: f64,
    /// Cumulative encoder counts.
    pub counts: EncoderCounts,
    /// True pose, world frame, where known.
    pub truth: Option<SE2>,
    /// Command of the tick, body frame.
    pub command: Twist,
    /// Run digest up to and with this tick; zeros where not known.
    pub digest: [u8; 16],
    /// The estimators in roster order.
    pub shown: Vec<Shown>,
    /// Ranges of the scan, m, where there is one.
    pub ranges_m: Option<Vec<f64>>,
    /// Readings of the small sensors.
    pub readings: OwnedReadings,
}

/// One estimator in a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// Its estimate in effect.
    pub estimate: Option<Estimate>,
    /// Compute time that it reported, and the one that the server observed, ns.
    pub times_ns: Option<[u64; 2]>,
}

impl Moment {
    /// Returns the record.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let ranges_m = self.ranges_m.as_deref().unwrap_or_default();
        let ranges = ranges_m.len().div_ceil(2);
        let words = HEAD_WORDS + ESTIMATOR_WORDS * self.shown.len() + ranges;
        let mut bytes = head(1, words);
        numbers(&mut bytes, [self.tick as f64, self.time_s]);
        numbers(&mut bytes, pose(self.truth));
        numbers(&mut bytes, [self.command.v_m_s, self.command.omega_rad_s]);
        bytes.extend((self.shown.len() as u32).to_le_bytes());
        bytes.extend((ranges_m.len() as u32).to_le_bytes());
        bytes.extend(self.digest);
        for shown in &self.shown {
            shown.encode(&mut bytes, self.truth);
        }
        bytes.extend(ranges_m.iter().flat_map(|range| (*range as f32).to_le_bytes()));
        bytes.resize(8 * words, 0);
        bytes
    }

    /// Returns the record of the readings of bumper and sonars; `None` of a tick without.
    #[must_use]
    pub fn encode_readings(&self) -> Option<Vec<u8>> {
        let readings = self.readings.get();
        let (bumper, ranges_m) = (readings.bumper(), readings.sonar_ranges_m());
        if bumper.is_none() && ranges_m.is_none() {
            return None;
        }
        let ranges_m = ranges_m.unwrap_or_default();
        let words = 3 + ranges_m.len().div_ceil(2);
        let mut bytes = head(READINGS, words);
        numbers(&mut bytes, [self.tick as f64]);
        bytes.extend(bumper.map_or(NO_BUMPER, u32::from).to_le_bytes());
        bytes.extend((ranges_m.len() as u32).to_le_bytes());
        bytes.extend(ranges_m.iter().flat_map(|range| (*range as f32).to_le_bytes()));
        bytes.resize(8 * words, 0);
        Some(bytes)
    }
}

impl Shown {
    fn encode(&self, bytes: &mut Vec<u8>, truth: Option<SE2>) {
        let known = self.estimate.filter(|e| e.pose_in_world.is_finite());
        numbers(bytes, pose(known.map(|e| e.pose_in_world)));
        numbers(
            bytes,
            known
                .and_then(|e| of_pose(e.pose_in_world.theta(), &e.covariance?))
                .unwrap_or([f64::NAN; 3]),
        );
        let judged = known.zip(truth).map(|(estimate, truth)| {
            let at = estimate.pose_in_world;
            let nees = estimate.covariance.and_then(|p| nees(&truth, &at, &p));
            let errors = [position_error_m(&at, &truth), heading_error_rad(&at, &truth).abs()];
            [errors[0], errors[1], nees.unwrap_or(f64::NAN)]
        });
        numbers(bytes, judged.unwrap_or([f64::NAN; 3]));
        let times_s = self.times_ns.map(|times| times.map(|ns| ns as f64 * 1e-9));
        numbers(bytes, times_s.unwrap_or([f64::NAN; 2]));
    }
}

/// Returns the record of a belief of the estimator at `index` of those that answer, in
/// its order; of many poses every N-th.
#[must_use]
pub fn belief(
    tick: u64,
    index: usize,
    (kind, whole): (BeliefKind, u32),
    poses: &[WeightedPose],
) -> Vec<u8> {
    let every = poses.len().div_ceil(MOST_POSES).max(1);
    let count = poses.len().div_ceil(every);
    let mut bytes = head(2, 4 + 2 * count);
    numbers(&mut bytes, [tick as f64]);
    for number in [index as u32, kind.number(), count as u32, whole] {
        bytes.extend(number.to_le_bytes());
    }
    for pose in poses.iter().step_by(every) {
        for value in [pose.x_m, pose.y_m, pose.theta_rad, pose.weight] {
            bytes.extend((value as f32).to_le_bytes());
        }
    }
    bytes
}

/// Returns the record of a tick without its ranges.
#[must_use]
pub fn history(tick: &[u8]) -> Vec<u8> {
    let word = |at: usize| {
        tick.get(at..at + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let words = HEAD_WORDS + ESTIMATOR_WORDS * word(64) as usize;
    let mut bytes = head(HISTORY, words);
    bytes.extend(tick.get(8..8 * words).unwrap_or_default());
    bytes[68..72].fill(0);
    bytes
}

/// Whether the record of readings has ranges of sonars.
#[must_use]
pub fn has_sonars(readings: &[u8]) -> bool {
    readings.get(20..24).is_some_and(|count| count != [0; 4])
}

/// Whether the record of a tick has ranges.
#[must_use]
pub fn has_scan(tick: &[u8]) -> bool {
    tick.get(68..72).is_some_and(|count| count != [0; 4])
}

fn head(kind: u32, words: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(8 * words);
    bytes.extend(kind.to_le_bytes());
    bytes.extend((words as u32).to_le_bytes());
    bytes
}

fn numbers<const N: usize>(bytes: &mut Vec<u8>, values: [f64; N]) {
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}

fn pose(pose: Option<SE2>) -> [f64; 3] {
    pose.map_or([f64::NAN; 3], |p| [p.x(), p.y(), p.theta()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(bytes: &[u8], word: usize) -> f64 {
        f64::from_le_bytes(bytes[8 * word..8 * word + 8].try_into().unwrap())
    }

    #[test]
    fn a_tick_is_where_the_table_has_it() {
        let at = SE2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
        // Along the body's x 4 m², across 1 m²: in the world along y.
        let covariance = [4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25];
        let estimate = Some(Estimate::new(at).with_covariance(covariance));
        let shown = vec![Shown { estimate, times_ns: Some([1000, 2000]) }, Shown::default()];
        let moment = Moment {
            tick: 7,
            time_s: 0.16,
            truth: Some(SE2::new(1.0, 4.0, at.theta())),
            command: Twist { v_m_s: 0.5, omega_rad_s: -1.0 },
            digest: [9; 16],
            shown,
            ranges_m: Some(vec![1.5, 2.5, 3.5]),
            ..Moment::default()
        };
        let bytes = moment.encode();
        assert_eq!(bytes.len(), 8 * (11 + 2 * 11 + 2));
        assert_eq!(u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize, bytes.len() / 8);
        assert_eq!([1, 2, 4, 6, 7].map(|w| number(&bytes, w)), [7.0, 0.16, 4.0, 0.5, -1.0]);
        assert_eq!(bytes[72..88], [9; 16]);
        let of = |k: usize| number(&bytes, 11 + k);
        assert_eq!([of(0), of(1)], [1.0, 2.0]);
        // 95 %: the square root of 5.99 times the standard deviation.
        assert!((of(3) - 2.4477).abs() < 1e-4 && (of(5) - 4.8955).abs() < 1e-4);
        // The truth is 2 m ahead, one standard deviation.
        assert!((of(6) - 2.0).abs() < 1e-12 && (of(8) - 1.0).abs() < 1e-12);
        assert_eq!([of(9), of(10)], [1000.0, 2000.0].map(|ns| ns * 1e-9));
        assert!((11..22).all(|k| of(k).is_nan()));
        assert_eq!(bytes[8 * 33..8 * 33 + 4], 1.5f32.to_le_bytes());
        let past = history(&bytes);
        assert!(has_scan(&bytes) && !has_scan(&past));
        assert_eq!((past[0], past.len(), &past[72..]), (3, 8 * 33, &bytes[72..8 * 33]));
    }

    #[test]
    fn bumper_and_sonars_are_where_the_table_has_them() {
        use rusty_contract::{Present, Readings};

        let of = |bumper: bool, sonars: Option<u8>, numbers: &[f64]| {
            let present = Present { bumper, sonars, ..Present::default() };
            let readings = Readings::new(present, numbers).into();
            Moment { tick: 9, readings, ..Moment::default() }.encode_readings()
        };
        let words = |bytes: &[u8]| -> Vec<u32> {
            bytes.chunks(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
        };
        assert_eq!(of(false, None, &[]), None);
        let both = of(true, Some(3), &[5.0, 0.5, 1.5, 10.7]).unwrap();
        assert_eq!((both.len(), number(&both, 1)), (8 * 5, 9.0));
        assert_eq!(words(&both)[..2], [4, 5]);
        let ranges = [0.5, 1.5, 10.7].map(|range_m: f32| range_m.to_bits());
        assert_eq!(words(&both)[4..], [&[5, 3], &ranges[..], &[0]].concat());
        let bumper = of(true, None, &[5.0]).unwrap();
        assert_eq!((&words(&bumper)[4..], has_sonars(&bumper)), (&[5, 0][..], false));
        let sonar = of(false, Some(1), &[0.5]).unwrap();
        assert_eq!((words(&sonar)[4], has_sonars(&sonar)), (u32::MAX, true));
    }

    #[test]
    fn a_large_belief_is_thinned_evenly() {
        let pose =
            |k: u32| WeightedPose { x_m: f64::from(k), y_m: 0.0, theta_rad: 0.0, weight: 1.0 };
        let poses: Vec<WeightedPose> = (0..7000).map(pose).collect();
        let bytes = belief(3, 1, (BeliefKind::Particles, 9000), &poses);
        assert_eq!(bytes.len(), 8 * 4 + 16 * 2334);
        assert_eq!(
            bytes[16..32],
            [[1u32, 1], [2334, 9000]]
                .concat()
                .iter()
                .flat_map(|n| n.to_le_bytes())
                .collect::<Vec<u8>>()
        );
        assert_eq!(bytes[48..52], 3f32.to_le_bytes());
    }
}
