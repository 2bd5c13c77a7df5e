//! Ranges that mean nothing came back, found among all ranges of a recording.
//!
//! Lasers report *no return* as codes at the top of their number range. A SICK
//! LMS reports 8183 to 8191 in its unit: 81.83 m to 81.91 m in centimetres,
//! around 51.15 m in units of 5 cm, 32.759 m to 32.767 m in 15 bits of
//! millimetres. So codes share a narrow band below the largest range, and are far
//! denser there than measured ranges, which thin out towards the top.

use std::collections::BTreeMap;

use rusty_geometry::SE2;

/// Ranges that a configuration can have as its maximum, m.
const CREDIBLE_M: std::ops::RangeInclusive<f64> = 1e-3..=1e4;
/// Lowest code of a SICK LMS in its centimetre mode, beyond the maximum.
const SICK_NOTHING_M: f64 = 81.83;
/// Highest of these codes, not valid.
const SICK_NOT_VALID_M: f64 = 81.91;
/// Half a centimetre: the last digit of such a range.
const SICK_HALF_DIGIT_M: f64 = 0.005;
/// Part of the largest range over which codes spread. Measured: 0.14 %.
const CODES_PART: f64 = 0.002;
/// Part of the largest range, below the codes, that they are compared with.
const BELOW_PART: f64 = 0.018;
/// Ratio of the densities in both parts from which the upper one holds codes.
/// Measured where there are codes: 670 and more.
const DENSITY_RATIO: f64 = 10.0;
/// Fewest ranges that are taken for codes.
const FEWEST_CODES: u64 = 10;
/// Fewest ranges that are taken for codes, as part of all.
const FEWEST_CODES_PART: f64 = 0.001;
/// Part of all ranges beyond the recording's own maximum from which it is doubted.
const DOUBTED_PART: f64 = 0.01;

/// Ranges of one millimetre.
#[derive(Clone, Copy, Debug)]
struct Bin {
    lowest_m: f64,
    /// All ranges.
    ranges: u64,
    /// Those of scans at which the robot had moved: a robot that stands measures
    /// the same far wall again and again.
    moved: u64,
}

/// The maximum of a recording's ranges, and its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RangeMax {
    /// Ranges from here on mean nothing came back, m.
    pub(super) m: f64,
    pub(super) known_from: &'static str,
    /// The recording's own maximum and the number of measured ranges beyond it,
    /// if these are many.
    pub(super) doubted: Option<(f64, u64)>,
}

/// Counts of a recording's ranges.
#[derive(Debug, Default)]
pub(super) struct Ranges {
    /// The recording's own maximum, m.
    parameter_m: Option<f64>,
    /// The maximum, where the recording has no codes.
    fixed_m: Option<f64>,
    last_pose: Option<SE2>,
    pub(super) all: u64,
    moved: u64,
    beyond_parameter: u64,
    largest_m: Option<f64>,
    /// Ranges within [`CODES_PART`] and [`BELOW_PART`] of the largest, by
    /// millimetre.
    top: BTreeMap<u64, Bin>,
}

impl Ranges {
    /// No ranges yet. A parameter that cannot be a maximum is not used.
    pub(super) fn new(parameter_m: Option<f64>) -> Self {
        let parameter_m = parameter_m.filter(|m| CREDIBLE_M.contains(m));
        Self { parameter_m, ..Self::default() }
    }

    /// No ranges yet, of a recording whose scans tell their maximum.
    pub(super) fn fixed(max_m: f64) -> Self {
        Self { fixed_m: Some(max_m), ..Self::default() }
    }

    /// Takes a scan with its pose.
    pub(super) fn take(&mut self, ranges_m: &[f64], pose: Option<SE2>) {
        let moved = pose.is_none() || std::mem::replace(&mut self.last_pose, pose) != pose;
        self.all += ranges_m.len() as u64;
        self.moved += if moved { ranges_m.len() as u64 } else { 0 };
        let parameter_m = self.parameter_m.unwrap_or(f64::INFINITY);
        for &range_m in ranges_m.iter().filter(|m| CREDIBLE_M.contains(m)) {
            self.beyond_parameter += u64::from(range_m >= parameter_m);
            self.count(range_m, moved);
        }
    }

