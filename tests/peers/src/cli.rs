//! The command line.

use std::fs;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, value_parser};
use rustix::process::Signal;
use rusty_bench::report::Printing;
use rusty_clients::ClientArgs;
use rusty_contract::Exit;

use crate::contender::{Contender, Wait};
use crate::error::BenchError;
use crate::output::{print, say};
use crate::{client, ours, raw, server, tour};

/// The tick of sim-server compared with the same tick over ZeroMQ, Zenoh and Unix sockets
///
/// A server makes a frame, sends it to its clients, waits for an answer from
/// each, and makes the next. The report gives the bytes of both. Server and
/// clients are separate processes and do the same work for all transports; only
/// frames and answers travel otherwise. The run digest of all must be equal.
#[derive(Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Ways of waiting:\n  \
        block     asleep in the kernel until woken: what people write\n  \
        poll      looking again and again, with sched_yield between looks\n  \
        balanced  poll for a while, then block: how sim-server comes, and ours alone\n\
        A ratio compares medians: \"same wait\" with ours waiting likewise, \"ours\" with ours as\n\
        it comes. Without a verdict of \"quiet\" believe ratios more than times.\n\n\
        Examples:\n  \
        rusty-peers --clients 3 --peers zmq,zenoh\n  \
        rusty-peers --clients 1 --waits poll --scans --json > peers.json\n\n\
        Exit codes: 0 done, 1 failed or not to be believed, 2 wrong usage, 3 interrupted or a\n\
        contender failed, 4 two contenders made different runs."
)]
pub struct Cli {
    #[command(flatten)]
    pub tour: TourArgs,

    #[command(subcommand)]
    role: Option<Role>,
}

/// What is measured.
#[derive(Args, Clone, Debug)]
pub struct TourArgs {
    /// Numbers of clients
    #[arg(long, value_delimiter = ',', default_value = "1,2,3,8", value_name = "K,…",
          value_parser = value_parser!(u32).range(1..=16))]
    pub clients: Vec<u32>,

    /// Ticks of one measurement
    #[arg(long, default_value_t = 10_000, value_name = "N",
          value_parser = value_parser!(u64).range(1..=10_000_000))]
    pub ticks: u64,

    /// Ticks before each that are not measured
    #[arg(long, default_value_t = 1_000, value_name = "N",
          value_parser = value_parser!(u64).range(0..=10_000_000))]
    pub warm_up: u64,

    /// How often each is measured, all taking turns
    #[arg(long, default_value_t = 3, value_name = "N",
          value_parser = value_parser!(u32).range(1..=1000))]
    pub repetitions: u32,

    /// Transports to compare with ours
    #[arg(long, value_delimiter = ',', default_value = "zmq,zenoh,uds,raw", value_name = "WHO,…")]
    pub peers: Vec<Contender>,

    /// Ways of waiting
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "block,poll,balanced",
        value_name = "HOW,…"
    )]
    pub waits: Vec<Wait>,

    /// With the scans of the scenario (180 beams in every fifth tick)
    #[arg(long)]
    pub scans: bool,

    /// One JSON document on stdout instead of tables
    #[arg(long)]
    pub json: bool,

    /// Do not fail because the machine was too noisy to be believed
    #[arg(long)]
    pub accept_noise: bool,
}

impl TourArgs {
    /// How the report is to print.
    pub fn printing(&self) -> Printing {
        Printing { json: self.json, accept_noise: self.accept_noise }
    }
}

/// What this program is when it starts itself.
#[derive(Subcommand)]
#[command(hide = true)]
enum Role {
    /// A server with its clients.
    #[command(hide = true)]
    Server(ServerPlan),
    /// A client of a transport of the others.
    #[command(hide = true)]
    Client(ClientPlan),
    /// A client of sim-server.
    #[command(hide = true)]
    DeadReckoning(ClientArgs),
}

