//! One tick in a log, and the last line.

use rusty_geometry::{EncoderCounts, SE2, Twist};
use serde::{Deserialize, Serialize};

use crate::digest::RunDigest;
use crate::frame::{Frame, MAX_BEAMS};
use crate::readings::{OwnedReadings, Readings};
use crate::reply::Reply;
use crate::truth::TruthKey;

/// The content of a record, owned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Entry {
    /// A tick.
    Tick(TickRecord),
    /// The last line.
    End(Trailer),
    /// A tick with readings of small sensors: these first.
    Sensed(OwnedReadings, TickRecord),
}

impl Entry {
    /// Reads the body of a record; a tick comes with its readings in it. `None`: it cannot
    /// be decoded.
    pub(super) fn decode(body: &[u8]) -> Option<Self> {
        Some(match postcard::from_bytes(body).ok()? {
            Self::Sensed(readings, record) => Self::Tick(TickRecord { readings, ..record }),
            entry => entry,
        })
    }
}

/// The same, borrowed, for writing without a copy.
#[derive(Clone, Copy, Debug, Serialize)]
pub enum EntryRef<'a> {
    /// A tick.
    Tick(TickRef<'a>),
    /// The last line.
    End(Trailer),
}

/// A frame with its truth, and the replies to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickRecord {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// Time of the frame where it is not (tick + 1)·dt, s.
    pub stamp_s: Option<f64>,
    /// Cumulative encoder counts.
    pub ticks: EncoderCounts,
    /// Command applied in this tick.
    pub command: Twist,
    /// True pose in the world frame, where known: x m, y m, θ rad.
    pub truth: Option<[f64; 3]>,
    /// The scan, where there is one, m.
    pub ranges_m: Option<Vec<f64>>,
    /// Replies of the answering participants, in roster order.
    pub replies: Vec<Reply>,
    /// What the small sensors say. A record without any is written as one of a
    /// robot that has none.
    #[serde(skip)]
    pub readings: OwnedReadings,
}

/// A [`TickRecord`] in borrowed parts; the same bytes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TickRef<'a> {
    /// See [`TickRecord::tick`].
    pub tick: u64,
    /// See [`TickRecord::stamp_s`].
    pub stamp_s: Option<f64>,
    /// See [`TickRecord::ticks`].
    pub ticks: EncoderCounts,
    /// See [`TickRecord::command`].
    pub command: Twist,
    /// See [`TickRecord::truth`].
    pub truth: Option<[f64; 3]>,
    /// See [`TickRecord::ranges_m`].
    pub ranges_m: Option<&'a [f64]>,
    /// See [`TickRecord::replies`].
    pub replies: &'a [Reply],
    /// See [`TickRecord::readings`].
    #[serde(skip)]
    pub readings: Readings<'a>,
}

/// The last line of a complete log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trailer {
    /// How many ticks the log has.
    pub ticks: u64,
    /// Run digest over all of them.
    pub run_digest: [u8; 16],
    /// World digest over all of them.
    pub world_digest: [u8; 16],
}

impl<'a> TickRef<'a> {
    /// The record of a frame. `dt_s` is the run's; a frame whose time is the
    /// one it implies does not store it.
    #[must_use]
    pub fn new(frame: &'a Frame, truth: Option<SE2>, replies: &'a [Reply], dt_s: f64) -> Self {
        let implied = frame.tick().saturating_add(1) as f64 * dt_s;
        let stamped = frame.time_s().to_bits() != implied.to_bits();
        Self {
            tick: frame.tick(),
            stamp_s: stamped.then(|| frame.time_s()),
            ticks: frame.encoders(),
            command: frame.command(),
            truth: truth.map(|p| [p.x(), p.y(), p.theta()]),
            ranges_m: frame.ranges_m(),
            replies,
            readings: frame.readings(),
        }
    }

