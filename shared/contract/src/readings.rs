//! `Readings`: what the small sensors say in a tick, one run of numbers.
//!
//! A frame carries the readings of its tick one after the other, without gaps,
//! before the scan. A sensor that says nothing in a tick takes no room there, so
//! that a tick without small sensors is as it would be if there were none.
//!
//! | order | reading   | numbers | unit, frame, meaning                                        |
//! |------:|-----------|--------:|-------------------------------------------------------------|
//! |     0 | bumper    |       1 | bit k: sector k touches something; at most 2^16 − 1           |
//! |     1 | IMU       |       3 | yaw rate rad/s; acceleration x, y m/s²; body frame            |
//! |     2 | sonars    |    1…16 | range of sonar k, m                                         |
//! |     3 | doors     |    0…32 | numbers of the doors that are detected, ascending           |
//! |     4 | landmarks |   0…192 | three for each: id (−1: unknown), range m, bearing rad, body frame |

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// The most sonars a robot can have.
pub const MAX_SONARS: usize = 16;
/// The most doors a tick can report.
pub const MAX_DOORS: usize = 32;
/// The most landmarks a tick can report.
pub const MAX_LANDMARKS: usize = 64;
/// The most numbers that readings take.
pub const MAX_READINGS: usize = 1 + IMU_NUMBERS + MAX_SONARS + MAX_DOORS + 3 * MAX_LANDMARKS;

const IMU_NUMBERS: usize = 3;

/// The names of the small sensors, in the order of the table.
pub const SENSOR_NAMES: [&str; 5] = ["bumper", "imu", "sonars", "doors", "landmarks"];

/// What the IMU says: the mean over a tick, body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ImuReading {
    /// Yaw rate ω, rad/s, counter-clockwise positive.
    pub yaw_rate_rad_s: f64,
    /// Acceleration ahead, m/s².
    pub accel_x_m_s2: f64,
    /// Acceleration to the left, m/s².
    pub accel_y_m_s2: f64,
}

/// A landmark as it is seen from the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LandmarkReading {
    id: f64,
    /// Distance, m.
    pub range_m: f64,
    /// Bearing in the body frame, rad, counter-clockwise positive.
    pub bearing_rad: f64,
}

impl LandmarkReading {
    /// A reading of the landmark `id`, or of one whose identity is not known.
    #[must_use]
    pub fn new(id: Option<u32>, range_m: f64, bearing_rad: f64) -> Self {
        Self { id: id.map_or(-1.0, f64::from), range_m, bearing_rad }
    }

    /// Which landmark it is, where the sensor knows.
    #[must_use]
    pub fn id(&self) -> Option<u32> {
        (self.id >= 0.0 && self.id <= f64::from(u32::MAX)).then_some(self.id as u32)
    }
}

/// Which readings a tick has, and how many numbers each takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Present {
    /// The bumper says which sectors touch.
    pub bumper: bool,
    /// The IMU was read.
    pub imu: bool,
    /// Number of sonars, where they were read.
    pub sonars: Option<u8>,
    /// Number of doors that were detected, where they were looked for.
    pub doors: Option<u8>,
    /// Number of landmarks that were seen, where they were looked for.
    pub landmarks: Option<u8>,
}

impl Present {
    /// Where the numbers of each reading end, in the order of the table.
    fn ends(&self) -> [usize; 5] {
        let count = |n: Option<u8>, most: usize| usize::from(n.unwrap_or(0)).min(most);
        let bumper = usize::from(self.bumper);
        let imu = bumper + if self.imu { IMU_NUMBERS } else { 0 };
        let sonars = imu + count(self.sonars, MAX_SONARS);
        let doors = sonars + count(self.doors, MAX_DOORS);
        [bumper, imu, sonars, doors, doors + 3 * count(self.landmarks, MAX_LANDMARKS)]
    }

    /// The names of the sensors that say something.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        let Self { bumper, imu, sonars, doors, landmarks } = *self;
        let present = [bumper, imu, sonars.is_some(), doors.is_some(), landmarks.is_some()];
        SENSOR_NAMES
            .into_iter()
            .zip(present)
            .filter_map(|(name, is_there)| is_there.then_some(name))
    }

    /// How many numbers all readings take together, at most [`MAX_READINGS`].
    #[must_use]
    pub fn numbers(&self) -> usize {
        self.ends()[4]
    }

    /// Whether no small sensor says anything.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The readings of a tick, where they lie. Each method returns `None` where its
