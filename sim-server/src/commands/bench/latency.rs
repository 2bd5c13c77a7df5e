//! `bench latency`: measure a tick against the raw transport and a lower bound.

use anyhow::Result;
use clap::Args;
use rusty_bench::latency::Plan;
use rusty_bench::noise::NoiseMeter;
use rusty_contract::{Exit, FieldError, MAX_PARTICIPANTS};
use rusty_engine::shell;
use rusty_link::WaitPolicy;

use super::{CommonArgs, check_repeat, prepare, stopped};

#[derive(Args, Clone, Debug)]
#[command(after_help = "Example: sim-server bench latency \
    --beside \"python3 clients/python/examples/dead_reckoning.py\"")]
pub struct LatencyArgs {
    /// Numbers of clients, each a separate process
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,2,3,8")]
    pub clients: Vec<usize>,
    /// Numbers of beams
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "180,1080")]
    pub beams: Vec<u32>,
    /// Scan every N ticks, 0 for no scans
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "0,1")]
    pub scan_every: Vec<u64>,
    /// Also measure server, estimator, scorer and logger together
    #[arg(long)]
    pub mix: bool,
    /// Also measure this program in place of one dead reckoning
    #[arg(long, value_name = "COMMAND", default_value = "", hide_default_value = true)]
    pub beside: String,
    /// Ticks of a repetition, after a warm-up of a tenth of them
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    pub ticks: usize,
    /// Repetitions of each measurement, in turns with the others
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repeat: usize,
    /// Waiting method of all processes, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,
    /// Cores of the server, then of the clients in turn
    /// [default: chosen by the kernel]
    #[arg(long, value_name = "CORE,…", value_delimiter = ',')]
    pub pin: Vec<usize>,
    #[command(flatten)]
    pub common: CommonArgs,
}

pub fn run(args: &LatencyArgs) -> Result<Exit> {
    let refuse = |field, value: usize, problem, remedy| {
        Err(FieldError::new(field, value, problem, remedy).into())
    };
    if let Some(&n) = args.clients.iter().find(|n| !(1..=MAX_PARTICIPANTS).contains(*n)) {
        return refuse("--clients", n, "a run has 1 to 16 participants", "give such numbers");
    }
    if args.ticks < 100 {
        return refuse("--ticks", args.ticks, "too few for any quantile", "give 100 or more");
    }
    check_repeat(args.repeat)?;
    let (run, stop) = prepare()?;
    let LatencyArgs { beside: command, .. } = args;
    let plan = Plan {
        clients: args.clients.clone(),
        beams: args.beams.clone(),
        scan_every: args.scan_every.clone(),
        mix: args.mix,
        beside: shell::words("--beside", command)?,
        ticks: args.ticks,
        repeat: args.repeat,
        wait: args.wait,
        pin: args.pin.clone(),
        quiet: args.common.quiet,
    };
    let mut meter = NoiseMeter::begin();
    let Some(results) = plan.measure(&run, &stop, &mut meter)? else {
        return Ok(stopped());
    };
    args.common.finish("latency", meter, results)
}
