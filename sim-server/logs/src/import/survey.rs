//! Looking through a recording before anything is written.
//!
//! The header of a run log comes first and says what only the whole recording
//! tells: how many ticks, how large the scans, where the robot starts. So the
//! file is read four times, and memory never holds more than one line:
//! the preview decides how lines are understood, [`look`] counts and measures,
//! [`drive`] turns the wheels, and the last reading (in `convert`) writes.

use std::collections::BTreeMap;

use rusty_contract::config::LidarConfig;
use rusty_geometry::SE2;

use super::Progress;
use super::error::ImportError;
use super::judge::Judge;
use super::preview::{Params, Preview, StampIntervals};
use super::ranges::Ranges;
use super::recording::{Event, Events};
use super::wheels::{LeverFit, Mount, Peak, Wheels, distance_m};

/// What a recording of ROS tells of itself.
#[derive(Debug)]
pub(super) struct Told {
    pub(super) format: &'static str,
    pub(super) flat: Option<StampIntervals>,
    /// `None`: there are no scans.
    pub(super) lidar: Option<LidarConfig>,
    pub(super) remarks: Vec<String>,
}

/// What is known before the events are read, by the kind of recording.
#[derive(Debug)]
pub(super) enum Before {
    Carmen(Box<Preview>),
    Ros(Told),
}

impl From<Told> for Before {
    fn from(told: Told) -> Self {
        Self::Ros(told)
    }
}

/// What a recording holds.
#[derive(Debug, Default)]
pub(super) struct Survey {
    pub(super) lines: u64,
    pub(super) readings: u64,
    pub(super) anchors: u64,
    /// Those of them that are not the echo of a scan before them.
    pub(super) detached: u64,
    pub(super) scans: u64,
    /// Scans with a separate odometry pose.
    pub(super) scans_with_odometry: u64,
    /// Beams of every scan, and the line of the first.
    pub(super) beams: usize,
    first_scan_line: u64,
    pub(super) first_stamp_s: f64,
    pub(super) last_stamp_s: f64,
    last_stamp_known: bool,
    pub(super) stamps_backwards: u64,
    /// Largest fall of a stamp, s.
    pub(super) backwards: Peak,
    pub(super) ranges: Ranges,
    pub(super) params: Params,
    /// The stamps' intervals, if the stamps stand still.
    pub(super) flat: Option<StampIntervals>,
    pub(super) two_times: u64,
    pub(super) skipped: BTreeMap<String, u64>,
    /// `None`: it is one of CARMEN.
    pub(super) told: Option<Told>,
    lever: LeverFit,
}

/// Reads a recording once, for its facts.
pub(super) fn look(
    recording: &mut dyn Events,
    before: Before,
    progress: &mut Progress<'_>,
) -> Result<Survey, ImportError> {
    let mut survey = match before {
        Before::Carmen(preview) => Survey {
            detached: preview.detached().len() as u64,
            params: preview.params,
            flat: preview.flat(),
            ranges: Ranges::new(preview.params.laser_max_m),
            ..Survey::default()
        },
        Before::Ros(told) => Survey {
            flat: told.flat,
            ranges: told.lidar.map_or_else(Ranges::default, |l| Ranges::fixed(l.range_max_m)),
            told: Some(told),
            ..Survey::default()
        },
    };
    let path = recording.facts().path.to_owned();
    while let Some(event) = recording.next_event()? {
        progress.at(event.line());
        survey.take(&event, &path)?;
    }
    let facts = recording.facts();
    survey.lines = facts.line;
    survey.two_times = facts.two_times;
    survey.skipped = facts.skipped.clone();
    Ok(survey)
}

impl Survey {
    fn take(&mut self, event: &Event<'_>, path: &str) -> Result<(), ImportError> {
        self.lever.take(event);
        match event {
            Event::Anchor { .. } => self.anchors += 1,
            Event::Reading { stamp_s, line, .. } => {
                self.readings += 1;
                self.stamp(*stamp_s, *line);
            }
            Event::Scan { pose, odometry, stamp_s, ranges_m, line } => {
                self.scans += 1;
                self.scans_with_odometry += u64::from(odometry.is_some());
                self.stamp(*stamp_s, *line);
                self.scan(ranges_m, *line, path)?;
                self.ranges.take(ranges_m, *pose);
            }
        }
        Ok(())
    }

    fn stamp(&mut self, stamp_s: f64, line: u64) {
        if self.flat.is_some() {
            return;
        }
        if !self.last_stamp_known {
            self.first_stamp_s = stamp_s;
            self.last_stamp_known = true;
        } else if stamp_s < self.last_stamp_s {
            self.stamps_backwards += 1;
            self.backwards.see(self.last_stamp_s - stamp_s, line);
        }
        self.last_stamp_s = stamp_s;
    }

