//! `bench start` on the page.

use super::Results;
use crate::quantiles::Quantiles;
use crate::section::{Finding, Section, Table};

/// What is measured from the start of a launch.
const UNTIL: [&str; 2] = ["to the first frame", "to the end"];

impl From<&Results> for Section {
    fn from(found: &Results) -> Self {
        let quantiles = [found.to_first_frame, found.to_end];
        Self {
            title: "The start",
            about: format!(
                "A launch of four processes (server, estimator, scorer, logger) from before the \
                 first of them is made, ms: to the first frame, and to the end of a run of two \
                 ticks with scores and a picture. {} launches after one that does not count. No \
                 server had more than {:.1} MB resident.",
                found.to_first_frame.count,
                megabytes(found)
            ),
            tables: vec![Table {
                columns: vec!["ms", "p50", "p90", "max"],
                rows: UNTIL.iter().zip(quantiles).map(|(until, q)| row(until, q)).collect(),
            }],
            findings: findings(found),
        }
    }
}

/// First cells of the rows that a run of the bench has.
#[must_use]
pub fn rows() -> Vec<String> {
    UNTIL.iter().map(|until| (*until).to_owned()).collect()
}

fn row(until: &str, q: Quantiles) -> Vec<String> {
    let ms = |ns: u64| format!("{:.1}", ns as f64 * 1e-6);
    vec![until.to_owned(), ms(q.p50_ns), ms(q.p90_ns), ms(q.max_ns)]
}

fn megabytes(found: &Results) -> f64 {
    found.server_peak_resident_bytes as f64 * 1e-6
}

/// What the goals of the start come to.
fn findings(found: &Results) -> Vec<Finding> {
    // Of no launches the quantiles are zeros, which are no measurement.
    let any = found.to_first_frame.count > 0;
    let first_ms = if any { found.to_first_frame.p50_ns as f64 * 1e-6 } else { f64::NAN };
    let peak = if any { megabytes(found) } else { f64::NAN };
    vec![
        Finding {
            key: "start-first-tick",
            goal: "a launch of four processes has its first frame ≤ 150 ms after its start, median",
            found: format!("{first_ms:.1} ms"),
            met: first_ms <= 150.0,
        },
        Finding {
            key: "start-memory",
            goal: "the server takes ≤ 20 MB at most with the Apartment",
            found: format!("{peak:.1} MB"),
            met: peak <= 20.0,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn met(launches_ns: &mut [u64], server_peak_resident_bytes: u64) -> Vec<bool> {
        let to_first_frame = Quantiles::of(launches_ns);
        let found = Results { to_first_frame, to_end: to_first_frame, server_peak_resident_bytes };
        findings(&found).iter().map(|finding| finding.met).collect()
    }

    #[test]
    fn the_median_and_the_most_memory_are_judged() {
        // One launch that took long is not the median.
        assert_eq!(met(&mut [150_000_000, 90_000_000, 900_000_000], 20_000_000), [true, true]);
        assert_eq!(met(&mut [150_000_001], 20_000_001), [false, false]);
    }

    #[test]
    fn what_was_not_measured_is_not_met() {
        assert_eq!(met(&mut [], 0), [false, false]);
    }

    #[test]
    fn a_row_for_each_end() {
        let found = Results {
            to_first_frame: Quantiles::of(&mut [31_250_000]),
            to_end: Quantiles::of(&mut [80_000_000]),
            server_peak_resident_bytes: 12_340_000,
        };
        let section = Section::from(&found);
        let firsts: Vec<&String> = section.tables[0].rows.iter().map(|row| &row[0]).collect();
        assert_eq!(firsts, rows().iter().collect::<Vec<_>>());
        assert_eq!(section.tables[0].rows[1][1], "80.0");
        assert!(section.about.contains("12.3 MB"), "{}", section.about);
    }
}
