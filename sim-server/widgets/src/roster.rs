//! The roster of a run: its estimators and their errors.

use rusty_contract::{LogHeader, Participant, Start};
use rusty_metrics::Errors;

use crate::estimators::Estimator;
#[cfg(feature = "filters")]
use crate::filters::estimator;

/// An estimator of a run, and its errors.
pub struct Entry {
    /// Name in the roster.
    pub name: String,
    /// The estimator.
    pub estimator: Box<dyn Estimator>,
    /// Its errors up to now.
    pub errors: Errors,
}

/// Returns the answering participants of a header, in roster order.
///
/// # Errors
/// A sentence that names the participant whose program is not in this module.
pub fn entries(header: &LogHeader) -> Result<Vec<Entry>, String> {
    let slots = header.roster.iter().enumerate().filter(|(_, p)| p.answers());
    let entry = |(slot, p): (usize, &Participant)| {
        let start = Start::new(header, slot, p);
        let estimator = estimator(&start, &p.command).map_err(|e| format!("{}: {e}", p.name))?;
        Ok(Entry { name: p.name.clone(), estimator, errors: Errors::default() })
    };
    slots.map(entry).collect()
}

#[cfg(not(feature = "filters"))]
fn estimator(start: &Start, command: &[String]) -> Result<Box<dyn Estimator>, String> {
    match command {
        [program] if program == "dead-reckoning" => {
            Ok(Box::new(crate::estimators::DeadReckoning::new(start)))
        }
        _ => Err(format!("{:?} is not in this module", command.join(" "))),
    }
}
