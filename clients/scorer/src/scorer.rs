//! The scorer: compares every estimate with the truth, draws the run and writes
//! its report. In a run it also keeps the beliefs that it draws, in a file for
//! each filter, because a log does not hold them; on a log it looks for those files.
//!
//! It takes no more memory for a longer run: the figures are sums
//! ([`Meter`]), and of a very long run not every tick is drawn ([`TraceKeeper`]).

mod origin;
mod shown;

use std::path::{Path, PathBuf};

use rusty_contract::belief::{file_name, tidy};
use rusty_contract::digest::observable_of;
use rusty_contract::log::{LogHeader, Source};
use rusty_contract::score::{ReferenceNoise, ScoreTable};
use rusty_contract::{
    BeliefHeader, BeliefKind, Brief, Effects, Exit, RunDigest, ScoreReport, WeightedPose, errln,
    outln, replace,
};
use rusty_geometry::place;
use rusty_metrics::{Given, Goals, Held, Meter, Moment, Planned, Yardstick};
use rusty_plot::png;

use crate::report::html;
use crate::scoring::sensed::Sensed;
use crate::scoring::trace::Whole;
use crate::scoring::{BeliefKeeper, BeliefMoment, RunTrace, TraceKeeper, scores, svg};
use rusty_clients::output_folder;
use rusty_clients::recorder::{Ending, Recorder, Step};
use rusty_clients::showing::{belief_file, failure};
use rusty_clients::{ClientArgs, ClientError};
use shown::Shown;

/// Compares every estimate with the truth; at the end writes `score.json`,
/// `report.html`, `report.svg` and `report.png`, and prints the table. On a log
/// without `--out` it prints the table only.
pub struct Scorer {
    folder: Option<PathBuf>,
    /// Whether it works on a log.
    from_log: bool,
    /// The folder of the run itself.
    run_folder: Option<PathBuf>,
    header: LogHeader,
    keeper: TraceKeeper,
    /// Whether it draws a report.
    draws: bool,
    beliefs: BeliefKeeper,
    /// `None` where the robot has no small sensor.
    sensed: Option<Sensed>,
    /// On a log: files of beliefs, whose frames must be those of the log.
    shown: Vec<Shown>,
    meter: Meter,
    reference: ReferenceNoise,
    held: Option<Held>,
    goals: Goals,
    blind: bool,
    digest: RunDigest,
    /// Which answers are in effect.
    effects: Effects,
    /// The first tick that it has not seen.
    next_tick: u64,
    /// The estimators to score; empty: all.
    only: Vec<String>,
}

/// The files of a score.
const FILES: [&str; 4] = ["score.json", "report.html", "report.svg", "report.png"];

/// A filter may be this many ticks ahead of a scorer that no process waits for.
const AHEAD_TICKS: u64 = 1000;

