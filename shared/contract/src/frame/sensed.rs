//! Writing the readings of the small sensors into a frame.

use super::{
    Frame, HAS_BUMPER, HAS_DOORS, HAS_IMU, HAS_LANDMARKS, HAS_SCAN, HAS_SONARS, HAS_TRUTH,
};
use crate::readings::{ImuReading, LandmarkReading, Present};

impl Frame {
    /// Writes which sectors of the bumper touch a wall, bit k for sector k.
    pub fn write_bumper(&mut self, sectors: u16) {
        self.write_readings(Present { bumper: true, ..Present::default() }, &[sectors.into()]);
    }

    /// Writes yaw rate and acceleration.
    pub fn write_imu(&mut self, reading: ImuReading) {
        let numbers = bytemuck::cast_ref::<ImuReading, [f64; 3]>(&reading);
        self.write_readings(Present { imu: true, ..Present::default() }, numbers);
    }

    /// Writes the range of each sonar, m.
    pub fn write_sonars(&mut self, ranges_m: &[f64]) {
        let sonars = Some(ranges_m.len() as u8);
        self.write_readings(Present { sonars, ..Present::default() }, ranges_m);
    }

    /// Writes the numbers of the doors that are detected, ascending.
    pub fn write_doors(&mut self, doors: &[f64]) {
        let count = Some(doors.len() as u8);
        self.write_readings(Present { doors: count, ..Present::default() }, doors);
    }

    /// Writes the landmarks that are seen.
    pub fn write_landmarks(&mut self, landmarks: &[LandmarkReading]) {
        let count = Some(landmarks.len() as u8);
        let numbers = bytemuck::cast_slice(landmarks);
        self.write_readings(Present { landmarks: count, ..Present::default() }, numbers);
    }

    /// Adds readings to those that are written: those of one sensor, or of all.
    /// What is written later comes later in the order of the layout, the scan
    /// last; builds with debug assertions check that.
    pub fn write_readings(&mut self, present: Present, numbers: &[f64]) {
        let flags = [
            (HAS_BUMPER, present.bumper),
            (HAS_IMU, present.imu),
            (HAS_SONARS, present.sonars.is_some()),
            (HAS_DOORS, present.doors.is_some()),
            (HAS_LANDMARKS, present.landmarks.is_some()),
        ];
        let flags = flags.iter().filter(|(_, set)| *set).fold(0, |all, (flag, _)| all | flag);
        let before = self.flags & !HAS_TRUTH;
        debug_assert!(
            before & HAS_SCAN == 0
                && (before == 0 || flags == 0 || before < flags & flags.wrapping_neg()),
            "readings {flags:b} written after {before:b}: keep to the order of the layout"
        );
        let numbers = &numbers[..numbers.len().min(present.numbers())];
        let at = self.present().numbers();
        self.numbers[at..at + numbers.len()].copy_from_slice(numbers);
        self.flags |= flags;
        self.sonars |= present.sonars.unwrap_or(0);
        self.doors |= present.doors.unwrap_or(0);
        self.landmarks |= present.landmarks.unwrap_or(0);
    }
}