    /// Adds the bytes of [`EntryRef::Tick`] with this record to `body`. The
    /// derived encoding hands out a scan byte by byte; postcard sets a number of
    /// 8 bytes down as it is, least byte first, and so does this, all at once.
    pub(super) fn encode(&self, body: Vec<u8>) -> postcard::Result<Vec<u8>> {
        // The variant, then all before the scan: parts follow each other bare.
        let mut body = if self.readings.present().is_empty() {
            postcard::to_extend(&0u32, body)?
        } else {
            postcard::to_extend(&(2u32, self.readings.present(), self.readings.numbers()), body)?
        };
        let head = (self.tick, self.stamp_s, self.ticks, self.command, self.truth);
        body = postcard::to_extend(&head, body)?;
        match self.ranges_m {
            None => body.push(0),
            Some(ranges_m) => {
                body = postcard::to_extend(&(1u8, ranges_m.len() as u64), body)?;
                let start = body.len();
                body.resize(start + size_of_val(ranges_m), 0);
                for (place, range_m) in body[start..].as_chunks_mut().0.iter_mut().zip(ranges_m) {
                    *place = range_m.to_bits().to_le_bytes();
                }
            }
        }
        postcard::to_extend(self.replies, body)
    }
}

impl<'a> From<&'a TickRecord> for TickRef<'a> {
    fn from(record: &'a TickRecord) -> Self {
        Self {
            tick: record.tick,
            stamp_s: record.stamp_s,
            ticks: record.ticks,
            command: record.command,
            truth: record.truth,
            ranges_m: record.ranges_m.as_deref(),
            replies: &record.replies,
            readings: record.readings.get(),
        }
    }
}

impl From<TickRef<'_>> for TickRecord {
    fn from(record: TickRef<'_>) -> Self {
        Self {
            tick: record.tick,
            stamp_s: record.stamp_s,
            ticks: record.ticks,
            command: record.command,
            truth: record.truth,
            ranges_m: record.ranges_m.map(<[f64]>::to_vec),
            replies: record.replies.to_vec(),
            readings: record.readings.into(),
        }
    }
}

impl TickRecord {
    /// Time of the frame in a run with this `dt_s`.
    #[must_use]
    pub fn time_s(&self, dt_s: f64) -> f64 {
        self.stamp_s.unwrap_or_else(|| self.tick.saturating_add(1) as f64 * dt_s)
    }

    /// Checks what a checksum does not: that numbers are numbers, and that there
    /// are no more beams and replies than a frame and `answering` participants
    /// have. A range may be infinite: nothing came back.
    pub(super) fn check(&self, answering: usize) -> Result<(), String> {
        let numbers = [self.command.v_m_s, self.command.omega_rad_s];
        let others = self.truth.iter().flatten().chain(&self.stamp_s);
        if let Some(value) = numbers.iter().chain(others).find(|v| !v.is_finite()) {
            return Err(format!("a record holds {value} where a number belongs"));
        }
        let ranges_m = self.ranges_m.as_deref().unwrap_or_default();
        if ranges_m.len() > MAX_BEAMS {
            return Err(format!("a record has {} beams, at most {MAX_BEAMS} fit", ranges_m.len()));
        }
        if let Some(value) = ranges_m.iter().find(|r| r.is_nan() || **r < 0.0) {
            return Err(format!("a record holds the range {value}, which is no distance"));
        }
        self.readings.check()?;
        if self.replies.len() > answering {
            let count = self.replies.len();
            return Err(format!("a record has {count} replies of {answering} participants"));
        }
        self.replies.iter().try_for_each(Reply::check).map_err(|e| format!("a reply: {e}"))
    }

    /// True pose in the world frame, where known.
    #[must_use]
    pub fn pose_in_world(&self) -> Option<SE2> {
        self.truth.map(|[x, y, theta]| SE2::new(x, y, theta))
    }

    /// Writes the frame again as it was, sealed with `key`.
    pub fn write_frame(&self, frame: &mut Frame, dt_s: f64, key: &TruthKey) {
        self.write_unsealed(frame, dt_s);
        frame.seal(key, self.pose_in_world());
    }

    /// Writes all of the frame but digest and seal.
    pub fn write_unsealed(&self, frame: &mut Frame, dt_s: f64) {
        frame.begin(self.tick, self.time_s(dt_s), self.ticks, self.command);
        let readings = self.readings.get();
        frame.write_readings(readings.present(), readings.numbers());
        if let Some(ranges) = &self.ranges_m {
            let place = frame.write_scan(ranges.len());
            let n = place.len();
            place.copy_from_slice(&ranges[..n]);
        }
    }

    /// Absorbs the tick, as server and logger do. `frame` is the one that
    /// [`write_frame`](Self::write_frame) wrote.
    pub fn absorb(&self, frame: &Frame, digest: &mut RunDigest) {
        digest.absorb_frame(frame, self.pose_in_world());
        digest.absorb_replies(self.replies.iter().copied());
    }
}
