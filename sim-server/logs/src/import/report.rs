//! What an import found and did, for a person and for a program.

use std::collections::BTreeMap;
use std::fmt;

use rusty_contract::log::Finding;
use rusty_geometry::{DiffDrive, tick_length};
use serde::Serialize;

/// The result of an import. Lengths in metres, times in seconds, lines of the
/// recording counted from 1 (0: no such line).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImportReport {
    /// Lines of the recording.
    pub lines: u64,
    /// Odometry readings (`ODOM` lines that are no anchors).
    pub readings: u64,
    /// Laser scans (`FLASER` lines).
    pub scans: u64,
    /// Scans that bring a separate odometry pose.
    pub scans_with_odometry: u64,
    /// `ODOM` lines that echo the corrected pose of the scan before them.
    pub anchors: u64,
    /// Those of them that are not the echo of a scan before them: their scan, or the echo
    /// of the scan before them, was deleted.
    pub detached: u64,
    /// Ticks of the run log: readings and scans.
    pub ticks: u64,
    /// Ranges per scan; 0 without scans.
    pub beams: u32,
    /// Mean length of a tick.
    pub dt_s: f64,
    /// Time of the first tick: its stamp in the recording, unless stamps stand
    /// still.
    pub first_stamp_s: f64,
    /// Time of the last tick.
    pub last_stamp_s: f64,
    /// Ticks whose stamp is earlier than the one before.
    pub stamps_backwards: u64,
    /// The largest such step back.
    pub backwards_max_s: f64,
    /// Its line.
    pub backwards_max_line: u64,
    /// Largest sideways part of an increment, which two wheels cannot show.
    pub lateral_max_m: f64,
    /// Its line.
    pub lateral_max_line: u64,
    /// Sum of all sideways parts, without sign.
    pub lateral_total_m: f64,
    /// Longest increment.
    pub step_max_m: f64,
    /// Its line.
    pub step_max_line: u64,
    /// Way of the odometry, Σ|Δs|.
    pub distance_m: f64,
    /// Distance between dead reckoning on the counts and the last corrected
    /// pose; both agree at the first. `None` without scans.
    pub end_error_m: Option<f64>,
    /// Messages of types that are not read.
    pub skipped: BTreeMap<String, u64>,
    /// The virtual wheels whose counts were written.
    pub wheel: DiffDrive,
    /// The remarks that the run log carries.
    pub remarks: Vec<String>,
    /// The findings that the run log carries.
    pub findings: Vec<Finding>,
}

impl fmt::Display for ImportReport {
    /// A few lines, without a newline at the end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let span_s = self.last_stamp_s - self.first_stamp_s + self.dt_s;
        writeln!(f, "read       {} lines", self.lines)?;
        let readings = self.readings + self.scans_with_odometry;
        writeln!(f, "odometry   {readings} readings, {:.2} m driven", self.distance_m)?;
        match self.beams {
            0 => writeln!(f, "scans      none")?,
            n => {
                let echoed = self.anchors - self.detached;
                writeln!(f, "scans      {} of {n} beams, {echoed} echoed", self.scans)?;
            }
        }
        if self.detached > 0 {
            let detached = self.detached;
            writeln!(f, "deleted    scans or echoes: {detached} ODOM lines show it, no readings")?;
        }
        writeln!(
            f,
            "written    {} ticks, {span_s:.1} s from {} s",
            self.ticks, self.first_stamp_s
        )?;
        if self.stamps_backwards > 0 {
            writeln!(
                f,
                "stamps     {} earlier than the one before, by up to {:.3} s (line {})",
                self.stamps_backwards, self.backwards_max_s, self.backwards_max_line
            )?;
        }
        if self.lateral_max_line > 0 {
            writeln!(
                f,
                "sideways   up to {:.2} mm dropped (line {}), {:.2} m in all",
                1e3 * self.lateral_max_m,
                self.lateral_max_line,
                self.lateral_total_m
            )?;
        }
        if let Some(error_m) = self.end_error_m {
            writeln!(f, "drift      dead reckoning ends {error_m:.2} m from the last true pose")?;
        }
        if !self.skipped.is_empty() {
            let list: Vec<String> =
                self.skipped.iter().map(|(name, n)| format!("{name} {n}")).collect();
            writeln!(f, "skipped    {}", list.join(", "))?;
        }
        for finding in &self.findings {
            writeln!(f, "finding    {finding}")?;
        }
        write!(
            f,
            "wheels     virtual: radius {} m, track {} m, {} counts per turn ({:.1} µm each)",
            self.wheel.wheel_radius_m,
            self.wheel.track_m,
            self.wheel.ticks_per_rev,
            1e6 * tick_length(&self.wheel)
        )
    }
}
