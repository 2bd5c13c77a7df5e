//! `replay`: replay a log to its participants in lockstep.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use rusty_contract::log::Ending;
use rusty_contract::{Exit, Scenario, errln};
use rusty_engine::source::FrameSource as _;
use rusty_logs::original::Compare as _;
use rusty_logs::replay::Recording;

use super::arguments::RunArgs;
use super::session::{RunPlace, RunSession, Starting};

#[derive(Args, Clone, Debug)]
pub struct ReplayArgs {
    /// Log to replay
    pub log: PathBuf,
    /// Start no program; wait for participants started by hand
    #[arg(long)]
    pub attach: bool,
    #[command(flatten)]
    pub run: RunArgs,
}

pub fn run(args: &ReplayArgs) -> Result<Exit> {
    let (mut source, ending) = Recording::open(&args.log)?;
    if let Ending::Cut { ticks, at_byte, problem } = &ending {
        let log = args.log.display();
        errln!("{log}: cut at byte {at_byte} ({problem}); its {ticks} complete ticks are played");
    }
    if let Some(damaged) = source.comparison().map(|c| c.damaged).filter(|n| *n > 0) {
        let log = args.log.display();
        errln!("{log}: the checksums of {damaged} records fail; what they hold is suspect");
    }
    if source.tick_count() == 0 {
        let error = rusty_engine::source::SourceError::Cut {
            ticks: 0,
            at_byte: 0,
            problem: "there is no complete tick in it to play".to_owned(),
        };
        errln!("{}: {error}", args.log.display());
        return Ok(Exit::Failed);
    }
    args.run.change_roster(&mut source.header_mut().roster)?;
    let place = RunPlace::find(&args.run, &source.header().config.scenario, &[&args.log])?;
    let defaults = Scenario::default();
    RunSession {
        args: &args.run,
        starting: if args.attach { Starting::ByHand } else { Starting::Launch },
        answer_timeout_s: defaults.answer_timeout_s,
        join_timeout_s: defaults.join_timeout_s,
        announced: true,
    }
    .run(place, &mut source)
}
