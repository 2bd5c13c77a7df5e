//! The run on disk.
//!
//! ```text
//! magic     8 bytes   "RUSTYLOG"
//! version   u32 LE    1
//! length    u32 LE    of the header
//! checksum  u32 LE    CRC-32 of the header
//! header    JSON      LogHeader: configuration, source of the commands, roster, writer
//! record*             one per tick
//! trailer             tick count and digests
//! ```
//!
//! Record and trailer share a frame: length of the body (LEB128, at most 3
//! bytes), CRC-32 of the body (4 bytes, little-endian), body ([postcard] of
//! [`Entry`]). Nothing in a log names a process, a clock or a machine: the
//! same seed gives the same bytes.
//!
//! A log is written as the run goes. Cut anywhere, it reads up to its last
//! complete tick and says so; a record whose checksum fails is still decoded
//! if it can be, and marked.
//!
//! [postcard]: https://postcard.jamesmunns.com/wire-format

mod finding;
mod header;
mod reader;
mod record;
mod whole;
mod writer;

#[cfg(test)]
mod tests;

pub use finding::Finding;
pub(crate) use header::RECORDING;
pub use header::{LogHeader, Source};
pub use reader::{Ending, LogReader, Read, ReadEntry};
pub use record::{Entry, EntryRef, TickRecord, TickRef, Trailer};
pub use whole::Log;
pub use writer::LogWriter;

use std::io;

use thiserror::Error;

/// The first eight bytes.
pub const MAGIC: &[u8; 8] = b"RUSTYLOG";
/// The version of the format.
pub const VERSION: u32 = 1;
/// Longest header that is read, bytes.
pub const MAX_HEADER_BYTES: u32 = 64 << 20;
/// Longest record that is written or read, bytes.
pub const MAX_RECORD_BYTES: usize = 1 << 16;

/// Why a log cannot be read or written at all.
#[derive(Debug, Error)]
pub enum LogError {
    /// The operating system says no.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: String,
        /// What it said.
        error: io::Error,
    },
    /// The file is something else.
    #[error(
        "{path}: this is no run log (it does not start with RUSTYLOG); `sim-server import` makes one from a CARMEN log"
    )]
    NotALog {
        /// The file.
        path: String,
    },
    /// A version that this build does not know.
    #[error(
        "{path}: log format {found}, this build reads {VERSION}; use the version that wrote it"
    )]
    Version {
        /// The file.
        path: String,
        /// What it says.
        found: u32,
    },
    /// The header is cut off or damaged.
    #[error(
        "{path}: header, byte {at}: {problem}; without its header a log cannot be read: restore the file"
    )]
    Header {
        /// The file.
        path: String,
        /// Where.
        at: u64,
        /// What is wrong.
        problem: String,
    },
    /// The log ends before its run does, or a record is damaged.
    #[error(
        "{path}: expected a complete log, got one that ends at byte {at_byte}: {problem}; \
         `sim-server verify` names the ticks that can be read"
    )]
    Incomplete {
        /// The file.
        path: String,
        /// Where it cannot be read on, bytes.
        at_byte: u64,
        /// What was found there.
        problem: String,
    },
    /// A record does not fit the format.
    #[error("a record of {bytes} bytes does not fit into a log (at most {MAX_RECORD_BYTES})")]
    TooLong {
        /// How long it is.
        bytes: usize,
    },
}
