//! `bench`: measure performance against a baseline.

mod latency;
mod page;
mod scan;

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::{Args, Subcommand};
use rusty_bench::machine::cores;
use rusty_bench::noise::NoiseMeter;
use rusty_bench::report::{Printing, Report};
use rusty_bench::results::Results;
use rusty_bench::stage::Bare;
use rusty_bench::{idle, log, start, step, sweep};
use rusty_contract::config::check_seconds;
use rusty_contract::{Exit, FieldError, RunName, errln};
use rusty_engine::run::{Stop, fresh_name};
use rusty_link::{Domain, WaitPolicy, floor, raw};

use super::arguments::Output;

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Every benchmark measures its subject and a baseline in turns in the same run. It
prints ratios, the machine, the noise of the machine, and a hash of the results.
Results are valid for release builds on an otherwise idle machine. In all other
cases they are printed and the exit code is 1, unless --accept-noise is given.")]
pub struct BenchArgs {
    /// Benchmark to run
    #[command(subcommand)]
    what: BenchVerb,
}

#[derive(Subcommand, Clone, Debug)]
enum BenchVerb {
    /// Measure a tick against the raw transport and a lower bound
    Latency(latency::LatencyArgs),
    /// Measure the CPU time of a paused and of a real-time run
    Idle(IdleArgs),
    /// Measure time to the first frame and memory of a launch
    Start(StartArgs),
    /// Measure writing a log against writing a plain file
    Log(LogArgs),
    /// Measure the noise of this machine
    Noise(NoiseArgs),
    /// Measure a scan against one ray cast per beam
    Scan(scan::ScanArgs),
    /// Measure the parts of a tick before it is sent
    Step(StepArgs),
    /// Measure sweeps without clients on one core and on all
    Sweep(SweepArgs),
    /// Write all benchmarks and their goals as a Markdown page
    Page(page::PageArgs),
}

#[derive(Args, Clone, Copy, Debug)]
pub struct CommonArgs {
    /// Exit with 0 although the machine was too noisy
    #[arg(long)]
    pub accept_noise: bool,
    #[command(flatten)]
    pub output: Output,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

#[derive(Args, Clone, Debug)]
pub struct NoiseArgs {
    /// Duration of the measurement, s
    #[arg(long, default_value_t = 2.0, value_name = "SECONDS")]
    pub seconds: f64,
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args, Clone, Debug)]
pub struct LogArgs {
    /// Folder to write to; it is left as it was
    #[arg(default_value = ".", value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Numbers of beams of the scan in each tick, 0 for no scans
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "0,180,1080")]
    pub beams: Vec<usize>,
    /// Number of ticks of a log
    #[arg(long, value_name = "N", default_value_t = 50_000)]
    pub ticks: u64,
    /// Repetitions of each measurement
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repeat: usize,
    /// Include the time until the disk has stored everything
    #[arg(long)]
    pub sync: bool,
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args, Clone, Debug)]
pub struct IdleArgs {
    /// Duration of the measurement of each run, s
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args, Clone, Debug)]
pub struct StartArgs {
    /// Number of launches, after one that is not counted
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub repeat: usize,
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args, Clone, Debug)]
pub struct StepArgs {
    /// Duration of the measurement, s
    #[arg(long, default_value_t = 3.0, value_name = "SECONDS")]
    pub seconds: f64,
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args, Clone, Debug)]
pub struct SweepArgs {
    /// Duration of the measurement, s
    #[arg(long, default_value_t = 6.0, value_name = "SECONDS")]
    pub seconds: f64,
    /// Workers to compare with one [default: one per processor]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args, Clone, Debug)]
pub struct BenchPeerArgs {
    /// Benchmark to take part in, raw or floor
    pub what: String,
    /// Index of this client, counted from 0
    pub client: usize,
    /// Run to take part in
    #[arg(long, value_name = "NAME")]
    pub run: RunName,
    /// Name of this client
    #[arg(long, value_name = "NAME")]
    pub name: String,
    /// Waiting method
    #[arg(long, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Process ID of the server that started this client
    #[arg(long, value_name = "PID")]
    pub launcher: u32,
    /// Accepted for uniformity and not used
    #[arg(long)]
    pub key_stdin: bool,
}

/// Exits with 0 if the results are valid, 1 if the machine was too noisy.
pub fn run(args: &BenchArgs) -> Result<Exit> {
    match &args.what {
        BenchVerb::Latency(args) => latency::run(args),
        BenchVerb::Idle(args) => idle(args),
        BenchVerb::Start(args) => start(args),
        BenchVerb::Log(args) => log(args),
        BenchVerb::Noise(args) => noise(args),
        BenchVerb::Scan(args) => scan::run(args),
        BenchVerb::Step(args) => step(args),
        BenchVerb::Sweep(args) => sweep(args),
        BenchVerb::Page(args) => page::run(args),
    }
}

impl CommonArgs {
    fn printing(self) -> Printing {
        Printing { json: self.output.json, accept_noise: self.accept_noise }
    }

