//! `run`: the loop of every filter, from its command line to its exit code.

use std::panic::{AssertUnwindSafe, catch_unwind};

use clap::Args;
use rusty_contract::{Exit, Start, errln, output};

use crate::showing::Showing;
use crate::tick::Answering as _;
use crate::{ClientArgs, ClientError, Filter, Session};

/// Runs a filter: parses the command line, and takes part until the end of the run, or of
/// the last run where the server offers several to one process.
///
/// `begin` makes the filter, anew for each run, from what a participant may know and from
/// the options `O` that its command line has in addition to [`ClientArgs`]; `()` for none.
/// The first lines of `O`'s documentation are the head of `--help`.
///
/// ```no_run
/// use rusty_clients::clap;
/// use rusty_clients::prelude::*;
///
/// /// Answer the same pose at every tick
/// #[derive(clap::Args)]
/// struct Options {
///     /// x of the pose, m
///     #[arg(long, default_value_t = 0.0)]
///     x_m: f64,
/// }
///
/// struct Fixed(SE2);
///
/// impl Filter for Fixed {
///     fn update(&mut self, _: &Tick) -> Reply {
///         self.0.into()
///     }
/// }
///
/// fn main() -> Exit {
///     rusty_clients::run(|_, options: Options| Ok(Fixed(SE2::new(options.x_m, 0.0, 0.0))))
/// }
/// ```
pub fn run<F: Filter, O: Args>(mut begin: impl FnMut(&Start, O) -> Result<F, ClientError>) -> Exit {
    let (args, mut options) = ClientArgs::with_options_of_runs();
    // Wrong options end the process before it joins.
    let mut first = Some(options());
    run_from(&args, |start| begin(start, first.take().unwrap_or_else(&mut options)))
}

/// Runs a filter with a command line that was parsed before.
pub fn run_from<F: Filter>(
    args: &ClientArgs,
    begin: impl FnMut(&Start) -> Result<F, ClientError>,
) -> Exit {
    conclude(args, drive(args, begin))
}

/// Prints why a participant failed, and returns its exit code: that of a failure
/// also where its results could not be written.
pub(crate) fn conclude(args: &ClientArgs, done: Result<Exit, ClientError>) -> Exit {
    let name = args.name();
    let exit = done.unwrap_or_else(|e| {
        errln!("{name}: {e}");
        e.exit()
    });
    output::finish(&name, exit)
}

fn drive<F: Filter>(
    args: &ClientArgs,
    mut begin: impl FnMut(&Start) -> Result<F, ClientError>,
) -> Result<Exit, ClientError> {
    if !F::SHOWS_BELIEF {
        args.check_no_beliefs()?;
    }
    every_run(&mut Session::enter(args)?, |run| drive_one(run, args, &mut begin))
}

/// Takes part in one run after the other, as long as each ends well: the exit code of this
/// process is that of its last run.
pub(crate) fn every_run(
    session: &mut Session,
    mut take_part: impl FnMut(&mut Session) -> Result<Exit, ClientError>,
) -> Result<Exit, ClientError> {
    let mut exit = Exit::Done;
    while let Some(run) = session.next_run()? {
        exit = take_part(run)?;
        if exit != Exit::Done || run.ending().is_none() || !output::is_open() {
            break;
        }
    }
    Ok(exit)
}

fn drive_one<F: Filter>(
    session: &mut Session,
    args: &ClientArgs,
    begin: impl FnOnce(&Start) -> Result<F, ClientError>,
) -> Result<Exit, ClientError> {
    let mut filter = begin(session.start()).inspect_err(|_| session.fail())?;
    let showing = F::SHOWS_BELIEF.then(|| Showing::new(args, session.start()));
    let mut showing = showing.transpose().inspect_err(|_| session.fail())?;
    loop {
        let Some(mut tick) = session.next()? else { break };
        // A panic is the filter's own failure: it is reported to the server at once,
        // and this process ends with a message and a code.
        let update = || {
            if filter.wait() {
                tick.restart_clock();
            }
            filter.update(&tick)
        };
        let Ok(reply) = catch_unwind(AssertUnwindSafe(update)) else {
            let number = tick.index();
            tick.fail();
            return Err(ClientError::Panicked { tick: number });
        };
        if filter.is_done() {
            tick.end_run();
        }
        if let Err(e) = tick.reply(reply) {
            tick.fail();
            return Err(e);
        }
        if let Some(showing) = &mut showing {
            let moment = showing.moment(&tick);
            drop(tick);
            showing.show(session, moment, &filter);
        }
    }
    // The filter's results come first: no belief is worth a map.
    filter.finish().inspect_err(|_| session.fail())?;
    showing.map_or(Ok(()), Showing::finish).inspect_err(|_| session.fail())?;
    Ok(if session.log_is_broken() { Exit::Lost } else { Exit::Done })
}
