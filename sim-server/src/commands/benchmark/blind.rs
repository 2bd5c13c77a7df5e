//! `benchmark seal` and `benchmark answer`: the suite for filters whose programs stay with
//! their authors.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use rusty_bench::machine::cores;
use rusty_contract::blind::Told;
use rusty_contract::{Exit, errln, outln};
use rusty_logs::seal::seal;
use rusty_study::benchmark::{Answering, Entry, Sealing, Selection, Suite, Track};
use serde::Serialize;

use super::super::arguments::Output;
use super::super::{WRITER, WrongUsage, stop_flag};
use super::{PartArgs, open_log};

const SEAL_HELP: &str = "\
The folder has two parts: `blind` is for the participants, `keys` stays with you. A
participant hands in a trajectory for each log (`benchmark answer` writes them). Their
results are those of `benchmark run` with the program `trajectory`:

  sim-server benchmark seal -o suite
  sim-server benchmark run --key \"$(cat suite/keys/key.txt)\" \\
      --add theirs=\"trajectory theirs/{run}.tum\" --file theirs -o theirs.json

The seeds are derived from a text that must stay secret until then: without --key it is
drawn at random. The tracks of drivers are not sealed: their commands make the frames.";

#[derive(Args, Clone, Debug)]
#[command(after_help = SEAL_HELP)]
pub struct SealArgs {
    /// Folder to make
    #[arg(short = 'o', long = "out", value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub part: PartArgs,
    #[command(flatten)]
    pub pace: Pace,
}

const ANSWER_HELP: &str = "\
Writes DIR/NAME.tum for each NAME.log, in TUM format: a line for each tick with an
estimate. A run in which the filter is lost has no file.

Example:
  sim-server benchmark answer suite/blind/*.log --add mine=./target/release/mine -o mine";

#[derive(Args, Clone, Debug)]
#[command(after_help = ANSWER_HELP)]
pub struct AnswerArgs {
    /// Logs of `benchmark seal`
    #[arg(required = true, value_name = "LOG")]
    pub logs: Vec<PathBuf>,
    /// The filter
    #[arg(long, value_name = "NAME=COMMAND")]
    pub add: String,
    /// File that it may read; may be repeated
    #[arg(long = "file", value_name = "PATH")]
    pub files: Vec<String>,
    /// Folder to make
    #[arg(short = 'o', long = "out", value_name = "DIR")]
    pub out: PathBuf,
    /// Do not confine the filter
    #[arg(long)]
    pub unconfined: bool,
    #[command(flatten)]
    pub pace: Pace,
}

/// How many runs at a time, and what is printed.
#[derive(Args, Clone, Debug)]
pub struct Pace {
    /// Number of parallel runs [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    #[command(flatten)]
    pub output: Output,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

impl Pace {
    pub fn jobs(&self) -> usize {
        self.jobs.map_or_else(cores, usize::from)
    }

    pub fn is_quiet(&self) -> bool {
        self.quiet || self.output.json
    }

    /// Says that the run with this number, from 0, begins.
    fn say(&self, number: usize, count: usize) {
        if !self.is_quiet() {
            errln!("run {} of {count}", number + 1);
        }
    }
}

/// What was sealed.
#[derive(Serialize)]
struct Sealed {
    blind: PathBuf,
    keys: PathBuf,
    runs: Vec<String>,
}

pub fn seal_suite(args: &SealArgs) -> Result<Exit> {
    let suite = Suite::built_in()?;
    let mut wanted = args.part.wanted(Vec::new());
    if wanted.tracks.contains(&Track::Driving) {
        let text = "--track driving cannot be sealed: its commands make the frames; leave it out";
        return Err(WrongUsage(text.to_owned()).into());
    }
    let key = wanted.key.take().map_or_else(random_key, Ok)?;
    wanted.key = Some(key.clone());
    if wanted.tracks.is_empty() {
        wanted.tracks.extend(Track::ALL.into_iter().filter(|track| !track.is_driving()));
    }
    let selection = Selection::of(&suite, wanted)?;
    let [blind, keys] = ["blind", "keys"].map(|name| args.out.join(name));
    make_folder(&args.out)?;
    for folder in [&blind, &keys] {
        make_folder(folder)?;
    }
    let sealing = Sealing {
        suite: &suite,
        selection: &selection,
        blind: &blind,
        keys: &keys,
        seal: seal_log,
        jobs: args.pace.jobs(),
    };
    let sealed = sealing.write(&stop_flag()?, |number, count| args.pace.say(number, count));
    let Ok(Some(runs)) = sealed else {
        // Half a suite is of no use, and the folder is ours.
        fs::remove_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
        sealed?;
        errln!("interrupted: nothing is sealed");
        return Ok(Exit::Lost);
    };
    let path = keys.join("key.txt");
    // Who reads it has the truth.
    let mut file = OpenOptions::new();
    let file = file.write(true).create_new(true).mode(0o600).open(&path);
    let written = file.and_then(|mut file| writeln!(file, "{key}"));
    written.with_context(|| path.display().to_string())?;
    let sealed = Sealed { blind, keys, runs };
    args.pace.output.print_with(&sealed, || {
        outln!("logs  {} in {} (to hand out)", sealed.runs.len(), sealed.blind.display());
        outln!("keys  {} (to keep; key.txt has the text for --key)", sealed.keys.display());
    });
    Ok(Exit::Done)
}

fn random_key() -> Result<String> {
    let words = [getrandom::u64(), getrandom::u64()];
    let [a, b] = words.map(|word| word.context("drawing a key failed; give one with --key"));
    Ok(format!("{:016x}{:016x}", a?, b?))
}

fn seal_log(log: &Path, told: Told, [blind, key]: [&Path; 2]) -> Result<(), String> {
    seal(log, blind, key, (Some(told), WRITER)).map(drop).map_err(|e| e.to_string())
}

/// Makes a folder that is not there.
fn make_folder(path: &Path) -> Result<()> {
    fs::create_dir(path).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => {
            let path = path.display();
            WrongUsage(format!("{path} is there already; give another --out")).into()
        }
        _ => anyhow::Error::from(error).context(path.display().to_string()),
    })
}

pub fn answer(args: &AnswerArgs) -> Result<Exit> {
    let suite = Suite::built_in()?;
    let added = [args.add.clone()];
    let entries = Entry::added(&suite, [&added, &[]], &args.files)?;
    let Some(entry) = entries.first() else {
        return Err(WrongUsage("--add has no name; write NAME=COMMAND".to_owned()).into());
    };
    make_folder(&args.out)?;
    let answering = Answering {
        entry,
        confined: !args.unconfined,
        logs: &args.logs,
        out: &args.out,
        open: open_log,
        jobs: args.pace.jobs(),
    };
    let count = args.logs.len();
    let answered = answering.write(&stop_flag()?, |number| args.pace.say(number, count));
    // It stays if something is in it.
    let _ = fs::remove_dir(&args.out);
    let answered = answered?;
    let lost: Vec<_> = answered.iter().filter(|a| a.trajectory.is_none()).collect();
    args.pace.output.print_with(&answered, || {
        let written = answered.len() - lost.len();
        outln!("{written} of {count} trajectories in {}", args.out.display());
    });
    for one in &lost {
        errln!("failed: {}: {}", one.run, one.failure.as_deref().unwrap_or_default());
    }
    if answered.len() < count {
        errln!("interrupted: {} logs are without an answer", count - answered.len());
    }
    let is_whole = lost.is_empty() && answered.len() == count;
    Ok(if is_whole { Exit::Done } else { Exit::Lost })
}
