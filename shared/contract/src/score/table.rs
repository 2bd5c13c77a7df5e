//! Scores as tables for people.

use std::fmt::{Display, Formatter, Result};

use super::numbers::{degrees, duration, metres, percent, share};
use super::{Alignment, ComputeTimes, Consistency, Convergence, Score};
use crate::TextTable;
use crate::scenario::Access;

/// Scores as tables for people, a line per estimator: how far off; and below it,
/// where anything of it is known, whether it knew, when it found the robot, and
/// how long it took.
pub struct ScoreTable<'a>(pub &'a [Score]);

impl Display for ScoreTable<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let mut table = TextTable::new(
            "estimator  alignment  >final  >heading  >mean  >p95  >ATE rmse  >driven  >drift",
        );
        for (score, alignment) in self.0.iter().flat_map(lines) {
            let figures = score.figures(alignment);
            let length = |value: Option<f64>| cell(value, metres, "m");
            table.row(&[
                &score.name,
                &alignment.word(),
                &length(figures.final_position_error_m),
                &cell(figures.final_heading_error_rad.map(f64::to_degrees), degrees, "°"),
                &length(figures.mean_position_error_m),
                &length(figures.p95_position_error_m),
                &length(figures.ate_rmse_m),
                &length(Some(score.distance_m)),
                &score.drift_percent.map_or("–".to_owned(), |d| format!("{} %", degrees(d))),
            ]);
        }
        writeln!(f, "{table}")?;
        let columns = columns(self.0);
        if columns.is_empty() {
            return wrong(self.0, f);
        }
        let heads: String = columns.iter().map(|(head, _)| format!("  >{head}")).collect();
        let mut table = TextTable::new(&format!("estimator{heads}"));
        for s in self.0 {
            let cells = columns.iter().map(|(_, cell)| cell(s));
            table.push(std::iter::once(s.name.clone()).chain(cells).collect());
        }
        writeln!(f, "\n{table}")?;
        wrong(self.0, f)
    }
}

/// A line for each estimator with wrong answers.
fn wrong(scores: &[Score], f: &mut Formatter<'_>) -> Result {
    for score in scores.iter().filter(|score| score.wrong_ticks > 0) {
        let part = share(score.wrong_ticks as f64 / score.scored_ticks as f64);
        writeln!(
            f,
            "{}: {part} of the answers are wrong (over 0.5 m off, not within 4 σ)",
            score.name
        )?;
    }
    Ok(())
}

/// The lines of a score: by the alignment that it is judged by; and as it is, too, if
/// it was given the map, in whose frame it should have found itself.
fn lines(score: &Score) -> impl Iterator<Item = (&Score, Alignment)> {
    let found_itself = score.alignment != Alignment::None && score.told.map == Access::Given;
    let raw = found_itself.then_some(Alignment::None);
    std::iter::once(score.alignment).chain(raw).map(move |alignment| (score, alignment))
}

fn cell(value: Option<f64>, number: fn(f64) -> String, unit: &str) -> String {
    value.map_or("unscored".to_owned(), |value| format!("{} {unit}", number(value)))
}

/// A head, and what is below it.
type Column = (String, fn(&Score) -> String);

/// The columns of the second table: those in which a participant has something, and
/// what is asked first of an estimator.
fn columns(scores: &[Score]) -> Vec<Column> {
    let any = |known: fn(&Score) -> bool| scores.iter().any(known);
    let times = any(|s| s.compute.is_some());
    let found = any(|s| s.convergence.is_some());
    if !(times || found || any(|s| s.nees.is_some() || s.nis.is_some())) {
        return Vec::new();
    }
    let level = |of: fn(&Score) -> Option<&Consistency>| {
        let level = scores.iter().find_map(of).map(|c| 100.0 * c.level);
        level.map_or(String::new(), |level| format!(" of 1, {} %", percent(level)))
    };
    let nees = format!("NEES{}", level(|s| s.nees.as_ref()));
    let nis = format!("NIS{}", level(|s| s.nis.as_ref()));
    let mut columns: Vec<Column> =
        vec![(nees, |s| consistency(s.nees.as_ref())), (nis, |s| consistency(s.nis.as_ref()))];
    if found {
        columns.push(("converged".to_owned(), |s| {
            s.convergence.as_ref().map_or("unscored".to_owned(), |c| after(c.after_s))
        }));
    }
    if any(|s| s.convergence.as_ref().is_some_and(|c| !c.recoveries.is_empty())) {
        columns.push(("recovered".to_owned(), |s| recovered(s.convergence.as_ref())));
    }
    if times {
        columns.push(("compute p50".to_owned(), |s| compute(s, |c| c.reported.p50_s)));
        columns.push(("p99".to_owned(), |s| compute(s, |c| c.reported.p99_s)));
    }
    columns
}

/// "consistent 1.02": the verdict, and the mean compared with what is expected of it.
fn consistency(found: Option<&Consistency>) -> String {
    let Some(c) = found else { return "unscored".to_owned() };
    let ratio = c.sum / c.degrees;
    let digits = if ratio < 10.0 { 2 } else { 0 };
    if ratio < 9999.5 {
        format!("{} {ratio:.digits$}", c.verdict)
    } else {
        format!("{} >9999", c.verdict)
    }
}

fn after(after_s: Option<f64>) -> String {
    after_s.map_or("never".to_owned(), |s| format!("{s:.2} s"))
}

