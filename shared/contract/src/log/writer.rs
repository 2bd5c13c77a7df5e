//! Writing a log as the run goes.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::{EntryRef, LogError, LogHeader, MAGIC, MAX_RECORD_BYTES, TickRef, Trailer, VERSION};
use crate::json::Json as _;

/// Writes header, records and trailer. Records are buffered; call
/// [`flush`](Self::flush) when the run pauses, and [`finish`](Self::finish) at
/// its end.
pub struct LogWriter<W: Write = BufWriter<File>> {
    path: PathBuf,
    out: W,
    /// The entry being written, after room for what stands before its body.
    /// Reused, so that a tick allocates nothing.
    entry: Vec<u8>,
}

/// Most bytes before a body: its length and its checksum.
const FRONT: usize = 3 + 4;

impl LogWriter {
    /// Creates the file and writes the header.
    ///
    /// # Errors
    /// [`LogError::Io`] names the file.
    pub fn create(path: &Path, header: &LogHeader) -> Result<Self, LogError> {
        let file = File::create(path)
            .map_err(|error| LogError::Io { path: path.display().to_string(), error })?;
        Self::new(BufWriter::with_capacity(1 << 16, file), path, header)
    }
}

impl<W: Write> LogWriter<W> {
    /// Writes the header to `out`; `path` is used in messages only.
    ///
    /// # Errors
    /// [`LogError`] names the file.
    pub fn new(out: W, path: &Path, header: &LogHeader) -> Result<Self, LogError> {
        let mut log = Self { path: path.to_owned(), out, entry: Vec::with_capacity(1 << 12) };
        let json = header.to_json().map_err(|e| log.io(e.into()))?;
        if json.len() > super::MAX_HEADER_BYTES as usize {
            return Err(LogError::TooLong { bytes: json.len() });
        }
        let mut start = Vec::with_capacity(json.len() + 20);
        start.extend_from_slice(MAGIC);
        start.extend_from_slice(&VERSION.to_le_bytes());
        start.extend_from_slice(&(json.len() as u32).to_le_bytes());
        start.extend_from_slice(&crc32fast::hash(&json).to_le_bytes());
        start.extend_from_slice(&json);
        log.out.write_all(&start).map_err(|e| log.io(e))?;
        Ok(log)
    }

    fn io(&self, error: std::io::Error) -> LogError {
        LogError::Io { path: self.path.display().to_string(), error }
    }

    /// Writes a tick, in one call to what is written to.
    ///
    /// # Errors
    /// [`LogError::Io`] when the disk is full, for instance.
    pub fn tick(&mut self, record: TickRef<'_>) -> Result<(), LogError> {
        self.entry(|body| record.encode(body))
    }

    fn entry(
        &mut self,
        encode: impl FnOnce(Vec<u8>) -> postcard::Result<Vec<u8>>,
    ) -> Result<(), LogError> {
        let mut entry = std::mem::take(&mut self.entry);
        entry.clear();
        entry.resize(FRONT, 0);
        self.entry = encode(entry).map_err(|e| self.io(std::io::Error::other(e.to_string())))?;
        let (front, body) = self.entry.split_at_mut(FRONT);
        if body.len() > MAX_RECORD_BYTES {
            return Err(LogError::TooLong { bytes: body.len() });
        }
        let checksum = crc32fast::hash(body).to_le_bytes();
        let mut length = [0; 3];
        let n = leb128(body.len(), &mut length);
        let start = FRONT - 4 - n;
        front[start..FRONT - 4].copy_from_slice(&length[..n]);
        front[FRONT - 4..].copy_from_slice(&checksum);
        self.out.write_all(&self.entry[start..]).map_err(|e| self.io(e))
    }

    /// What the bytes go to.
    #[must_use]
    pub fn output(&self) -> &W {
        &self.out
    }

    /// Hands everything written so far to the operating system.
    ///
    /// # Errors
    /// [`LogError::Io`] when the disk is full, for instance.
    pub fn flush(&mut self) -> Result<(), LogError> {
        self.out
            .flush()
            .map_err(|e| LogError::Io { path: self.path.display().to_string(), error: e })
    }

    /// Writes the last line and hands everything to the operating system.
    ///
    /// # Errors
    /// [`LogError::Io`] when the disk is full, for instance.
    pub fn finish(mut self, trailer: Trailer) -> Result<W, LogError> {
        self.entry(|body| postcard::to_extend(&EntryRef::End(trailer), body))?;
        self.flush()?;
        Ok(self.out)
    }
}

/// Writes `value` (below 2^21) as LEB128 and says how many bytes it took.
fn leb128(mut value: usize, out: &mut [u8; 3]) -> usize {
    let mut n = 0;
    loop {
        let low = (value & 0x7F) as u8;
        value >>= 7;
        out[n] = if value == 0 { low } else { low | 0x80 };
        n += 1;
        if value == 0 {
            return n;
        }
    }
}
