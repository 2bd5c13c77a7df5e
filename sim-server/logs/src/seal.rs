//! Sealing: a log becomes a blind one to hand out, and a key to keep.

use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use rusty_contract::blind::{BlindKey, BlindKeyError, Told, blind_header};
use rusty_contract::digest::ObservableDigest;
use rusty_contract::log::{
    Ending, LogError, LogReader, LogWriter, Read, Source, TickRecord, TickRef, Trailer,
};
use rusty_contract::{Exit, FieldError, Frame, LogHeader, RunDigest, TruthKey};
use serde::Serialize;
use thiserror::Error;

/// Why a log cannot be sealed.
#[derive(Debug, Error)]
pub enum SealError {
    /// A path that cannot be written to.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The log cannot be read, or the blind one not be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The key.
    #[error(transparent)]
    Key(#[from] BlindKeyError),
    /// An error of the operating system about a file.
    #[error("{0}: {1}")]
    Io(String, io::Error),
    /// A log that is blind.
    #[error(
        "{0} is blind already: it has no truth to take out; seal the log that it was made from, \
         or hand it out as it is"
    )]
    Blind(String),
    /// Sealing would make what is damaged look whole.
    #[error(
        "{log}: {problem}; a blind log of it would look whole: restore the log first \
         (`sim-server verify` says what else is wrong with it)"
    )]
    Damaged {
        /// The log.
        log: String,
        /// What is wrong.
        problem: String,
    },
}

impl SealError {
    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Field(_) | Self::Blind(_) => Exit::Usage,
            _ => Exit::Failed,
        }
    }
}

/// What sealing came to.
#[derive(Debug, Serialize)]
pub struct Sealed {
    /// The log without its truth.
    pub blind: String,
    /// The rest.
    pub key_file: String,
    /// Ticks sealed.
    pub ticks: u64,
    /// Ticks whose true pose is in the key.
    pub ticks_with_truth: u64,
    /// Observable digest of log and blind log.
    pub observable_digest: String,
    /// The initial pose stays: a participant that answers was told it.
    pub start_known: bool,
    /// The walls stay: a participant that answers was given them.
    pub world_known: bool,
    /// The log had its end. If not, the blind one has none either.
    pub complete: bool,
    /// Where the log ends, if it has no end.
    pub cut: Option<String>,
    /// The header of the log, which is in the key.
    #[serde(skip)]
    pub header: LogHeader,
}

/// Seals `log`: writes the blind log and the key (mode 0600), neither over a
/// file that is there. What was written is removed again on failure. Without `told`, readers
/// are told what the participants of the log were.
///
/// # Errors
/// [`SealError`] names file, problem and remedy.
pub fn seal(
    log: &Path,
    blind: &Path,
    key_file: &Path,
    (told, by): (Option<Told>, &str),
) -> Result<Sealed, SealError> {
    check_paths(log, blind, key_file)?;
    let (key, ending) = look(log)?;
    let observable_digest = rusty_contract::digest::hex(&key.observable_digest);
    let ticks = key.ticks.len() as u64;
    let told = told.unwrap_or_else(|| Told::of(&key.header));
    let header = blind_header(&key.header, told, (observable_digest.clone(), ticks), by);
    let mut made = WrittenFiles(Vec::new());
    let bytes = key.to_bytes()?;
    let mut file = made.create(key_file, 0o600)?;
    file.write_all(&bytes).and_then(|()| file.sync_all()).map_err(io_error(key_file))?;
    let out = BufWriter::with_capacity(1 << 16, made.create(blind, 0o666)?);
    let writer = LogWriter::new(out, blind, &header)?;
    copy(log, &key, &header, writer, matches!(ending, Ending::Complete(_)))?;
    made.0.clear();
    let cut = match &ending {
        Ending::Complete(_) => None,
        Ending::Cut { at_byte, problem, .. } => Some(format!("at byte {at_byte}: {problem}")),
    };
    Ok(Sealed {
        blind: blind.display().to_string(),
        key_file: key_file.display().to_string(),
        ticks,
        ticks_with_truth: key.ticks.iter().filter(|t| t.truth.is_some()).count() as u64,
        observable_digest,
        start_known: header.known_start().is_some(),
        world_known: header.known_world().is_some(),
        complete: cut.is_none(),
        cut,
        header: key.header,
    })
}

/// Files that were made and are removed again unless all goes well.
struct WrittenFiles(Vec<PathBuf>);

