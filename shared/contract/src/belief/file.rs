//! Beliefs in a file: what a filter showed while it worked on a log.
//!
//! ```text
//! magic     8 bytes   "RUSTYBEL"
//! version   u32 LE    1
//! length    u32 LE    of the header
//! checksum  u32 LE    CRC-32 of the header
//! header    JSON      BeliefFileHeader: who wrote it, name of the filter, scenario
//! moment*             one per belief, ticks growing
//! end                 a moment of kind 0 without poses; its tick is their number
//! ```
//!
//! A moment, little-endian throughout:
//!
//! ```text
//! tick        u64     after which the filter held this
//! observable  u64     of that tick's frame, by which it is found to belong to a log
//! kind        u32     1 particles, 2 histogram, 0 the end
//! whole       u32     poses the filter had
//! count       u32     poses that follow, at most 20,000
//! checksum    u32     CRC-32 of the 28 bytes before it and the poses
//! poses       32 bytes each: x m, y m, θ rad, weight, as f64
//! ```
//!
//! Nothing in it names a clock, a process or a machine: the same filter on the
//! same log gives the same bytes.

use std::io::{self, Read, Write};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{BeliefKind, MAX_POSES, WeightedPose};
use crate::json::{Json as _, json};

const MAGIC: &[u8; 8] = b"RUSTYBEL";
const VERSION: u32 = 1;
/// Longest header that is read, bytes.
const MAX_HEADER_BYTES: u32 = 1 << 16;
/// Bytes of a moment before its poses.
const FRONT_BYTES: usize = 32;

/// The file, next to a log, with what this participant showed.
#[must_use]
pub fn file_name(participant: &str) -> String {
    format!("{participant}.beliefs")
}

/// What a file of beliefs says of itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeliefFileHeader {
    /// The program that wrote it.
    pub writer: String,
    /// What the filter was called.
    pub name: String,
    /// Scenario of the log it worked on.
    pub scenario: String,
}

/// Why a file of beliefs cannot be read or written.
#[derive(Debug, Error)]
pub enum BeliefFileError {
    /// The operating system says no.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The bytes are something else.
    #[error(
        "this is no file of beliefs (it does not start with RUSTYBEL); give one that a filter \
         wrote with `--log LOG --beliefs FILE`"
    )]
    NotBeliefs,
    /// A version that this build does not know.
    #[error("format {0} of beliefs, this build reads {VERSION}; use the version that wrote it")]
    Version(u32),
    /// A part of it is not what was written.
    #[error("byte {at}: {problem}; write the file again with the filter's --beliefs")]
    Damaged {
        /// Where, bytes.
        at: u64,
        /// What is wrong.
        problem: String,
    },
}

/// What [`BeliefReader::next`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found<'a> {
    /// A belief.
    Moment {
        /// The tick after which the filter held it.
        tick: u64,
        /// [`observable_of`](crate::digest::observable_of) of that tick's frame.
        observable: u64,
        /// What the poses are.
        kind: BeliefKind,
        /// How many the filter had.
        whole: u32,
        /// The poses.
        poses: &'a [WeightedPose],
    },
    /// The end: nothing is missing.
    End,
    /// The file ends where no end was written: its writer was cut short.
    Cut,
}

json!(BeliefFileHeader);

/// Writes beliefs. [`finish`](Self::finish) writes the end.
pub struct BeliefWriter<W: Write> {
    out: W,
    moments: u64,
}

impl<W: Write> BeliefWriter<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// [`BeliefFileError::Io`].
    pub fn new(mut out: W, header: &BeliefFileHeader) -> Result<Self, BeliefFileError> {
        let json = header.to_json().map_err(io::Error::from)?;
        if json.len() > MAX_HEADER_BYTES as usize {
            let text =
                format!("a header of {} bytes is longer than {MAX_HEADER_BYTES}", json.len());
            return Err(io::Error::other(text).into());
        }
        out.write_all(MAGIC)?;
        for word in [VERSION, json.len() as u32, crc32fast::hash(&json)] {
            out.write_all(&word.to_le_bytes())?;
        }
        out.write_all(&json)?;
        Ok(Self { out, moments: 0 })
    }

    /// Writes a belief whose poses [`tidy`](super::tidy) has seen.
    ///
    /// # Errors
    /// [`BeliefFileError::Io`] when the disk is full, for instance.
    pub fn moment(
        &mut self,
        (tick, observable): (u64, u64),
        (kind, whole): (BeliefKind, u32),
        poses: &[WeightedPose],
    ) -> Result<(), BeliefFileError> {
        let poses = &poses[..poses.len().min(MAX_POSES)];
        self.moments += 1;
        self.put(tick, observable, [kind.number(), whole, poses.len() as u32], poses)
    }

    fn put(
        &mut self,
        tick: u64,
        observable: u64,
        words: [u32; 3],
        poses: &[WeightedPose],
    ) -> Result<(), BeliefFileError> {
        let mut front = Vec::with_capacity(FRONT_BYTES);
        front.extend(tick.to_le_bytes());
        front.extend(observable.to_le_bytes());
        words.iter().for_each(|word| front.extend(word.to_le_bytes()));
        let poses = bytemuck::cast_slice(poses);
        front.extend(checksum(&front, poses).to_le_bytes());
        self.out.write_all(&front)?;
        self.out.write_all(poses)?;
        Ok(())
    }

    /// How many beliefs were written.
    #[must_use]
    pub fn moments(&self) -> u64 {
        self.moments
    }

    /// Writes the end and hands everything to the operating system.
    ///
    /// # Errors
    /// [`BeliefFileError::Io`] when the disk is full, for instance.
    pub fn finish(mut self) -> Result<W, BeliefFileError> {
        self.put(self.moments, 0, [0; 3], &[])?;
        self.out.flush()?;
        Ok(self.out)
    }
}

