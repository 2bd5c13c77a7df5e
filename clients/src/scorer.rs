//! The scorer: compares every estimate with the truth, and draws the run.

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;

use rusty_contract::score::ScoreTable;
use rusty_contract::{Brief, Effects, Exit, RunDigest, ScoreReport, Start};
use rusty_plot::png;

use crate::logger::output_folder;
use crate::scoring::{RunTrace, score, svg};
use crate::witness::{Ending, Step, Witness};
use crate::{ClientArgs, ClientError};

/// Compares every estimate with the truth; at the end writes `score.json`,
/// `run.svg` and `run.png`, and prints the table.
pub struct Scorer {
    folder: PathBuf,
    trace: RunTrace,
    seed: Option<u64>,
    blind: bool,
    digest: RunDigest,
    /// Which answers are in effect.
    effects: Effects,
}

impl Witness for Scorer {
    fn start(_: &Start, brief: &Brief, args: &ClientArgs) -> Result<Self, ClientError> {
        let blind = brief.header.is_blind();
        if let (true, Some(log)) = (blind, &args.log) {
            let log = log.display();
            let text = format!("{log} is blind, nothing in it can be scored: give its --key-file");
            return Err(ClientError::Unusable(text));
        }
        Ok(Self {
            blind,
            folder: output_folder(brief, args)?,
            trace: RunTrace::new(&brief.header),
            seed: brief.header.seed(),
            digest: RunDigest::default(),
            effects: Effects::of(&brief.header),
        })
    }

    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        // A late estimate is judged as late as it is.
        let (tick, has_scan) = (step.frame.tick(), step.frame.ranges_m().is_some());
        self.effects.close(tick, has_scan, step.replies.iter().copied());
        let estimates = self.effects.replies().map(|r| r.estimate().map(|e| e.pose_in_world));
        self.trace.push(step.frame.time_s(), step.truth, step.frame.ranges_m(), estimates);
        self.digest = step.digest;
        Ok(())
    }

    fn finish(mut self, ending: Ending) -> Result<Exit, ClientError> {
        self.trace.digest = self.digest.run_hex();
        let ticks_with_truth = self.trace.truth.iter().flatten().count() as u64;
        // Without a truth there is no figure, and a distance of 0 m is none.
        let unscored = (ticks_with_truth == 0).then(|| self.why_unscored());
        let scores = if unscored.is_none() { score(&self.trace) } else { Vec::new() };
        let mut report = ScoreReport {
            scenario: self.trace.scenario.clone(),
            seed: self.seed,
            ticks: self.trace.time_s.len() as u64,
            ticks_with_truth,
            digest: self.trace.digest.clone(),
            scores,
            unscored,
            pictures: Vec::new(),
        };
        let drawn = self.draw(&mut report);
        // The numbers are written even where the picture could not be.
        let path = self.folder.join("score.json");
        let json = serde_json::to_vec_pretty(&report)
            .map_err(|e| ClientError::Unusable(format!("the scores cannot be written: {e}")))?;
        fs::write(&path, json).map_err(ClientError::io(&path))?;
        let _ = match &report.unscored {
            Some(why) => writeln!(std::io::stdout(), "unscored: {why}"),
            None => writeln!(std::io::stdout(), "{}", ScoreTable(&report.scores)),
        };
        drawn?;
        Ok(match ending {
            Ending::Broken | Ending::LogCut => Exit::Lost,
            Ending::Told(_) | Ending::LogEnd => Exit::Done,
        })
    }
}

impl Scorer {
    fn why_unscored(&self) -> String {
        if self.blind {
            "the frames are those of a blind log, and their truth is in its key: log this run, \
             then `score --log run.log --key-file KEY`"
                .to_owned()
        } else {
            "no tick of this run has a known truth".to_owned()
        }
    }

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
