//! Reading a log, however it ends.

use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::Path;

use super::{Entry, LogError, LogHeader, MAGIC, MAX_HEADER_BYTES, MAX_RECORD_BYTES, TickRecord};
use super::{Trailer, VERSION};
use crate::json::Json as _;

/// Reads a log from its start to wherever it ends.
pub struct LogReader<R: std::io::Read = BufReader<File>> {
    path: String,
    input: R,
    header: LogHeader,
    at: u64,
    next_tick: u64,
    ending: Option<Ending>,
    damaged: u64,
    body: Vec<u8>,
}

/// A record, and whether it is what was written.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadEntry {
    /// The tick.
    pub record: TickRecord,
    /// Where in the file its record begins, bytes.
    pub at_byte: u64,
    /// Its checksum holds. If not, the record decoded all the same, but some
    /// bit of it is not what was written.
    pub intact: bool,
}

/// One step of reading.
#[derive(Clone, Debug, PartialEq)]
pub enum Read {
    /// A tick.
    Tick(ReadEntry),
    /// No more ticks, and why.
    End(Ending),
}

/// How a log ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// With its trailer: nothing is missing.
    Complete(Trailer),
    /// Without one: it was cut off, or damaged beyond reading.
    Cut {
        /// Complete ticks before the end.
        ticks: u64,
        /// Where reading stopped, bytes.
        at_byte: u64,
        /// What was found there.
        problem: String,
    },
}

/// Many name the folder of a run.
const FOLDER: &str = "Is a directory; the log of a run is run.log in its folder";

impl LogReader {
    /// Opens a log and reads its header.
    ///
    /// # Errors
    /// [`LogError`] names file, place and remedy.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let name = path.display().to_string();
        let open = match path.is_dir() {
            true => Err(std::io::Error::new(std::io::ErrorKind::IsADirectory, FOLDER)),
            false => crate::input::open(path),
        };
        let file = open.map_err(|error| LogError::Io { path: name.clone(), error })?;
        Self::new(BufReader::with_capacity(1 << 16, file), &name)
    }
}

impl<R: std::io::Read> LogReader<R> {
    /// Reads the header from `input`; `path` is used in messages.
    ///
    /// # Errors
    /// [`LogError`] names file, place and remedy.
    pub fn new(mut input: R, path: &str) -> Result<Self, LogError> {
        let path = path.to_owned();
        let mut front = [0u8; 20];
        let got = fill(&mut input, &mut front)
            .map_err(|error| LogError::Io { path: path.clone(), error })?;
        if !front[..got].starts_with(&MAGIC[..got.min(8)]) || got == 0 {
            return Err(LogError::NotALog { path });
        }
        let cut = |at: u64| LogError::Header {
            path: path.clone(),
            at,
            problem: "the file ends here".to_owned(),
        };
        if got < front.len() {
            return Err(cut(got as u64));
        }
        let word =
            |i: usize| u32::from_le_bytes([front[i], front[i + 1], front[i + 2], front[i + 3]]);
        if word(8) != VERSION {
            return Err(LogError::Version { path, found: word(8) });
        }
        let bad = |problem: String| LogError::Header { path: path.clone(), at: 20, problem };
        if word(12) > MAX_HEADER_BYTES {
            return Err(bad(format!("a length of {} bytes is not credible", word(12))));
        }
        // Read through `take`, so that memory follows what is there, not what
        // a damaged length claims.
        let mut json = Vec::new();
        let read = (&mut input).take(u64::from(word(12))).read_to_end(&mut json);
        read.map_err(|error| LogError::Io { path: path.clone(), error })?;
        if json.len() < word(12) as usize {
            return Err(cut(20 + json.len() as u64));
        }
        if crc32fast::hash(&json) != word(16) {
            return Err(bad("its checksum fails".to_owned()));
        }
        let header = LogHeader::from_json(&json).map_err(|e| bad(e.to_string()))?;
        header.check().map_err(|e| bad(e.to_string()))?;
        let at = 20 + json.len() as u64;
        let body = Vec::with_capacity(1 << 12);
        Ok(Self { path, input, header, at, next_tick: 0, ending: None, damaged: 0, body })
    }

    /// What the log says of its run.
    #[must_use]
    pub fn header(&self) -> &LogHeader {
        &self.header
    }

