//! The key of a blind log: what sealing took away.
//!
//! ```text
//! magic     8 bytes   "RUSTYKEY"
//! version   u32 LE    1
//! length    u64 LE    of the body
//! checksum  u64 LE    XXH3-64 of the body
//! body      postcard  the header in JSON, digests, a line per tick
//! ```

use serde::{Deserialize, Serialize};
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

use crate::digest::{ObservableDigest, observable_of};
use crate::frame::Frame;
use crate::json::Json as _;
use crate::log::LogHeader;

const MAGIC: &[u8; 8] = b"RUSTYKEY";
const VERSION: u32 = 1;
/// Magic, version, length, checksum.
const FRONT_BYTES: usize = 28;

/// What sealing took out of a log. Its `Debug` shows no truth.
#[derive(Clone, PartialEq)]
pub struct BlindKey {
    /// The header as it was.
    pub header: LogHeader,
    /// Run digest of the log as it was; `None` if it had no end.
    pub run_digest: Option<[u8; 16]>,
    /// World digest of the log as it was; `None` if it had no end.
    pub world_digest: Option<[u8; 16]>,
    /// Observable digest of all its frames.
    pub observable_digest: [u8; 16],
    /// One per tick.
    pub ticks: Vec<KeyTick>,
}

/// One tick of a key.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KeyTick {
    /// The frame's observable part, hashed: see [`observable_of`].
    pub observable: u64,
    /// True pose in the world frame, where known: x m, y m, θ rad.
    pub truth: Option<[f64; 3]>,
}

#[derive(Serialize, Deserialize)]
struct Body {
    /// JSON, as in a log: it is read by name.
    header: Vec<u8>,
    run_digest: Option<[u8; 16]>,
    world_digest: Option<[u8; 16]>,
    observable_digest: [u8; 16],
    ticks: Vec<KeyTick>,
}

/// Why a key cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BlindKeyError {
    /// The bytes are something else.
    #[error(
        "this is no key of a blind log (it does not start with RUSTYKEY); give the file that \
         `sim-server seal` wrote with --key-file"
    )]
    NotAKey,
    /// A version that this build does not know.
    #[error("key format {0}, this build reads {VERSION}; use the version that wrote it")]
    Version(u32),
    /// The file is shorter or longer than it says.
    #[error(
        "the key has {found} bytes and should have {expected}; it was cut or added to: restore it"
    )]
    Length {
        /// Bytes that there are.
        found: u64,
        /// Bytes that there should be.
        expected: u64,
    },
    /// A bit of it is another.
    #[error("the key's checksum fails; it is not what was written: restore it")]
    Damaged,
    /// It cannot be decoded, or not be written.
    #[error("the key cannot be read or written: {0}")]
    Content(String),
    /// A frame of the log is none of the key's.
    #[error(
        "the key is not of this log: the frame of tick {tick} is another{}",
        if *tick == 0 { "" } else { ", those before it are the same" }
    )]
    OtherFrame {
        /// The first such tick.
        tick: u64,
    },
    /// The log goes on where the key ends.
    #[error("the key is not of this log: the key has {ticks} ticks, the log has more")]
    Longer {
        /// Ticks of the key.
        ticks: u64,
    },
}

impl std::fmt::Debug for BlindKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BlindKey({} ticks, hidden)", self.ticks.len())
    }
}

