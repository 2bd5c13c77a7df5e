//! `benchmark`: run a filter and the baselines through a fixed suite.

mod blind;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use rusty_bench::machine::Machine;
use rusty_contract::log::Ending;
use rusty_contract::{Exit, FieldError, Participant, errln, outln, replace};
use rusty_engine::source::FrameSource;
use rusty_logs::replay::Recording;
use rusty_study::benchmark::recorded_log::RecordedLog;
use rusty_study::benchmark::selection::Wanted;
use rusty_study::benchmark::verify::{checkable, verify};
use rusty_study::benchmark::{
    BenchmarkError, BenchmarkJob, BenchmarkResult, Entry, LeaderboardText, Recordings, Selection,
    Suite, Track, leaderboard, page,
};

use self::blind::{AnswerArgs, Pace, SealArgs};
use super::arguments::{Output, check_apart, check_free, check_writable};
use super::{WRITER, WrongUsage, stop_flag};

/// The steps of a benchmark.
#[derive(Subcommand, Clone, Debug)]
pub enum BenchmarkStep {
    /// Run filters and baselines, and write the result
    Run(RunArgs),
    /// Make the runs of a result again and compare every bit
    Verify(VerifyArgs),
    /// Print a leaderboard, and write a page with pictures
    Report(ReportArgs),
    /// Write the suite's frames without truth and seeds, for others to answer
    Seal(SealArgs),
    /// Run a filter on sealed logs, and write its trajectories
    Answer(AnswerArgs),
    /// List scenarios, tracks, metrics and baselines
    List(Output),
}

/// Options of all steps that make runs.
#[derive(Args, Clone, Debug)]
pub struct MakeArgs {
    /// Add a filter; may be repeated
    #[arg(long, value_name = "NAME=COMMAND")]
    pub add: Vec<String>,
    /// Add a driver; may be repeated
    #[arg(long = "driver", value_name = "NAME=COMMAND")]
    pub drivers: Vec<String>,
    /// Replay this log as well, a run of the scenario `recordings`; may be repeated
    #[arg(long = "log", value_name = "FILE")]
    pub logs: Vec<PathBuf>,
    /// File that the added programs may read; may be repeated
    #[arg(long = "file", value_name = "PATH")]
    pub files: Vec<String>,
    #[command(flatten)]
    pub pace: Pace,
}

/// The part of the suite.
#[derive(Args, Clone, Debug)]
pub struct PartArgs {
    /// Scenario; may be repeated [default: all]
    #[arg(long, value_name = "SCENARIO")]
    pub only: Vec<String>,
    /// Track; may be repeated [default: those of the added, or all of estimators]
    #[arg(long = "track", value_name = "TRACK", value_enum)]
    pub tracks: Vec<Track>,
    /// Number of seeds of each scenario [default: the suite's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub seeds: Option<u64>,
    /// Derive the seeds from this text [default: those of the suite; of `seal` a random text]
    #[arg(long, value_name = "TEXT")]
    pub key: Option<String>,
}

impl PartArgs {
    fn wanted(&self, recordings: Vec<RecordedLog>) -> Wanted {
        let Self { only, tracks, seeds, key } = self.clone();
        Wanted { only, tracks, seeds, key, recordings }
    }
}

const RUN_HELP: &str = "\
Every entry makes each run alone, confined by the kernel, on the frames that all
others receive. One that is lost has a failed run, which counts as the worst.
Drivers (--driver) receive the goals as `--waypoint X,Y`, like `goto`.
The result has all figures and digests: `benchmark verify FILE` makes the runs again.

`{run}` in a command stands for the name of the run (SCENARIO-MAP-NUMBER, or that of
the log): `--add theirs=\"trajectory theirs/{run}.tum\"`, as of `benchmark seal`.
The seeds of the suite are public. --key derives others from a text: choose it after
the filters are handed in, and publish it with the result.

Examples:
  sim-server benchmark run --add mine=./target/release/mine -o mine.json
  sim-server benchmark run --driver mine=./my-driver -o mine.json
  sim-server benchmark run --add mine=./mine --only few-beams --seeds 3 -o try.json
  sim-server benchmark run --add mine=./mine --log intel.log --only recordings -o intel.json
  sim-server benchmark verify mine.json --add mine=./target/release/mine
  sim-server benchmark report mine.json theirs.json --page leaderboard.html";

#[derive(Args, Clone, Debug)]
#[command(after_help = RUN_HELP)]
pub struct RunArgs {
    /// Result to write
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    pub out: PathBuf,
    /// Replace an existing result
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub part: PartArgs,
    /// Do not confine the filters; the result records it
    #[arg(long)]
    pub unconfined: bool,
    #[command(flatten)]
    pub make: MakeArgs,
}

