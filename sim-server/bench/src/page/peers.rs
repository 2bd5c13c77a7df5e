//! What people would use instead, on the page: the document of `rusty-peers`,
//! a program beside the workspace (`tests/peers`).

use serde::{Deserialize, Serialize};

use super::{Finding, Section, Table};
use crate::quantiles::Quantiles;

/// What the page needs of the document's results.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PeersResults {
    /// A row for each peer, way of waiting and number of clients.
    pub rows: Vec<PeerRow>,
    /// What was aimed at.
    pub goals: Vec<PeerGoal>,
}

/// A peer, waiting in one way, with so many clients.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PeerRow {
    /// `zmq`, `zenoh`, `uds` or `ours`.
    pub contender: String,
    /// `block`, `poll` or `balanced`.
    pub wait: String,
    /// How many clients.
    pub clients: u32,
    /// From the beginning of a tick to that of the next.
    pub tick: Quantiles,
    /// Ticks in a second.
    pub ticks_per_s: f64,
    /// Median over that of ours waiting in the same way.
    pub times_ours_same_wait: Option<f64>,
    /// Median over that of ours as it comes.
    pub times_ours: Option<f64>,
}

/// What was aimed at for one peer.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PeerGoal {
    /// Which.
    pub contender: String,
    /// As people use it.
    pub as_used: Option<f64>,
    /// Both poll.
    pub both_poll: Option<f64>,
}

impl From<&PeersResults> for Section {
    fn from(found: &PeersResults) -> Self {
        let us = |ns: u64| format!("{:.1}", ns as f64 * 1e-3);
        let row = |row: &PeerRow| {
            vec![
                format!("{}, {}, {} clients", name(&row.contender), row.wait, row.clients),
                us(row.tick.p50_ns),
                us(row.tick.p90_ns),
                us(row.tick.p99_ns),
                format!("{:.0}", row.ticks_per_s),
                ratio(row.times_ours_same_wait),
                ratio(row.times_ours),
            ]
        };
        Self {
            title: "What people would use instead",
            about: "The same frame and the same answers over other transports, without a \
                    protocol, in the same run; µs from the beginning of a tick to that of the \
                    next. See [tests/peers](../tests/peers/README.md) for who they are and how \
                    they are set up."
                .to_owned(),
            tables: vec![Table {
                columns: vec![
                    "who, how it waits, clients",
                    "p50 µs",
                    "p90 µs",
                    "p99 µs",
                    "ticks/s",
                    "× ours, same wait",
                    "× ours",
                ],
                rows: found.rows.iter().map(row).collect(),
            }],
            findings: vec![finding(&found.goals)],
        }
    }
}

/// The goal is one for ZeroMQ and Zenoh as people use them.
fn finding(goals: &[PeerGoal]) -> Finding {
    let words = goals.iter().map(|goal| {
        let (used, poll) = (ratio(goal.as_used), ratio(goal.both_poll));
        format!("{} {used} × as people use it ({poll} × if both poll)", name(&goal.contender))
    });
    let met = |goal: &PeerGoal| goal.as_used.is_some_and(|times| times >= 20.0);
    Finding {
        key: "peers",
        goal: "≥ 20 × faster than ZeroMQ and Zenoh with three clients",
        found: words.collect::<Vec<_>>().join("; "),
        met: goals.len() == 2 && goals.iter().all(met),
    }
}

fn name(contender: &str) -> &str {
    match contender {
        "zmq" => "ZeroMQ",
        "zenoh" => "Zenoh",
        "uds" => "Unix sockets",
        other => other,
    }
}

fn ratio(times: Option<f64>) -> String {
    times.map_or("–".to_owned(), |times| format!("{times:.1}"))
}

/// Its rows are what the other program measured: none is known here.
#[must_use]
pub fn rows() -> Vec<String> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_goal_is_met_by_both_or_not_at_all() {
        let goal = |contender: &str, as_used| PeerGoal {
            contender: contender.to_owned(),
            as_used,
            both_poll: Some(3.0),
        };
        let both = finding(&[goal("zmq", Some(20.0)), goal("zenoh", Some(31.25))]);
        assert!(both.met);
        assert_eq!(
            both.found,
            "ZeroMQ 20.0 × as people use it (3.0 × if both poll); Zenoh 31.2 × as people use it \
             (3.0 × if both poll)"
        );
        assert!(!finding(&[goal("zmq", Some(20.0)), goal("zenoh", None)]).met);
        assert!(!finding(&[goal("zmq", Some(20.0))]).met);
    }
}
