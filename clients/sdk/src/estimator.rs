//! `Estimator` and `Filter`: a filter as a type, and the loop that runs it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rusty_contract::{BeliefKind, Exit, Reply, Start, WeightedPose, errln, output};

use crate::showing::Showing;
use crate::{ClientArgs, ClientError, Session, Tick};

/// A filter. [`run`] does everything else: command line, joining, answering,
/// logs, goodbye.
pub trait Estimator: Sized {
    /// Begins, knowing what an estimator may know.
    fn start(start: &Start) -> Self;

    /// Answers one tick: a pose, an `Estimate`, a command, or `Reply::Abstain`.
    fn tick(&mut self, tick: &Tick<'_>) -> Reply;
}

/// A filter that can do more than an [`Estimator`]: it may have options of its
/// own, fail to begin, show what it holds possible, and leave something behind.
/// [`run_from`] runs it.
pub trait Filter: Sized {
    /// Whether there is anything in [`belief`](Self::belief). A filter without
    /// one says no and has no part in showing any; `--beliefs` is then refused at
    /// once.
    const SHOWS_BELIEF: bool = true;

    /// Answers one tick: a pose, an `Estimate`, a command, or `Reply::Abstain`.
    fn tick(&mut self, tick: &Tick<'_>) -> Reply;

    /// Adds what it holds possible now to `poses`, for whoever looks on; `None`
    /// if its answer says it all. Asked after a tick with a scan was answered
    /// (after every tick before the first scan), and only while somebody looks;
    /// so nothing may depend on it. Poses that are none are taken out, and of
    /// more than [`MAX_POSES`](rusty_contract::belief::MAX_POSES) some are shown.
    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let _ = poses;
        None
    }

    /// The run is over: the place to write down what was found.
    ///
    /// # Errors
    /// Whatever kept it from writing; this process then fails.
    fn finish(self) -> Result<(), ClientError> {
        Ok(())
    }
}

impl<E: Estimator> Filter for E {
    const SHOWS_BELIEF: bool = false;

    fn tick(&mut self, tick: &Tick<'_>) -> Reply {
        Estimator::tick(self, tick)
    }
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
    run_from(&ClientArgs::from_command_line(), |start| Ok(E::start(start)))
}

/// The same for a [`Filter`] whose `main` has read the command line itself:
/// flatten [`ClientArgs`] into the arguments of your own.
///
/// ```no_run
/// use rusty_clients::clap::{self, Parser};
/// use rusty_clients::prelude::*;
///
/// /// Stands where it is told.
/// #[derive(Parser)]
/// struct Cli {
///     #[command(flatten)]
///     args: ClientArgs,
///
///     /// Where, m
///     #[arg(long, default_value_t = 0.0)]
///     x_m: f64,
/// }
///
/// struct Stubborn(SE2);
///
/// impl Filter for Stubborn {
///     fn tick(&mut self, _: &Tick) -> Reply {
///         self.0.into()
///     }
/// }
///
/// fn main() -> Exit {
///     let Cli { args, x_m } = Cli::parse();
///     run_from(&args, |_| Ok(Stubborn(SE2::new(x_m, 0.0, 0.0))))
/// }
/// ```
pub fn run_from<F: Filter>(
    args: &ClientArgs,
    begin: impl FnOnce(&Start) -> Result<F, ClientError>,
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
    begin: impl FnOnce(&Start) -> Result<F, ClientError>,
) -> Result<Exit, ClientError> {
    if !F::SHOWS_BELIEF && !args.beliefs.is_empty() {
        return Err(ClientError::ShowsNone(args.name()));
    }
    let mut session = Session::enter(args)?;
    let mut filter = begin(session.start()).inspect_err(|_| session.fail())?;
    let showing = F::SHOWS_BELIEF.then(|| Showing::new(args, session.start()));
    let mut showing = showing.transpose().inspect_err(|_| session.fail())?;
    loop {
        let Some(mut tick) = session.next()? else { break };
        // A panic is the estimator's own failure: the server hears of it at
        // once, and this process ends with a message and a code.
        let Ok(reply) = catch_unwind(AssertUnwindSafe(|| filter.tick(&tick))) else {
            let number = tick.tick();
            tick.fail();
            return Err(ClientError::Panicked { tick: number });
        };
        if let Err(e) = tick.reply(reply) {
            tick.fail();
            return Err(e);
        }
        if let Some(showing) = &mut showing {
            let moment = showing.moment(&tick);
            drop(tick);
            showing.show(&mut session, moment, &filter);
        }
    }
    // What the filter leaves behind comes first: no belief is worth a map.
    filter.finish().inspect_err(|_| session.fail())?;
    showing.map_or(Ok(()), Showing::finish).inspect_err(|_| session.fail())?;
    Ok(if session.log_is_broken() { Exit::Lost } else { Exit::Done })
}
