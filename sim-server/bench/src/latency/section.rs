//! `bench latency` on the page.

use rusty_link::WaitPolicy;

use super::{Case, Plan, Results, Row, scans};
use crate::section::{Finding, Section, Table};

/// Who takes part where server, estimator, scorer and logger are measured.
const MIX: &str = "estimator, scorer, logger";

impl From<&Results> for Section {
    fn from(found: &Results) -> Self {
        Self {
            title: "The tick",
            about: format!(
                "A full tick of the protocol with real client processes (step, scan or not, \
                 digest, seal, publish, answers, next), µs; beside it the same frame and answers \
                 over the transport without a protocol (*raw*) and two processes on one cache \
                 line (*floor*), waiting in the same way ({}). {} times {} ticks each, in turns; \
                 ratios are formed within a repetition. Processor time, switches and system calls \
                 are those of a tick; `sched_yield` is not among the calls.",
                found.wait, found.repeat, found.ticks
            ),
            tables: vec![
                Table {
                    columns: vec![
                        "µs",
                        "p50",
                        "p90",
                        "p99",
                        "p99.9",
                        "max",
                        "ticks/s",
                        "raw p50",
                        "floor p50",
                        "tick / raw",
                        "raw / floor",
                    ],
                    rows: found.rows.iter().map(times).collect(),
                },
                Table {
                    columns: vec![
                        "a tick uses",
                        "server µs",
                        "clients µs",
                        "server sleeps",
                        "clients sleep",
                        "system calls",
                    ],
                    rows: found.rows.iter().map(uses).collect(),
                },
            ],
            findings: findings(&found.rows),
        }
    }
}

/// First cells of the rows that a run for the page has.
#[must_use]
pub fn rows() -> Vec<String> {
    let plan = Plan {
        clients: vec![1, 2, 3, 8],
        beams: vec![180, 1080],
        scan_every: vec![0, 1],
        mix: true,
        beside: Vec::new(),
        ticks: 20_000,
        repeat: 5,
        wait: WaitPolicy::default(),
        pin: Vec::new(),
        quiet: true,
    };
    // The scenario is a built-in one.
    plan.cases().unwrap_or_default().iter().map(Case::title).collect()
}

fn label(row: &Row) -> String {
    format!("{}, {}", row.who, scans(row.scan_every, row.beams))
}

fn times(row: &Row) -> Vec<String> {
    let us = |ns: u64| format!("{:.2}", ns as f64 * 1e-3);
    let q = row.tick.all;
    vec![
        label(row),
        us(q.p50_ns),
        us(q.p90_ns),
        us(q.p99_ns),
        us(q.p99_9_ns),
        us(q.max_ns),
        format!("{:.0}", row.tick.per_s.median),
        us(row.raw.all.p50_ns),
        us(row.floor.all.p50_ns),
        format!("{:.2}", row.tick_over_raw.median),
        format!("{:.2}", row.raw_over_floor.median),
    ]
}

fn uses(row: &Row) -> Vec<String> {
    let (server, clients) = (row.tick.server, row.tick.clients);
    vec![
        label(row),
        format!("{:.2}", server.cpu_ns * 1e-3),
        format!("{:.2}", clients.cpu_ns * 1e-3),
        format!("{:.4}", server.voluntary_switches),
        format!("{:.4}", clients.voluntary_switches),
        row.system_calls.line(),
    ]
}

/// What the goals of the tick come to.
fn findings(rows: &[Row]) -> Vec<Finding> {
    let one = || rows.iter().filter(|row| row.clients == 1);
    let ratio = |scans: bool| {
        let rows = one().filter(|row| (row.scan_every > 0) == scans);
        rows.map(|row| row.tick_over_raw.median).fold(f64::NAN, f64::max)
    };
    let (without, with) = (ratio(false), ratio(true));
    let mix = rows.iter().find(|row| row.who == MIX && row.scan_every == 0);
    let per_s = mix.map_or(f64::NAN, |row| row.tick.per_s.median);
    let calls: Option<Vec<f64>> = one().map(|row| row.system_calls.total_per_tick).collect();
    let calls = calls.unwrap_or_default().into_iter().fold(f64::NAN, f64::max);
    vec![
        Finding {
            key: "latency-raw",
            goal: "a tick with one client ≤ 1.5 × the raw round trip, medians",
            found: format!("{without:.2} × without a scan, up to {with:.2} × with one"),
            met: without <= 1.5,
        },
        Finding {
            key: "latency-rate",
            goal: "server, estimator, scorer and logger ≥ 100,000 ticks/s without scans",
            found: format!("{per_s:.0} ticks/s"),
            met: per_s >= 1e5,
        },
        Finding {
            key: "latency-calls",
            goal: "no system call per tick while all are awake (one client, < 0.01)",
            found: if calls.is_nan() {
                "not counted".to_owned()
            } else {
                format!("up to {calls:.3}")
            },
            met: calls < 0.01,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_for_each_combination_and_what_was_not_measured_is_not_met() {
        let rows = rows();
        assert_eq!(rows.len(), 5 * 3);
        assert_eq!(rows[0], "1 estimator, no scans");
        assert_eq!(rows[14], "estimator, scorer, logger, 1080 beams in every tick");
        assert!(findings(&[]).iter().all(|finding| !finding.met));
    }
}
