//! `Showing`: a filter's beliefs, on their way to an observer, or into a
//! file.
//!
//! In a run they go out after the answer, and only while a process observes: whether
//! anybody does changes no bit of it. On a log, `--beliefs` writes those of every
//! so-manieth scan, at most about [`MOST_MOMENTS`] of a run as long as planned;
//! which ones depends on the log alone.

use std::fs::File;
use std::io::BufWriter;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use rusty_contract::belief::{BeliefFileError, BeliefFileHeader, BeliefWriter, tidy};
use rusty_contract::digest::observable_of;
use rusty_contract::{Start, WeightedPose, errln, output};

use crate::{ClientArgs, ClientError, Filter, Session, Tick};

/// The most moments of a filter that are kept; it is even.
pub const MOST_MOMENTS: usize = 256;

/// Where beliefs go.
pub(crate) struct Showing {
    to: To,
    has_scanned: bool,
    /// Reused, so that a tick allocates nothing.
    poses: Vec<WeightedPose>,
    /// Why a file is not what was asked for: no reason for the filter to stop.
    problem: Option<ClientError>,
}

enum To {
    /// The observers of the run.
    Viewers,
    /// A file: one of `every` moments, of which `seen` have passed.
    File { path: PathBuf, writer: BeliefWriter<BufWriter<File>>, every: u64, seen: u64 },
    /// Nowhere: on a log without `--beliefs`, or because the filter panicked.
    Nobody,
}

/// A tick after which a belief may be shown.
pub(crate) struct Moment {
    tick: u64,
    time_s: f64,
    /// Of its frame; needed in a file only.
    observable: u64,
}

impl Showing {
    pub(crate) fn new(args: &ClientArgs, start: &Start) -> Result<Self, ClientError> {
        let to = match (&args.beliefs[..], &args.log) {
            ([], None) => To::Viewers,
            ([], Some(_)) => To::Nobody,
            ([path], _) => create(path, args, start)?,
            _ => {
                let text = "a filter writes its beliefs to one file: give --beliefs once";
                return Err(ClientError::Unusable(text.to_owned()));
            }
        };
        Ok(Self { to, has_scanned: false, poses: Vec::new(), problem: None })
    }

    /// Whether a tick is one after which a belief is shown: it has a scan, or
    /// none has had one yet. A file takes one of this many.
    pub(crate) fn moment(&mut self, tick: &Tick<'_>) -> Option<Moment> {
        let has_scan = tick.ranges_m().is_some();
        let is_one = has_scan || !self.has_scanned;
        self.has_scanned |= has_scan;
        let observable = match &mut self.to {
            To::Viewers if is_one => 0,
            To::File { every, seen, .. } if is_one => {
                *seen += 1;
                if !(*seen - 1).is_multiple_of(*every) {
                    return None;
                }
                observable_of(tick.frame())
            }
            _ => return None,
        };
        Some(Moment { tick: tick.index(), time_s: tick.time_s(), observable })
    }

    /// Shows the belief that the filter holds now.
    pub(crate) fn show(
        &mut self,
        session: &mut Session,
        moment: Option<Moment>,
        filter: &impl Filter,
    ) {
        let shown = moment.map_or(Ok(()), |moment| self.try_show(session, moment, filter));
        if let Err(problem) = shown {
            (self.problem, self.to) = (Some(problem), To::Nobody);
        }
    }

    fn try_show(
        &mut self,
        session: &mut Session,
        moment: Moment,
        filter: &impl Filter,
    ) -> Result<(), ClientError> {
        let Moment { tick, time_s, observable } = moment;
        let live = matches!(self.to, To::Viewers);
        if live && !session.is_watched() {
            return Ok(());
        }
        let poses = &mut self.poses;
        poses.clear();
        let Ok(kind) = catch_unwind(AssertUnwindSafe(|| filter.belief(poses))) else {
            if !live {
                return Err(ClientError::Panicked { tick });
            }
            // The run does not depend on it: it goes on, unseen.
            errln!(
                "tick {tick}: the filter panicked while it showed its belief; it is not asked again"
            );
            self.to = To::Nobody;
            return Ok(());
        };
        let Some(kind) = kind else { return Ok(()) };
        match &mut self.to {
            To::Viewers => session.show_belief((tick, time_s), kind, poses),
            To::File { path, writer, .. } => {
                let whole = tidy(poses);
                if whole > 0 {
                    let written = writer.moment((tick, observable), (kind, whole), poses);
                    written.map_err(failure(path))?;
                }
            }
            To::Nobody => {}
        }
        Ok(())
    }

    /// Writes the end of a file. One without a belief is taken away again.
    pub(crate) fn finish(self) -> Result<(), ClientError> {
        if let Some(problem) = self.problem {
            return Err(problem);
        }
        let To::File { path, writer, .. } = self.to else { return Ok(()) };
        if writer.moments() == 0 {
            let _ = std::fs::remove_file(&path);
            let text = format!("{}: this filter had no belief to show on this log", path.display());
            return Err(ClientError::Unusable(text));
        }
        writer.finish().map(drop).map_err(failure(&path))
    }
}

fn create(path: &Path, args: &ClientArgs, start: &Start) -> Result<To, ClientError> {
    args.check_free(path)?;
    let writer = belief_file(path, &args.name(), &start.scenario)?;
    // A recording has scans when it has them: some for every eight ticks, say.
    let between = if start.scan_every == 0 { 8 } else { start.scan_every };
    let planned = start.ticks / between;
    let every = planned.div_ceil(MOST_MOMENTS as u64).max(1);
    Ok(To::File { path: path.to_owned(), writer, every, seen: 0 })
}

/// Creates a file for the beliefs of the filter `name`.
pub fn belief_file(
    path: &Path,
    name: &str,
    scenario: &str,
) -> Result<BeliefWriter<BufWriter<File>>, ClientError> {
    let header = BeliefFileHeader {
        writer: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")).to_owned(),
        name: name.to_owned(),
        scenario: scenario.to_owned(),
    };
    let out = BufWriter::new(output::create(path).map_err(ClientError::io(path))?);
    BeliefWriter::new(out, &header).map_err(failure(path))
}

/// Wraps an error about a file of beliefs.
pub fn failure(path: &Path) -> impl FnOnce(BeliefFileError) -> ClientError {
    let path = path.display().to_string();
    move |error| ClientError::Beliefs { path, error }
}
