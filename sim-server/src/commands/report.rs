//! The report of a run: the document of `--json`, and its text.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rusty_bench::usage::Usage;
use rusty_contract::log::Finding;
use rusty_contract::score::{GoalScore, Score, ScoreTable};
use rusty_contract::{Exit, LogHeader, Phase, RunName, ScoreReport, TextTable, Timing};
use rusty_engine::confine::Gate;
use rusty_engine::lockstep::{Loss, ParticipantSummary};
use rusty_engine::run::{Outcome, has_content};
use rusty_logs::comparison::Comparison;
use rusty_logs::fork::Fork;
use rusty_logs::original::Compare;
use serde::Serialize;

#[derive(Debug, Serialize)]
pub struct RunReport {
    pub scenario: String,
    pub run: String,
    /// The robot, where several share the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// The seed; null for a recording.
    pub seed: Option<u64>,
    /// Complete ticks.
    pub ticks: u64,
    pub ticks_planned: u64,
    /// How it ended: done, interrupted or aborted.
    pub ended: &'static str,
    pub digest: String,
    /// Digest of the frames and truths alone.
    pub world_digest: String,
    /// Ticks per second, from the first frame to the last answer.
    pub ticks_per_s: f64,
    pub elapsed_s: f64,
    /// The machine's monotonic clock when the first frame went out, ns: with
    /// the moment before the start, what starting took.
    pub first_frame_ns: Option<u64>,
    /// The most memory that was resident in the server, bytes; 0 where the
    /// kernel does not say.
    pub peak_resident_bytes: u64,
    pub server_pid: u32,
    /// The log; null without a logger.
    pub log: Option<String>,
    /// The scores; null without a scorer.
    pub scores_file: Option<String>,
    pub pictures: Vec<String>,
    /// The report, a page of hypertext; null without a scorer.
    pub report: Option<String>,
    /// In roster order.
    pub participants: Vec<ParticipantSummary>,
    /// How far the kernel confines each participant, by name.
    pub gates: BTreeMap<String, Gate>,
    pub losses: Vec<Loss>,
    /// Losses after which the participant returned.
    pub restarts: Vec<Loss>,
    /// The file with all that a participant printed, by name, for each that was
    /// lost or failed.
    pub outputs: BTreeMap<String, String>,
    /// Effects of modelled compute times.
    pub timings: Vec<Timing>,
    /// Participants that ended badly after the run, and why the run ended
    /// early, in words.
    pub remarks: Vec<String>,
    /// For a recording: its defects.
    pub findings: Vec<Finding>,
    /// One per estimator.
    pub scores: Vec<Score>,
    /// Ticks in which a wall kept the robot where it was; null without a scorer
    /// that can tell.
    pub blocked_ticks: Option<u64>,
    /// Goals that the robot reached, where the scorer has some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goals: Option<GoalScore>,
    /// Whether a participant drove.
    #[serde(skip)]
    driven: bool,
    /// Why there are none, where the scorer has no truth to compare with.
    pub unscored: Option<String>,
    /// For a replay: how the answers compare with the recorded ones.
    pub comparison: Option<Comparison>,
    /// For a fork: the comparison with its original. `comparison` is then about the
    /// ticks before it.
    pub fork: Option<Fork>,
}

pub(crate) fn how_ended(phase: Phase) -> &'static str {
    match phase {
        Phase::Tick | Phase::Done => "done",
        Phase::Interrupted => "interrupted",
        Phase::Aborted => "aborted",
    }
}

impl RunReport {
    pub fn new(
        header: &LogHeader,
        name: &RunName,
        out_dir: &Path,
        outcome: &Outcome,
        source: &impl Compare,
    ) -> Self {
        let mut remarks = outcome.remarks(&header.roster);
        let there = |file: &str| {
            let path = out_dir.join(file);
            // A folder in the place of a file is not of this run.
            (path.exists() && !path.is_dir()).then(|| path.display().to_string())
        };
        let has = |role| header.roster.iter().any(|p| p.role == role);
        let scores_file = has(rusty_contract::Role::Scorer).then(|| there("score.json")).flatten();
        let digest = outcome.digest.run_hex();
        let scored = scores_file
            .as_ref()
            .and_then(|path| ScoreReport::read(Path::new(path), Some(&digest)).ok());
        if has(rusty_contract::Role::Scorer) && scored.is_none() && outcome.ticks > 0 {
            remarks.push("there are no scores of this run".to_owned());
        }
        let scores_file = scores_file.filter(|_| scored.is_some());
        let blocked_ticks = scored.as_ref().and_then(|s| s.blocked_ticks);
        let goals = scored.as_ref().and_then(|s| s.goals);
        let (scores, unscored, pictures, report) =
            scored.map(|s| (s.scores, s.unscored, s.pictures, s.report)).unwrap_or_default();
        let per_s =
            if outcome.elapsed_s > 0.0 { outcome.ticks as f64 / outcome.elapsed_s } else { 0.0 };
        Self {
            scenario: header.config.scenario.clone(),
            run: name.to_string(),
            robot: header.config.fleet.as_ref().map(|fleet| fleet.name.clone()),
            seed: header.seed(),
            ticks: outcome.ticks,
            ticks_planned: source.tick_count(),
            ended: how_ended(outcome.phase),
            digest,
            world_digest: outcome.digest.world_hex(),
            ticks_per_s: per_s,
            elapsed_s: outcome.elapsed_s,
            first_frame_ns: outcome.first_frame_ns,
            peak_resident_bytes: Usage::own().map_or(0, |usage| usage.peak_resident_bytes),
            server_pid: std::process::id(),
            log: has(rusty_contract::Role::Logger).then(|| there("run.log")).flatten(),
            scores_file,
            pictures,
            report,
            participants: outcome.slots.clone(),
            gates: BTreeMap::new(),
            losses: outcome.losses.clone(),
            restarts: outcome.restarts.clone(),
            outputs: BTreeMap::new(),
            timings: outcome.timings.clone(),
            remarks,
            findings: header.findings().to_vec(),
            scores,
            blocked_ticks,
            goals,
            driven: has(rusty_contract::Role::Driver),
            unscored,
            comparison: source.comparison().cloned(),
            fork: source.fork().cloned(),
        }
    }

