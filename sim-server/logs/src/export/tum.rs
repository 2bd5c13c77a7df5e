//! Trajectories in the format of the TUM RGB-D benchmark, which evo reads.
//!
//! [`rusty_contract::tum`] has its lines.

use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use rusty_contract::output::make_folder;
use rusty_contract::tum::line;

use super::error::ExportError;
use super::sheet::Sheet;
use super::walk::{StampOrder, Walk, truth};
use super::{Exported, Written};

/// The name of the truth among those of the estimators.
const TRUTH: &str = "truth";

/// How trajectories are written.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tum {
    /// Every estimate, also of ticks without a known true pose.
    pub all: bool,
    /// Over files that are there.
    pub force: bool,
}

/// File name of an estimator's trajectory; the truth keeps its own.
fn file_name(estimator: &str) -> String {
    let is_truth = estimator.eq_ignore_ascii_case(TRUTH);
    if is_truth { format!("{estimator}.estimate.tum") } else { format!("{estimator}.tum") }
}

impl Tum {
    /// Writes the trajectories of `log` into `folder`, which is made if need be.
    /// Of a log with a truth, an estimator's trajectory has the ticks that are
    /// scored (see [`Tum::all`]). No file is empty: a participant that has no pose has no
    /// file.
    ///
    /// # Errors
    /// [`ExportError`]; nothing is written then.
    pub fn export(
        self,
        log: &Path,
        folder: &Path,
        stop: &AtomicBool,
    ) -> Result<Exported, ExportError> {
        let every = self.all || !has_truth(log, stop)?;
        let mut walk = Walk::open(log, stop)?;
        let made = !folder.exists();
        make_folder(folder).map_err(ExportError::io(folder))?;
        let done = self.write(&mut walk, folder, every);
        if done.is_err() && made {
            // Only if it is empty, which it is unless another process uses it.
            let _ = fs::remove_dir(folder);
        }
        let (files, ticks_with_truth, stamps) = done?;
        let wrote = |name: &String| files.iter().any(|w| w.estimator.as_ref() == Some(name));
        let without = walk.names().into_iter().filter(|name| !wrote(name)).collect();
        let (log, walked) = (log.display().to_string(), walk.walked.clone());
        Ok(Exported { log, walked, ticks_with_truth, stamps, files, without })
    }

    /// The files, the number of ticks with a truth, and the order of the stamps.
    fn write(
        self,
        walk: &mut Walk<'_>,
        folder: &Path,
        every: bool,
    ) -> Result<(Vec<Written>, u64, StampOrder), ExportError> {
        let names = walk.names();
        let sheet = |name: &str| Sheet::create(&folder.join(name), self.force);
        let mut of_truth = sheet(&format!("{TRUTH}.tum"))?;
        let estimators = names.iter().map(|name| sheet(&file_name(name)));
        let mut sheets = estimators.collect::<Result<Vec<Sheet>, _>>()?;
        let (dt_s, mut stamps) = (walk.header.config.dt_s, StampOrder::default());
        while let Some(record) = walk.tick()? {
            let (time_s, truth) = (record.time_s(dt_s), truth(&record));
            if let Some(pose) = &truth {
                of_truth.line(format_args!("{}", line(time_s, pose)))?;
            }
            if truth.is_none() && !every {
                continue;
            }
            stamps.see(time_s);
            for (sheet, estimate) in sheets.iter_mut().zip(walk.estimates()) {
                if let Some(estimate) = estimate {
                    sheet.line(format_args!("{}", line(time_s, &estimate.pose_in_world)))?;
                }
            }
        }
        let truths = of_truth.lines;
        let mut files = Vec::new();
        let all = std::iter::once((None, of_truth)).chain(names.into_iter().map(Some).zip(sheets));
        for (estimator, sheet) in all {
            match sheet.lines {
                // A trajectory of another log must not be taken for this one's.
                0 => sheet.discard()?,
                lines => files.push(Written { estimator, lines, path: sheet.finish()? }),
            }
        }
        Ok((files, truths, stamps))
    }
}

/// Whether any tick of a log has a known true pose.
fn has_truth(log: &Path, stop: &AtomicBool) -> Result<bool, ExportError> {
    let mut walk = Walk::open(log, stop)?;
    while let Some(record) = walk.tick()? {
        if truth(&record).is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimator_called_truth_is_not_taken_for_it() {
        assert_eq!(file_name("truth"), "truth.estimate.tum");
        assert_eq!(file_name("truth-2"), "truth-2.tum");
    }
}