impl WrittenFiles {
    fn create(&mut self, path: &Path, mode: u32) -> Result<fs::File, SealError> {
        let file = OpenOptions::new().write(true).create_new(true).mode(mode).open(path);
        let file = file.map_err(io_error(path))?;
        self.0.push(path.to_owned());
        Ok(file)
    }
}

impl Drop for WrittenFiles {
    fn drop(&mut self) {
        for path in &self.0 {
            let _ = fs::remove_file(path);
        }
    }
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> SealError {
    let path = path.display().to_string();
    move |error| SealError::Io(path, error)
}

fn check_paths(log: &Path, blind: &Path, key_file: &Path) -> Result<(), FieldError> {
    let real = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    for (argument, path) in [("--output", blind), ("--key-file", key_file)] {
        let problem = if real(path) == real(log) {
            "is the log that is to be sealed"
        } else if fs::symlink_metadata(path).is_ok() {
            "is there already, and nothing is written over"
        } else if blind == key_file {
            "is the other file, too: whoever gets the log would get the truth"
        } else {
            continue;
        };
        return Err(FieldError::new(argument, path.display(), problem, "give another path"));
    }
    Ok(())
}

/// First pass: what the key has, and how the log ends.
fn look(log: &Path) -> Result<(BlindKey, Ending), SealError> {
    let damaged = |problem| SealError::Damaged { log: log.display().to_string(), problem };
    let mut reader = LogReader::open(log)?;
    if let Source::Blind { .. } = reader.header().source {
        return Err(SealError::Blind(log.display().to_string()));
    }
    let mut key = BlindKey {
        header: reader.header().clone(),
        run_digest: None,
        world_digest: None,
        observable_digest: ObservableDigest::default().value(),
        ticks: Vec::new(),
    };
    let dt_s = key.header.config.dt_s;
    let nobody = TruthKey::from_bytes([0; 32]);
    let (mut frame, mut digest) = (Frame::boxed(), RunDigest::default());
    let mut observable = ObservableDigest::default();
    let ending = loop {
        match reader.read()? {
            Read::Tick(entry) if entry.intact => {
                let record = entry.record;
                record.write_frame(&mut frame, dt_s, &nobody);
                record.absorb(&frame, &mut digest);
                key.push(&frame, record.truth, &mut observable);
            }
            Read::Tick(entry) => {
                let (tick, at) = (key.ticks.len(), entry.at_byte);
                let problem = format!("tick {tick}: the checksum of its record (byte {at}) fails");
                return Err(damaged(problem));
            }
            Read::End(ending) => break ending,
        }
    };
    if key.ticks.is_empty() {
        return Err(damaged("there is no complete tick in it".to_owned()));
    }
    if let Ending::Complete(trailer) = &ending {
        if (trailer.run_digest, trailer.world_digest) != (digest.run(), digest.world()) {
            return Err(damaged("its digest is not that of its records".to_owned()));
        }
        key.run_digest = Some(trailer.run_digest);
        key.world_digest = Some(trailer.world_digest);
    }
    Ok((key, ending))
}

/// Second pass: the records without their truth.
fn copy(
    log: &Path,
    key: &BlindKey,
    header: &LogHeader,
    mut writer: LogWriter<BufWriter<fs::File>>,
    complete: bool,
) -> Result<(), SealError> {
    let mut reader = LogReader::open(log)?;
    let nobody = TruthKey::from_bytes([0; 32]);
    let (mut frame, mut digest) = (Frame::boxed(), RunDigest::default());
    for tick in 0..key.ticks.len() as u64 {
        let Read::Tick(entry) = reader.read()? else {
            let problem = "it changed while it was read".to_owned();
            return Err(SealError::Damaged { log: log.display().to_string(), problem });
        };
        let record = TickRecord { truth: None, ..entry.record };
        record.write_frame(&mut frame, header.config.dt_s, &nobody);
        // A file that changes between the passes would not fit its key.
        let _ = key.truth_of(tick, &frame)?;
        record.absorb(&frame, &mut digest);
        writer.tick(TickRef::from(&record))?;
    }
    if complete {
        let (run_digest, world_digest) = (digest.run(), digest.world());
        writer.finish(Trailer { ticks: key.ticks.len() as u64, run_digest, world_digest })?;
    } else {
        writer.flush()?;
    }
    Ok(())
}
