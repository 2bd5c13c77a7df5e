//! `fork`: a simulated run again, with something changed from a tick on.

use std::path::Path;
use std::process::{Command, Stdio};

use rusty_contract::log::LogReader;
use rusty_contract::score::Score;
use rusty_contract::{FieldError, LogHeader, Role, RunConfig, Scenario, ScoreReport, ScriptConfig};
use rusty_contract::{errln, input};

use super::Verbed;
use super::launch::change_roster;
use super::session::{RunPlace, RunSession, Starting};
use crate::cli::ForkArgs;
use rusty_engine::run::{find_program, with_folder};
use rusty_engine::scenario_file;
use rusty_engine::source::{Branch, FrameSource as _};

/// Runs a log's scenario again with its participants, and changes the world at
/// a tick.
///
/// # Errors
/// [`VerbError`](crate::error::VerbError) before the run; losses in the run are an exit code.
pub fn fork(args: &ForkArgs) -> Verbed {
    let before = LogReader::open(&args.log)?.header().clone();
    let mut after = scenario_file::change_config(&before.config, &args.changes)?;
    after.seed = args.seed.unwrap_or(after.seed);
    after.ticks = args.ticks.unwrap_or(after.ticks);
    check(args, &before.config, &after)?;
    let mut source = Branch::new(&args.log, args.at, after)?;
    change_roster(&mut source.header_mut().roster, &args.run)?;
    check_driver(source.header())?;
    let place = RunPlace::find(&args.run, &source.header().config.scenario, Some(&args.log))?;
    source.fork_mut().original_scores = original_scores(&args.log, source.header());
    let defaults = Scenario::default();
    RunSession {
        args: &args.run,
        starting: Starting::Launch,
        answer_timeout_s: defaults.answer_timeout_s,
        join_timeout_s: defaults.join_timeout_s,
        announced: true,
    }
    .run(place, &mut source)
}

fn check(args: &ForkArgs, before: &RunConfig, after: &RunConfig) -> Result<(), FieldError> {
    after.check()?;
    before.check_change(after)?;
    if args.at == 0 {
        let remedy = "use `sim-server launch` for a run that differs from the start";
        return Err(FieldError::new("--at", 0, "leaves nothing of the original", remedy));
    }
    if args.at >= after.ticks {
        let problem = format!("is behind the last tick of the branch ({})", after.ticks - 1);
        return Err(FieldError::new(
            "--at",
            args.at,
            problem,
            "give more --ticks, or fork earlier",
        ));
    }
    Ok(())
}

/// Without its driver the robot would stand, from the first tick on.
fn check_driver(header: &LogHeader) -> Result<(), FieldError> {
    let driven = matches!(header.config.script, ScriptConfig::Driver {});
    if driven && header.answering().all(|p| p.role != Role::Driver) {
        let problem = "takes away the driver, and without it the past does not come again";
        return Err(FieldError::new("--without", "", problem, "leave the driver in"));
    }
    Ok(())
}

/// The original's scores, by the scorer that takes part in the branch. Without
/// them the branch is a run all the same.
fn original_scores(log: &Path, header: &LogHeader) -> Vec<Score> {
    let scorer = header.roster.iter().find(|p| p.role == Role::Scorer && !p.command.is_empty());
    let Some(scorer) = scorer else { return Vec::new() };
    match score(log, &scorer.name, &scorer.command) {
        Ok(scores) => scores,
        Err(why) => {
            errln!("{}: the original cannot be scored: {why}", log.display());
            Vec::new()
        }
    }
}

fn score(log: &Path, name: &str, command: &[String]) -> Result<Vec<Score>, String> {
    let text = |e: &dyn std::fmt::Display| e.to_string();
    let program = find_program(name, &command[0]).map_err(|e| text(&e))?;
    let folder = tempfile::tempdir().map_err(|e| text(&e))?;
    let mut process = Command::new(program);
    process
        .args(with_folder(&command[1..], folder.path()))
        .arg("--log")
        .arg(log)
        .arg("--out")
        .arg(folder.path());
    let quiet = process.stdin(Stdio::null()).stdout(Stdio::null());
    let ended = quiet.output().map_err(|e| text(&e))?;
    let json = input::read(&folder.path().join("score.json")).map_err(|_| {
        let said = String::from_utf8_lossy(&ended.stderr);
        said.lines().last().unwrap_or("the scorer wrote nothing").to_owned()
    })?;
    let report: ScoreReport = serde_json::from_slice(&json).map_err(|e| text(&e))?;
    Ok(report.scores)
}
