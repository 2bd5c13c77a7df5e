//! How the answers of a replay compare with the recorded ones.

use rusty_contract::Reply;
use rusty_contract::log::TickRecord;
use serde::Serialize;

use super::compare;

/// How the replies of a replay compare with the recorded ones.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Comparison {
    /// Run digest in the log's trailer; null if it was cut.
    pub recorded_digest: Option<String>,
    /// World digest in the log's trailer; null if it was cut.
    pub recorded_world_digest: Option<String>,
    /// Replies that a participant of the same name gave in the log.
    pub compared: u64,
    /// Those equal to the recorded one, bit for bit.
    pub equal: u64,
    /// The same, participant by participant.
    pub participants: Vec<Compared>,
    /// The first that is not equal.
    pub first_difference: Option<Difference>,
    /// The log has no trailer.
    pub cut: bool,
    /// Records of the log whose checksums fail.
    pub damaged: u64,
    /// Others answer than in the log, so that the run digest cannot be its own.
    pub other_roster: bool,
}

/// One participant's replies compared with the recorded ones.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Compared {
    /// Whose.
    pub name: String,
    /// Replies that the log has too.
    pub compared: u64,
    /// Those equal to the recorded one, bit for bit.
    pub equal: u64,
    /// Answers to ticks at which the log has none, because the participant had
    /// been lost by then: there is nothing to compare them with.
    pub unrecorded: u64,
}

/// A reply that is not the recorded one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Where.
    pub tick: u64,
    /// Whose.
    pub name: String,
    /// What of it: `estimate x_m`, `covariance[1][1]`, `command v_m_s`, `kind`.
    pub field: String,
    /// What the log has, with its bits.
    pub recorded: String,
    /// What came, with its bits.
    pub replayed: String,
}

impl Comparison {
    /// Compares the replies of one tick, by name, with what `record` has;
    /// `names` are those who answer in the log, in its order.
    pub(crate) fn take(
        &mut self,
        record: &TickRecord,
        names: &[String],
        replies: &mut dyn Iterator<Item = (&str, Reply)>,
    ) {
        let mut answering = 0;
        for (i, (name, reply)) in replies.enumerate() {
            let place = names.iter().position(|n| n == name);
            self.other_roster |= place != Some(i);
            answering += 1;
            let Some(recorded) = place.and_then(|i| record.replies.get(i)) else { continue };
            self.one(record.tick, name, recorded, &reply);
        }
        self.other_roster |= answering != names.len();
    }

    fn one(&mut self, tick: u64, name: &str, recorded: &Reply, replayed: &Reply) {
        let place = self.participants.iter().position(|p| p.name == name);
        let place = place.unwrap_or_else(|| {
            self.participants.push(Compared { name: name.to_owned(), ..Compared::default() });
            self.participants.len() - 1
        });
        let participant = &mut self.participants[place];
        let difference = compare::reply(recorded, replayed);
        if difference.is_some() && *recorded == Reply::Missing {
            participant.unrecorded += 1;
            return;
        }
        let equal = u64::from(difference.is_none());
        participant.compared += 1;
        participant.equal += equal;
        self.compared += 1;
        self.equal += equal;
        if let (Some(found), None) = (difference, &self.first_difference) {
            self.first_difference = Some(Difference {
                tick,
                name: name.to_owned(),
                field: found.field,
                recorded: found.a,
                replayed: found.b,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{EncoderCounts, SE2, Twist};

    fn record(replies: Vec<Reply>) -> TickRecord {
        TickRecord {
            tick: 7,
            stamp_s: None,
            ticks: EncoderCounts::default(),
            command: Twist::default(),
            truth: None,
            ranges_m: None,
            replies,
            readings: rusty_contract::OwnedReadings::default(),
        }
    }

    #[test]
    fn the_first_difference_is_named_and_everyone_is_counted() {
        let names = ["a", "b"].map(str::to_owned);
        let pose = |x| Reply::from(SE2::new(x, 0.0, 0.0));
        let mut found = Comparison::default();
        let mut replies = [("a", pose(1.0)), ("b", pose(2.0))].into_iter();
        found.take(&record(vec![pose(1.0), pose(-2.0)]), &names, &mut replies);
        assert_eq!((found.compared, found.equal, found.other_roster), (2, 1, false));
        let first = found.first_difference.clone().unwrap();
        assert_eq!((first.tick, first.name.as_str()), (7, "b"));
        assert_eq!(first.field, "estimate x_m");
        assert_eq!(first.recorded, "-2.0 (bits c000000000000000)");
        assert_eq!(first.replayed, "2.0 (bits 4000000000000000)");
        // What the log lacks is no difference.
        let mut replies = [("a", pose(1.0)), ("b", pose(2.0))].into_iter();
        found.take(&record(vec![pose(1.0), Reply::Missing]), &names, &mut replies);
        let counts = |p: &Compared| (p.compared, p.equal, p.unrecorded);
        assert_eq!(
            found.participants.iter().map(counts).collect::<Vec<_>>(),
            [(2, 2, 0), (1, 0, 1)]
        );
        assert_eq!(found.first_difference, Some(first));
    }

    #[test]
    fn another_roster_is_noticed() {
        let names = ["a", "b"].map(str::to_owned);
        let mut found = Comparison::default();
        found.take(
            &record(vec![Reply::Abstain; 2]),
            &names,
            &mut [("b", Reply::Abstain)].into_iter(),
        );
        assert!(found.other_roster);
        assert_eq!((found.compared, found.equal), (1, 1));
    }
}
