//! The messages of MCAP files, one after the other, in the order of the files.
//!
//! Chunks are unpacked whole and their records are read here, every length checked: a
//! damaged file is an error, and memory follows the bytes that are there.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read as _};
use std::ops::Range;
use std::path::{Path, PathBuf};

use lz4_flex::frame::FrameDecoder;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ruzstd::decoding::StreamingDecoder;

use crate::import::ImportError;

/// Largest chunk that is unpacked, bytes. rosbag2 writes less than one MiB.
const MAX_CHUNK_BYTES: u64 = 64 << 20;

/// A topic of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Channel {
    pub(super) topic: String,
    /// Such as `sensor_msgs/msg/LaserScan`.
    pub(super) type_name: String,
    /// Such as `cdr`.
    pub(super) encoding: String,
}

/// A message.
pub(super) struct Message<'a> {
    pub(super) channel: &'a Channel,
    /// Time at which it was recorded, s.
    pub(super) log_s: f64,
    pub(super) data: &'a [u8],
    /// Its number in all files, from 1.
    pub(super) number: u64,
}

/// Reads files one after the other; memory holds one chunk.
pub(super) struct Files {
    /// The path of the file that is being read, for messages.
    pub(super) path: String,
    paths: std::vec::IntoIter<PathBuf>,
    file: Option<(BufReader<File>, LinearReader)>,
    types: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    /// Records that are unpacked.
    chunk: Vec<u8>,
    /// Where the next of them begins.
    at: usize,
    /// Number of the message just read.
    pub(super) number: u64,
}

impl Files {
    pub(super) fn open(paths: Vec<PathBuf>) -> Self {
        Self {
            path: paths.first().map(|path| path.display().to_string()).unwrap_or_default(),
            paths: paths.into_iter(),
            file: None,
            types: BTreeMap::new(),
            channels: BTreeMap::new(),
            chunk: Vec::new(),
            at: 0,
            number: 0,
        }
    }

    /// The next message, or `None` at the end of the last file.
    pub(super) fn advance(&mut self) -> Result<Option<Message<'_>>, ImportError> {
        let found = loop {
            if self.at < self.chunk.len() {
                if let Some(found) = self.record().map_err(|problem| self.error(&problem))? {
                    break found;
                }
            } else if self.file.is_some() {
                self.fill()?;
            } else if !self.next_file()? {
                return Ok(None);
            }
        };
        let (id, log_ns, data) = found;
        self.number += 1;
        let Some(channel) = self.channels.get(&id) else {
            return Err(self.error("a message names a channel that the file does not define"));
        };
        let (log_s, number) = (log_ns as f64 / 1e9, self.number);
        Ok(Some(Message { channel, log_s, data: &self.chunk[data], number }))
    }

    fn error(&self, problem: &str) -> ImportError {
        let problem = format!(
            "after message {}: {problem}; the file is damaged or cut off: copy it again, or repair \
             it (`mcap recover`)",
            self.number
        );
        ImportError::file(Path::new(&self.path), problem)
    }

    /// Begins the next file; `false` after the last one.
    fn next_file(&mut self) -> Result<bool, ImportError> {
        let Some(path) = self.paths.next() else { return Ok(false) };
        let io = |error: std::io::Error| {
            ImportError::file(&path, format!("{error}; give the path of an MCAP file"))
        };
        let file = File::open(&path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if !metadata.is_file() {
            let problem = "expected a file, got something else; give the path of an MCAP file, \
                           which is read four times";
            return Err(ImportError::file(&path, problem));
        }
        let longest = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
        let options =
            LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(longest);
        let reader = LinearReader::new_with_options(options);
        self.path = path.display().to_string();
        self.file = Some((BufReader::with_capacity(1 << 16, file), reader));
        self.types.clear();
        self.channels.clear();
        Ok(true)
    }

    /// Reads on until there are records, or to the end of the file.
    fn fill(&mut self) -> Result<(), ImportError> {
        self.chunk.clear();
        self.at = 0;
        let Some((source, reader)) = &mut self.file else { return Ok(()) };
        let mut problem = None;
        let mut is_over = false;
        while self.chunk.is_empty() && problem.is_none() && !is_over {
            match reader.next_event() {
                None => is_over = true,
                Some(Err(error)) => problem = Some(error.to_string()),
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => {
                    match source.read(reader.insert(bytes)) {
                        Ok(got) => reader.notify_read(got),
                        Err(error) => problem = Some(error.to_string()),
                    }
                }
                // What follows repeats what was read.
                Some(Ok(LinearReadEvent::Record { opcode: op::DATA_END, .. })) => is_over = true,
                Some(Ok(LinearReadEvent::Record { opcode: op::CHUNK, data })) => {
                    problem = unpack(data, &mut self.chunk).err();
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                        self.chunk.push(opcode);
                        self.chunk.extend((data.len() as u64).to_le_bytes());
                        self.chunk.extend(data);
                    }
                }
            }
        }
        if is_over {
            self.file = None;
        }
        problem.map_or(Ok(()), |problem| Err(self.error(&problem)))
    }

    /// Reads a record: channel, time and place of a message, or nothing of another kind.
    fn record(&mut self) -> Result<Option<(u16, u64, Range<usize>)>, String> {
        const CUT: &str = "a record is longer than its chunk";
        let mut rest = Fields(&self.chunk[self.at..]);
        let head = rest.take().and_then(|[opcode]| Ok((opcode, rest.u64()?)));
        let (opcode, length) = head.map_err(|_| CUT)?;
        let mut fields = Fields(rest.bytes(length).map_err(|_| CUT)?);
        let end = self.chunk.len() - rest.0.len();
        self.at = end;
        match opcode {
            op::MESSAGE => {
                let (id, _sequence) = (fields.u16()?, fields.u32()?);
                let (log_ns, _publish_ns) = (fields.u64()?, fields.u64()?);
                return Ok(Some((id, log_ns, end - fields.0.len()..end)));
            }
            op::SCHEMA => {
                let id = fields.u16()?;
                self.types.insert(id, fields.text()?);
            }
            op::CHANNEL => {
                let (id, schema) = (fields.u16()?, fields.u16()?);
                let type_name = self.types.get(&schema).cloned().unwrap_or_default();
                let (topic, encoding) = (fields.text()?, fields.text()?);
                self.channels.insert(id, Channel { topic, type_name, encoding });
            }
            _ => {}
        }
        Ok(None)
    }
}

