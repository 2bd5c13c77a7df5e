//! The scorer: compares every estimate with the truth, and draws the run.

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;

use rusty_contract::score::ScoreTable;
use rusty_contract::{Brief, Exit, RunDigest, ScoreReport, Start};

use crate::logger::output_folder;
use crate::scoring::{RunTrace, png, score, svg};
use crate::witness::{Ending, Step, Witness};
use crate::{ClientArgs, ClientError};

/// Compares every estimate with the truth; at the end writes `score.json`,
/// `run.svg` and `run.png`, and prints the table.
pub struct Scorer {
    folder: PathBuf,
    trace: RunTrace,
    seed: Option<u64>,
    digest: RunDigest,
}

impl Witness for Scorer {
    fn start(_: &Start, brief: &Brief, args: &ClientArgs) -> Result<Self, ClientError> {
        Ok(Self {
            folder: output_folder(brief, args)?,
            trace: RunTrace::new(&brief.header),
            seed: brief.header.seed(),
            digest: RunDigest::default(),
        })
    }

    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        let estimates = step.replies.iter().map(|r| r.estimate().map(|e| e.pose_in_world));
        self.trace.push(step.frame.time_s(), step.truth, step.frame.ranges_m(), estimates);
        self.digest = step.digest;
        Ok(())
    }

    fn finish(mut self, ending: Ending) -> Result<Exit, ClientError> {
        self.trace.digest = self.digest.run_hex();
        let scores = score(&self.trace);
        let mut report = ScoreReport {
            scenario: self.trace.scenario.clone(),
            seed: self.seed,
            ticks: self.trace.time_s.len() as u64,
            ticks_with_truth: self.trace.truth.iter().flatten().count() as u64,
            digest: self.trace.digest.clone(),
            scores,
            pictures: Vec::new(),
        };
        let drawn = self.draw(&mut report);
        // The numbers are written even where the picture could not be.
        let path = self.folder.join("score.json");
        let json = serde_json::to_vec_pretty(&report)
            .map_err(|e| ClientError::Unusable(format!("the scores cannot be written: {e}")))?;
        fs::write(&path, json).map_err(ClientError::io(&path))?;
        let _ = writeln!(std::io::stdout(), "{}", ScoreTable(&report.scores));
        drawn?;
        Ok(match ending {
            Ending::Broken | Ending::LogCut => Exit::Lost,
            Ending::Told(_) | Ending::LogEnd => Exit::Done,
        })
    }
}

impl Scorer {
    fn draw(&self, report: &mut ScoreReport) -> Result<(), ClientError> {
        let picture = |e: &dyn std::fmt::Display| ClientError::Picture(e.to_string());
        let drawing = svg(&self.trace, &report.scores).map_err(|e| picture(&e))?;
        let path = self.folder.join("run.svg");
        fs::write(&path, &drawing).map_err(ClientError::io(&path))?;
        report.pictures.push(path.display().to_string());
        let pixels = png(&drawing).map_err(|e| picture(&e))?;
        let path = self.folder.join("run.png");
        fs::write(&path, pixels).map_err(ClientError::io(&path))?;
        report.pictures.push(path.display().to_string());
        Ok(())
    }
}
