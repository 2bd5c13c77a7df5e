//! `import`: convert recordings of real robots into run logs.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Subcommand};
use rusty_contract::{Exit, errln, outln};
use rusty_logs::import::{self, ImportOptions};

use super::WRITER;
use super::arguments::{Output, check_free};

#[derive(Subcommand, Clone, Debug)]
pub enum ImportFormat {
    /// Convert a CARMEN log (ODOM and FLASER), plain or gzip
    Carmen(CarmenArgs),
}

#[derive(Args, Clone, Debug)]
pub struct CarmenArgs {
    /// Recording to read
    pub input: PathBuf,
    /// Run log to write
    #[arg(short = 'o', long = "output", value_name = "LOG")]
    pub log: PathBuf,
    /// Refuse a recording that has findings
    #[arg(long)]
    pub strict: bool,
    /// Replace an existing run log
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Number of lines between two lines of progress.
const PROGRESS_LINES: u64 = 50_000;

pub fn run(format: &ImportFormat) -> Result<Exit> {
    let ImportFormat::Carmen(args) = format;
    check_free(&args.log, args.force)?;
    let is_shown = std::io::stderr().is_terminal() && !args.output.json;
    let mut progress = |lines: u64| {
        if is_shown && lines.is_multiple_of(PROGRESS_LINES) {
            errln!("  {lines} lines");
        }
    };
    let options = ImportOptions { writer: WRITER, strict: args.strict };
    let report = import::import_carmen(&args.input, &args.log, options, &mut progress)?;
    args.output.print_with(&report, || {
        outln!("{report}");
        outln!("log       {}", args.log.display());
        outln!("play it   sim-server replay {}", args.log.display());
    });
    Ok(Exit::Done)
}