/// The fields of a record that are not read yet. `parse_record` of the crate reserves
/// what a damaged length says.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (field, rest) = self.0.split_first_chunk().ok_or(SHORT)?;
        self.0 = rest;
        Ok(*field)
    }

    fn u16(&mut self) -> Result<u16, String> {
        self.take().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.take().map(u64::from_le_bytes)
    }

    fn bytes(&mut self, length: u64) -> Result<&'a [u8], String> {
        let length = usize::try_from(length).map_err(|_| SHORT)?;
        let (field, rest) = self.0.split_at_checked(length).ok_or(SHORT)?;
        self.0 = rest;
        Ok(field)
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.u32()?;
        let text = String::from_utf8(self.bytes(length.into())?.to_vec());
        text.map_err(|error| error.utf8_error().to_string())
    }
}

const SHORT: &str = "a record is shorter than its fields";

/// Unpacks the records of a chunk.
fn unpack(chunk: &[u8], records: &mut Vec<u8>) -> Result<(), String> {
    let mut fields = Fields(chunk);
    let (_begin_ns, _end_ns) = (fields.u64()?, fields.u64()?);
    let (size, crc, compression) = (fields.u64()?, fields.u32()?, fields.text()?);
    let packed = fields.u64()?;
    let data = fields.bytes(packed)?;
    if size > MAX_CHUNK_BYTES {
        return Err(format!("a chunk of {size} bytes (at most {MAX_CHUNK_BYTES} are unpacked)"));
    }
    // A byte more, so that one that is longer than it says is found out.
    let most = size + 1;
    let unpacked = match compression.as_str() {
        "" => data.take(most).read_to_end(records).map_err(|e| e.to_string()),
        "lz4" => FrameDecoder::new(data).take(most).read_to_end(records).map_err(|e| e.to_string()),
        "zstd" => StreamingDecoder::new(data)
            .map_err(|e| e.to_string())
            .and_then(|frame| frame.take(most).read_to_end(records).map_err(|e| e.to_string())),
        other => Err(format!("a chunk is packed with {other:?} (known: lz4, zstd)")),
    };
    unpacked.map_err(|problem| format!("a chunk cannot be unpacked: {problem}"))?;
    if records.len() as u64 != size {
        return Err(format!("a chunk has {} bytes, {size} are announced", records.len()));
    }
    if crc != 0 && crc32fast::hash(records) != crc {
        return Err("the checksum of a chunk fails".to_owned());
    }
    Ok(())
}
