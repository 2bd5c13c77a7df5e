//! `bench log` on the page.

use super::{BEAMS, Results, Row};
use crate::quantiles::Spread;
use crate::section::{Finding, Section, Table};

/// Beams of the records whose rate is judged.
const LARGEST: usize = BEAMS[BEAMS.len() - 1];

impl From<&Results> for Section {
    fn from(found: &Results) -> Self {
        let until = if found.synced { "the disk" } else { "the operating system" };
        Self {
            title: "The log",
            about: format!(
                "{} ticks as the logger writes them, until {until} has them; beside it the same \
                 bytes as a plain file in the same folder, and encoded to nowhere, which is what \
                 the thread of the tick has to do. MB (10⁶ bytes) a second, medians; ratios are \
                 formed within a repetition.",
                found.ticks
            ),
            tables: vec![Table {
                columns: vec![
                    "in every tick",
                    "bytes a tick",
                    "log MB/s",
                    "plain MB/s",
                    "log / plain",
                    "encoding MB/s",
                    "encoding ns a tick",
                ],
                rows: found.rows.iter().map(row).collect(),
            }],
            findings: findings(&found.rows),
        }
    }
}

/// First cells of the rows that a run of the bench has.
#[must_use]
pub fn rows() -> Vec<String> {
    BEAMS.iter().map(|&beams| label(beams)).collect()
}

fn label(beams: usize) -> String {
    if beams == 0 { "no scan".to_owned() } else { format!("{beams} beams") }
}

fn row(row: &Row) -> Vec<String> {
    let rate = |rate: Spread| format!("{:.0}", rate.median);
    vec![
        label(row.beams),
        format!("{:.1}", row.bytes_per_tick),
        rate(row.log_mb_s),
        rate(row.plain_mb_s),
        format!("{:.2}", row.log_over_plain.median),
        rate(row.encode_mb_s),
        rate(row.encode_ns_per_tick),
    ]
}

/// What the goals of the log come to.
fn findings(rows: &[Row]) -> Vec<Finding> {
    let of = |beams: usize, number: fn(&Row) -> f64| {
        rows.iter().find(|row| row.beams == beams).map_or(f64::NAN, number)
    };
    let rate = of(LARGEST, |row| row.log_mb_s.median);
    let over_plain = of(LARGEST, |row| row.log_over_plain.median);
    // A million ticks: bytes of one are MB of all.
    let size = of(0, |row| row.bytes_per_tick);
    vec![
        Finding {
            key: "log-rate",
            goal: "a log with 1080 beams in every tick ≥ 500 MB/s, or ≥ 0.9 × a plain file there",
            found: format!("{rate:.0} MB/s, {over_plain:.2} × a plain file"),
            met: rate >= 500.0 || over_plain >= 0.9,
        },
        Finding {
            key: "log-size",
            goal: "a log of 1,000,000 ticks without scans < 100 MB",
            found: format!("{size:.1} MB"),
            met: size < 100.0,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(beams: usize, bytes_per_tick: f64, log_mb_s: f64, plain_mb_s: f64) -> Row {
        let of = |number| Spread::of([number]);
        Row {
            beams,
            bytes_per_tick,
            log_mb_s: of(log_mb_s),
            plain_mb_s: of(plain_mb_s),
            log_over_plain: of(log_mb_s / plain_mb_s),
            encode_mb_s: of(2000.0),
            encode_ns_per_tick: of(80.0),
            digest: "00".to_owned(),
        }
    }

    fn met(rows: &[Row]) -> Vec<bool> {
        findings(rows).iter().map(|finding| finding.met).collect()
    }

    #[test]
    fn the_rate_is_enough_if_the_folder_takes_no_more() {
        // What the small records come to is not judged.
        let small = || case(0, 99.9, 100.0, 1000.0);
        assert_eq!(met(&[small(), case(1080, 8800.0, 500.0, 2000.0)]), [true, true]);
        assert_eq!(met(&[small(), case(1080, 8800.0, 90.0, 100.0)]), [true, true]);
        assert_eq!(met(&[small(), case(1080, 8800.0, 499.0, 600.0)]), [false, true]);
    }

    #[test]
    fn the_size_is_that_of_the_records_without_scans() {
        let rate = case(1080, 8800.0, 500.0, 500.0);
        assert_eq!(met(&[case(0, 100.0, 500.0, 500.0), rate]), [true, false]);
    }

    #[test]
    fn what_was_not_measured_is_not_met() {
        assert_eq!(met(&[]), [false, false]);
        assert_eq!(met(&[case(180, 50.0, 900.0, 900.0)]), [false, false]);
    }

    #[test]
    fn a_row_for_each_number_of_beams() {
        assert_eq!(rows(), ["no scan", "180 beams", "1080 beams"]);
        let rows = vec![case(0, 72.25, 300.0, 400.0)];
        let section = Section::from(&Results { ticks: 10, synced: true, rows });
        let cells = ["no scan", "72.2", "300", "400", "0.75", "2000", "80"];
        assert_eq!(section.tables[0].rows[0], cells);
        assert!(section.about.contains("until the disk has them"), "{}", section.about);
    }
}
