//! `fork`: repeat a simulated run with changes from a tick.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Result, anyhow};
use clap::Args;
use rusty_contract::log::LogReader;
use rusty_contract::score::Score;
use rusty_contract::{
    Exit, FieldError, Json as _, JsonTree as _, LogHeader, Role, RunConfig, Scenario, ScoreReport,
    errln, input,
};
use rusty_engine::run::{find_program, with_folder};
use rusty_engine::scenario_file;
use rusty_engine::source::FrameSource as _;
use rusty_logs::fork::Branch;
use rusty_study::documents::{self, Difference};

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
    let given =
        [("seed", "--seed", args.seed.is_some()), ("ticks", "--ticks", args.ticks.is_some())];
    scenario_file::check_options(&args.changes, &given)?;
    let mut after = scenario_file::change_config(&before.config, &args.changes)?;
    after.seed = args.seed.unwrap_or(after.seed);
    after.ticks = args.ticks.unwrap_or(after.ticks);
    check(args, &before.config, &after)?;
    let mut source = Branch::new(&args.log, args.at, after, &args.with)?;
    args.run.change_roster(&mut source.header_mut().roster)?;
    check_driver(source.header())?;
    let played: Vec<&Path> =
        std::iter::once(&args.log).chain(&args.with).map(PathBuf::as_path).collect();
    let place = RunPlace::find(&args.run, &source.header().config.scenario, &played)?;
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
    before.check_change(after).map_err(|error| in_detail(error, before, after))?;
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
    check_past(args.at, before, after)
}

/// Refuses to change what happened before the fork, which the branch repeats.
fn check_past(at: u64, before: &RunConfig, after: &RunConfig) -> Result<(), FieldError> {
    let carried = |config: &RunConfig| {
        config.kidnappings.iter().filter(|k| k.tick < at).cloned().collect::<Vec<_>>()
    };
    let changed = |config: &RunConfig| {
        config.events.iter().filter(|e| e.tick() < at).cloned().collect::<Vec<_>>()
    };
    let field = match () {
        () if carried(before) != carried(after) => "kidnapping",
        () if changed(before) != changed(after) => "event",
        () => return Ok(()),
    };
    let problem = format!("changes what was before tick {at}, where the branch begins");
    let remedy = "repeat the entries of the log before it (`info --json`), and change later ones";
    Err(FieldError::new("--set", field, problem, remedy))
}

/// The same error about the first field that differs, where it is about a table.
fn in_detail(error: FieldError, before: &RunConfig, after: &RunConfig) -> FieldError {
    let [was, is] = [before, after].map(|config| config.to_tree().unwrap_or_default());
    let found = documents::differing(&was, &is);
    let first = found.into_iter().find(|found| found.path.starts_with(&error.field));
    let Some(Difference { path, values }) = first else { return error };
    let unset = |value: String| if value == "null" { "unset".to_owned() } else { value };
    let [was, value] = values.map(unset);
    let problem = format!("was {was} when the run began, and must stay so");
    FieldError { field: path.replacen("walkers", "walker", 1), value, problem, ..error }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_in_a_table_is_named_by_its_field() {
        let text = "[sensors.imu]\n[sensors.bumper]\n[[walker]]\nwaypoints = [[1, 2], [3, 4]]\n";
        let scenario = scenario_file::read(text, &[]).unwrap();
        let before = scenario.config(rusty_geometry::apartment().spec().clone());
        let refused = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|c| (*c).to_owned()).collect();
            let after = scenario_file::change_config(&before, &changes).unwrap();
            let error = in_detail(before.check_change(&after).unwrap_err(), &before, &after);
            (error.field, error.value)
        };
        for (change, field, value) in [
            ("sensors.imu.gyro_noise_deg_sqrt_h=3", "sensors.imu.gyro_noise_deg_sqrt_h", "3.0"),
            ("walkers=[{waypoints=[[1,2],[3.5,4]]}]", "walker[0].waypoints[1][0]", "3.5"),
            ("start.theta_rad=0.5", "start.theta_rad", "0.5"),
            ("lidar.beams=7", "lidar.beams", "7"),
        ] {
            assert_eq!(refused(&[change]), (field.to_owned(), value.to_owned()));
        }
    }
}
