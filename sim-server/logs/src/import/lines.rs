//! The lines of a file, plain or gzip, however large it is.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use rusty_contract::input::BYTE_ORDER_MARK;

use super::error::{ImportError, MAX_LINE_BYTES};

/// The first two bytes of every gzip member (RFC 1952, section 2.3.1).
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Reads line by line; memory holds one line and the buffers.
pub(super) struct Lines {
    /// The file's path, for messages.
    pub(super) path: String,
    input: Box<dyn BufRead>,
    raw: Vec<u8>,
    /// The line just read. Bytes that are not UTF-8 are replaced: they can only be in
    /// names and comments.
    pub(super) text: String,
    /// Number of the line just read, from 1; after the end, of the last.
    pub(super) line: u64,
    bytes: u64,
}

impl Lines {
    /// Opens a file; gzip is known by its first bytes, not by its name.
    pub(super) fn open(path: &Path) -> Result<Self, ImportError> {
        let name = path.display().to_string();
        let io = |error: std::io::Error| {
            let problem = format!("{error}; give the path of a CARMEN log, plain or gzip");
            ImportError::file(path, problem)
        };
        if !std::fs::metadata(path).map_err(io)?.is_file() {
            let problem = "this is no regular file; an import reads its input four times, so \
                           write it to a file first";
            return Err(ImportError::file(path, problem));
        }
        let mut file = BufReader::with_capacity(1 << 16, File::open(path).map_err(io)?);
        let packed = file.fill_buf().map_err(io)?.starts_with(&GZIP_MAGIC);
        let input: Box<dyn BufRead> = if packed {
            Box::new(BufReader::with_capacity(1 << 16, MultiGzDecoder::new(file)))
        } else {
            Box::new(file)
        };
        Ok(Self { path: name, input, raw: Vec::new(), text: String::new(), line: 0, bytes: 0 })
    }

    /// Goes to the next line; `false` at the end.
    pub(super) fn advance(&mut self) -> Result<bool, ImportError> {
        self.raw.clear();
        let limit = MAX_LINE_BYTES as u64 + 1;
        let mut limited = self.input.by_ref().take(limit);
        let read = limited.read_until(b'\n', &mut self.raw);
        let got = read.map_err(|error| {
            let place = format!("after line {} ({} bytes unpacked)", self.line, self.bytes);
            let problem = match error.kind() {
                ErrorKind::UnexpectedEof => format!(
                    "the gzip stream is cut off {place}; fetch the file again, or unpack what \
                     there is (gzip -dc), delete the last, incomplete line and import that"
                ),
                _ => format!(
                    "{place}: {error}; the file is damaged there, or its disk is: fetch it again"
                ),
            };
            ImportError::file(Path::new(&self.path), problem)
        })?;
        if got == 0 {
            return Ok(false);
        }
        self.line += 1;
        self.bytes += got as u64;
        if got > MAX_LINE_BYTES {
            let problem = format!(
                "line {} is longer than {MAX_LINE_BYTES} bytes; this is no CARMEN log, or its \
                 line ends are lost: end each message with a newline",
                self.line
            );
            return Err(ImportError::file(Path::new(&self.path), problem));
        }
        let marked = self.raw.strip_prefix(BYTE_ORDER_MARK).filter(|_| self.line == 1);
        self.text.clear();
        self.text.push_str(&String::from_utf8_lossy(marked.unwrap_or(&self.raw)));
        Ok(true)
    }
}
