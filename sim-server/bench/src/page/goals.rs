//! What the figures of the benchmarks should reach.

use super::PEERS;
use crate::results::{Results, Row};
use Limit::{AtLeast, AtMost};

/// A goal: all these rows reach a limit.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// The name by which the template explains it.
    pub key: &'static str,
    /// The benchmark.
    pub bench: &'static str,
    /// The rows: those whose name begins so.
    pub rows: &'static str,
    /// Figures and their limits; one of them is enough.
    pub limits: &'static [(&'static str, Limit)],
}

/// A limit of a figure.
#[derive(Clone, Copy, Debug)]
pub enum Limit {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
}

const ONE: &str = "1 estimator, no scans";
const MIX: &str = "estimator, scorer, logger, no scans";
const SEEDS: &str = "500 seeds × 300 ticks, no scans";
const SCANS: &str = "50 seeds × 300 ticks, 180 beams every 5 ticks";

/// The goals in the order of the page.
pub const GOALS: [Goal; 19] = [
    goal("latency-raw", "latency", ONE, &[("tick_over_raw", AtMost(1.5))]),
    goal("latency-rate", "latency", MIX, &[("per_s", AtLeast(1e5))]),
    goal("latency-calls", "latency", "1 estimator", &[("system_calls_per_tick", AtMost(0.01))]),
    goal("peers", PEERS, "zmq, block, 3 clients", &[("times_ours", AtLeast(20.0))]),
    goal("peers", PEERS, "zenoh, block, 3 clients", &[("times_ours", AtLeast(20.0))]),
    goal("scan-apartment", "scan", "apartment, 180", &[("kernel_ns_per_beam", AtMost(15.0))]),
    goal("scan-reference", "scan", "rooms", &[("rays_over_kernel", AtLeast(8.0))]),
    goal("scan-reference", "scan", "segments", &[("rays_over_kernel", AtLeast(8.0))]),
    goal("scan-growth", "scan", "", &[("growth", AtMost(2.0))]),
    goal("scan-many-beams", "scan", "apartment, 1080", &[("kernel_ns_per_beam", AtMost(6.0))]),
    goal("scan-noise", "scan", "", &[("noise_ns_per_beam", AtMost(15.0))]),
    goal("sweep-chapter", "sweep", SEEDS, &[("all_ms", AtMost(50.0))]),
    goal("sweep-cores", "sweep", SEEDS, &[("one_over_all", AtLeast(1.9))]),
    goal("sweep-scans", "sweep", SCANS, &[("ticks_per_s", AtLeast(7e5))]),
    goal(
        "log-rate",
        "log",
        "1080 beams",
        &[("log_mb_s", AtLeast(500.0)), ("log_over_plain", AtLeast(0.9))],
    ),
    goal("log-size", "log", "no scan", &[("bytes_per_tick", AtMost(100.0))]),
    goal("idle-cost", "idle", "", &[("core_percent", AtMost(2.0))]),
    goal("start-first-tick", "start", "to the first frame", &[("p50_ms", AtMost(150.0))]),
    goal("start-memory", "start", "server", &[("peak_resident_mb", AtMost(20.0))]),
];

const fn goal(
    key: &'static str,
    bench: &'static str,
    rows: &'static str,
    limits: &'static [(&'static str, Limit)],
) -> Goal {
    Goal { key, bench, rows, limits }
}

impl Goal {
    /// Returns what is aimed at, as text.
    #[must_use]
    pub fn text(&self) -> String {
        let limits = self.limits.iter().map(|(name, limit)| match limit {
            AtMost(most) => format!("{name} ≤ {most}"),
            AtLeast(least) => format!("{name} ≥ {least}"),
        });
        let rows = if self.rows.is_empty() { "all rows" } else { self.rows };
        format!("{rows}: {}", limits.collect::<Vec<_>>().join(" or "))
    }

    /// Returns the least and the greatest of each figure, and whether the goal is
    /// met; a figure that was not measured does not meet it.
    #[must_use]
    pub fn judge(&self, results: &Results) -> (String, bool) {
        let (mut found, mut is_met) = (Vec::new(), false);
        for (name, limit) in self.limits {
            let is_meant = |row: &&Row| row.name.starts_with(self.rows);
            let numbers = results.rows.iter().filter(is_meant).map(|row| row.number(name));
            // A row without this figure is NaN, which both skip.
            let (least, most) =
                numbers.fold((f64::NAN, f64::NAN), |(least, most), x| (x.min(least), x.max(most)));
            is_met |= match *limit {
                AtMost(limit) => most <= limit,
                AtLeast(limit) => least >= limit,
            };
            let digits = results.tables.iter().flatten().find(|column| column.name == *name);
            let digits = digits.map_or(0, |column| column.digits);
            found.push(match (least, most) {
                _ if least.is_nan() => "not measured".to_owned(),
                _ if least < most => format!("{least:.digits$} to {most:.digits$}"),
                _ => format!("{most:.digits$}"),
            });
        }
        (found.join("; "), is_met)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantiles::Spread;

    fn judged(limits: &'static [(&'static str, Limit)], rows: Vec<Row>) -> (String, bool) {
        let results = Results::new(&[&[("ns", 1), ("mb_s", 0)]], rows);
        goal("key", "test", "rooms", limits).judge(&results)
    }

    #[test]
    fn the_worst_of_the_rows_is_judged() {
        let rows = |ns: f64| {
            let spread = Spread { median: ns, min: 0.0, max: 99.0 };
            let others =
                [Row::new("rooms-64").with("ns", 10.0), Row::new("other").with("ns", 99.0)];
            others.into_iter().chain([Row::new("rooms-512").with("ns", spread)]).collect()
        };
        assert_eq!(judged(&[("ns", AtMost(15.0))], rows(15.0)), ("10.0 to 15.0".to_owned(), true));
        assert!(!judged(&[("ns", AtMost(15.0))], rows(15.5)).1);
        assert!(judged(&[("ns", AtLeast(8.0))], rows(8.0)).1);
        assert!(!judged(&[("ns", AtLeast(8.0))], rows(7.5)).1);
    }

    #[test]
    fn one_of_several_limits_is_enough() {
        const LIMITS: &[(&str, Limit)] = &[("mb_s", AtLeast(500.0)), ("ns", AtMost(2.0))];
        let met = |mb_s: f64, ns: f64| {
            judged(LIMITS, vec![Row::new("rooms").with("mb_s", mb_s).with("ns", ns)])
        };
        assert_eq!(met(500.0, 9.0), ("500; 9.0".to_owned(), true));
        assert!(met(90.0, 2.0).1 && !met(499.0, 9.0).1);
        assert_eq!(goal("key", "x", "", LIMITS).text(), "all rows: mb_s ≥ 500 or ns ≤ 2");
    }

    #[test]
    fn what_was_not_measured_is_not_met() {
        let nothing = ("not measured".to_owned(), false);
        assert_eq!(judged(&[("ns", AtMost(15.0))], Vec::new()), nothing);
        assert_eq!(judged(&[("ns", AtLeast(15.0))], vec![Row::new("rooms")]), nothing);
    }
}
