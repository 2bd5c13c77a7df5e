//! `seal`: split a log into a blind log and the key to its truth.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use rusty_contract::{Exit, errln, outln};
use rusty_engine::shell;

use super::arguments::Output;
use super::{WRITER, warn_of_guessable_seed};

#[derive(Args, Clone, Debug)]
pub struct SealArgs {
    /// Log of a simulation or of a recording
    pub log: PathBuf,
    /// Blind log to write, without truth, seed and true parameters
    #[arg(short = 'o', long = "output", value_name = "BLIND")]
    pub path: PathBuf,
    /// Key to write, with all that the blind log lacks (mode 0600)
    #[arg(long, value_name = "FILE")]
    pub key_file: PathBuf,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(args: &SealArgs) -> Result<Exit> {
    let sealed = rusty_logs::seal::seal(&args.log, &args.path, &args.key_file, (None, WRITER))?;
    let ticks = sealed.ticks;
    if let Some(cut) = &sealed.cut {
        let log = args.log.display();
        errln!("{log}: cut {cut}; its {ticks} complete ticks are sealed, without an end");
    }
    warn_of_guessable_seed(&sealed.header, "a reader of the blind log");
    args.output.print_with(&sealed, || {
        let word =
            |known: bool| if known { "kept: an answering participant has it" } else { "out" };
        outln!("blind      {} (to hand out)", sealed.blind);
        outln!("key        {} (to keep)", sealed.key_file);
        outln!("ticks      {ticks}, {} with a truth", sealed.ticks_with_truth);
        outln!("start      {}", word(sealed.start_known));
        outln!("world      {}", word(sealed.world_known));
        outln!("observable {}", sealed.observable_digest);
        outln!("play it    sim-server replay {} --add NAME=COMMAND", shell::quoted(&sealed.blind));
        let key_file = shell::quoted(&sealed.key_file);
        outln!("score it   score --log RUN.log --key-file {key_file}");
    });
    Ok(if sealed.complete { Exit::Done } else { Exit::Lost })
}
