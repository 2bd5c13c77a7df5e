//! The part of a shard: the records of its runs in one file.
//!
//! The file has the form of a [`journal`](super::journal): a line of JSON with the
//! digest of the manifest and the shard, then the records, here in the order of the
//! runs. It is written under a hidden name and renamed when it is complete.

use std::io::{self, BufWriter, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};

use rusty_contract::{Replacement, input};
use serde_json::json;
use thiserror::Error;

use super::error::SweepError;
use super::journal::{encoded, read_all};
use super::record::Record;
use super::settings::Settings;
use super::shard::Shard;

/// The file of a shard.
pub struct Part {
    /// Its path.
    pub path: PathBuf,
    /// The runs of the shard.
    pub runs: Range<u64>,
    shard: Shard,
    head: Settings,
}

/// The reason why a part cannot be used.
#[derive(Debug, Error)]
pub enum PartFault {
    /// There is no file.
    #[error("is missing")]
    Missing,
    /// It was made for another manifest or shard.
    #[error("is another part: {0} (there and expected)")]
    Other(String),
    /// It was cut or changed.
    #[error("is damaged after {good} of {all} runs")]
    Damaged {
        /// Number of records that are good.
        good: u64,
        /// Number of runs of the shard.
        all: u64,
    },
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(String),
}

impl Part {
    /// The part of `shard` in `folder`, of the manifest with this digest and number of
    /// runs.
    pub(super) fn new(folder: &Path, digest: &str, shard: Shard, runs: u64) -> Self {
        let head = [("manifest", json!(digest)), ("shard", json!(shard.to_string()))];
        let head = head.map(|(name, value)| (name, value.to_string()));
        Self {
            path: folder.join(format!("part-{digest}-{}", shard.index)),
            runs: shard.of(runs),
            shard,
            head: Settings::from_parts(head.iter().map(|(name, text)| (*name, &**text))),
        }
    }

    /// Returns the shard.
    #[must_use]
    pub fn shard(&self) -> Shard {
        self.shard
    }

    /// Reads the records of the shard, in order.
    ///
    /// # Errors
    /// [`PartFault`] if they are not all there, once each.
    pub fn read(&self) -> Result<Vec<Record>, PartFault> {
        let unreadable = |e: io::Error| match e.kind() {
            io::ErrorKind::NotFound => PartFault::Missing,
            _ => PartFault::Unreadable(e.to_string()),
        };
        let file = input::open(&self.path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        let all = self.runs.end - self.runs.start;
        let damaged = |good| PartFault::Damaged { good, all };
        let found = read_all(&file).map_err(unreadable)?.ok_or(damaged(0))?;
        let head = Settings::read(&found.head).map_err(|_| damaged(0))?;
        if let Some(difference) = head.difference(&self.head) {
            return Err(PartFault::Other(difference));
        }
        let in_order = found.records.iter().map(|r| r.run).zip(self.runs.clone());
        let good = in_order.take_while(|(run, expected)| run == expected).count() as u64;
        let is_whole = good == all && found.records.len() as u64 == all && found.good == length;
        if is_whole { Ok(found.records) } else { Err(damaged(good)) }
    }

    /// Writes the records of the shard, which are in order. Replaces what is there.
    ///
    /// # Errors
    /// [`SweepError`] if the disk says no.
    pub fn write(&self, records: &[Record]) -> Result<(), SweepError> {
        let io = || SweepError::io(&self.path);
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        // Two machines may make the same shard in a folder that they share.
        let host = rustix::system::uname().nodename().to_string_lossy().into_owned();
        let file = Replacement::of(&self.path.with_file_name(format!("{name}.{host}")));
        let mut file = BufWriter::new(file.map_err(io())?);
        writeln!(file, "{}", self.head.text()).map_err(io())?;
        for record in records {
            file.write_all(&encoded(record)).map_err(io())?;
        }
        let file = file.into_inner().map_err(|e| io()(e.into_error()))?;
        file.commit(&self.path).map_err(io())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn records(runs: Range<u64>) -> Vec<Record> {
        let record = |run| Record { run, rows: Vec::new(), tracks: Vec::new(), lost: None };
        runs.map(record).collect()
    }

    #[test]
    fn a_part_is_whole_or_a_fault() {
        let place = tempfile::tempdir().unwrap();
        let shard = |index| Part::new(place.path(), "abc", Shard { index, count: 3 }, 10);
        let part = shard(1);
        assert!(matches!(part.read(), Err(PartFault::Missing)));
        let all = records(part.runs.clone());
        assert_eq!(all.len(), 3);
        part.write(&all).unwrap();
        assert_eq!(part.read().unwrap(), all);
        // Nothing else is left in the folder.
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
        let bytes = fs::read(&part.path).unwrap();
        for length in 0..bytes.len() {
            fs::write(&part.path, &bytes[..length]).unwrap();
            assert!(matches!(part.read(), Err(PartFault::Damaged { .. })), "{length} bytes");
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1;
            fs::write(&part.path, &changed).unwrap();
            part.read().unwrap_err();
        }
        fs::write(&part.path, [&bytes[..], b"x"].concat()).unwrap();
        assert!(matches!(part.read(), Err(PartFault::Damaged { good: 3, all: 3 })));
        // A record twice, one of another shard, and one too few.
        for runs in [vec![3, 3, 4], vec![3, 4, 6], vec![3, 4], vec![3, 4, 5, 6], vec![4, 3, 5]] {
            let records = runs.iter().flat_map(|run| records(*run..run + 1)).collect::<Vec<_>>();
            part.write(&records).unwrap();
            assert!(matches!(part.read(), Err(PartFault::Damaged { .. })), "{runs:?}");
        }
    }

    #[test]
    fn a_part_of_another_shard_or_manifest_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let part = |digest: &str, index, runs| {
            Part::new(place.path(), digest, Shard { index, count: 3 }, runs)
        };
        let (first, second) = (part("abc", 0, 9), part("abc", 1, 9));
        first.write(&records(0..3)).unwrap();
        fs::copy(&first.path, &second.path).unwrap();
        let fault = second.read().unwrap_err().to_string();
        assert!(fault.contains("shard: \"0/3\" and \"1/3\""), "{fault}");
        let other = part("def", 0, 9);
        fs::copy(&first.path, &other.path).unwrap();
        let fault = other.read().unwrap_err().to_string();
        assert!(fault.contains("manifest: \"abc\" and \"def\""), "{fault}");
    }
}