    /// Prints the results of a benchmark and returns its exit code.
    fn finish(self, bench: &'static str, meter: NoiseMeter, results: Results) -> Result<Exit> {
        Ok(Report::new(bench, meter.finish(), results).finish(self.printing()))
    }
}

fn noise(args: &NoiseArgs) -> Result<Exit> {
    check_seconds("--seconds", args.seconds)?;
    let until = Instant::now() + Duration::from_secs_f64(args.seconds);
    let mut meter = NoiseMeter::begin();
    while Instant::now() < until {
        meter.look();
    }
    let noise = meter.finish();
    let results = noise.results();
    Ok(Report::new("noise", noise, results).finish(args.common.printing()))
}

fn log(args: &LogArgs) -> Result<Exit> {
    check_repeat(args.repeat)?;
    let plan = log::Plan {
        folder: args.folder.clone(),
        ticks: args.ticks,
        beams: args.beams.clone(),
        sync: args.sync,
        repeat: args.repeat,
        quiet: args.common.quiet,
    };
    let mut meter = NoiseMeter::begin();
    let results = plan.measure(&mut meter)?;
    args.common.finish("log", meter, results)
}

fn idle(args: &IdleArgs) -> Result<Exit> {
    check_seconds("--seconds", args.seconds)?;
    let (run, stop) = prepare()?;
    let meter = NoiseMeter::begin();
    let Some(results) = idle::measure(&run, args.wait, args.seconds, &stop)? else {
        return Ok(stopped());
    };
    args.common.finish("idle", meter, results)
}

fn start(args: &StartArgs) -> Result<Exit> {
    check_repeat(args.repeat)?;
    let (run, stop) = prepare()?;
    let mut meter = NoiseMeter::begin();
    let Some(results) = start::measure(&run, args.repeat, &stop, &mut meter)? else {
        return Ok(stopped());
    };
    args.common.finish("start", meter, results)
}

fn step(args: &StepArgs) -> Result<Exit> {
    check_seconds("--seconds", args.seconds)?;
    let meter = NoiseMeter::begin();
    let results = step::run(Duration::from_secs_f64(args.seconds))?;
    args.common.finish("step", meter, results)
}

fn sweep(args: &SweepArgs) -> Result<Exit> {
    check_seconds("--seconds", args.seconds)?;
    let jobs = args.jobs.map_or_else(cores, usize::from);
    let meter = NoiseMeter::begin();
    let results = sweep::run(Duration::from_secs_f64(args.seconds), jobs)?;
    args.common.finish("sweep", meter, results)
}

fn check_repeat(repeat: usize) -> Result<(), FieldError> {
    match repeat {
        0 => Err(FieldError::new("--repeat", 0, "measures nothing", "give 1 or more")),
        _ => Ok(()),
    }
}

/// Returns a name that no other benchmark has, and the signals that stop it.
fn prepare() -> Result<(RunName, Stop)> {
    let run = fresh_name("bench")?;
    let stop = Stop::listen(std::slice::from_ref(&run))?;
    // `clean` names what cannot be removed here.
    let _ = Domain::sweep_dead();
    Ok((run, stop))
}

fn stopped() -> Exit {
    errln!("stopped; no result is kept");
    Exit::Lost
}

pub fn run_peer(args: &BenchPeerArgs) -> Result<Exit> {
    if args.what == Bare::Raw.word() {
        raw::serve_raw(&args.run, args.wait)?;
    } else {
        floor::serve_floor(&args.run, args.client, args.wait)?;
    }
    Ok(Exit::Done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Command, FromArgMatches as _};

    #[test]
    fn without_arguments_a_log_has_the_beams_of_the_page() {
        let matches = LogArgs::augment_args(Command::new("log")).get_matches_from(["log"]);
        assert_eq!(LogArgs::from_arg_matches(&matches).unwrap().beams, log::BEAMS);
    }
}
