//! Defects of a recording, found by its import.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A defect of a recording that changes what a score on it means. Lines are
/// those of the recording, from 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Finding {
    /// The stamps stand still; ticks are numbered at a nominal rate instead.
    FlatStamps {
        /// Intervals between scans (without scans: readings) of length 0.
        standing: u64,
        /// All of these intervals.
        intervals: u64,
        /// Rate at which the ticks are numbered, Hz.
        nominal_rate_hz: f64,
    },
    /// Time runs backwards, by too much at once or as a whole.
    BackwardStamps {
        /// Ticks whose stamp is earlier than the one before.
        backwards: u64,
        /// All ticks.
        ticks: u64,
        /// The largest such step back, s.
        max_s: f64,
        /// Its line.
        line: u64,
    },
    /// The pose moves between two scans, and no odometry was recorded there.
    NoOdometry {
        /// Number of such intervals.
        missing: u64,
        /// All intervals between scans.
        intervals: u64,
        /// Line of the scan that ends the interval with the largest turn.
        line: u64,
        /// Turn of the corrected pose in that interval, rad.
        turn_rad: f64,
        /// Distance between the corrected poses of that interval, m.
        distance_m: f64,
        /// Length of that interval, s; unknown where the stamps stand still.
        gap_s: Option<f64>,
    },
    /// The odometry is absent for a while in which the robot moves, in a recording without
    /// true poses.
    OdometryGap {
        /// Number of such intervals.
        gaps: u64,
        /// All intervals between readings.
        intervals: u64,
        /// Line of the reading that ends the interval with the largest turn.
        line: u64,
        /// Turn of the odometry's pose in that interval, rad.
        turn_rad: f64,
        /// Distance between the odometry's poses of that interval, m.
        distance_m: f64,
        /// Length of that interval, s.
        gap_s: f64,
    },
    /// The odometry covers a fraction of the corrected path.
    ShortOdometry {
        /// Length of the odometry, m.
        odometry_m: f64,
        /// Length of the corrected path, m.
        path_m: f64,
    },
    /// The odometry moves sideways, which two wheels cannot; that part is dropped.
    Sideways {
        /// Sum of the sideways parts, m.
        total_m: f64,
        /// Length of the odometry, m.
        odometry_m: f64,
        /// Largest sideways part, m.
        max_m: f64,
        /// Its line.
        line: u64,
    },
    /// Measured ranges exceed the recording's own maximum, which is not used.
    RangeMaxDoubted {
        /// `robot_front_laser_max` of the recording, m.
        parameter_m: f64,
        /// Ranges from there on that are not codes for *no return*.
        exceeding: u64,
        /// All ranges.
        ranges: u64,
        /// Maximum that is used instead, m.
        used_m: f64,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FlatStamps { standing, intervals, nominal_rate_hz } => write!(
                f,
                "the stamps stand still in {standing} of {intervals} intervals; ticks are \
                 numbered at a nominal rate of {nominal_rate_hz} Hz"
            ),
            Self::BackwardStamps { backwards, ticks, max_s, line } => write!(
                f,
                "{backwards} of {ticks} stamps are earlier than the one before, by up to \
                 {max_s:.3} s (line {line}): sort the recording by time, before anything \
                 corrects its poses"
            ),
            Self::NoOdometry { missing, intervals, line, turn_rad, distance_m, gap_s } => {
                write!(
                    f,
                    "{missing} of {intervals} intervals between scans have motion and no \
                     odometry; the worst ends at line {line}: "
                )?;
                if let Some(gap_s) = gap_s {
                    write!(f, "{gap_s:.1} s, ")?;
                }
                let turn_deg = turn_rad.to_degrees();
                write!(f, "the pose turns by {turn_deg:.1}° and moves by {distance_m:.2} m")
            }
            Self::OdometryGap { gaps, intervals, line, turn_rad, distance_m, gap_s } => write!(
                f,
                "{gaps} of {intervals} intervals between readings have motion and no odometry; the \
                 worst ends at line {line}: {gap_s:.1} s, the odometry's pose turns by {:.1}° and \
                 moves by {distance_m:.2} m",
                turn_rad.to_degrees()
            ),
            Self::ShortOdometry { odometry_m, path_m } => write!(
                f,
                "the odometry covers {odometry_m:.1} m, the corrected path is {path_m:.1} m long"
            ),
            Self::Sideways { total_m, odometry_m, max_m, line } => write!(
                f,
                "the odometry moves {total_m:.2} m sideways on {odometry_m:.1} m, by up to \
                 {max_m:.3} m (line {line}); two wheels cannot, so this part is dropped"
            ),
            Self::RangeMaxDoubted { parameter_m, exceeding, ranges, used_m } => write!(
                f,
                "robot_front_laser_max {parameter_m} m is doubted: {exceeding} of {ranges} ranges \
                 exceed it and are measured; {used_m} m is used"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::super::Source;
    use super::*;

    /// A source as logs had it before there were findings.
    fn without() -> Value {
        json!({ "kind": "recorded", "format": "carmen", "file": "a.log", "remarks": ["one"] })
    }

    #[test]
    fn a_source_without_findings_has_the_bytes_it_had() {
        let source: Source = serde_json::from_value(without()).unwrap();
        assert!(matches!(&source, Source::Recorded { findings, .. } if findings.is_empty()));
        assert_eq!(serde_json::to_value(&source).unwrap(), without());
    }

    #[test]
    fn every_finding_reads_back_and_shows_its_numbers() {
        let none = Finding::NoOdometry {
            missing: 219,
            intervals: 236,
            line: 1696,
            turn_rad: 80.6_f64.to_radians(),
            distance_m: 0.25,
            gap_s: Some(3.1),
        };
        let findings = [
            Finding::FlatStamps { standing: 404, intervals: 405, nominal_rate_hz: 10.0 },
            Finding::BackwardStamps { backwards: 404, ticks: 405, max_s: 10.0, line: 3 },
            none,
            Finding::OdometryGap {
                gaps: 2,
                intervals: 900,
                line: 77,
                turn_rad: 80.6_f64.to_radians(),
                distance_m: 0.25,
                gap_s: 3.1,
            },
            Finding::ShortOdometry { odometry_m: 39.9, path_m: 221.4 },
            Finding::Sideways { total_m: 25.45, odometry_m: 372.0, max_m: 0.387, line: 2690 },
            Finding::RangeMaxDoubted {
                parameter_m: 10.0,
                exceeding: 17_844,
                ranges: 61_200,
                used_m: 51.09,
            },
        ];
        for (finding, numbers) in findings.iter().zip([
            ["404", "405", "10 Hz"],
            ["404 of 405", "10.000 s", "line 3"],
            ["219 of 236", "3.1 s", "80.6°"],
            ["2 of 900", "3.1 s", "80.6°"],
            ["39.9 m", "221.4 m", "path"],
            ["25.45 m", "0.387 m", "line 2690"],
            ["10 m", "17844 of 61200", "51.09 m"],
        ]) {
            let text = finding.to_string();
            assert!(numbers.iter().all(|n| text.contains(n)), "{text}");
        }
        let text = serde_json::to_string(&findings).unwrap();
        assert_eq!(serde_json::from_str::<Vec<Finding>>(&text).unwrap(), findings);
    }
}
