//! `seal`: a log without its truth to hand out, and the key to keep.

use rusty_contract::{Exit, errln, outln};

use super::launch::writer;
use super::{Verbed, print_json, warn_of_guessable_seed};
use crate::cli::SealArgs;

/// Seals a log: exit 0, or 3 if the log has no end.
///
/// # Errors
/// [`VerbError`](crate::error::VerbError) names file, problem and remedy.
pub fn seal(args: &SealArgs) -> Verbed {
    let sealed = rusty_logs::seal::seal(&args.log, &args.output, &args.key_file, &writer())?;
    let ticks = sealed.ticks;
    if let Some(cut) = &sealed.cut {
        let log = args.log.display();
        errln!("{log}: cut {cut}; its {ticks} complete ticks are sealed, without an end");
    }
    warn_of_guessable_seed(&sealed.header, "a reader of the blind log");
    if args.json {
        print_json(&sealed);
    } else {
        let word =
            |known: bool| if known { "kept: an answering participant has it" } else { "out" };
        outln!("blind      {} (to hand out)", sealed.blind);
        outln!("key        {} (to keep)", sealed.key_file);
        outln!("ticks      {ticks}, {} with a truth", sealed.ticks_with_truth);
        outln!("start      {}", word(sealed.start_known));
        outln!("world      {}", word(sealed.world_known));
        outln!("observable {}", sealed.observable_digest);
        outln!("play it    sim-server replay {} --add NAME=COMMAND", sealed.blind);
        outln!("score it   score --log RUN.log --key-file {}", sealed.key_file);
    }
    Ok(if sealed.complete { Exit::Done } else { Exit::Lost })
}