    fn scan(&mut self, ranges_m: &[f64], line: u64, path: &str) -> Result<(), ImportError> {
        if self.first_scan_line == 0 {
            self.first_scan_line = line;
            self.beams = ranges_m.len();
        }
        if ranges_m.len() != self.beams {
            let problem = format!(
                "the scan has {} beams, the first scan (line {}) has {}; a run has one LiDAR: split \
                 the recording where the number changes",
                ranges_m.len(),
                self.first_scan_line,
                self.beams
            );
            return Err(ImportError::line(path, line, problem));
        }
        Ok(())
    }

    /// How many ticks the run gets: one per reading and one per scan.
    pub(super) fn tick_count(&self) -> u64 {
        self.readings + self.scans
    }

    /// Whether anything tells how the wheels turned.
    pub(super) fn has_odometry(&self) -> bool {
        self.readings + self.scans_with_odometry > 0
    }

    /// How far before the axle the odometry's poses move, m, if it can be told.
    pub(super) fn arm_m(&self) -> Option<f64> {
        self.lever.arm_m()
    }

    /// What the poses of this file are poses of.
    ///
    /// By the format the first pose of a `FLASER` is the laser's and the second
    /// the robot's. A log that GMapping wrote may have the laser's everywhere
    /// (that of Freiburg has); whether it does shows in turns, see [`LeverFit`].
    pub(super) fn mount(&self) -> Mount {
        let offset_m = self.params.laser_offset_m.unwrap_or(0.0);
        let odometry_is_laser =
            offset_m != 0.0 && self.arm_m().is_some_and(|arm_m| arm_m / offset_m > 0.5);
        Mount {
            offset_m,
            odometry_is_laser,
            scans_are_laser: odometry_is_laser || self.scans_with_odometry > 0,
        }
    }
}

/// The result of driving the virtual wheels through the recording.
#[derive(Debug)]
pub(super) struct Drive {
    pub(super) wheels: Wheels,
    /// Where the robot starts, in the frame of the corrected poses.
    pub(super) start: SE2,
    /// Distance between dead reckoning and the last corrected pose, m.
    pub(super) end_error_m: Option<f64>,
    /// x_min, y_min, x_max, y_max of the corrected poses; without any, of the
    /// odometry's. Metres.
    pub(super) around_m: [f64; 4],
    /// Ranges that mean nothing came back, and all.
    pub(super) nothing: [u64; 2],
    /// Largest distance between a scan's pose and the odometry's, m.
    pub(super) correction: Peak,
    /// Odometry compared with the corrected path.
    pub(super) judge: Judge,
}

/// Reads a recording once, turning the wheels.
pub(super) fn drive(
    recording: &mut dyn Events,
    mount: Mount,
    range_max_m: f64,
    progress: &mut Progress<'_>,
) -> Result<Drive, ImportError> {
    let mut wheels = Wheels::new(mount);
    let (mut odometry_m, mut truth_m) = (NOWHERE, NOWHERE);
    let (mut first, mut last, mut first_pose) = (None, None, None);
    let mut nothing = [0, 0];
    let mut correction = Peak::default();
    let mut judge = Judge::default();
    while let Some(event) = recording.next_event()? {
        let line = event.line();
        progress.at(line);
        if let Event::Scan { ranges_m, .. } = event {
            let none = ranges_m.iter().filter(|r| **r >= range_max_m).count();
            nothing = [nothing[0] + none as u64, nothing[1] + ranges_m.len() as u64];
        }
        let tick = wheels.take(&event);
        judge.take(&event, tick.and_then(|tick| tick.truth));
        first_pose = first_pose.or(wheels.last());
        if let Some(pose) = wheels.last() {
            widen(&mut odometry_m, &pose);
        }
        if let Some(truth) = tick.and_then(|tick| tick.truth) {
            widen(&mut truth_m, &truth);
            first = first.or(Some((truth, wheels.driven())));
            last = Some((truth, wheels.driven()));
            if let Some(pose) = wheels.last() {
                correction.see(distance_m(&pose, &truth), line);
            }
        }
    }
    let start = match (first, first_pose) {
        (Some((truth, driven)), _) => truth * driven.inverse(),
        (None, Some(pose)) => pose,
        (None, None) => SE2::identity(),
    };
    Ok(Drive {
        end_error_m: last.map(|(truth, driven)| distance_m(&(start * driven), &truth)),
        around_m: if last.is_some() { truth_m } else { odometry_m },
        wheels,
        start,
        nothing,
        correction,
        judge,
    })
}

const NOWHERE: [f64; 4] = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

fn widen(box_m: &mut [f64; 4], pose: &SE2) {
    box_m[0] = box_m[0].min(pose.x());
    box_m[1] = box_m[1].min(pose.y());
    box_m[2] = box_m[2].max(pose.x());
    box_m[3] = box_m[3].max(pose.y());
}