    /// With the output, where there is any, of each participant that was lost or
    /// failed.
    pub fn with_outputs(
        mut self,
        header: &LogHeader,
        outputs: &[(usize, PathBuf)],
        ended_badly: &[(usize, String)],
    ) -> Self {
        let lost = |slot: usize| self.losses.iter().chain(&self.restarts).any(|l| l.slot == slot);
        let named = |slot: usize| lost(slot) || ended_badly.iter().any(|(bad, _)| *bad == slot);
        let shown = outputs.iter().filter(|(slot, path)| named(*slot) && has_content(path));
        let entry = |(slot, path): &(usize, PathBuf)| {
            (header.roster[*slot].name.clone(), path.display().to_string())
        };
        self.outputs = shown.map(entry).collect();
        self
    }

    /// With everyone's kernel gate, given in roster order.
    pub fn with_gates(mut self, header: &LogHeader, gates: &[Gate]) -> Self {
        let names = header.roster.iter().map(|p| p.name.clone());
        self.gates = names.zip(gates.iter().cloned()).collect();
        self
    }

    /// The exit code that goes with it.
    pub fn exit(&self) -> Exit {
        let broken = self.comparison.as_ref().is_some_and(|c| c.cut || c.damaged > 0);
        match self.ended {
            "aborted" => Exit::Failed,
            _ if self.comparison.as_ref().is_some_and(|c| self.differs(c)) => Exit::NotBitExact,
            _ if self.fork.as_ref().is_some_and(|f| f.first_frame_difference.is_some()) => {
                Exit::NotBitExact
            }
            "interrupted" => Exit::Lost,
            _ if !self.losses.is_empty() || !self.remarks.is_empty() || broken => Exit::Lost,
            _ => Exit::Done,
        }
    }

    /// Whether a replay gave other bits than the log has, as far as both have
    /// any: the frames always, the run where the same participants answered.
    fn differs(&self, c: &Comparison) -> bool {
        let whole = self.ticks == self.ticks_planned;
        let other = |recorded: &Option<String>, now: &str| {
            recorded.as_ref().is_some_and(|digest| whole && digest != now)
        };
        c.first_difference.is_some()
            || other(&c.recorded_world_digest, &self.world_digest)
            || (c.compared > 0 && !c.other_roster && other(&c.recorded_digest, &self.digest))
    }
}

impl std::fmt::Display for RunReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.write_processes(f)?;
        self.write_scores(f)?;
        if self.ended != "done" {
            writeln!(f, "{} after {} of {} ticks", self.ended, self.ticks, self.ticks_planned)?;
        }
        for (name, gate) in self.gates.iter().filter(|(_, gate)| **gate != Gate::NotAsked) {
            writeln!(f, "gate     {name}: {gate}")?;
        }
        for t in &self.timings {
            let (name, latest) = (&t.name, t.latest_ticks);
            write!(f, "timing   {name}: answers take effect up to {latest} ticks later")?;
            match t.budget_s {
                Some(budget_s) => writeln!(f, "; {} overruns of {budget_s} s", t.overruns)?,
                None => writeln!(f)?,
            }
        }
        for loss in &self.losses {
            writeln!(f, "lost     {loss}")?;
        }
        for loss in &self.restarts {
            writeln!(f, "restart  {loss}")?;
        }
        for remark in &self.remarks {
            writeln!(f, "remark   {remark}")?;
        }
        for finding in &self.findings {
            writeln!(f, "finding  {finding}")?;
        }
        for (name, path) in &self.outputs {
            writeln!(f, "output   {name}: {path}")?;
        }
        if let (Some(fork), Some(c)) = (&self.fork, &self.comparison) {
            write_fork(f, fork, c)?;
        } else if let Some(c) = &self.comparison {
            self.write_comparison(f, c)?;
        }
        writeln!(f, "digest   {}", self.digest)?;
        writeln!(
            f,
            "ticks    {} in {:.2} s, {:.0} per s",
            self.ticks, self.elapsed_s, self.ticks_per_s
        )?;
        let files = [("log", &self.log), ("scores", &self.scores_file)];
        for (what, path) in files.into_iter().filter_map(|(w, p)| Some((w, p.as_ref()?))) {
            writeln!(f, "{what:8} {path}")?;
        }
        for picture in &self.pictures {
            writeln!(f, "picture  {picture}")?;
        }
        if let Some(report) = &self.report {
            writeln!(f, "report   {report}")?;
        }
        Ok(())
    }
}

