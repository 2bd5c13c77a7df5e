//! `bench idle` on the page.

use super::{RUNS, Results, Row, processes};
use crate::section::{Finding, Section, Table};

impl From<&Results> for Section {
    fn from(found: &Results) -> Self {
        Self {
            title: "Waiting",
            about: format!(
                "Processor time of each process over the time that passed, in a run that is \
                 paused and in one at the pace of real time, each watched for {} s; everyone \
                 waits {}.",
                found.seconds, found.wait
            ),
            tables: vec![Table {
                columns: vec!["run, process", "% of a core"],
                rows: found.rows.iter().flat_map(of_run).collect(),
            }],
            findings: findings(&found.rows),
        }
    }
}

/// First cells of the rows that a run of the bench has.
#[must_use]
pub fn rows() -> Vec<String> {
    let processes = processes();
    let of = |run: &'static str| processes.iter().map(move |process| label(run, process));
    RUNS.iter().flat_map(|(run, _, _)| of(run)).collect()
}

fn label(run: &str, process: &str) -> String {
    format!("{run}, {process}")
}

fn of_run(row: &Row) -> impl Iterator<Item = Vec<String>> + '_ {
    let cells = |cores: f64| format!("{:.2}", 100.0 * cores);
    row.cores.iter().map(move |(process, cores)| vec![label(&row.run, process), cells(*cores)])
}

/// What the goal of waiting comes to.
fn findings(rows: &[Row]) -> Vec<Finding> {
    let cores = rows.iter().flat_map(|row| &row.cores).map(|(_, cores)| *cores);
    let worst = 100.0 * cores.fold(f64::NAN, f64::max);
    vec![Finding {
        key: "idle-cost",
        goal: "paused or at the pace of real time, each process uses < 2 % of a core",
        found: format!("up to {worst:.2} %"),
        met: worst < 2.0,
    }]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run of each kind in which all use so much of a core, but the last more.
    fn found(all: f64, last: f64) -> Results {
        let one = |run: &str| {
            let mut cores: Vec<_> = processes().into_iter().map(|name| (name, all)).collect();
            if let Some(process) = cores.last_mut() {
                process.1 = last;
            }
            Row { run: run.to_owned(), cores }
        };
        let rows = RUNS.iter().map(|(run, _, _)| one(run)).collect();
        Results { wait: "balanced".to_owned(), seconds: 5.0, rows }
    }

    #[test]
    fn the_process_that_uses_most_is_judged() {
        assert!(findings(&found(0.001, 0.0199).rows)[0].met);
        let missed = &findings(&found(0.001, 0.02).rows)[0];
        assert_eq!((missed.found.as_str(), missed.met), ("up to 2.00 %", false));
    }

    #[test]
    fn what_was_not_measured_is_not_met() {
        assert!(!findings(&[])[0].met);
    }

    #[test]
    fn a_row_for_each_process_of_each_run() {
        let rows = rows();
        assert_eq!(rows.len(), 2 * 4);
        assert_eq!(rows[0], "paused, server");
        assert_eq!(rows[7], "real time, 50 ticks a second, logger");
        let section = Section::from(&found(0.001, 0.005));
        let cells = &section.tables[0].rows;
        assert_eq!(cells.iter().map(|row| row[0].clone()).collect::<Vec<_>>(), rows);
        assert_eq!(cells[7][1], "0.50");
    }
}