/// What server and clients must agree about.
#[derive(Args, Clone, Debug)]
pub struct CellPlan {
    /// Who carries.
    #[arg(long)]
    pub contender: Contender,
    /// How everyone waits.
    #[arg(long)]
    pub wait: Wait,
    /// Place for sockets.
    #[arg(long)]
    pub folder: PathBuf,
    /// The process that started this one.
    #[arg(long)]
    pub parent: u32,
    /// Whether frames have scans.
    #[arg(long)]
    pub scans: bool,
}

impl CellPlan {
    /// The same as a command line, for a child of this process.
    pub fn to_args(&self) -> Vec<String> {
        let mut args = vec![
            format!("--contender={}", self.contender),
            format!("--wait={}", self.wait),
            format!("--folder={}", self.folder.display()),
            format!("--parent={}", std::process::id()),
        ];
        args.extend(self.scans.then(|| "--scans".to_owned()));
        args
    }
}

/// What a server is told.
#[derive(Args, Clone, Debug)]
pub struct ServerPlan {
    #[command(flatten)]
    pub cell: CellPlan,
    /// How many clients it starts.
    #[arg(long)]
    pub clients: usize,
    /// Ticks that are measured.
    #[arg(long)]
    pub ticks: u64,
    /// Ticks before them.
    #[arg(long)]
    pub warm_up: u64,
}

impl ServerPlan {
    /// The same as a command line, for a child of this process.
    pub fn to_args(&self) -> Vec<String> {
        let mut args = self.cell.to_args();
        args.push(format!("--clients={}", self.clients));
        args.push(format!("--ticks={}", self.ticks));
        args.push(format!("--warm-up={}", self.warm_up));
        args
    }
}

/// What a client is told.
#[derive(Args, Clone, Debug)]
pub struct ClientPlan {
    #[command(flatten)]
    pub cell: CellPlan,
    /// Its place among the clients, from 0.
    #[arg(long)]
    pub place: u32,
}

/// Does what the command line asks for.
pub fn main() -> Exit {
    let cli = Cli::parse();
    let done = match &cli.role {
        None => return tour::main(&cli.tour),
        Some(Role::Server(plan)) => serve(plan),
        Some(Role::Client(plan)) if plan.cell.contender == Contender::Raw => raw::client(plan),
        Some(Role::Client(plan)) => client::main(plan),
        Some(Role::DeadReckoning(args)) => ours::dead_reckoning(args),
    };
    match done {
        Ok(()) => Exit::Done,
        Err(BenchError::Stopped) => Exit::Lost,
        Err(e) => {
            say(e);
            Exit::Failed
        }
    }
}

/// A server's process: measures and prints what it measured.
fn serve(plan: &ServerPlan) -> Result<(), BenchError> {
    client::end_with_parent(plan.cell.parent, Signal::TERM)?;
    let measured = match plan.cell.contender {
        Contender::Ours => ours::measure(plan),
        Contender::Raw => raw::measure(plan),
        _ => server::measure(plan),
    };
    // If the parent has ended, no other process removes it.
    let _ = fs::remove_dir_all(&plan.cell.folder);
    let text = serde_json::to_string(&measured?).map_err(BenchError::of("serde_json", "write"))?;
    print(text);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        use clap::CommandFactory as _;
        Cli::command().debug_assert();
    }

    #[test]
    fn a_server_s_plan_survives_the_command_line() {
        let words = "x server --contender=zmq --wait=poll --folder=/f --parent=3 --scans \
                     --clients=2 --ticks=7 --warm-up=1";
        let plan = |words: Vec<String>| match Cli::parse_from(words).role {
            Some(Role::Server(plan)) => plan,
            _ => panic!("no server"),
        };
        let first = plan(words.split_whitespace().map(str::to_owned).collect());
        let mut again = vec!["x".to_owned(), "server".to_owned()];
        again.extend(first.to_args());
        let second = plan(again);
        assert_eq!(second.cell.parent, std::process::id());
        let same = ServerPlan { cell: CellPlan { parent: 3, ..second.cell }, ..second };
        assert_eq!(format!("{first:?}"), format!("{same:?}"));
    }
}