/// sensor says nothing in the tick.
#[derive(Clone, Copy, Debug)]
pub struct Readings<'a> {
    present: Present,
    numbers: &'a [f64],
}

impl<'a> Readings<'a> {
    /// The readings that `numbers` holds; numbers that are missing count as
    /// readings that are absent.
    #[must_use]
    pub fn new(present: Present, numbers: &'a [f64]) -> Self {
        match numbers.get(..present.numbers()) {
            Some(numbers) => Self { present, numbers },
            None => Self { present: Present::default(), numbers: &[] },
        }
    }

    /// Which readings there are.
    #[must_use]
    pub fn present(&self) -> Present {
        self.present
    }

    /// All readings, one after the other.
    #[must_use]
    pub fn numbers(&self) -> &'a [f64] {
        self.numbers
    }

    fn part(&self, index: usize) -> &'a [f64] {
        let ends = self.present.ends();
        let from = index.checked_sub(1).map_or(0, |before| ends[before]);
        &self.numbers[from..ends[index]]
    }

    /// Sectors of the body that touch something: bit k for sector k.
    #[must_use]
    pub fn bumper(&self) -> Option<u16> {
        self.part(0).first().map(|sectors| *sectors as u16)
    }

    /// Yaw rate and acceleration.
    #[must_use]
    pub fn imu(&self) -> Option<ImuReading> {
        bytemuck::cast_slice(self.part(1)).first().copied()
    }

    /// Range of each sonar, m.
    #[must_use]
    pub fn sonar_ranges_m(&self) -> Option<&'a [f64]> {
        self.present.sonars.map(|_| self.part(2))
    }

    /// Numbers of the doors that are detected, ascending, each a whole number
    /// from 0 to 255.
    #[must_use]
    pub fn doors(&self) -> Option<&'a [f64]> {
        self.present.doors.map(|_| self.part(3))
    }

    /// The landmarks that are seen.
    #[must_use]
    pub fn landmarks(&self) -> Option<&'a [LandmarkReading]> {
        self.present.landmarks.map(|_| bytemuck::cast_slice(self.part(4)))
    }

    /// Each number with the name of its place: `imu.yaw_rate_rad_s`, `sonar_m[3]`,
    /// `landmark[2].range_m`, ….
    pub fn named(&self) -> impl Iterator<Item = (String, f64)> + 'a {
        const IMU: [&str; IMU_NUMBERS] = ["yaw_rate_rad_s", "accel_x_m_s2", "accel_y_m_s2"];
        const LANDMARK: [&str; 3] = ["id", "range_m", "bearing_rad"];
        let ends = self.present.ends();
        self.numbers.iter().enumerate().map(move |(i, number)| {
            let part = ends.iter().position(|end| i < *end).unwrap_or(4);
            let k = i - part.checked_sub(1).map_or(0, |before| ends[before]);
            let name = match part {
                0 => "bumper".to_owned(),
                1 => format!("imu.{}", IMU[k]),
                2 => format!("sonar_m[{k}]"),
                3 => format!("door[{k}]"),
                _ => format!("landmark[{}].{}", k / 3, LANDMARK[k % 3]),
            };
            (name, *number)
        })
    }

    /// Checks what anybody may have written.
    ///
    /// # Errors
    /// The number and what is wrong with it.
    pub fn check(&self) -> Result<(), String> {
        let whole = |n: f64, low: f64, high: f64| n.fract() == 0.0 && (low..=high).contains(&n);
        for (name, number) in self.named() {
            let usable = match name.split(['[', '.']).next() {
                Some("bumper") => whole(number, 0.0, 65_535.0),
                Some("door") => whole(number, 0.0, 255.0),
                Some("sonar_m") => number >= 0.0 && number.is_finite(),
                _ if name.ends_with("].id") => whole(number, -1.0, f64::from(u32::MAX)),
                _ => number.is_finite(),
            };
            if !usable {
                return Err(format!("{name} = {number} is no such reading"));
            }
        }
        Ok(())
    }
}

/// [`Readings`], owned, as a log keeps them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnedReadings {
    present: Present,
    numbers: Vec<f64>,
}

