//! Echoes that lost their scan, and scans that lost their echo.
//!
//! Recordings are edited: a scan that cannot be read is deleted, or nine of ten
//! are. The echo of a deleted scan still stands among the `ODOM` lines, and
//! those behind it go on from its corrected pose: taken for a reading it would
//! put the correction into the wheels. It shows by
//!
//! * a stamp that is not between those of the lines before and behind it, for
//!   the writer never set it (see `preview`);
//! * or a `NEFF` line right behind it: GMapping writes that line behind each
//!   echo, and no robot writes one.
//!
//! Where the echo is missing too, or the stamp of the line before `NEFF` can be
//! its time, the motion up to the next `ODOM` line is given up: one step less
//! in the odometry is better than one correction more.

/// Largest time by which a stamp may be earlier than that of the scan or line before,
/// s. In the log of the Intel Research Lab real stamps fall back by up to 0.9 s.
const BEFORE_S: f64 = 1.0;
/// Largest time by which it may be later, s.
const AFTER_S: f64 = 3600.0;
/// Stamps nearer to zero are not times, unless the other is the same, s.
const TINY_S: f64 = 1e-9;

/// Whether a line right behind one with the stamp `before_s` can have this stamp.
pub(super) fn is_time_near(stamp_s: f64, before_s: f64) -> bool {
    let tiny = stamp_s.abs() < TINY_S && stamp_s != before_s;
    let near = stamp_s >= before_s - BEFORE_S && stamp_s <= before_s + AFTER_S;
    near && !tiny
}

/// Finds, line by line, the `ODOM` lines from which the odometry goes on
/// although no scan stands before them.
#[derive(Debug, Default)]
pub(super) struct Detached {
    /// Last stamp that can be a time.
    time_s: Option<f64>,
    /// Lines whose stamp is far from it, until the next line decides, and the last's stamp.
    far: Vec<u64>,
    far_s: f64,
    /// The `ODOM` line just read, and whether its stamp can be its time.
    last: Option<(u64, bool)>,
    /// A scan without echo, or a `NEFF` line without either: the next `ODOM` line goes on
    /// from somewhere else.
    scan_alone: bool,
    mark_alone: bool,
    by_stamp: Vec<u64>,
    by_mark: Vec<u64>,
    behind_mark: Vec<u64>,
    behind_scan: Vec<u64>,
    /// Scans that their echo follows.
    echoed: u64,
    /// Echoes that a `NEFF` line follows.
    marked: u64,
}

impl Detached {
    /// A scan.
    pub(super) fn scan(&mut self, stamp_s: f64) {
        self.settle(stamp_s);
        self.far.clear();
        self.time_s = Some(stamp_s);
        (self.last, self.scan_alone) = (None, true);
    }

    /// An `ODOM` line that repeats the pose of the scan before it.
    pub(super) fn echo(&mut self) {
        self.echoed += 1;
        (self.last, self.scan_alone, self.mark_alone) = (None, false, false);
    }

    /// Any other `ODOM` line.
    pub(super) fn reading(&mut self, stamp_s: f64, line: u64) {
        if std::mem::take(&mut self.scan_alone) {
            self.behind_scan.push(line);
        }
        if std::mem::take(&mut self.mark_alone) {
            self.behind_mark.push(line);
        }
        let can_be_time = self.settle(stamp_s);
        self.last = Some((line, can_be_time));
        if can_be_time {
            self.time_s = Some(stamp_s);
        } else if !stamp_s.is_finite() || stamp_s.abs() < TINY_S {
            self.by_stamp.push(line);
        } else if self.far.is_empty() || !is_time_near(stamp_s, self.far_s) {
            self.far.push(line);
            self.far_s = stamp_s;
        } else {
            // Two that agree: the clock was set, or there is a gap.
            self.far.clear();
            self.time_s = Some(stamp_s);
        }
    }

    /// A `NEFF` line right behind an `ODOM` line.
    pub(super) fn mark(&mut self) {
        match self.last.take() {
            None => self.marked += 1,
            Some((line, can_be_time)) => {
                self.by_mark.push(line);
                self.mark_alone = can_be_time;
            }
        }
    }

    /// Whether a stamp can follow the last time; if so, the lines between were echoes.
    fn settle(&mut self, stamp_s: f64) -> bool {
        let near = self.time_s.is_none_or(|time_s| is_time_near(stamp_s, time_s));
        if near {
            self.by_stamp.append(&mut self.far);
        }
        near
    }

    /// Whether a `NEFF` line stands behind the echo of a scan.
    pub(super) fn is_marked(&self) -> bool {
        self.marked > 0
    }

    /// The numbers of the lines, in order. `has_echoes`: the file has them behind scans;
    /// `are_times`: its stamps tell the time.
    pub(super) fn lines(&self, has_echoes: bool, are_times: bool) -> Vec<u64> {
        let mut lines = self.by_mark.clone();
        if are_times {
            lines.extend(&self.behind_mark);
        }
        if are_times && (has_echoes || !lines.is_empty()) {
            lines.extend(&self.by_stamp);
        }
        // A writer that echoes, echoes every scan; a robot that stands still, some.
        if has_echoes && 2 * (self.behind_scan.len() as u64) < self.echoed {
            lines.extend(&self.behind_scan);
        }
        lines.sort_unstable();
        lines.dedup();
        lines
    }
}
