//! `replay`: a log's frames to the same participants again, in lockstep.

use rusty_contract::log::Ending;
use rusty_contract::{Scenario, errln};

use super::Verbed;
use super::launch::change_roster;
use super::session::{RunPlace, RunSession, Starting};
use crate::cli::ReplayArgs;
use rusty_engine::source::{FrameSource as _, Recording};

/// Plays a log.
///
/// # Errors
/// [`VerbError`](crate::error::VerbError) before the run; losses in the run
/// are an exit code.
pub fn replay(args: &ReplayArgs) -> Verbed {
    let (mut source, ending) = Recording::open(&args.log)?;
    if let Ending::Cut { ticks, at_byte, problem } = &ending {
        let log = args.log.display();
        errln!("{log}: cut at byte {at_byte} ({problem}); its {ticks} complete ticks are played");
    }
    if let Some(damaged) = source.comparison().map(|c| c.damaged).filter(|n| *n > 0) {
        let log = args.log.display();
        errln!("{log}: the checksums of {damaged} records fail; what they hold is suspect");
    }
    if source.ticks() == 0 {
        let error = rusty_engine::source::SourceError::Cut {
            ticks: 0,
            at_byte: 0,
            problem: "there is no complete tick in it to play".to_owned(),
        };
        errln!("{}: {error}", args.log.display());
        return Ok(rusty_contract::Exit::Failed);
    }
    change_roster(&mut source.header_mut().roster, &args.run)?;
    let place = RunPlace::find(&args.run, &source.header().config.scenario, Some(&args.log))?;
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
