//! Another program in the place of one dead reckoning: what a tick costs then.

use rusty_contract::{Participant, Role};
use serde::{Deserialize, Serialize};

use super::{Measured, Repeated};
use crate::quantiles::Spread;

/// The same run with another program in the place of the first estimator.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Beside {
    /// Its command line.
    pub command: String,
    /// A full tick of that run.
    pub tick: Measured,
    /// Median tick over the median tick with dead reckoning, in each repetition.
    pub over_tick: Spread,
    /// By how much the median tick is longer, in each repetition, ns.
    pub more_ns: Spread,
}

impl Beside {
    pub(super) fn of(command: &[String], there: Repeated, here: &Repeated) -> Self {
        let pairs = || there.p50_ns.iter().zip(&here.p50_ns);
        Self {
            command: command.join(" "),
            over_tick: Spread::of(pairs().map(|(there, here)| there / here.max(1.0))),
            more_ns: Spread::of(pairs().map(|(there, here)| there - here)),
            tick: there.measured,
        }
    }
}

/// The roster with the program in the place of the first estimator.
pub(super) fn replaced(roster: &[Participant], command: &[String]) -> Vec<Participant> {
    let mut roster = roster.to_vec();
    if let Some(first) = roster.iter_mut().find(|p| p.role == Role::Estimator) {
        first.command = command.to_vec();
    }
    roster
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::mix;

    #[test]
    fn one_estimator_is_replaced_and_nobody_else() {
        let command = ["python3".to_owned(), "my_filter.py".to_owned()];
        let (before, after) = (mix(), replaced(&mix(), &command));
        assert_eq!((&after[0].name, &after[0].command[..]), (&before[0].name, &command[..]));
        assert_eq!(after[1..], before[1..]);
    }
}
