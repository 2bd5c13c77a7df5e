//! The command line that every participant shares.

use std::path::PathBuf;

use clap::{Args, Parser};
use rusty_contract::RunName;
use rusty_link::WaitPolicy;

/// How a participant takes part: in a run (`--run`), or on a log (`--log`).
#[derive(Args, Clone, Debug, Default)]
#[command(after_help = "A launcher appends --run, --name, --wait, --launcher and, for scorers \
    and loggers, --key-stdin.\nExit codes: 0 done, 1 failed, 2 wrong usage, 3 data was lost, 4 not bit-exact.")]
pub struct ClientArgs {
    /// Join the run of this name
    #[arg(long, value_name = "NAME", required_unless_present = "log", conflicts_with = "log")]
    pub run: Option<RunName>,

    /// Work on a log instead, without a server
    #[arg(long, value_name = "PATH")]
    pub log: Option<PathBuf>,

    /// Name in the roster [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,

    /// How to wait: balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW")]
    pub wait: WaitPolicy,

    /// How long to wait for the run to appear, s
    #[arg(long, default_value_t = 20.0, value_name = "SECONDS")]
    pub join_timeout: f64,

    /// Process of the server that started this one: once it is gone, do not
    /// wait for the run
    #[arg(long, value_name = "PID")]
    pub launcher: Option<u32>,

    /// File or folder to write to: an estimator on a log writes its answers
    /// there as CSV (default: stdout), a scorer or logger its files
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,

    /// Read the key to the truth from this file (scorers and loggers; default:
    /// the file that `sim-server serve` left in the run's folder). With --log:
    /// the key of a blind log, which `sim-server seal` wrote
    #[arg(long, value_name = "FILE")]
    pub key_file: Option<PathBuf>,

    /// Read the key to the truth from standard input
    #[arg(long, conflicts_with = "key_file")]
    pub key_stdin: bool,
}

#[derive(Parser)]
#[command(version, about = "Takes part in a run of sim-server, or works on its log")]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,
}

impl ClientArgs {
    /// Reads this process's command line; ends it with help or an error where
    /// that is what the command line asks for.
    #[must_use]
    pub fn from_command_line() -> Self {
        Cli::parse().args
    }

    /// The name in the roster: `--name`, or the program's.
    #[must_use]
    pub fn name(&self) -> String {
        self.name.clone().unwrap_or_else(|| {
            let program = std::env::args().next().map(PathBuf::from);
            let stem = program.and_then(|p| Some(p.file_stem()?.to_string_lossy().into_owned()));
            stem.unwrap_or_else(|| "client".to_owned())
        })
    }
}
