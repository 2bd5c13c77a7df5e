//! A run with its first line, progress, report and exit code.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use rusty_contract::config::check_seconds;
use rusty_contract::score::seconds;
use rusty_contract::{Exit, FieldError, LogHeader, RunName, errln, outln};
use rusty_engine::confine::{self, Gate};
use rusty_engine::run::{Outcome, RunBuilder, RunError, find_program, fresh_name};
use rusty_logs::folder::{FreeFolder, Marker, RunEnd};
use rusty_logs::original::Compare;

use super::arguments::RunArgs;
use super::report::{RunReport, how_ended};
use super::warn_of_guessable_seed;

/// Who starts the participants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Starting {
    /// The server.
    Launch,
    /// The user.
    ByHand,
}

/// The name of a run and the folder that is free for it.
pub(super) struct RunPlace {
    name: RunName,
    folder: FreeFolder,
}

impl RunPlace {
    /// Looks for it; nothing is written yet. `played` is a log that the run reads.
    pub(super) fn find(args: &RunArgs, scenario: &str, played: Option<&Path>) -> Result<Self> {
        let name = match &args.run {
            Some(name) => name.clone(),
            None => name_after(scenario)?,
        };
        let path = args.out.clone().unwrap_or_else(|| Path::new("runs").join(name.as_str()));
        Ok(Self { folder: FreeFolder::check(&path, args.force, played)?, name })
    }
}

/// A run to be made.
pub(super) struct RunSession<'a> {
    pub args: &'a RunArgs,
    pub starting: Starting,
    pub answer_timeout_s: f64,
    pub join_timeout_s: f64,
    /// Whether a first line says what is run.
    pub announced: bool,
}

/// A run that was made, before anybody is told of it.
pub(super) struct FinishedRun {
    pub header: LogHeader,
    pub name: RunName,
    pub out_dir: PathBuf,
    pub outcome: Outcome,
    /// How far the kernel confines each participant.
    pub gates: Vec<Gate>,
}

impl RunSession<'_> {
    pub(super) fn run(self, place: RunPlace, source: &mut impl Compare) -> Result<Exit> {
        let made = self.make(place, source)?;
        let FinishedRun { header, name, out_dir, outcome, gates } = &made;
        let Outcome { ended_badly, outputs, .. } = outcome;
        let report = RunReport::new(header, name, out_dir, outcome, ended_badly, source)
            .with_outputs(header, outputs, ended_badly)
            .with_gates(header, gates);
        self.args.output.print(&report);
        Ok(report.exit())
    }

    /// Makes the run, from the first join to the end of the last participant.
    pub(super) fn make(&self, place: RunPlace, source: &mut impl Compare) -> Result<FinishedRun> {
        let RunPlace { name, folder } = place;
        let args = self.args;
        let header = source.header().clone();
        let (answer_timeout_s, join_timeout_s) = self.timeouts_s()?;
        confine::close_memory().context("this process's memory")?;
        let options = RunBuilder {
            pace: args.pace,
            paused: args.paused,
            join_timeout_s,
            answer_timeout_s,
            by_hand: self.starting == Starting::ByHand,
            quiet: args.quiet || args.output.json,
            ..RunBuilder::new(name.clone(), args.wait)
        };
        let prepared = options.prepare(&header.roster)?;
        let gates = prepared.gates().to_vec();
        report_gates(&header, &gates);
        let mut folder = folder.take(Marker::new(name.as_str(), &header))?;
        let out_dir = folder.path().to_owned();
        if self.announced {
            self.first_line(&header, &name, source.tick_count());
            if header.roster.iter().any(|p| !p.sandbox.is_none()) {
                warn_of_guessable_seed(&header, "a confined participant");
            }
        }
        let run = prepared.build(source, &out_dir)?;
        folder.begin();
        let outcome = run.drive()?;
        let end = RunEnd {
            ended: how_ended(outcome.phase).to_owned(),
            ticks: outcome.ticks,
            digest: outcome.digest.run_hex(),
        };
        // The run is none the worse for it; `runs` then has it as cut short.
        folder.end(end).unwrap_or_else(|e| errln!("{e}"));
        Ok(FinishedRun { header, name, out_dir, outcome, gates })
    }

    /// How long an answer, and joining, may take, s.
    fn timeouts_s(&self) -> Result<(f64, f64), FieldError> {
        let answer_s = self.args.answer_timeout.unwrap_or(self.answer_timeout_s);
        let join_s = self.args.join_timeout.unwrap_or(self.join_timeout_s);
        check_seconds("--answer-timeout", answer_s)?;
        check_seconds("--join-timeout", join_s)?;
        Ok((answer_s, join_s))
    }

    fn first_line(&self, header: &LogHeader, name: &RunName, ticks: u64) {
        let config = &header.config;
        let line = format!(
            "{} · scenario {} · {ticks} ticks of {} s · run {name}",
            header.seed_in_words(),
            config.scenario,
            seconds(config.dt_s)
        );
        if self.args.output.json {
            errln!("{line}");
        } else {
            outln!("{line}");
        }
        if self.args.paused {
            errln!("paused; `sim-server control {name} step` or `resume` lets it go on");
        }
        if self.starting == Starting::ByHand {
            let expected: Vec<&str> =
                header.roster.iter().filter(|p| p.is_awaited()).map(|p| p.name.as_str()).collect();
            errln!("waiting for {} (each with --run {name})", expected.join(", "));
            return;
        }
        for p in header.roster.iter().filter(|p| p.is_awaited() && p.command.is_empty()) {
            let p = &p.name;
            let found = find_program(p, p).ok().map(|path| path.display().to_string());
            let offer = found.map(|path| format!(", or use --add {p}={p} ({path})"));
            let offer = offer.unwrap_or_default();
            errln!("waiting for {p}, which has no command: start it with --run {name}{offer}");
        }
    }
}

/// Prints a line for each participant whose sandbox is not what was asked for.
fn report_gates(header: &LogHeader, gates: &[Gate]) {
    for (participant, gate) in header.roster.iter().zip(gates) {
        if matches!(gate, Gate::Partial { .. } | Gate::Down { .. }) {
            errln!("{}: {gate}", participant.name);
        }
    }
}

/// Returns the scenario's name, shortened, and eight random digits.
fn name_after(scenario: &str) -> Result<RunName, RunError> {
    let stem: String =
        scenario.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '-').take(14).collect();
    let stem = stem.trim_start_matches('-');
    fresh_name(if stem.is_empty() { "run" } else { stem })
}
