//! The journal of a sweep: what is done, on disk while the rest is not.
//!
//! A file next to the table, `FILE.part`: the settings as one line of JSON, then
//! a record per run in the order in which they ended: length and CRC-32 (4
//! bytes each, little-endian), then a [`Record`] as postcard. Wherever it is cut, it
//! is good up to the last complete record. The kernel's lock on it says that a process
//! is at work.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead as _, BufReader, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::error::SweepError;
use super::record::Record;
use super::settings::Settings;

/// Longest record that is believed, bytes: sixteen estimators need 70 kB.
const MOST_BYTES: u32 = 1 << 20;

/// An open journal.
pub struct Journal {
    path: PathBuf,
    file: BufWriter<File>,
    /// Whether it has no record.
    is_empty: bool,
}

impl Journal {
    /// Begins a journal, or goes on with the one that is there, which must be of
    /// the same settings: then with what it holds of `runs`, in no order. With `anew`,
    /// what it holds is dropped.
    ///
    /// # Errors
    /// [`SweepError`] if another process writes it, it is of another sweep, or the
    /// disk says no.
    pub fn open(
        path: &Path,
        settings: &Settings,
        runs: &Range<u64>,
        anew: bool,
    ) -> Result<(Self, Vec<Record>), SweepError> {
        let io = || SweepError::io(path);
        let mut open = OpenOptions::new();
        let file = open.read(true).write(true).create(true).truncate(false).open(path);
        let file = file.map_err(io())?;
        lock(&file, path)?;
        if anew {
            file.set_len(0).map_err(io())?;
        }
        let (good, records) = read(&file, path, settings, runs)?;
        let mut file = file;
        file.set_len(good).and_then(|()| file.seek(SeekFrom::Start(good))).map_err(io())?;
        let mut journal = Self {
            path: path.to_owned(),
            file: BufWriter::new(file),
            is_empty: records.is_empty(),
        };
        if good == 0 {
            let line = settings.text();
            journal.file.write_all(line.as_bytes()).map_err(io())?;
            journal.file.write_all(b"\n").map_err(io())?;
            journal.flush()?;
        }
        Ok((journal, records))
    }

    /// Adds a record as [`encoded`]; it is safe from the death of this process
    /// after the next [`flush`](Self::flush).
    ///
    /// # Errors
    /// [`SweepError::Run`] if the disk says no.
    pub fn append(&mut self, record: &[u8]) -> Result<(), SweepError> {
        self.is_empty = false;
        self.file.write_all(record).map_err(SweepError::io(&self.path))
    }

    /// Hands everything to the operating system.
    ///
    /// # Errors
    /// [`SweepError::Run`] if the disk says no.
    pub fn flush(&mut self) -> Result<(), SweepError> {
        self.file.flush().map_err(SweepError::io(&self.path))
    }

    /// Removes it: its table is written.
    ///
    /// # Errors
    /// [`SweepError::Run`] if the disk says no.
    pub fn remove(self) -> Result<(), SweepError> {
        std::fs::remove_file(&self.path).map_err(SweepError::io(&self.path))
    }

    /// Whether it has no record.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.is_empty
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Takes the lock of a journal, until the file is closed.
///
/// # Errors
/// [`SweepError::InTheWay`] if a process is at work.
pub(super) fn lock(file: &File, path: &Path) -> Result<(), SweepError> {
    file.try_lock().map_err(|error| match error {
        TryLockError::WouldBlock => SweepError::InTheWay {
            path: path.display().to_string(),
            what: "is being written by another sweep".to_owned(),
            remedy: "wait until it has ended, or write to another --out",
        },
        TryLockError::Error(error) => SweepError::io(path)(error),
    })
}

/// A record as it is in a journal; empty if it has no such form, which no
/// record lacks.
#[must_use]
pub fn encoded(record: &Record) -> Vec<u8> {
    let body = postcard::to_allocvec(record).unwrap_or_default();
    let mut bytes = Vec::with_capacity(8 + body.len());
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend(crc32fast::hash(&body).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// What a file has before the first byte that is not good.
pub(super) struct Contents {
    /// The first line.
    pub head: Vec<u8>,
    /// Number of bytes that are good.
    pub good: u64,
    /// The records, in the order of the file.
    pub records: Vec<Record>,
}

/// Reads the records of a file; `None` if it was cut in its first line.
pub(super) fn read_all(file: &File) -> std::io::Result<Option<Contents>> {
    let mut reader = BufReader::new(file);
    let mut head = Vec::new();
    reader.read_until(b'\n', &mut head)?;
    if head.pop() != Some(b'\n') {
        return Ok(None);
    }
    let (mut good, mut records) = (head.len() as u64 + 1, Vec::new());
    while let Some((record, bytes)) = next(&mut reader)? {
        good += bytes;
        records.push(record);
    }
    Ok(Some(Contents { head, good, records }))
}

/// How many bytes of a journal are good, and the records of `runs` in them. A file
/// that was cut in its first line holds nothing.
fn read(
    file: &File,
    path: &Path,
    settings: &Settings,
    runs: &Range<u64>,
) -> Result<(u64, Vec<Record>), SweepError> {
    let Some(mut found) = read_all(file).map_err(SweepError::io(path))? else {
        return Ok((0, Vec::new()));
    };
    let name = || path.display().to_string();
    let there = Settings::read(&found.head).map_err(|e| SweepError::NoSweep {
        path: name(),
        problem: format!("its first line is not that of a journal: {e}"),
    })?;
    if let Some(difference) = there.difference(settings) {
        return Err(SweepError::Other { path: name(), difference });
    }
    found.records.retain(|record| runs.contains(&record.run));
    Ok((found.good, found.records))
}

/// The next record and its length in bytes; `None` where no good one follows.
fn next(reader: &mut BufReader<&File>) -> std::io::Result<Option<(Record, u64)>> {
    let mut head = [0; 8];
    let mut body = Vec::new();
    let mut part = |reader: &mut BufReader<&File>| -> std::io::Result<Option<Record>> {
        reader.read_exact(&mut head)?;
        let [length, crc] = [0, 4]
            .map(|at| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]));
        if length > MOST_BYTES {
            return Ok(None);
        }
        body.resize(length as usize, 0);
        reader.read_exact(&mut body)?;
        if crc32fast::hash(&body) != crc {
            return Ok(None);
        }
        Ok(postcard::from_bytes(&body).ok())
    };
    match part(reader) {
        Ok(record) => Ok(record.map(|record| (record, 8 + body.len() as u64))),
        Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Ok(None),
        Err(e) => Err(e),
    }
}

#[cfg(test)]
mod tests {
    use super::super::client_figures::{ClientFigures, Found};
    use super::*;
    use crate::sweep::{Row, fixtures};

