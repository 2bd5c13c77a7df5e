//! `Estimator`: a filter as a type, and the loop that runs it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rusty_contract::{Exit, Reply, Start};

use crate::{ClientArgs, ClientError, Session, Tick};

/// A filter. [`run`] does everything else: command line, joining, answering,
/// logs, goodbye.
pub trait Estimator: Sized {
    /// Begins, knowing what an estimator may know.
    fn start(start: &Start) -> Self;

    /// Answers one tick: a pose, an `Estimate`, a command, or `Reply::Abstain`.
    fn tick(&mut self, tick: &Tick<'_>) -> Reply;
}

/// `main` of an estimator: parses the command line and takes part to the end.
///
/// ```no_run
/// use rusty_clients::prelude::*;
///
/// struct Lost;
///
/// impl Estimator for Lost {
///     fn start(_: &Start) -> Self {
///         Lost
///     }
///     fn tick(&mut self, _: &Tick) -> Reply {
///         Reply::Abstain
///     }
/// }
///
/// fn main() -> Exit {
///     rusty_clients::run::<Lost>()
/// }
/// ```
pub fn run<E: Estimator>() -> Exit {
    let args = ClientArgs::from_command_line();
    match drive::<E>(&args) {
        Ok(exit) => exit,
        Err(e) => {
            crate::error::say(format_args!("{}: {e}", args.name()));
            e.exit()
        }
    }
}

fn drive<E: Estimator>(args: &ClientArgs) -> Result<Exit, ClientError> {
    let mut session = Session::join(args)?;
    let mut estimator = E::start(session.start());
    while let Some(mut tick) = session.next()? {
        // A panic is the estimator's own failure: the server hears of it at
        // once, and this process ends with a message and a code.
        let Ok(reply) = catch_unwind(AssertUnwindSafe(|| estimator.tick(&tick))) else {
            let number = tick.tick();
            tick.fail();
            return Err(ClientError::Panicked { tick: number });
        };
        if let Err(e) = tick.reply(reply) {
            tick.fail();
            return Err(e);
        }
    }
    Ok(if session.log_is_broken() { Exit::Lost } else { Exit::Done })
}
