//! The logger: writes the run down as it happens.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rusty_contract::log::{LogWriter, TickRef, Trailer};
use rusty_contract::{Brief, Exit, Phase, RunDigest, Start};

use crate::witness::{Ending, Step, Witness};
use crate::{ClientArgs, ClientError};

/// Nothing older than this stays in a buffer while ticks come.
const FLUSH_AFTER: Duration = Duration::from_millis(200);

/// Writes a log: a record per tick, the trailer at the end.
pub struct Logger {
    path: PathBuf,
    /// Where it writes until it has caught up with the run it comes back into,
    /// and how many ticks that takes: what its predecessor saved stays till then.
    again: Option<(PathBuf, u64)>,
    writer: LogWriter,
    dt_s: f64,
    ticks: u64,
    digest: RunDigest,
    flushed: Instant,
}

/// Where a witness writes `file`: into `--out`, or the run's folder.
pub(crate) fn output_folder(brief: &Brief, args: &ClientArgs) -> Result<PathBuf, ClientError> {
    let folder = match (&args.out, &brief.out_dir) {
        (Some(out), _) => out.clone(),
        (None, Some(out)) => PathBuf::from(out),
        (None, None) => {
            args.log.as_ref().and_then(|log| log.parent().map(Path::to_owned)).unwrap_or_default()
        }
    };
    if !folder.as_os_str().is_empty() {
        fs::create_dir_all(&folder).map_err(ClientError::io(&folder))?;
    }
    Ok(folder)
}

impl Witness for Logger {
    fn start(start: &Start, brief: &Brief, args: &ClientArgs) -> Result<Self, ClientError> {
        let path = output_folder(brief, args)?.join("run.log");
        if args.log.as_ref().is_some_and(|log| same_file(log, &path)) {
            let path = path.display();
            let text = format!("{path} is the log being read; give another folder with --out");
            return Err(ClientError::Unusable(text));
        }
        let again = start.catch_up.as_ref().map(|c| (path.with_extension("log.again"), c.ticks));
        let file = again.as_ref().map_or(&path, |(file, _)| file);
        let writer = LogWriter::create(file, &brief.header)?;
        let (dt_s, digest) = (brief.header.config.dt_s, RunDigest::default());
        Ok(Self { path, again, writer, dt_s, ticks: 0, digest, flushed: Instant::now() })
    }

    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        self.writer.tick(TickRef::new(step.frame, step.truth, step.replies, self.dt_s))?;
        self.ticks += 1;
        self.digest = step.digest;
        if let Some((file, _)) = self.again.take_if(|(_, ticks)| *ticks <= self.ticks) {
            self.writer.flush()?;
            fs::rename(&file, &self.path).map_err(ClientError::io(&self.path))?;
        }
        if self.flushed.elapsed() >= FLUSH_AFTER {
            self.writer.flush()?;
            self.flushed = Instant::now();
        }
        Ok(())
    }

    fn finish(mut self, ending: Ending) -> Result<Exit, ClientError> {
        if matches!(ending, Ending::Broken | Ending::LogCut) {
            self.writer.flush()?;
            if let Some((file, of)) = &self.again {
                let _ = fs::remove_file(file);
                let (path, ticks) = (self.path.display(), self.ticks);
                crate::error::say(format_args!(
                    "the run ended after {ticks} of {of} ticks had been given again; {path} is as \
                     the logger before left it"
                ));
                return Ok(Exit::Lost);
            }
            let (path, ticks) = (self.path.display(), self.ticks);
            crate::error::say(format_args!("{path} holds {ticks} complete ticks and no trailer"));
            return Ok(Exit::Lost);
        }
        self.writer.finish(Trailer {
            ticks: self.ticks,
            run_digest: self.digest.run(),
            world_digest: self.digest.world(),
        })?;
        let interrupted = ending == Ending::Told(Phase::Aborted);
        Ok(if interrupted { Exit::Lost } else { Exit::Done })
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
