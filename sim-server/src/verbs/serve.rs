//! `serve`: only the server; participants join by name, started by hand.

use super::Verbed;
use super::launch::simulate;
use super::session::Starting;
use crate::cli::ServeArgs;

/// Serves a scenario. The key for scorers and loggers lies in the run's folder
/// (mode 0600) for as long as the run lasts.
///
/// # Errors
/// [`VerbError`](crate::error::VerbError) before the run; losses in the run
/// are an exit code.
pub fn serve(args: &ServeArgs) -> Verbed {
    simulate(&args.scenario, &args.run, Starting::ByHand)
}