    /// Records so far whose checksum failed.
    #[must_use]
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// The next tick, or the end. After the end, the end again.
    ///
    /// # Errors
    /// [`LogError::Io`] if the operating system fails to read; a log that is
    /// cut or damaged is no error but an [`Ending`].
    pub fn read(&mut self) -> Result<Read, LogError> {
        if let Some(ending) = &self.ending {
            return Ok(Read::End(ending.clone()));
        }
        match self.entry()? {
            Ok(Read::End(ending)) => self.end(ending),
            Ok(tick) => Ok(tick),
            Err(problem) => {
                let cut = Ending::Cut { ticks: self.next_tick, at_byte: self.at, problem };
                self.end(cut)
            }
        }
    }

    fn end(&mut self, ending: Ending) -> Result<Read, LogError> {
        self.ending = Some(ending.clone());
        Ok(Read::End(ending))
    }

    fn fill(&mut self, buffer: &mut [u8]) -> Result<usize, LogError> {
        fill(&mut self.input, buffer)
            .map_err(|error| LogError::Io { path: self.path.clone(), error })
    }

    /// Length of the next body and length of the length, bytes.
    fn length(&mut self) -> Result<Result<(usize, usize), String>, LogError> {
        let mut length = 0usize;
        for i in 0..3 {
            let mut byte = [0];
            if self.fill(&mut byte)? == 0 {
                let what = if i == 0 { "the file ends without a trailer" } else { CUT };
                return Ok(Err(what.to_owned()));
            }
            length |= usize::from(byte[0] & 0x7F) << (7 * i);
            if byte[0] & 0x80 == 0 {
                if length == 0 || length > MAX_RECORD_BYTES {
                    return Ok(Err(format!("a record of {length} bytes is not credible")));
                }
                return Ok(Ok((length, i + 1)));
            }
        }
        Ok(Err("a record's length is not credible".to_owned()))
    }

    fn entry(&mut self) -> Result<Result<Read, String>, LogError> {
        let (length, front) = match self.length()? {
            Ok(lengths) => lengths,
            Err(problem) => return Ok(Err(problem)),
        };
        let mut checksum = [0u8; 4];
        if self.fill(&mut checksum)? < 4 {
            return Ok(Err(CUT.to_owned()));
        }
        let mut body = std::mem::take(&mut self.body);
        body.resize(length, 0);
        let got = self.fill(&mut body)?;
        let intact = got == length && crc32fast::hash(&body) == u32::from_le_bytes(checksum);
        let entry = Entry::decode(&body[..got]);
        self.body = body;
        if got < length {
            return Ok(Err(CUT.to_owned()));
        }
        let at_byte = self.at;
        let read = match entry {
            None | Some(Entry::Sensed(..)) => {
                return Ok(Err("a record cannot be decoded".to_owned()));
            }
            Some(Entry::Tick(record)) => {
                if record.tick != self.next_tick && intact {
                    let (found, expected) = (record.tick, self.next_tick);
                    return Ok(Err(format!("tick {found} stands where tick {expected} should")));
                }
                let answering = self.header.answering().count();
                if let (true, Err(problem)) = (intact, record.check(answering)) {
                    return Ok(Err(problem));
                }
                self.next_tick += 1;
                self.damaged += u64::from(!intact);
                Read::Tick(ReadEntry { record, at_byte, intact })
            }
            Some(Entry::End(trailer)) if intact && trailer.ticks == self.next_tick => {
                if self.fill(&mut [0])? > 0 {
                    return Ok(Err("the file goes on after its trailer".to_owned()));
                }
                Read::End(Ending::Complete(trailer))
            }
            Some(Entry::End(trailer)) if intact => {
                let (said, found) = (trailer.ticks, self.next_tick);
                return Ok(Err(format!("the trailer counts {said} ticks, the log has {found}")));
            }
            Some(Entry::End(_)) => return Ok(Err("the trailer's checksum fails".to_owned())),
        };
        self.at += (front + 4 + length) as u64;
        Ok(Ok(read))
    }
}

const CUT: &str = "the file ends inside a record";

/// Reads until `buffer` is full or the input ends.
fn fill(input: &mut impl std::io::Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut got = 0;
    while got < buffer.len() {
        match input.read(&mut buffer[got..]) {
            Ok(0) => break,
            Ok(n) => got += n,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(got)
}