    fn record(run: u64) -> Record {
        Record { run, rows: Vec::new(), tracks: Vec::new(), lost: Some("x".repeat(run as usize)) }
    }

    #[test]
    fn a_journal_is_good_up_to_wherever_it_was_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        let settings = Settings::read(br#"{"seeds":"0..9"}"#).unwrap();
        let open = || Journal::open(&path, &settings, &(0..9), false).unwrap();
        let (mut journal, none) = open();
        assert!(none.is_empty());
        assert!(matches!(
            Journal::open(&path, &settings, &(0..9), false),
            Err(SweepError::InTheWay { .. })
        ));
        for run in [4, 0, 7] {
            journal.append(&encoded(&record(run))).unwrap();
        }
        journal.flush().unwrap();
        drop(journal);
        let whole = std::fs::read(&path).unwrap();
        let expected = [record(4), record(0), record(7)];
        let head = settings.text().len() + 1;
        let ends = expected.iter().scan(head, |end, r| {
            *end += encoded(r).len();
            Some(*end)
        });
        let ends: Vec<usize> = ends.collect();
        assert_eq!(ends[2], whole.len());
        for length in 0..=whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let found = open().1;
            let complete = ends.iter().filter(|end| **end <= length).count();
            assert_eq!(found, expected[..complete], "{length} bytes");
            // What follows the last good byte is removed, the first line is there.
            let left = std::fs::metadata(&path).unwrap().len() as usize;
            assert_eq!(left, ends[..complete].last().copied().unwrap_or(head));
        }
        // A bit that fell over ends it there.
        let mut damaged = whole.clone();
        damaged[ends[0] + 9] ^= 4;
        std::fs::write(&path, &damaged).unwrap();
        assert_eq!(open().1, expected[..1]);
        std::fs::write(&path, &whole).unwrap();
        let (_, few) = Journal::open(&path, &settings, &(0..5), false).unwrap();
        assert_eq!(few, expected[..2]);
        let other = Settings::read(br#"{"seeds":"0..8"}"#).unwrap();
        let error = Journal::open(&path, &other, &(0..9), false).err().unwrap().to_string();
        assert!(error.contains("seeds: \"0..9\" and \"0..8\""), "{error}");
    }

    #[test]
    fn all_figures_of_a_client_are_kept() {
        let found =
            Found { position_rmse_m: 0.02, heading_rmse_rad: 0.01, kidnapped: 2, recovered: 1 };
        // No NaN, which equals nothing.
        let value = serde_json::to_value(ClientFigures::of(None)).unwrap();
        let mut figures: serde_json::Map<_, _> =
            value.as_object().unwrap().keys().map(|k| (k.clone(), 1.into())).collect();
        figures.insert("found".to_owned(), serde_json::to_value(found).unwrap());
        let clients = serde_json::from_value(serde_json::Value::Object(figures)).unwrap();
        let row = |clients| Row { parameters: [].into(), clients, ..fixtures::row(0, 3, "ekf") };
        let whole = Record { rows: vec![row(None), row(Some(clients))], ..record(3) };
        assert_eq!(postcard::from_bytes::<Record>(&encoded(&whole)[8..]).unwrap(), whole);
    }
}
