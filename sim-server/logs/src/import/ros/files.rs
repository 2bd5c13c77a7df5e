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
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ruzstd::decoding::StreamingDecoder;

use crate::import::ImportError;

/// Largest chunk that is unpacked, bytes. rosbag2 writes less than one MiB.
const MAX_CHUNK_BYTES: u64 = 64 << 20;
/// Bytes of a record before its content: kind and length.
const HEAD_BYTES: usize = 9;
/// Bytes of a message before its content: channel, sequence, two times.
const MESSAGE_HEAD_BYTES: usize = 22;

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
        let rest = &self.chunk[self.at..];
        let (opcode, length) = match rest {
            [opcode, a, b, c, d, e, f, g, h, ..] => {
                (*opcode, u64::from_le_bytes([*a, *b, *c, *d, *e, *f, *g, *h]))
            }
            _ => return Err(CUT.to_owned()),
        };
        let length = usize::try_from(length).map_err(|_| CUT.to_owned())?;
        let body = rest[HEAD_BYTES..].get(..length).ok_or(CUT)?;
        let start = self.at + HEAD_BYTES;
        self.at = start + length;
        match opcode {
            op::MESSAGE => {
                let [a, b, _, _, _, _, time @ .., _, _, _, _, _, _, _, _] = body
                    .first_chunk::<MESSAGE_HEAD_BYTES>()
                    .ok_or("a message is shorter than its head")?;
                let found = (u16::from_le_bytes([*a, *b]), u64::from_le_bytes(*time));
                return Ok(Some((found.0, found.1, start + MESSAGE_HEAD_BYTES..start + length)));
            }
            op::SCHEMA | op::CHANNEL => {
                let record = mcap::parse_record(opcode, body).map_err(|e| e.to_string())?;
                define(&mut self.types, &mut self.channels, &record);
            }
            _ => {}
        }
        Ok(None)
    }
}

fn define(
    types: &mut BTreeMap<u16, String>,
    channels: &mut BTreeMap<u16, Channel>,
    record: &Record<'_>,
) {
    match record {
        Record::Schema { header, .. } => {
            types.insert(header.id, header.name.clone());
        }
        Record::Channel(channel) => {
            let of_channel = Channel {
                topic: channel.topic.clone(),
                type_name: types.get(&channel.schema_id).cloned().unwrap_or_default(),
                encoding: channel.message_encoding.clone(),
            };
            channels.insert(channel.id, of_channel);
        }
        _ => {}
    }
}

/// Unpacks the records of a chunk.
fn unpack(chunk: &[u8], records: &mut Vec<u8>) -> Result<(), String> {
    let parsed = mcap::parse_record(op::CHUNK, chunk).map_err(|e| e.to_string())?;
    let Record::Chunk { header, data } = parsed else { return Ok(()) };
    let ChunkHeader { uncompressed_size: size, uncompressed_crc: crc, .. } = header;
    if size > MAX_CHUNK_BYTES {
        return Err(format!("a chunk of {size} bytes (at most {MAX_CHUNK_BYTES} are unpacked)"));
    }
    // A byte more, so that one that is longer than it says is found out.
    let most = size + 1;
    let unpacked = match header.compression.as_str() {
        "" => (&*data).take(most).read_to_end(records).map_err(|e| e.to_string()),
        "lz4" => {
            FrameDecoder::new(&*data).take(most).read_to_end(records).map_err(|e| e.to_string())
        }
        "zstd" => StreamingDecoder::new(&*data)
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
