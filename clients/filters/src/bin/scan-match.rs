//! `scan-match`: odometry by matching scans.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from};
use rusty_contract::Exit;
use rusty_filters::scan_match::{ScanMatch, ScanMatchOptions};

/// Estimate odometry by scan matching
///
/// Each scan is matched to the walls of a key scan (point-to-line ICP). The encoders
/// give the initial guess and its uncertainty. No map is needed. The estimate drifts
/// only from key scan to key scan, and its covariance grows accordingly.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    options: ScanMatchOptions,
}

fn main() -> Exit {
    let Cli { args, options } = Cli::parse();
    run_from(&args, |start| Ok(ScanMatch::new(start, &options)))
}