impl BlindKey {
    /// The key as bytes, for a file.
    ///
    /// # Errors
    /// [`BlindKeyError::Content`] if a number in the header is none.
    pub fn to_bytes(&self) -> Result<Vec<u8>, BlindKeyError> {
        let content = |e: &dyn std::fmt::Display| BlindKeyError::Content(e.to_string());
        let body = Body {
            header: self.header.to_json().map_err(|e| content(&e))?,
            run_digest: self.run_digest,
            world_digest: self.world_digest,
            observable_digest: self.observable_digest,
            ticks: self.ticks.clone(),
        };
        let body = postcard::to_stdvec(&body).map_err(|e| content(&e))?;
        let mut bytes = Vec::with_capacity(FRONT_BYTES + body.len());
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&xxh3_64(&body).to_le_bytes());
        bytes.extend_from_slice(&body);
        Ok(bytes)
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// [`BlindKeyError`] says what the bytes are instead.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, BlindKeyError> {
        let (magic, rest) = bytes.split_at_checked(8).ok_or(BlindKeyError::NotAKey)?;
        if magic != MAGIC {
            return Err(BlindKeyError::NotAKey);
        }
        let found = bytes.len() as u64;
        let front = BlindKeyError::Length { found, expected: FRONT_BYTES as u64 };
        let (version, rest) = rest.split_first_chunk::<4>().ok_or(front.clone())?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            return Err(BlindKeyError::Version(version));
        }
        let (length, rest) = rest.split_first_chunk::<8>().ok_or(front.clone())?;
        let (checksum, body) = rest.split_first_chunk::<8>().ok_or(front)?;
        let length = u64::from_le_bytes(*length);
        if length != body.len() as u64 {
            let expected = length.saturating_add(FRONT_BYTES as u64);
            return Err(BlindKeyError::Length { found, expected });
        }
        if u64::from_le_bytes(*checksum) != xxh3_64(body) {
            return Err(BlindKeyError::Damaged);
        }
        let content = |e: &dyn std::fmt::Display| BlindKeyError::Content(e.to_string());
        let body: Body = postcard::from_bytes(body).map_err(|e| content(&e))?;
        let header = LogHeader::from_json(&body.header).map_err(|e| content(&e))?;
        Ok(Self {
            header,
            run_digest: body.run_digest,
            world_digest: body.world_digest,
            observable_digest: body.observable_digest,
            ticks: body.ticks,
        })
    }

    /// Adds the next tick while a log is being sealed; `digest` is the
    /// observable digest of the ticks so far.
    pub fn push(&mut self, frame: &Frame, truth: Option<[f64; 3]>, digest: &mut ObservableDigest) {
        digest.absorb(frame);
        self.observable_digest = digest.value();
        self.ticks.push(KeyTick { observable: observable_of(frame), truth });
    }

    /// The truth of tick `tick`, if `frame` is the frame that the key has there.
    ///
    /// # Errors
    /// [`BlindKeyError`] names the tick otherwise.
    pub fn truth_of(&self, tick: u64, frame: &Frame) -> Result<Option<[f64; 3]>, BlindKeyError> {
        let place = usize::try_from(tick).ok().and_then(|i| self.ticks.get(i));
        let ticks = self.ticks.len() as u64;
        let found = place.ok_or(BlindKeyError::Longer { ticks })?;
        if found.observable != observable_of(frame) {
            return Err(BlindKeyError::OtherFrame { tick });
        }
        Ok(found.truth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scenario, TruthKey};
    use rusty_geometry::{EncoderCounts, Twist};

    fn frame(tick: u64) -> Box<Frame> {
        let mut frame = Frame::boxed();
        frame.begin(tick, 0.1, EncoderCounts::default(), Twist::default());
        frame.seal(&TruthKey::from_bytes([0; 32]), None);
        frame
    }

    fn key() -> BlindKey {
        let scenario = Scenario { seed: u64::MAX, dt_s: 0.1 + 0.2, ..Scenario::default() };
        let world = rusty_geometry::places::apartment().spec().clone();
        let mut key = BlindKey {
            header: LogHeader::simulated("test", &scenario, world),
            run_digest: Some([1; 16]),
            world_digest: None,
            observable_digest: [0; 16],
            ticks: Vec::new(),
        };
        let mut digest = ObservableDigest::default();
        key.push(&frame(0), Some([1.5, -0.0, f64::MIN_POSITIVE]), &mut digest);
        key.push(&frame(1), None, &mut digest);
        key
    }

    #[test]
    fn a_key_survives_its_bytes_and_no_other_bytes_are_one() {
        let key = key();
        let bytes = key.to_bytes().unwrap();
        assert_eq!(BlindKey::from_bytes(&bytes).unwrap(), key);
        assert_eq!(format!("{key:?}"), "BlindKey(2 ticks, hidden)");
        for at in 0..bytes.len() {
            assert!(BlindKey::from_bytes(&bytes[..at]).is_err(), "cut at {at}");
            let mut flipped = bytes.clone();
            flipped[at] ^= 1;
            assert!(BlindKey::from_bytes(&flipped).is_err(), "flipped at {at}");
        }
        let longer = [&bytes[..], &[0]].concat();
        let error = BlindKey::from_bytes(&longer).unwrap_err().to_string();
        let n = bytes.len();
        assert!(error.contains(&format!("{} bytes and should have {n}", n + 1)), "{error}");
        assert_eq!(BlindKey::from_bytes(b"RUSTYLOG"), Err(BlindKeyError::NotAKey));
    }

    #[test]
    fn a_truth_belongs_to_its_frame() {
        let key = key();
        assert_eq!(key.truth_of(0, &frame(0)), Ok(Some([1.5, -0.0, f64::MIN_POSITIVE])));
        assert_eq!(key.truth_of(1, &frame(1)), Ok(None));
        assert_eq!(key.truth_of(1, &frame(0)), Err(BlindKeyError::OtherFrame { tick: 1 }));
        assert_eq!(key.truth_of(2, &frame(2)), Err(BlindKeyError::Longer { ticks: 2 }));
    }
}
