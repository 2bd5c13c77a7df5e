//! The logger: writes the run down as it happens.
//!
//! It writes behind: a tick is taken when its record is in a buffer, and a
//! thread writes the buffer out ([`crate::write_behind`]). So a disk that
//! hesitates holds up no run, a disk that is slower than the run sets its pace,
//! and a disk that is full ends the logger, at the next tick or at the end. The
//! trailer is written after all before it was, and after the file was found to
//! be as long as what was written.
//!
//! "Written" means that the operating system has it: a log outlives every
//! process of its run. If the machine itself loses power, what reached the disk
//! is what can be read; checksums and trailer say how far that goes.

pub mod measure;
mod program;
pub mod write_behind;

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use rusty_contract::log::{LogError, LogHeader, LogWriter, TickRef, Trailer};
use rusty_contract::{Brief, Exit, Phase, RunDigest, Start, errln, output};

use rusty_clients::recorder::{Ending, Recorder, Step};
use rusty_clients::{ClientArgs, ClientError, output_folder};
use write_behind::WriteBehind;

pub use program::PROGRAMS;

/// Writes a log: a record per tick, the trailer at the end.
pub struct Logger {
    path: PathBuf,
    /// Where it writes until it has caught up with the run it comes back into,
    /// and how many ticks that takes: what its predecessor saved stays till then.
    again: Option<(PathBuf, u64)>,
    writer: LogWriter<WriteBehind>,
    dt_s: f64,
    ticks: u64,
    digest: RunDigest,
}

/// Creates a log.
fn create(path: &Path, header: &LogHeader) -> Result<LogWriter<WriteBehind>, ClientError> {
    output::create(path).map_err(ClientError::io(path))?;
    // Always at its end: if another process cuts it, what follows makes no hole.
    let file = File::options().append(true).open(path).map_err(ClientError::io(path))?;
    let mut writer = behind(file, path, header)?;
    // A logger that is killed now leaves a log that reads: one without ticks.
    writer.flush().map_err(|e| failure(path, 0, e))?;
    Ok(writer)
}

/// A log that is written behind.
fn behind(
    file: File,
    path: &Path,
    header: &LogHeader,
) -> Result<LogWriter<WriteBehind>, ClientError> {
    let out = WriteBehind::new(file).map_err(ClientError::io(path))?;
    Ok(LogWriter::new(out, path, header)?)
}

impl Recorder for Logger {
    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        let record = TickRef::new(step.frame, step.truth, step.replies, self.dt_s);
        self.writer.tick(record).map_err(|e| self.failed(e))?;
        self.ticks += 1;
        self.digest = step.digest;
        if let Some((file, _)) = self.again.take_if(|(_, ticks)| *ticks <= self.ticks) {
            self.writer.flush().map_err(|e| failure(&file, self.ticks, e))?;
            fs::rename(&file, &self.path).map_err(ClientError::io(&self.path))?;
        }
        Ok(())
    }

    fn finish(mut self, ending: Ending) -> Result<Exit, ClientError> {
        self.writer.flush().map_err(|e| self.failed(e))?;
        if matches!(ending, Ending::Broken | Ending::LogCut) {
            if let Some((file, of)) = &self.again {
                let _ = fs::remove_file(file);
                let (path, ticks) = (self.path.display(), self.ticks);
                errln!(
                    "the run ended after {ticks} of {of} ticks had been given again; {path} is as \
                     the logger before left it"
                );
                return Ok(Exit::Lost);
            }
            let (path, ticks) = (self.path.display(), self.ticks);
            errln!("{path} holds {ticks} complete ticks and no trailer");
            return Ok(Exit::Lost);
        }
        self.check_length()?;
        let (path, ticks) = (self.path, self.ticks);
        let trailer =
            Trailer { ticks, run_digest: self.digest.run(), world_digest: self.digest.world() };
        self.writer.finish(trailer).map_err(|e| failure(&path, ticks, e))?;
        let interrupted = ending == Ending::Told(Phase::Aborted);
        Ok(if interrupted { Exit::Lost } else { Exit::Done })
    }
}

impl Logger {
    /// Creates the log.
    ///
    /// # Errors
    /// The file is there already, or cannot be written.
    pub fn new(start: &Start, brief: &Brief, args: &ClientArgs) -> Result<Self, ClientError> {
        args.check_no_beliefs()?;
        let path = output_folder(brief, args)?.join("run.log");
        let chosen = args.out.is_some() || args.log.is_some();
        if chosen && start.catch_up.is_none() {
            args.check_free(&path)?;
        }
        let again = start.catch_up.as_ref().map(|c| (path.with_extension("log.again"), c.ticks));
        let file = again.as_ref().map_or(&path, |(file, _)| file);
        let writer = create(file, &brief.header)?;
        let (dt_s, digest) = (brief.header.config.dt_s, RunDigest::default());
        Ok(Self { path, again, writer, dt_s, ticks: 0, digest })
    }

    /// What the ticks are written to.
    fn file(&self) -> &Path {
        self.again.as_ref().map_or(&self.path, |(file, _)| file)
    }

    fn failed(&self, error: LogError) -> ClientError {
        failure(self.file(), self.ticks, error)
    }

    /// Whether the log is there and as long as what was written to it. Only a
    /// file has a length.
    fn check_length(&self) -> Result<(), ClientError> {
        let path = self.file();
        let found = fs::metadata(path).map_err(ClientError::io(path))?;
        let written = self.writer.output().taken_bytes();
        if !found.is_file() || found.len() == written {
            return Ok(());
        }
        let (path, found) = (path.display(), found.len());
        Err(ClientError::Unusable(format!(
            "{path} has {found} bytes where {written} were written: something else writes to it or \
             cuts it, and the log is not complete; keep others away from it and run again"
        )))
    }
}

/// What kept a log from being written, with how far it had come and what helps.
fn failure(path: &Path, ticks: u64, error: LogError) -> ClientError {
    match error {
        LogError::Io { error, .. } => {
            ClientError::Logging { path: path.display().to_string(), ticks, error }
        }
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::log::{Ending as LogEnding, LogReader, Read};

    #[test]
    fn a_log_can_be_read_as_soon_as_it_was_created() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.log");
        let writer = create(&path, &measure::header(10)).unwrap();
        let read = LogReader::open(&path).unwrap().read().unwrap();
        assert!(matches!(read, Read::End(LogEnding::Cut { ticks: 0, .. })), "{read:?}");
        drop(writer);
    }
}
