//! `bench sweep` on the page.

use super::CASES;
use super::results::{SweepCase, SweepResults};
use crate::section::{Finding, Section, Table};

impl From<&SweepResults> for Section {
    fn from(found: &SweepResults) -> Self {
        let hashes: Vec<String> =
            found.cases.iter().map(|case| format!("`{}`", case.digests_hash)).collect();
        Self {
            title: "A sweep",
            about: format!(
                "Sweeps without clients in the Apartment, from plan to rows, with one worker and \
                 with {}; *bare* is the same world stepped as often with nothing reckoned, \
                 digested or kept. Medians, in turns; ratios are formed within a round. Hashes \
                 of the run digests, the same on every machine: {}.",
                found.jobs,
                hashes.join(", ")
            ),
            tables: vec![Table {
                columns: vec![
                    "sweep",
                    "one worker, ms",
                    "all, ms",
                    "one / all",
                    "one / bare",
                    "ticks/s of one worker",
                ],
                rows: found.cases.iter().map(row).collect(),
            }],
            findings: findings(found),
        }
    }
}

/// First cells of the rows that a run of the bench has.
#[must_use]
pub fn rows() -> Vec<String> {
    CASES.iter().map(|(name, ..)| (*name).to_owned()).collect()
}

fn row(case: &SweepCase) -> Vec<String> {
    vec![
        case.name.clone(),
        format!("{:.1}", case.one_ns.median * 1e-6),
        format!("{:.1}", case.all_ns.median * 1e-6),
        format!("{:.2}", case.one_over_all.median),
        format!("{:.2}", case.one_over_bare.median),
        format!("{:.0}", case.ticks_per_s()),
    ]
}

/// What the goals of the sweep come to.
fn findings(found: &SweepResults) -> Vec<Finding> {
    let of = |place: usize, number: fn(&SweepCase) -> f64| {
        found.cases.get(place).map_or(f64::NAN, number)
    };
    let all_ms = of(0, |case| case.all_ns.median * 1e-6);
    let speedup = of(0, |case| case.one_over_all.median);
    let with_scans = of(1, SweepCase::ticks_per_s);
    vec![
        Finding {
            key: "sweep-chapter",
            goal: "500 seeds × 300 ticks without scans ≤ 50 ms on 2 cores",
            found: format!("{all_ms:.1} ms"),
            met: all_ms <= 50.0,
        },
        Finding {
            key: "sweep-cores",
            goal: "≥ 1.9 × faster on 2 cores than on 1",
            found: format!("{speedup:.2} ×"),
            met: speedup >= 1.9,
        },
        Finding {
            key: "sweep-scans",
            goal: "with 180 beams every 5 ticks ≥ 700,000 ticks/s a core",
            found: format!("{with_scans:.0} ticks/s"),
            met: with_scans >= 7e5,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_run_has_the_rows_it_says_and_the_digests_do_not_depend_on_the_workers() {
        let case = |jobs| super::super::case("x", 6, 5, jobs, Duration::ZERO).unwrap();
        let (one, three) = (case(1), case(3));
        assert_eq!(one.digests_hash, three.digests_hash);
        assert_eq!(one.ticks, 1800);
        let found = SweepResults { jobs: 3, cases: vec![one; CASES.len()] };
        let section = Section::from(&found);
        assert_eq!(section.tables[0].rows.len(), rows().len());
        let none = SweepResults { jobs: 1, cases: Vec::new() };
        assert!(findings(&none).iter().all(|finding| !finding.met));
    }
}
