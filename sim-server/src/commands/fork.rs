//! `fork`: repeat a simulated run with changes from a tick.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Result, anyhow};
use clap::Args;
use rusty_contract::log::LogReader;
use rusty_contract::score::Score;
use rusty_contract::{
    Exit, FieldError, Json as _, LogHeader, Role, RunConfig, Scenario, ScoreReport, errln, input,
};
use rusty_engine::run::{find_program, with_folder};
use rusty_engine::scenario_file;
use rusty_engine::source::FrameSource as _;
use rusty_logs::fork::Branch;

use super::arguments::{RunArgs, seed_or_random};
use super::session::{RunPlace, RunSession, Starting};

#[derive(Args, Clone, Debug)]
pub struct ForkArgs {
    /// Log of a simulated run
    pub log: PathBuf,
    /// First tick that differs from the original run
    #[arg(long, value_name = "TICK")]
    pub at: u64,
    /// Change a field from that tick, e.g. robot.slip_std=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// Seed from that tick, a number or random [default: the log's]
    #[arg(long, value_parser = seed_or_random, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// Total number of ticks [default: the log's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Log of another robot of the run that has a driver
    #[arg(long, value_name = "LOG")]
    pub with: Vec<PathBuf>,
    #[command(flatten)]
    pub run: RunArgs,
}

pub fn run(args: &ForkArgs) -> Result<Exit> {
    let before = LogReader::open(&args.log)?.header().clone();
    let mut after = scenario_file::change_config(&before.config, &args.changes)?;
    after.seed = args.seed.unwrap_or(after.seed);
    after.ticks = args.ticks.unwrap_or(after.ticks);
    check(args, &before.config, &after)?;
    let mut source = Branch::new(&args.log, args.at, after, &args.with)?;
    args.run.change_roster(&mut source.header_mut().roster)?;
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
    let driven = header.config.script.is_driver();
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

fn score(log: &Path, name: &str, command: &[String]) -> Result<Vec<Score>> {
    let folder = tempfile::tempdir()?;
    let ended = find_program(name, &command[0])?
        .command()
        .args(with_folder(&command[1..], folder.path()))
        .arg("--log")
        .arg(log)
        .arg("--out")
        .arg(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .output()?;
    let json = input::read(&folder.path().join("score.json")).map_err(|_| {
        let stderr = String::from_utf8_lossy(&ended.stderr);
        anyhow!("{}", stderr.lines().last().unwrap_or("the scorer wrote nothing"))
    })?;
    Ok(ScoreReport::from_json(&json)?.scores)
}