fn checksum(front: &[u8], poses: &[u8]) -> u32 {
    let mut state = crc32fast::Hasher::new();
    state.update(front);
    state.update(poses);
    state.finalize()
}

/// Reads beliefs. Memory is that of one of them, whatever the bytes claim.
pub struct BeliefReader<R: Read> {
    input: R,
    header: BeliefFileHeader,
    at: u64,
    next_tick: u64,
    moments: u64,
    poses: Vec<WeightedPose>,
}

impl<R: Read> BeliefReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`BeliefFileError`] says what the bytes are instead.
    pub fn new(mut input: R) -> Result<Self, BeliefFileError> {
        let mut front = [0; 20];
        let got = fill(&mut input, &mut front)?;
        if got < 8 || &front[..8] != MAGIC {
            return Err(BeliefFileError::NotBeliefs);
        }
        let damaged =
            |at: u64, problem: &str| BeliefFileError::Damaged { at, problem: problem.to_owned() };
        if got < front.len() {
            return Err(damaged(got as u64, "the file ends within its header"));
        }
        let [version, length, sum] = [8, 12, 16].map(|i| word(&front, i));
        if version != VERSION {
            return Err(BeliefFileError::Version(version));
        }
        if length > MAX_HEADER_BYTES {
            return Err(damaged(12, &format!("a header of {length} bytes is not credible")));
        }
        let mut json = vec![0; length as usize];
        if fill(&mut input, &mut json)? < json.len() {
            return Err(damaged(20, "the file ends within its header"));
        }
        if crc32fast::hash(&json) != sum {
            return Err(damaged(20, "the checksum of the header fails"));
        }
        let header = BeliefFileHeader::from_json(&json).map_err(|e| damaged(20, &e.to_string()))?;
        let at = 20 + u64::from(length);
        Ok(Self { input, header, at, next_tick: 0, moments: 0, poses: Vec::new() })
    }

    /// What the file says of itself.
    #[must_use]
    pub fn header(&self) -> &BeliefFileHeader {
        &self.header
    }

    /// The next belief, or the end.
    ///
    /// # Errors
    /// [`BeliefFileError::Damaged`] names the place; what came before it is
    /// good.
    #[allow(clippy::should_implement_trait)] // a belief borrows the reader
    pub fn next(&mut self) -> Result<Found<'_>, BeliefFileError> {
        let mut front = [0; FRONT_BYTES];
        if fill(&mut self.input, &mut front)? < front.len() {
            return Ok(Found::Cut);
        }
        let [kind, whole, count, sum] = [16, 20, 24, 28].map(|i| word(&front, i));
        if count as usize > MAX_POSES {
            let problem = format!("{count} poses are more than the {MAX_POSES} of a belief");
            return Err(self.damaged(problem));
        }
        self.poses.clear();
        self.poses.resize(count as usize, bytemuck::Zeroable::zeroed());
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut self.poses);
        if fill(&mut self.input, bytes)? < bytes.len() {
            return Ok(Found::Cut);
        }
        if checksum(&front[..28], bytes) != sum {
            return Err(self.damaged("the checksum of a belief fails".to_owned()));
        }
        let [tick, observable] =
            [0, 8].map(|i| u64::from(word(&front, i)) | u64::from(word(&front, i + 4)) << 32);
        if kind == 0 {
            return match tick == self.moments {
                true => Ok(Found::End),
                false => Err(self.damaged(format!("{} of {tick} beliefs are here", self.moments))),
            };
        }
        let Some(kind) = BeliefKind::of_number(kind) else {
            return Err(self.damaged(format!("a belief of kind {kind}")));
        };
        if tick < self.next_tick || !self.poses.iter().all(super::can_be_shown) {
            return Err(self.damaged(format!("tick {tick}: out of order, or poses that are none")));
        }
        self.at += (FRONT_BYTES + 32 * self.poses.len()) as u64;
        self.next_tick = tick.saturating_add(1);
        self.moments += 1;
        Ok(Found::Moment { tick, observable, kind, whole, poses: &self.poses })
    }

    fn damaged(&self, problem: String) -> BeliefFileError {
        BeliefFileError::Damaged { at: self.at, problem }
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// Fills a buffer as far as there are bytes, and says how far.
fn fill(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut got = 0;
    while got < buffer.len() {
        match input.read(&mut buffer[got..]) {
            Ok(0) => break,
            Ok(n) => got += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(got)
}

#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