#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Result to check
    pub file: PathBuf,
    /// Do not confine the filters; for a result that was made like this
    #[arg(long)]
    pub unconfined: bool,
    #[command(flatten)]
    pub make: MakeArgs,
}

#[derive(Args, Clone, Debug)]
pub struct ReportArgs {
    /// Results of the same selection of the suite
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Page to write, with tables and pictures
    #[arg(long, value_name = "FILE")]
    pub page: Option<PathBuf>,
    /// Replace an existing page
    #[arg(long, requires = "page")]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(step: &BenchmarkStep) -> Result<Exit> {
    match step {
        BenchmarkStep::Run(args) => make(args),
        BenchmarkStep::Verify(args) => check(args),
        BenchmarkStep::Report(args) => report(args),
        BenchmarkStep::Seal(args) => blind::seal_suite(args),
        BenchmarkStep::Answer(args) => blind::answer(args),
        BenchmarkStep::List(output) => list(*output),
    }
}

impl MakeArgs {
    fn added(&self, suite: &Suite) -> Result<Vec<Entry>> {
        Ok(Entry::added(suite, [&self.add, &self.drivers], &self.files)?)
    }

    fn job<'s>(
        &self,
        suite: &'s Suite,
        selection: &'s Selection,
        (entries, confined): (&'s [Entry], bool),
        recordings: &'s Recordings,
    ) -> BenchmarkJob<'s> {
        BenchmarkJob {
            suite,
            selection,
            entries,
            confined,
            recordings,
            open: open_log,
            jobs: self.pace.jobs(),
            quiet: self.pace.is_quiet(),
        }
    }
}

/// Returns the recordings of these logs. What cannot be scored shows before the first run.
fn recordings(logs: &[PathBuf]) -> Result<Recordings> {
    let recordings = Recordings::of(logs)?;
    for path in logs {
        let opened = open_log(path, Vec::new()).and_then(|log| match log.header().is_blind() {
            true => Err("it is blind: there are no true poses to score with".to_owned()),
            false => Ok(()),
        });
        let path = path.display().to_string();
        opened.map_err(|problem| BenchmarkError::NoLog { path, problem })?;
    }
    Ok(recordings)
}

/// Opens a log for these participants.
fn open_log(
    path: &Path,
    roster: Vec<Participant>,
) -> std::result::Result<Box<dyn FrameSource>, String> {
    let (mut source, ending) = Recording::open(path).map_err(|e| e.to_string())?;
    let problem = if source.tick_count() == 0 {
        "it has no complete tick"
    } else if !matches!(ending, Ending::Complete(_)) {
        "it is cut off, or its run was"
    } else if source.damaged() > 0 {
        "checksums of its records fail"
    } else {
        source.header_mut().roster = roster;
        return Ok(Box::new(source));
    };
    Err(problem.to_owned())
}

fn make(args: &RunArgs) -> Result<Exit> {
    check_free(&args.out, args.force)?;
    let files: Vec<PathBuf> = args.make.files.iter().map(PathBuf::from).collect();
    check_apart(args.make.logs.iter().chain(&files), [&args.out])?;
    check_writable(&args.out)?;
    let recordings = recordings(&args.make.logs)?;
    let suite = Suite::built_in()?.with(&recordings.logs);
    let mut entries = args.make.added(&suite)?;
    let wanted = args.part.wanted(recordings.logs.clone());
    let selection = Selection::with(&suite, wanted, &entries)?;
    if let (Some(log), true) = (args.make.logs.first(), selection.recordings.is_empty()) {
        let problem = "is not replayed: the scenario `recordings` is not selected";
        let remedy = "add --only recordings and a track that has it, or leave out --log";
        bail!(FieldError::new("--log", log.display(), problem, remedy));
    }
    entries.extend(Entry::baselines(&suite));
    let confined = !args.unconfined;
    let job = args.make.job(&suite, &selection, (&entries, confined), &recordings);
    let Some(runs) = job.make(&stop_flag()?)? else {
        errln!("interrupted: no result is written");
        return Ok(Exit::Lost);
    };
    let machine = serde_json::to_value(Machine::here())?;
    let rest = (confined, WRITER.to_owned(), machine);
    let result = BenchmarkResult::of(&suite, selection.clone(), entries.clone(), runs, rest)?;
    args.make.pace.output.print(&result);
    result.write(&args.out)?;
    for run in result.runs.iter().filter(|run| run.failure.is_some()) {
        let (scenario, seed, entry) = (&run.scenario, run.seed, &run.entry);
        let why = run.failure.as_deref().unwrap_or_default();
        errln!("failed: {scenario}, seed {seed}, {entry}: {why}");
    }
    errln!("result in {}", args.out.display());
    Ok(if result.failed() > 0 { Exit::Lost } else { Exit::Done })
}