impl OwnedReadings {
    /// The readings.
    #[must_use]
    pub fn get(&self) -> Readings<'_> {
        Readings::new(self.present, &self.numbers)
    }

    /// Checks what a log may hold.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self) -> Result<(), String> {
        let fits = |n: Option<u8>, most: usize| usize::from(n.unwrap_or(0)) <= most;
        let Present { sonars, doors, landmarks, .. } = self.present;
        if !(fits(sonars, MAX_SONARS) && fits(doors, MAX_DOORS) && fits(landmarks, MAX_LANDMARKS)) {
            return Err("a record counts more readings than a tick can have".to_owned());
        }
        if self.numbers.len() != self.present.numbers() {
            let (n, wanted) = (self.numbers.len(), self.present.numbers());
            return Err(format!("a record holds {n} numbers for readings of {wanted}"));
        }
        self.get().check()
    }
}

impl From<Readings<'_>> for OwnedReadings {
    fn from(readings: Readings<'_>) -> Self {
        Self { present: readings.present, numbers: readings.numbers.to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> (Present, Vec<f64>) {
        let present = Present {
            bumper: true,
            imu: true,
            sonars: Some(2),
            doors: Some(1),
            landmarks: Some(2),
        };
        let numbers = [5.0, 0.1, 0.2, 0.3, 1.5, 2.5, 7.0, 3.0, 4.0, 0.5, -1.0, 6.0, -0.5];
        (present, numbers.to_vec())
    }

    #[test]
    fn each_reading_is_found_in_its_place() {
        let (present, numbers) = all();
        let readings = Readings::new(present, &numbers);
        assert_eq!(readings.bumper(), Some(5));
        assert_eq!(readings.imu().unwrap().accel_y_m_s2, 0.3);
        assert_eq!(readings.sonar_ranges_m(), Some(&[1.5, 2.5][..]));
        assert_eq!(readings.doors(), Some(&[7.0][..]));
        let landmarks = readings.landmarks().unwrap();
        assert_eq!(landmarks[0], LandmarkReading::new(Some(3), 4.0, 0.5));
        assert_eq!((landmarks[1].id(), landmarks[1].range_m), (None, 6.0));
        assert_eq!(readings.check(), Ok(()));
        let names: Vec<String> = readings.named().map(|(name, _)| name).collect();
        assert_eq!(
            names[..5],
            ["bumper", "imu.yaw_rate_rad_s", "imu.accel_x_m_s2", "imu.accel_y_m_s2", "sonar_m[0]"]
        );
        assert_eq!(names[12], "landmark[1].bearing_rad");
    }

    #[test]
    fn a_sensor_that_sees_nothing_is_not_a_sensor_that_says_nothing() {
        let present = Present { doors: Some(0), landmarks: Some(0), ..Present::default() };
        let readings = Readings::new(present, &[]);
        assert_eq!(readings.doors(), Some(&[][..]));
        assert_eq!(readings.landmarks().map(<[_]>::len), Some(0));
        assert!(readings.sonar_ranges_m().is_none() && readings.imu().is_none());
        assert!(!present.is_empty() && Present::default().is_empty());
    }

    #[test]
    fn what_cannot_be_a_reading_is_refused() {
        let (present, good) = all();
        for (place, wrong) in [
            (0, 0.5),
            (0, 65_536.0),
            (1, f64::NAN),
            (4, -1.0),
            (4, f64::INFINITY),
            (6, 256.0),
            (7, -2.0),
            (8, f64::INFINITY),
        ] {
            let mut numbers = good.clone();
            numbers[place] = wrong;
            let error = Readings::new(present, &numbers).check();
            assert!(error.is_err(), "{wrong} at {place}");
        }
        let short = OwnedReadings { present, numbers: vec![1.0] };
        assert!(short.check().is_err() && short.get().present().is_empty());
    }

    #[test]
    fn counts_beyond_the_room_are_cut() {
        let present = Present {
            sonars: Some(255),
            landmarks: Some(255),
            doors: Some(255),
            ..Present::default()
        };
        assert_eq!(present.numbers(), MAX_SONARS + MAX_DOORS + 3 * MAX_LANDMARKS);
        let forged = OwnedReadings { present, numbers: vec![1.0; present.numbers()] };
        assert!(forged.check().is_err());
    }
}
