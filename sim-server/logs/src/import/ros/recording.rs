//! Messages as events: odometry, and scans with the odometry of their time.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::rc::Rc;

use rusty_geometry::SE2;
use rusty_ros::messages::{LaserScan, Odometry, TfMessage};

use super::content::{decode, frame, stamp_s};
use super::files::{Files, Message};
use super::survey::{Beams, OdometrySource, truth_at};
use crate::import::ImportError;
use crate::import::recording::{Event, Events, Facts};

/// What is read of a recording.
#[derive(Debug)]
pub(super) struct Choice {
    pub(super) odometry: OdometrySource,
    pub(super) beams: Option<Beams>,
    pub(super) truth: Vec<(f64, SE2)>,
}

/// A stamp and the number of its message.
type Moment = (f64, u64);

/// A recording of ROS, read event by event.
pub(super) struct RosRecording {
    files: Files,
    choice: Rc<Choice>,
    ranges_m: Vec<f64>,
    /// Odometry that waits for a scan of its time.
    reading: Option<(SE2, Moment)>,
    /// A scan that waits for odometry of its time: topics have no order.
    scan: Option<(Moment, Vec<f64>)>,
    two_times: u64,
    skipped: BTreeMap<String, u64>,
}

impl RosRecording {
    pub(super) fn open(paths: &[PathBuf], choice: Rc<Choice>) -> Self {
        Self {
            files: Files::open(paths.to_vec()),
            choice,
            ranges_m: Vec::new(),
            reading: None,
            scan: None,
            two_times: 0,
            skipped: BTreeMap::new(),
        }
    }

    /// The scan whose ranges were just read, or what waited before it.
    fn scanned(&mut self, moment: Moment) -> Option<Ready> {
        let before = self.reading.take();
        if let Some((pose, _)) = before.filter(|(_, of)| of.0 == moment.0) {
            return Some(Ready::Scan(Some(pose), moment));
        }
        let waited = self.scan.replace((moment, std::mem::take(&mut self.ranges_m)));
        let waited = waited.map(|scan| self.waited(scan, None));
        before.map(Ready::Reading).or(waited)
    }

    /// A scan that waited, with its ranges at hand.
    fn waited(&mut self, (moment, ranges_m): (Moment, Vec<f64>), odometry: Option<SE2>) -> Ready {
        self.ranges_m = ranges_m;
        Ready::Scan(odometry, moment)
    }

    /// What waited before this odometry, or a scan of its time.
    fn driven(&mut self, (pose, moment): (SE2, Moment)) -> Option<Ready> {
        let Some(scan) = self.scan.take() else {
            return self.reading.replace((pose, moment)).map(Ready::Reading);
        };
        let odometry = (scan.0.0 == moment.0).then_some(pose);
        if odometry.is_none() {
            self.reading = Some((pose, moment));
        }
        Some(self.waited(scan, odometry))
    }

    /// What waits at the end of the recording.
    fn last(&mut self) -> Option<Ready> {
        let scan = self.scan.take().map(|scan| self.waited(scan, None));
        scan.or_else(|| self.reading.take().map(Ready::Reading))
    }

    fn event(&self, ready: Ready) -> Event<'_> {
        match ready {
            Ready::Reading((pose, (stamp_s, line))) => Event::Reading { pose, stamp_s, line },
            Ready::Scan(odometry, (stamp_s, line)) => {
                let pose = truth_at(&self.choice.truth, stamp_s);
                Event::Scan { pose, odometry, stamp_s, ranges_m: &self.ranges_m, line }
            }
        }
    }
}

/// What can be told: nothing that follows belongs to it.
enum Ready {
    Reading((SE2, Moment)),
    /// The scan with the ranges at hand, and the odometry of its time.
    Scan(Option<SE2>, Moment),
}

impl Events for RosRecording {
    fn next_event(&mut self) -> Result<Option<Event<'_>>, ImportError> {
        let choice = Rc::clone(&self.choice);
        loop {
            let path = self.files.path.clone();
            let Some(message) = self.files.advance()? else {
                let last = self.last();
                return Ok(last.map(|ready| self.event(ready)));
            };
            let topic = &message.channel.topic;
            let ready = match &choice.beams {
                Some(beams) if beams.topic == *topic => {
                    let moment = ranges(&path, &message, beams, &mut self.ranges_m)?;
                    self.two_times += u64::from(moment.0 != message.log_s);
                    self.scanned(moment)
                }
                _ if choice.odometry.topic() == topic => {
                    let reading = odometry(&path, &message, &choice.odometry)?;
                    let two_times = reading.is_some_and(|(_, of)| of.0 != message.log_s);
                    self.two_times += u64::from(two_times);
                    reading.and_then(|reading| self.driven(reading))
                }
                _ => {
                    *self.skipped.entry(topic.clone()).or_default() += 1;
                    None
                }
            };
            if let Some(ready) = ready {
                return Ok(Some(self.event(ready)));
            }
        }
    }

    fn facts(&self) -> Facts<'_> {
        Facts {
            path: &self.files.path,
            line: self.files.number,
            two_times: self.two_times,
            skipped: &self.skipped,
        }
    }
}

/// The pose of a message of the odometry; `None`: it has other frames.
fn odometry(
    path: &str,
    message: &Message<'_>,
    source: &OdometrySource,
) -> Result<Option<(SE2, Moment)>, ImportError> {
    let found = match source {
        OdometrySource::Topic(_) => {
            let odometry: Odometry = decode(path, message)?;
            Some((SE2::from(odometry.pose.pose), odometry.header.stamp))
        }
        OdometrySource::Frames(_, child) => {
            let frames: TfMessage = decode(path, message)?;
            let mut moved = frames.transforms.into_iter();
            let moved = moved.find(|moved| frame(&moved.child_frame_id) == child);
            moved.map(|moved| (SE2::from(moved.transform), moved.header.stamp))
        }
    };
    let Some((pose, stamp)) = found else { return Ok(None) };
    // As far out as a pose of CARMEN may be.
    if !pose.is_finite() || pose.x().abs().max(pose.y().abs()) > 9e5 {
        let problem =
            format!("the odometry is at {pose:?}; shift the origin, or mend the recording");
        return Err(ImportError::line(path, message.number, problem));
    }
    Ok(Some((pose, (stamp_s(stamp, message), message.number))))
}

/// The ranges of a scan, m: the greatest range where nothing came back, and where there
/// is no valid range.
fn ranges(
    path: &str,
    message: &Message<'_>,
    beams: &Beams,
    ranges_m: &mut Vec<f64>,
) -> Result<Moment, ImportError> {
    let scan: LaserScan = decode(path, message)?;
    ranges_m.clear();
    let max_m = beams.lidar.range_max_m;
    let valid = |range_m: &f32| {
        let range_m = f64::from(*range_m);
        if range_m >= beams.range_min_m && range_m > 0.0 && range_m < max_m {
            range_m
        } else {
            max_m
        }
    };
    if scan.ranges.len() != beams.given {
        let problem = format!(
            "scan of {}: expected {} ranges, as in the first scan, got {}; convert the scans to \
             one length first, or name another topic with --scan",
            beams.topic,
            beams.given,
            scan.ranges.len()
        );
        return Err(ImportError::line(path, message.number, problem));
    }
    ranges_m.extend(scan.ranges[..beams.taken].iter().step_by(beams.every).map(valid));
    if beams.is_reversed {
        ranges_m.reverse();
    }
    Ok((stamp_s(scan.header.stamp, message), message.number))
}
