//! A log as a value.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::Path;

use super::{
    Ending, LogError, LogHeader, LogReader, LogWriter, Read as Step, TickRecord, TickRef, Trailer,
};

/// A complete log in memory: what a file holds from header to trailer.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Configuration, source of the frames, roster.
    pub header: LogHeader,
    /// The ticks, from tick 0 on.
    pub records: Vec<TickRecord>,
    /// Number of ticks and digests, of the records as they were made: with another record the
    /// log is not bit-exact.
    pub trailer: Trailer,
}

impl Log {
    /// Reads a log to its end from `input`; `path` is used in messages only.
    ///
    /// # Errors
    /// [`LogError`] names file, place and remedy. A log that is cut off or damaged is
    /// an error here; [`LogReader`] reads the ticks that it has.
    pub fn read(input: impl Read, path: &str) -> Result<Self, LogError> {
        Self::rest(LogReader::new(input, path)?, path)
    }

    /// Reads a log file to its end.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn load(path: &Path) -> Result<Self, LogError> {
        Self::rest(LogReader::<BufReader<File>>::open(path)?, &path.display().to_string())
    }

    fn rest<R: Read>(mut reader: LogReader<R>, path: &str) -> Result<Self, LogError> {
        let incomplete =
            |at_byte, problem| LogError::Incomplete { path: path.to_owned(), at_byte, problem };
        let mut records = Vec::new();
        loop {
            match reader.read()? {
                Step::Tick(entry) if entry.intact => records.push(entry.record),
                Step::Tick(entry) => {
                    let problem = format!("the checksum of tick {} fails", records.len());
                    return Err(incomplete(entry.at_byte, problem));
                }
                Step::End(Ending::Complete(trailer)) => {
                    return Ok(Self { header: reader.header().clone(), records, trailer });
                }
                Step::End(Ending::Cut { at_byte, problem, .. }) => {
                    return Err(incomplete(at_byte, problem));
                }
            }
        }
    }

    /// Writes the bytes of the log file to `out`, and returns it.
    ///
    /// # Errors
    /// [`LogError`] where `out` fails, or a record is too long.
    pub fn write<W: Write>(&self, out: W) -> Result<W, LogError> {
        self.write_to(out, Path::new("the log"))
    }

    fn write_to<W: Write>(&self, out: W, path: &Path) -> Result<W, LogError> {
        let mut writer = LogWriter::new(out, path, &self.header)?;
        for record in &self.records {
            writer.tick(TickRef::from(record))?;
        }
        writer.finish(self.trailer)
    }

    /// Writes the log to a file, which is complete or not there. A log of that name is
    /// replaced.
    ///
    /// # Errors
    /// [`LogError`] names the file.
    // There are no files and no process numbers in a browser.
    #[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
    pub fn save(&self, path: &Path) -> Result<(), LogError> {
        let io = |error| LogError::Io { path: path.display().to_string(), error };
        let file = crate::Replacement::of(path).map_err(io)?;
        let out = self.write_to(std::io::BufWriter::with_capacity(1 << 16, file), path)?;
        out.into_inner().map_err(|e| io(e.into_error()))?.commit(path).map_err(io)
    }
}