impl RunReport {
    fn write_scores(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.scores.is_empty() {
            writeln!(f, "{}", ScoreTable(&self.scores))?;
        }
        if let Some(why) = &self.unscored {
            writeln!(f, "unscored {why}")?;
        }
        if let Some(ticks) = self.blocked_ticks.filter(|ticks| self.driven || *ticks > 0) {
            writeln!(f, "blocked  in {ticks} of {} ticks", self.ticks)?;
        }
        if let Some(goals) = &self.goals {
            writeln!(f, "{goals}")?;
        }
        Ok(())
    }

    fn write_processes(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(robot) = &self.robot {
            writeln!(f, "\nrobot {robot}")?;
        }
        let mut table = TextTable::new("process  role  >pid  >answers  >abstained  lost");
        table.row(&[&"sim-server", &"server", &self.server_pid, &"", &"", &""]);
        for p in &self.participants {
            let pid = p.pid.map_or_else(|| "-".to_owned(), |pid| pid.to_string());
            let lost = p.lost.as_ref().map_or("", |loss| loss.kind.word());
            table.row(&[&p.name, &p.role.word(), &pid, &p.answers, &p.abstained, &lost]);
        }
        writeln!(f, "\n{table}\n")
    }

    fn write_comparison(
        &self,
        f: &mut std::fmt::Formatter<'_>,
        c: &Comparison,
    ) -> std::fmt::Result {
        if c.compared == 0 {
            return writeln!(
                f,
                "replay   the log has no answers by these participants to compare with"
            );
        }
        writeln!(
            f,
            "replay   {} of {} answers equal the recorded ones, bit for bit",
            c.equal, c.compared
        )?;
        write_difference(f, c)?;
        for p in c.participants.iter().filter(|p| p.unrecorded > 0) {
            let (n, name) = (p.unrecorded, &p.name);
            writeln!(f, "         {n} answers of {name} have no recorded one: it had been lost")?;
        }
        match &c.recorded_digest {
            Some(digest) if *digest == self.digest => {
                writeln!(f, "         the digest is the recorded one")
            }
            Some(digest) if c.other_roster => {
                writeln!(f, "         the recorded digest, of another roster, is {digest}")
            }
            Some(digest) => writeln!(f, "         the recorded digest is {digest}"),
            None => writeln!(f, "         the log was cut, so it has no digest to compare with"),
        }
    }
}

fn write_difference(f: &mut std::fmt::Formatter<'_>, c: &Comparison) -> std::fmt::Result {
    if let Some(d) = &c.first_difference {
        writeln!(f, "         first difference at tick {}, {}, {}:", d.tick, d.name, d.field)?;
        writeln!(f, "         recorded {}", d.recorded)?;
        writeln!(f, "         replayed {}", d.replayed)?;
    }
    Ok(())
}

fn write_fork(f: &mut std::fmt::Formatter<'_>, fork: &Fork, c: &Comparison) -> std::fmt::Result {
    let (at, same, equal, compared) = (fork.at_tick, fork.frames_equal, c.equal, c.compared);
    writeln!(f, "fork     of {} at tick {at}", fork.original)?;
    writeln!(
        f,
        "before   {same} of {at} frames and {equal} of {compared} answers equal the recorded ones, \
         bit for bit"
    )?;
    if let Some(m) = &fork.first_frame_difference {
        writeln!(f, "         first other frame: {m}")?;
    }
    write_difference(f, c)?;
    match (fork.truths_differ_at, fork.greatest, fork.final_m) {
        (Some(tick), Some((most_m, most_at)), Some(final_m)) => writeln!(
            f,
            "after    the true paths part at tick {tick}: {most_m:.3} m apart at most (tick \
             {most_at}), {final_m:.3} m at the end of both"
        )?,
        (None, Some(_), _) => writeln!(f, "after    the true path is the same, bit for bit")?,
        _ => writeln!(f, "after    the original has no such tick to compare with")?,
    }
    if !fork.original_scores.is_empty() {
        writeln!(f, "\nthe original:\n{}", ScoreTable(&fork.original_scores))?;
    }
    Ok(())
}