    fn count(&mut self, range_m: f64, moved: bool) {
        let largest_m = self.largest_m.map_or(range_m, |m| m.max(range_m));
        let floor_m = largest_m * (1.0 - CODES_PART - BELOW_PART);
        if self.largest_m.replace(largest_m) != Some(largest_m) {
            self.top = self.top.split_off(&millimetres(floor_m));
        }
        if range_m < floor_m {
            return;
        }
        let new = Bin { lowest_m: range_m, ranges: 0, moved: 0 };
        let bin = self.top.entry(millimetres(range_m)).or_insert(new);
        bin.lowest_m = bin.lowest_m.min(range_m);
        bin.ranges += 1;
        bin.moved += u64::from(moved);
    }

    /// The lowest code for *no return*, m, the number of ranges that are codes,
    /// and what tells so.
    fn codes(&self) -> Option<(f64, u64, &'static str)> {
        let largest_m = self.largest_m?;
        let number = |from_mm: u64| self.top.range(from_mm..).map(|(_, bin)| bin.ranges).sum();
        let sick_m = SICK_NOTHING_M - SICK_HALF_DIGIT_M;
        if largest_m > sick_m && largest_m < SICK_NOT_VALID_M + SICK_HALF_DIGIT_M {
            let codes = number(millimetres(sick_m));
            return Some((SICK_NOTHING_M, codes, "the SICK LMS's lowest error code"));
        }
        let lowest_mm = millimetres(largest_m * (1.0 - CODES_PART));
        let above = self.top.range(lowest_mm..);
        let lowest_m = above.clone().next()?.1.lowest_m;
        let above: u64 = above.map(|(_, bin)| bin.moved).sum();
        let below: u64 = self.top.range(..lowest_mm).map(|(_, bin)| bin.moved).sum();
        let is_dense = above as f64 / CODES_PART > DENSITY_RATIO * below as f64 / BELOW_PART;
        let is_much = above as f64 >= FEWEST_CODES_PART * self.moved as f64;
        (is_dense && is_much && above >= FEWEST_CODES).then(|| {
            (
                lowest_m,
                number(lowest_mm),
                "the lowest of the values that repeat too often at the top",
            )
        })
    }

    /// The maximum: of the log's own parameter, unless it is doubted, and the
    /// codes for *no return* the smaller one; else the largest range there is.
    pub(super) fn max(&self) -> RangeMax {
        if let Some(m) = self.fixed_m {
            return RangeMax { m, known_from: "the scans' range_max", doubted: None };
        }
        let codes = self.codes();
        let measured = self.beyond_parameter.saturating_sub(codes.map_or(0, |c| c.1));
        let is_doubted = measured as f64 > DOUBTED_PART * self.all as f64;
        let doubted = self.parameter_m.filter(|_| is_doubted).map(|m| (m, measured));
        let parameter_m = self.parameter_m.filter(|_| !is_doubted);
        let (m, known_from) = match (parameter_m, codes, self.largest_m) {
            (Some(m), Some((code_m, ..)), _) if m <= code_m => {
                (m, "the log's robot_front_laser_max")
            }
            (_, Some((m, _, known_from)), _) => (m, known_from),
            (Some(m), ..) => (m, "the log's robot_front_laser_max"),
            (None, None, Some(m)) => (m, "the largest range in the log"),
            (None, None, None) => (SICK_NOT_VALID_M, "assumed"),
        };
        RangeMax { m, known_from, doubted }
    }
}

/// Whole millimetres.
fn millimetres(range_m: f64) -> u64 {
    (1e3 * range_m) as u64
}
