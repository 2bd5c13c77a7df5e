//! The filters for comparison, with the options of their command lines.

use rusty_clients::clap::{Args, Command};
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Frame, Reply, Start, WeightedPose};
use rusty_filters::{ekf, mcl};

use crate::estimators::{DeadReckoning, Estimator};

/// A filter as its program runs it.
struct Client<F>(F);

impl<F: Filter + Send> Estimator for Client<F> {
    fn update(&mut self, frame: &Frame) -> Reply {
        self.0.update(&Tick::detached(frame))
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) {
        if F::SHOWS_BELIEF {
            let _ = self.0.belief(poses);
        }
    }
}

/// Returns the estimator that a program would be with this command.
///
/// # Errors
/// A sentence: the program is not in this module, or its options are invalid.
pub fn estimator(start: &Start, command: &[String]) -> Result<Box<dyn Estimator>, String> {
    match command.first().map(String::as_str) {
        Some("dead-reckoning") if command.len() == 1 => Ok(Box::new(DeadReckoning::new(start))),
        Some("ekf") => boxed(ekf::Ekf::new(start, &options(command)?)),
        Some("mcl") => boxed(mcl::Mcl::of_start(start, &options(command)?)),
        _ => Err(format!("{:?} is not in this module", command.join(" "))),
    }
}

fn boxed<F>(filter: Result<F, ClientError>) -> Result<Box<dyn Estimator>, String>
where
    F: Filter + Send + 'static,
{
    let filter = filter.map_err(|e| e.to_string())?;
    Ok(Box::new(Client(filter)))
}

fn options<O: Args>(command: &[String]) -> Result<O, String> {
    let matches = O::augment_args(Command::new("widget")).try_get_matches_from(command);
    matches.and_then(|m| O::from_arg_matches(&m)).map_err(|e| e.to_string())
}