fn check(args: &VerifyArgs) -> Result<Exit> {
    let suite = Suite::built_in()?;
    let result = BenchmarkResult::read(&args.file, &suite)?;
    if result.confined == args.unconfined {
        let path = args.file.display();
        let text = match args.unconfined {
            false => format!(
                "{path}: its filters were not confined, so they could read other files; add \
                 --unconfined to run them again like this"
            ),
            true => format!("--unconfined: the filters of {path} were confined; leave it out"),
        };
        return Err(WrongUsage(text).into());
    }
    let suite = suite.with(&result.selection.recordings);
    let recordings = recordings(&args.make.logs)?.matching(&result.selection.recordings)?;
    let added = args.make.added(&suite)?;
    let is_it = |a: &Entry, e: &Entry| (&a.name, a.is_driver) == (&e.name, e.is_driver);
    if let Some(other) = added.iter().find(|a| !result.entries.iter().any(|e| is_it(a, e))) {
        let names: Vec<&str> = result.entries.iter().map(|e| e.name.as_str()).collect();
        let (path, names) = (args.file.display(), names.join(", "));
        let (option, name) = (other.option(), &other.name);
        let text = format!("{option} {name}: {path} has no such entry; it has {names}");
        return Err(WrongUsage(text).into());
    }
    let checked = checkable(&result, &suite, added);
    let rest = (&checked[..], result.confined);
    let job = args.make.job(&suite, &result.selection, rest, &recordings);
    let Some(runs) = job.make(&stop_flag()?)? else {
        errln!("interrupted: the result is not checked");
        return Ok(Exit::Lost);
    };
    let found = verify(&result, &suite, &checked, runs)?;
    args.make.pace.output.print_with(&found, || {
        found.differences.iter().for_each(|difference| outln!("{difference}"));
        let (runs, names) = (found.runs, found.checked.join(", "));
        match found.differences.len() {
            0 => outln!("equal: {runs} runs of {names}, to the bit"),
            count => outln!("not equal: {count} fields (the file's value and the expected one)"),
        }
    });
    for name in &found.unchecked {
        let mut entries = result.entries.iter();
        let option = entries.find(|e| e.name == *name).map_or("--add", Entry::option);
        errln!("{name}: its runs were not made again; give {option} {name}=COMMAND");
    }
    Ok(if found.is_equal { Exit::Done } else { Exit::NotBitExact })
}

fn report(args: &ReportArgs) -> Result<Exit> {
    args.page.as_ref().map_or(Ok(()), |path| check_free(path, args.force))?;
    check_apart([], &args.files)?;
    check_apart(&args.files, &args.page)?;
    let suite = Suite::built_in()?;
    let read = |path: &PathBuf| -> Result<(String, BenchmarkResult), BenchmarkError> {
        let result = BenchmarkResult::read(path, &suite)?;
        let suite = suite.clone().with(&result.selection.recordings);
        let path = path.display().to_string();
        // Scores and verdicts must follow from the runs.
        let found = verify(&result, &suite, &[], Vec::new())?;
        match found.differences.into_iter().next() {
            Some(difference) => Err(BenchmarkError::Changed { path, difference }),
            None => Ok((path, result)),
        }
    };
    let results: Vec<_> = args.files.iter().map(read).collect::<Result<_, _>>()?;
    let recordings = results.first().map(|(_, r)| &r.selection.recordings[..]);
    let suite = suite.clone().with(recordings.unwrap_or_default());
    let standings = leaderboard(&suite, &results)?;
    args.output.print_with(&standings, || outln!("{}", LeaderboardText(&standings)));
    if let Some(path) = &args.page {
        let text = page::page(&suite, &results, &standings);
        write_page(path, &text)?;
    }
    Ok(Exit::Done)
}

fn write_page(path: &Path, text: &str) -> Result<(), BenchmarkError> {
    replace(path, text.as_bytes()).map_err(BenchmarkError::io(path))?;
    errln!("page in {}", path.display());
    Ok(())
}

fn list(output: Output) -> Result<Exit> {
    output.print(&Suite::built_in()?);
    Ok(Exit::Done)
}
