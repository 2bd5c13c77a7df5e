//! A run with its first line, progress, report and exit code.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use rusty_contract::config::check_seconds;
use rusty_contract::score::seconds;
use rusty_contract::{Exit, FieldError, LogHeader, RunName, errln, outln};
use rusty_engine::confine::{self, Gate};
use rusty_engine::run::{
    Outcome, Pace, Run, RunBuilder, RunError, Stop, check_limits, find_program, fresh_name,
};
use rusty_logs::folder::{FreeFolder, Marker, RunEnd, RunFolder};
use rusty_logs::original::Compare;

use super::arguments::RunArgs;
use super::report::{RunReport, how_ended};
use super::warn_of_guessable_seed;
use super::watch::Viewer;

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
    /// Looks for it; nothing is written yet. `played` are the logs that the run reads.
    pub(super) fn find(args: &RunArgs, scenario: &str, played: &[&Path]) -> Result<Self> {
        let name = match &args.run {
            Some(name) => name.clone(),
            None => name_after(scenario, 0)?,
        };
        let path = args.out.clone().unwrap_or_else(|| Path::new("runs").join(name.as_str()));
        Ok(Self { folder: FreeFolder::check(&path, args.force, played)?, name })
    }

    /// Looks for the places of the runs of several robots: `NAME-robot` for each.
    pub(super) fn find_each(args: &RunArgs, scenario: &str, robots: &[&str]) -> Result<Vec<Self>> {
        let longest = robots.iter().map(|robot| robot.len() + 1).max().unwrap_or(0);
        let all = match &args.run {
            Some(name) => name.clone(),
            None => name_after(scenario, longest)?,
        };
        let place = |robot: &&str| {
            let name = RunName::new(&format!("{all}-{robot}"))?;
            let path = match &args.out {
                Some(folder) => folder.join(robot),
                None => Path::new("runs").join(name.as_str()),
            };
            Ok(Self { folder: FreeFolder::check(&path, args.force, &[])?, name })
        };
        robots.iter().map(place).collect()
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

/// The viewers of runs that have ended.
struct Watching {
    viewers: Vec<Viewer>,
    stop: Stop,
}

impl Watching {
    /// Waits until all pages are closed, or for Ctrl-C.
    fn stay(self) {
        self.viewers.into_iter().for_each(|viewer| viewer.stay(&self.stop));
    }
}

impl FinishedRun {
    fn report(&self, source: &impl Compare) -> RunReport {
        let Self { header, name, out_dir, outcome, gates } = self;
        let Outcome { ended_badly, outputs, .. } = outcome;
        RunReport::new(header, name, out_dir, outcome, source)
            .with_outputs(header, outputs, ended_badly)
            .with_gates(header, gates)
    }
}

impl RunSession<'_> {
    pub(super) fn run(self, place: RunPlace, source: &mut impl Compare) -> Result<Exit> {
        let (made, watching) = self.make_together(vec![place], std::slice::from_mut(source))?;
        let report = made[0].report(source);
        self.args.output.print(&report);
        watching.stay();
        Ok(report.exit())
    }

    /// Makes the runs of several robots, and reports on each.
    pub(super) fn run_together(
        self,
        places: Vec<RunPlace>,
        sources: &mut [impl Compare],
    ) -> Result<Exit> {
        let (made, watching) = self.make_together(places, sources)?;
        let reports = made.iter().zip(&*sources).map(|(made, source)| made.report(source));
        let reports: Vec<RunReport> = reports.collect();
        self.args.output.print_with(&reports, || reports.iter().for_each(|r| outln!("{r}")));
        watching.stay();
        Ok(reports.iter().map(RunReport::exit).max_by_key(|exit| *exit as u8).unwrap_or(Exit::Done))
    }

    /// Makes the run, from the first join to the end of the last participant.
    pub(super) fn make<S: Compare>(&self, place: RunPlace, source: &mut S) -> Result<FinishedRun> {
        let (mut made, _) = self.make_together(vec![place], std::slice::from_mut(source))?;
        Ok(made.swap_remove(0))
    }

    fn make_together(
        &self,
        places: Vec<RunPlace>,
        sources: &mut [impl Compare],
    ) -> Result<(Vec<FinishedRun>, Watching)> {
        confine::close_memory().context("this process's memory")?;
        let names: Vec<RunName> = places.iter().map(|place| place.name.clone()).collect();
        let participants = sources.iter().map(|source| source.header().roster.len()).sum();
        check_limits(names.len(), participants).map_err(RunError::from)?;
        let stop = Stop::listen(&names)?;
        let (mut runs, mut made, mut folders) = (Vec::new(), Vec::new(), Vec::new());
        let mut viewers = Vec::new();
        for (RunPlace { name, folder }, source) in places.into_iter().zip(sources) {
            let header = source.header().clone();
            let options = self.options(&name, &names[0], &header, &stop)?;
            let prepared = options.prepare(&header.roster)?;
            let gates = prepared.gates().to_vec();
            report_gates(&header, &gates);
            let folder = folder.take(Marker::new(name.as_str(), &header))?;
            let out_dir = folder.path().to_owned();
            if self.announced {
                self.first_line(&header, &name, source.tick_count());
                if header.roster.iter().any(|p| !p.sandbox.is_none()) {
                    warn_of_guessable_seed(&header, "a confined participant");
                }
            }
            if self.args.watch {
                let key = prepared.observer_credentials();
                viewers.push(Viewer::start(&name, &header, &key, &self.args.allow_origin)?);
            }
            runs.push(prepared.build(source, &out_dir)?);
            made.push((header, name, out_dir, gates));
            folders.push(folder);
        }
        folders.iter_mut().for_each(RunFolder::begin);
        let outcomes = match runs.len() {
            1 => vec![runs.swap_remove(0).drive()?],
            _ => Run::drive_together(runs)?,
        };
        let ended = made.into_iter().zip(outcomes).zip(folders);
        let finish =
            |(((header, name, out_dir, gates), outcome), folder): ((_, Outcome), RunFolder)| {
                let end = RunEnd {
                    ended: how_ended(outcome.phase).to_owned(),
                    ticks: outcome.ticks,
                    digest: outcome.digest.run_hex(),
                };
                // The run stays as it is; `runs` then has it as cut short.
                folder.end(end).unwrap_or_else(|e| errln!("{e}"));
                FinishedRun { header, name, out_dir, outcome, gates }
            };
        Ok((ended.map(finish).collect(), Watching { viewers, stop }))
    }

    /// The options of one run, of which the first sets the pace of all.
    fn options(
        &self,
        name: &RunName,
        first: &RunName,
        header: &LogHeader,
        stop: &Stop,
    ) -> Result<RunBuilder, FieldError> {
        let args = self.args;
        let (answer_timeout_s, join_timeout_s) = self.timeouts_s()?;
        let leader = (name != first).then(|| first.clone());
        Ok(RunBuilder {
            pace: if leader.is_none() { self.pace() } else { Pace::Max },
            paused: args.paused && leader.is_none(),
            join_timeout_s,
            answer_timeout_s,
            by_hand: self.starting == Starting::ByHand,
            quiet: args.quiet || args.output.json,
            report: !args.no_report,
            stop: Some(stop.clone()),
            robot: header.config.fleet.as_ref().map(|fleet| fleet.name.clone()),
            leader,
            ..RunBuilder::new(name.clone(), args.wait)
        })
    }

    /// A run that is shown goes in real time, unless it is told otherwise.
    fn pace(&self) -> Pace {
        let usual = if self.args.watch { Pace::Factor(1.0) } else { Pace::Max };
        self.args.pace.unwrap_or(usual)
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
            "{} · scenario {} ·{} {ticks} ticks of {} s · run {name}",
            header.seed_in_words(),
            config.scenario,
            config.fleet.as_ref().map_or(String::new(), |f| format!(" robot {} ·", f.name)),
            seconds(config.dt_s)
        );
        if self.args.output.json {
            errln!("{line}");
        } else {
            outln!("{line}");
        }
        let is_first = config.fleet.as_ref().is_none_or(|fleet| fleet.place == 0);
        if self.args.paused && is_first {
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
            let found = find_program(p, p).ok().map(|program| program.to_string());
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

/// Returns the scenario's name, shortened so that `free` characters fit behind all, and
/// eight random digits.
fn name_after(scenario: &str, free: usize) -> Result<RunName, RunError> {
    let room = 15_usize.saturating_sub(free.max(1));
    let stem: String =
        scenario.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '-').take(room).collect();
    let stem = stem.trim_start_matches('-');
    fresh_name(if stem.is_empty() { "run" } else { stem })
}