impl Recorder for Scorer {
    fn belief(&mut self, header: &BeliefHeader, poses: &mut Vec<WeightedPose>) {
        // One that names no participant of this run, or not the one in that slot, is dropped;
        // so is one of a tick that cannot have been yet.
        let whose = self.header.roster.get(header.participant as usize);
        let name = header.name().filter(|name| whose.is_some_and(|p| p.name == *name));
        let name = name.filter(|_| header.tick <= self.next_tick.saturating_add(AHEAD_TICKS));
        let (Some(name), Some(kind)) = (name, BeliefKind::of_number(header.kind)) else { return };
        if tidy(poses) > 0 {
            let moment = BeliefMoment::of(header.tick, kind, header.whole.max(header.count), poses);
            self.beliefs.offer(name, moment);
        }
    }

    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        self.beliefs.close(step.frame.tick());
        self.next_tick = step.frame.tick() + 1;
        if !self.from_log {
            self.beliefs.seen(step.frame.tick(), observable_of(step.frame));
        }
        self.check_shown(|shown| shown.check(step.frame))?;
        // A late estimate is judged as late as it is.
        let (tick, has_scan) = (step.frame.tick(), step.frame.ranges_m().is_some());
        self.effects.close(tick, has_scan, step.replies.iter().copied());
        let (effects, frame) = (&self.effects, step.frame);
        let given = effects.replies().enumerate().map(|(i, in_effect)| Given {
            estimate: in_effect.estimate().copied(),
            innovation: step.replies.get(i).and_then(|r| r.estimate()?.innovation),
            times_ns: step
                .delays
                .get(i)
                .and_then(|delay| delay.map(|d| [d.reported_ns, d.observed_ns])),
        });
        let moment = Moment { tick, time_s: frame.time_s(), truth: step.truth };
        self.meter.push(&moment, given);
        if let Some(held) = &mut self.held {
            held.push(tick, step.truth, frame.command());
        }
        self.goals.push(frame.time_s(), step.truth, self.meter.driven_m());
        let estimates = effects.replies().map(|r| r.estimate().copied());
        self.sensed.iter_mut().for_each(|s| s.push(tick, &frame.readings(), step.truth));
        self.keeper.push(frame.time_s(), step.truth, frame.ranges_m(), estimates);
        self.digest = step.digest;
        Ok(())
    }

    fn finish(mut self, ending: Ending) -> Result<Exit, ClientError> {
        let whole = Whole {
            ticks: self.meter.tick_count(),
            ticks_with_truth: self.meter.ticks_with_truth(),
            driven_m: self.meter.driven_m(),
        };
        // Without a truth there is no figure, and a distance of 0 m is none.
        let unscored = (whole.ticks_with_truth == 0).then(|| self.why_unscored());
        let is_whole = matches!(ending, Ending::LogEnd);
        self.check_shown(|shown| shown.finish(is_whole))?;
        let mut trace = self.keeper.finish(whole);
        trace.beliefs = self.beliefs.finish(&trace.names);
        trace.sensed = self.sensed.take();
        trace.from_log = self.from_log;
        trace.reference = self.reference;
        let mut scores =
            if unscored.is_none() { scores(&mut self.meter, &trace) } else { Vec::new() };
        if !self.only.is_empty() {
            scores.retain(|score| self.only.contains(&score.name));
            trace.keep_only(&self.only);
        }
        trace.digest = self.digest.run_hex();
        trace.origin = self.run_folder.as_ref().and_then(|f| origin::of(f, &trace.digest));
        let mut report = ScoreReport {
            blocked_ticks: self.held.as_ref().filter(|_| unscored.is_none()).map(Held::tick_count),
            goals: self.goals.score().filter(|_| unscored.is_none()),
            unscored,
            ..trace.report(scores)
        };
        let mut drawn = Ok(());
        if let Some(folder) = &self.folder {
            if self.draws {
                drawn = draw(folder, &self.header, &trace, &mut report);
            }
            drawn = drawn.and(if self.from_log { Ok(()) } else { keep_beliefs(folder, &trace) });
            // The numbers are written even where the pictures could not be.
            let path = folder.join("score.json");
            let json = serde_json::to_vec_pretty(&report)
                .map_err(|e| ClientError::Unusable(format!("the scores cannot be written: {e}")))?;
            replace(&path, &json).map_err(ClientError::io(&path))?;
        }
        match &report.unscored {
            Some(why) => outln!("unscored: {why}"),
            None => outln!("{}", ScoreTable(&report.scores)),
        }
        if !report.reference.is_none() {
            outln!("{}", report.reference);
        }
        report.goals.iter().for_each(|goals| outln!("{goals}"));
        drawn?;
        Ok(match ending {
            Ending::Broken | Ending::LogCut => Exit::Lost,
            Ending::Told(_) | Ending::LogEnd => Exit::Done,
        })
    }
}

impl Scorer {
    /// A scorer that judges by this.
    ///
    /// # Errors
    /// A blind log, or a folder that cannot be made.
    pub fn with(
        yardstick: Yardstick,
        brief: &Brief,
        args: &ClientArgs,
    ) -> Result<Self, ClientError> {
        let blind = brief.header.is_blind();
        if let (true, Some(log)) = (blind, &args.log) {
            let log = log.display();
            let text = format!("{log} is blind, nothing in it can be scored: give its --key-file");
            return Err(ClientError::Unusable(text));
        }
        let from_log = args.log.is_some();
        let folder = match from_log && args.out.is_none() {
            true => None,
            false => Some(output_folder(brief, args)?),
        };
        if let (Some(folder), Some(_)) = (&folder, &args.out) {
            let kept = brief.header.answering().filter(|_| !from_log).map(|p| file_name(&p.name));
            let mut all = FILES.map(str::to_owned).into_iter().chain(kept);
            all.try_for_each(|file| args.check_free(&folder.join(file)))?;
        }
        let mut beliefs = BeliefKeeper::default();
        let read = |file: &PathBuf| Shown::read(file, &brief.header.config.scenario, &mut beliefs);
        let mut shown: Vec<Shown> = args.beliefs.iter().map(read).collect::<Result<_, _>>()?;
        Shown::check_names(&shown)?;
        if let (Some(log), Some(_)) = (&args.log, &folder) {
            Shown::find(log, &brief.header, &mut shown, &mut beliefs);
        }
        let config = &brief.header.config;
        let names: Vec<String> = brief.header.answering().map(|p| p.name.clone()).collect();
        let kidnapped_at = brief.header.kidnappings().map(|k| k.tick).collect();
        // A simulation begins at 0; the stamps of a robot may be the time of day.
        let recorded = matches!(brief.header.source, Source::Recorded { .. });
        let began_s = (!recorded).then_some(0.0);
        let (ticks, start) = (config.ticks, brief.header.true_start());
        let planned = Planned { ticks, start, kidnapped_at, began_s };
        Ok(Self {
            blind,
            run_folder: match &args.log {
                Some(log) => log.parent().map(Path::to_owned),
                None => brief.out_dir.as_ref().map(PathBuf::from),
            },
            folder,
            from_log,
            header: brief.header.clone(),
            keeper: TraceKeeper::new(&brief.header),
            draws: brief.report,
            beliefs,
            sensed: (!config.sensors.is_none()).then(|| Sensed::new(config)),
            shown,
            held: Held::of(&brief.header),
            goals: Goals::default(),
            meter: Meter::new(&names, &planned, yardstick),
            reference: yardstick.reference,
            digest: RunDigest::default(),
            effects: Effects::of(&brief.header),
            next_tick: 0,
            only: Vec::new(),
        })
    }