/// The longest way back; how many of them there were, where some never ended.
fn recovered(found: Option<&Convergence>) -> String {
    let all = found.map_or(&[][..], |c| &c.recoveries);
    let done = all.iter().filter(|r| r.after_s.is_some()).count();
    match (all.len(), done) {
        (0, _) => "unscored".to_owned(),
        (1, 0) => "never".to_owned(),
        (all, done) if done < all => format!("{done} of {all}"),
        _ => after(all.iter().filter_map(|r| r.after_s).reduce(f64::max)),
    }
}

fn compute(score: &Score, of: fn(&ComputeTimes) -> f64) -> String {
    score.compute.as_ref().map_or("unknown".to_owned(), |c| duration(of(c)))
}

#[cfg(test)]
mod tests {
    use super::super::{Durations, Figures, Recovery, Verdict, Within};
    use super::*;

    fn score(name: &str) -> Score {
        Score {
            name: name.to_owned(),
            distance_m: 14.31,
            final_position_error_m: Some(0.179),
            ..Score::default()
        }
    }

    fn checked(ratio: f64, verdict: Verdict) -> Option<Consistency> {
        Some(Consistency {
            samples: 10,
            unusable: 0,
            degrees: 30.0,
            sum: 30.0 * ratio,
            mean: 3.0 * ratio,
            last: 3.0,
            last_degrees: 3.0,
            share_within: 0.9,
            effective_samples: 5.0,
            interval: [2.0, 4.0],
            level: 0.95,
            verdict,
        })
    }

    fn found(after_s: Option<f64>, recoveries: &[Option<f64>]) -> Option<Convergence> {
        let recovery = |after_s: &Option<f64>| Recovery { kidnapped_at_tick: 9, after_s: *after_s };
        Some(Convergence {
            within: Within::default(),
            after_s,
            position_rmse_m: None,
            heading_rmse_rad: None,
            recoveries: recoveries.iter().map(recovery).collect(),
        })
    }

    #[test]
    fn what_nobody_has_takes_no_column() {
        let plain = ScoreTable(&[score("a")]).to_string();
        assert_eq!(plain.lines().count(), 2, "{plain}");
        let scores = [Score { convergence: found(Some(0.02), &[]), ..score("a") }];
        let both = ScoreTable(&scores).to_string();
        let lines: Vec<&str> = both.lines().collect();
        assert_eq!(lines[..2], plain.lines().collect::<Vec<_>>());
        assert_eq!(lines[2], "");
        let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(lines[3]), ["estimator", "NEES", "NIS", "converged"]);
        assert_eq!(words(lines[4]), ["a", "unscored", "unscored", "0.02", "s"]);
    }

    #[test]
    fn wrong_answers_have_a_line_where_there_are_any() {
        let lines = |wrong_ticks, nis| {
            let scores = [Score { scored_ticks: 300, wrong_ticks, nis, ..score("a") }, score("b")];
            let text = ScoreTable(&scores).to_string();
            text.lines().map(str::to_owned).collect::<Vec<_>>()
        };
        for nis in [None, checked(1.0, Verdict::Consistent)] {
            let (without, with) = (lines(0, nis), lines(5, nis));
            assert_eq!(with[..without.len()], without);
            let [line] = &with[without.len()..] else { panic!("{with:?}") };
            assert!(line.starts_with("a: 1.7 % "), "{line}");
        }
    }

    #[test]
    fn a_line_has_its_alignment_and_small_errors_their_digits() {
        let words = |score: Score| -> Vec<Vec<String>> {
            let text = ScoreTable(&[score]).to_string();
            let lines = text.lines().skip(1);
            lines.map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
        };
        let near = Score { final_position_error_m: Some(4.5e-4), ..score("mcl") };
        assert_eq!(words(near.clone())[0][..4], ["mcl", "none", "4.5e-4", "m"]);
        let aligned = Figures { final_position_error_m: Some(0.25), ..Figures::default() };
        let mut lost = Score { aligned, alignment: Alignment::Se2, ..near };
        // Given the map, it should have found itself in it: as it is, too.
        let lines = words(lost.clone());
        assert_eq!(lines[0][..4], ["mcl", "SE(2)", "0.250", "m"]);
        assert_eq!(lines[1][..4], ["mcl", "none", "4.5e-4", "m"]);
        lost.told.map = Access::Hidden;
        assert_eq!(words(lost), lines[..1]);
    }

    #[test]
    fn all_of_it_fits_into_a_hundred_columns() {
        let took = Durations { p50_s: 12.3e-6, p99_s: 0.000_999_7, max_s: 2.0 };
        let all = |nees: (f64, Verdict), recoveries: &[Option<f64>]| Score {
            nees: checked(nees.0, nees.1),
            nis: checked(12_345.0, Verdict::Overconfident),
            convergence: found(None, recoveries),
            compute: Some(ComputeTimes { reported: took, observed: took }),
            scored_ticks: 300,
            wrong_ticks: 300,
            ..score("dead-reckoning")
        };
        let scores = [
            all((1.02, Verdict::Consistent), &[Some(1.0), Some(12.5)]),
            all((123.4, Verdict::Overconfident), &[Some(1.0), None]),
            all((0.25, Verdict::Conservative), &[None]),
            score("b"),
        ];
        let text = ScoreTable(&scores).to_string();
        assert!(text.lines().all(|l| l.chars().count() <= 100), "{text}");
        for words in [
            "NEES of 1, 95 %",
            "consistent 1.02  overconfident >9999      never    12.50 s        12 µs   1.0 ms",
            "overconfident 123",
            "1 of 2",
            "conservative 0.25",
            "unknown",
        ] {
            assert!(text.contains(words), "{words:?} is not in\n{text}");
        }
    }
}
