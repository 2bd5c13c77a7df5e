//! A pose as a line of a trajectory in the format of the TUM RGB-D benchmark.
//!
//! Source: J. Sturm, N. Engelhard, F. Endres, W. Burgard, D. Cremers, *A Benchmark
//! for the Evaluation of RGB-D SLAM Systems* (IROS 2012): lines of `timestamp tx
//! ty tz qx qy qz qw`. Departure: poses are planar, so z is 0 and the quaternion
//! turns about z alone: (0, 0, sin θ/2, cos θ/2).

use rusty_geometry::{SE2, trig};

/// Returns a pose as a line without its end. Every number reads back to the bits it has here.
#[must_use]
pub fn line(time_s: f64, pose: &SE2) -> String {
    let (sin, cos) = trig::sin_cos(0.5 * pose.theta());
    format!("{time_s:?} {:?} {:?} 0 0 0 {sin:?} {cos:?}", pose.x(), pose.y())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_reads_back_to_the_same_bits() {
        let pose = SE2::new(0.1 + 0.2, -1e-17, -2.5);
        let text = line(1.5e9 + 0.123, &pose);
        let numbers: Vec<f64> = text.split(' ').map(|w| w.parse().unwrap()).collect();
        assert_eq!(numbers.len(), 8);
        assert_eq!(numbers[..3], [1.5e9 + 0.123, pose.x(), pose.y()]);
        assert_eq!(numbers[3..6], [0.0; 3]);
        // Twice the angle of the quaternion is the heading.
        let theta_rad = 2.0 * trig::atan2(numbers[6], numbers[7]);
        assert!((theta_rad - pose.theta()).abs() < 1e-15);
        assert!(line(0.02, &SE2::identity()).ends_with(" 0.0 1.0"));
    }
}