    /// Draws the walls of this map; without one, and in a report on a recording, those of
    /// the `map.yaml` next to the log.
    ///
    /// # Errors
    /// The file is not a map or a world.
    pub fn with_map(mut self, map: Option<&Path>) -> Result<Self, ClientError> {
        let has_walls = !self.header.config.world.walls.is_empty();
        let is_wanted = self.from_log && self.folder.is_some() && !has_walls;
        let beside = self.run_folder.as_ref().filter(|_| is_wanted).map(|f| f.join("map.yaml"));
        let beside = beside.filter(|path| path.is_file());
        match (map, beside) {
            (Some(path), _) => {
                let world = match path.to_str().and_then(place) {
                    Some(built_in) => Ok(built_in.spec().clone()),
                    None => rusty_floorplan::read_unchecked(path),
                };
                self.keeper.set_world(world.map_err(|e| ClientError::Unusable(e.to_string()))?);
            }
            (None, Some(path)) => match rusty_floorplan::read_unchecked(&path) {
                Ok(world) => self.keeper.set_world(world),
                Err(e) => errln!("{e}; it is left out"),
            },
            (None, None) => {}
        }
        Ok(self)
    }

    /// Scores these estimators only; all of them if there are none.
    ///
    /// # Errors
    /// A name of no estimator of this run.
    pub fn with_only(mut self, only: &[String]) -> Result<Self, ClientError> {
        let names: Vec<&str> = self.header.answering().map(|p| p.name.as_str()).collect();
        if let Some(name) = only.iter().find(|name| !names.contains(&name.as_str())) {
            let there = names.join(", ");
            let text = format!("--only {name}: expected an estimator of this run, one of {there}");
            return Err(ClientError::Usage(text));
        }
        self.only = only.to_vec();
        Ok(self)
    }

    /// Times the way to these goals.
    #[must_use]
    pub fn with_goals(self, goals: Goals) -> Self {
        Self { goals, ..self }
    }

    /// Checks the files of beliefs. One that was found and does not fit is left out.
    fn check_shown(
        &mut self,
        mut fits: impl FnMut(&mut Shown) -> Result<(), ClientError>,
    ) -> Result<(), ClientError> {
        let (mut problem, beliefs) = (None, &mut self.beliefs);
        self.shown.retain_mut(|shown| match fits(shown) {
            Err(e) if shown.is_found => {
                beliefs.forget(&shown.name);
                errln!("{e}; it is left out");
                false
            }
            Err(e) => {
                problem.get_or_insert(e);
                true
            }
            Ok(()) => true,
        });
        problem.map_or(Ok(()), Err)
    }

    fn why_unscored(&self) -> String {
        if self.blind {
            "the frames are those of a blind log, and their truth is in its key: log this run, \
             then `score --log run.log --key-file KEY`"
                .to_owned()
        } else if self.next_tick == 0 {
            "the run has no tick".to_owned()
        } else {
            "no tick of this run has a known truth".to_owned()
        }
    }
}

/// Writes what is drawn of beliefs to a file for each filter.
fn keep_beliefs(folder: &Path, trace: &RunTrace) -> Result<(), ClientError> {
    trace.beliefs.iter().try_for_each(|track| {
        let path = folder.join(file_name(&track.name));
        let mut writer = belief_file(&path, &track.name, &trace.scenario)?;
        for moment in &track.moments {
            let Some(observable) = moment.observable else { continue };
            let (at, what) = ((moment.tick, observable), (moment.kind, moment.whole));
            writer.moment(at, what, &moment.poses()).map_err(failure(&path))?;
        }
        writer.finish().map(drop).map_err(failure(&path))
    })
}

/// Writes report and pictures, each of them even where another could not be;
/// names those that were.
fn draw(
    folder: &Path,
    header: &LogHeader,
    trace: &RunTrace,
    report: &mut ScoreReport,
) -> Result<(), ClientError> {
    let write = |file: &str, bytes: &[u8]| {
        let path = folder.join(file);
        replace(&path, bytes).map_err(ClientError::io(&path))?;
        Ok(path.display().to_string())
    };
    let page = write("report.html", html(header, trace, report).as_bytes());
    let drawing = svg(trace, &report.scores);
    let lines = write("report.svg", drawing.as_bytes());
    let pixels = png(&drawing).map_err(|e| ClientError::Picture(e.to_string()));
    let pixels = pixels.and_then(|pixels| write("report.png", &pixels));
    report.report = page.as_ref().ok().cloned();
    report.pictures = [&lines, &pixels].into_iter().flatten().cloned().collect();
    page.and(lines).and(pixels).map(drop)
}
