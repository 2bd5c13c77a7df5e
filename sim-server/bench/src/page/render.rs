//! The page.

use std::fs;
use std::path::Path;

use super::documents::Documents;
use super::error::PageError;
use super::goals::{GOALS, Goal};
use super::{BENCHES, PEERS};
use crate::noise::Verdict;
use crate::report::Report;
use crate::results::{fact_text, markdown_table};

/// Reads a template; without a file, one without prose.
///
/// # Errors
/// [`PageError::Io`] names the file.
pub fn read_template(path: &Path) -> Result<String, PageError> {
    match fs::read_to_string(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            let names = BENCHES.iter().map(|bench| bench.name).chain([PEERS]);
            let sections = names.map(|name| format!("\n## {name}\n\n{{{name}}}\n"));
            Ok(format!("# Benchmarks\n\n{{goals}}\n{}", sections.collect::<String>()))
        }
        read => read.map_err(PageError::io(path)),
    }
}

/// Returns the page of these reports. The same reports and template give the same
/// bytes.
///
/// # Errors
/// [`PageError`] if a benchmark has no report or a changed one, or if the template
/// has a placeholder for which there is no value.
pub fn render(documents: &Documents, template: &str) -> Result<String, PageError> {
    documents.check()?;
    let (mut page, mut rest) = (String::new(), template);
    while let Some((before, (name, after))) =
        rest.split_once('{').and_then(|(before, rest)| Some((before, rest.split_once('}')?)))
    {
        page.push_str(before);
        page.push_str(&value(documents, name)?);
        rest = after;
    }
    Ok(page + rest)
}

/// Returns the goals that were missed on a quiet machine and that the template does
/// not explain: a paragraph that begins with `**KEY.**`.
///
/// # Errors
/// As [`render`].
pub fn unexplained(documents: &Documents, template: &str) -> Result<Vec<&'static str>, PageError> {
    documents.check()?;
    let is_silent = |goal: &Goal| !template.contains(&format!("\n**{}.** ", goal.key));
    let silent = judged(documents).filter(|(goal, report, (_, is_met))| {
        !is_met && report.noise.verdict == Verdict::Quiet && is_silent(goal)
    });
    Ok(silent.map(|(goal, ..)| goal.key).collect())
}

/// Returns rows that a benchmark has as of this version and that its report lacks, or
/// the other way round, as `bench: row`.
///
/// # Errors
/// As [`render`].
pub fn stale_rows(documents: &Documents) -> Result<Vec<String>, PageError> {
    documents.check()?;
    let mut stale = Vec::new();
    for bench in &BENCHES {
        let results = documents.get(bench.name).map(|report| &report.results);
        let first = results.and_then(|results| Some((results, results.tables.first()?)));
        let rows = first.into_iter().flat_map(|(results, columns)| results.rows_of(columns));
        let there: Vec<String> = rows.map(|row| row.name.clone()).collect();
        let wanted = (bench.rows)();
        let lacking = wanted.iter().filter(|row| !there.contains(row));
        let left_over = there.iter().filter(|row| !wanted.contains(row));
        stale.extend(lacking.chain(left_over).map(|row| format!("{}: {row}", bench.name)));
    }
    Ok(stale)
}

/// The value of a placeholder.
fn value(documents: &Documents, name: &str) -> Result<String, PageError> {
    let (bench, fact) = name.split_once('.').unwrap_or((name, ""));
    match documents.get(bench) {
        _ if name == "goals" => Ok(goals(documents)),
        Some(report) if fact.is_empty() => Ok(section(report)),
        Some(report) if report.results.facts.contains_key(fact) => {
            Ok(fact_text(&report.results.facts[fact]))
        }
        // Another program's, which may not have run.
        None if bench == PEERS => Ok("not measured".to_owned()),
        _ => Err(PageError::StrayPlaceholder { name: name.to_owned() }),
    }
}

/// Every goal whose benchmark has a report, with what was found and whether it is met.
fn judged(documents: &Documents) -> impl Iterator<Item = (&'static Goal, &Report, (String, bool))> {
    GOALS.iter().filter_map(|goal| {
        let report = documents.get(goal.bench)?;
        Some((goal, report, goal.judge(&report.results)))
    })
}

fn goals(documents: &Documents) -> String {
    let head = ["key", "goal", "found", ""].map(str::to_owned).to_vec();
    let rows = judged(documents).map(|(goal, report, (found, is_met))| {
        let verdict = match (is_met, report.noise.verdict == Verdict::Quiet) {
            (true, true) => "met",
            (false, true) => "**missed**",
            // A disturbed machine proves nothing.
            (true, false) => "met?",
            (false, false) => "missed?",
        };
        vec![goal.key.to_owned(), goal.text(), found, verdict.to_owned()]
    });
    markdown_table(&std::iter::once(head).chain(rows).collect::<Vec<_>>()).trim_end().to_owned()
}

/// The tables of a report, and how they were measured.
fn section(report: &Report) -> String {
    let of_output = ["--json", "--accept-noise", "--quiet", "-q"];
    let words = report.command.split_whitespace().filter(|word| !of_output.contains(word));
    format!(
        "{}\n`{}`, results `{}`. {}; {}.",
        report.results.markdown(),
        words.collect::<Vec<_>>().join(" "),
        report.results_hash,
        report.machine.line(),
        report.noise.line()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::results::{Results, Row};
    use std::collections::BTreeMap;

    /// A report of each benchmark with the rows that it has.
    fn documents(verdict: Verdict) -> BTreeMap<String, Report> {
        let report = |bench: &super::super::Bench| {
            let rows = (bench.rows)().into_iter().map(|name| Row::new(name).with("ns", 7.25));
            let results = Results::new(&[&[("ns", 1)]], rows).fact("rounds", 5);
            let noise = Noise { verdict, reasons: Vec::new(), disturbances: None };
            let mut report = Report::new(bench.name, noise, results);
            report.command = format!("sim-server bench {} --json --accept-noise", bench.name);
            (bench.name.to_owned(), report)
        };
        BENCHES.iter().map(report).collect()
    }

    fn quiet() -> Documents {
        Documents::from(documents(Verdict::Quiet))
    }

    #[test]
    fn placeholders_are_replaced_by_what_was_measured() {
        let page = render(&quiet(), "# B\n{goals}\n\n{step.rounds} rounds.\n\n{step}\n\n{peers}\n");
        let page = page.unwrap();
        for text in [
            "# B\n| key | goal | found |  |\n",
            "| scan-apartment | apartment, 180: kernel_ns_per_beam ≤ 15 | not measured | **missed** |",
            "\n\n5 rounds.\n\n|  | ns |\n|---|---:|\n| copy of a frame | 7.2 |\n",
            "\n\n`sim-server bench step`, results `",
            "\n\nnot measured\n",
        ] {
            assert!(page.contains(text), "{text:?} is not on the page:\n{page}");
        }
        let plain = read_template("no/such/file".as_ref()).unwrap();
        assert!(render(&quiet(), &plain).unwrap().contains("\n## scan\n\n|  | ns |"));
    }

    #[test]
    fn a_missed_goal_needs_an_explanation_on_a_quiet_machine() {
        let notes = "\n**scan-growth.** Because.\n";
        assert!(!unexplained(&quiet(), notes).unwrap().contains(&"scan-growth"));
        assert!(unexplained(&quiet(), "").unwrap().contains(&"scan-growth"));
        let noisy = Documents::from(documents(Verdict::Noisy));
        assert_eq!(unexplained(&noisy, "").unwrap(), [""; 0]);
    }

    #[test]
    fn rows_that_are_missing_or_left_over_are_stale() {
        assert_eq!(stale_rows(&quiet()).unwrap(), [""; 0]);
        let mut reports = documents(Verdict::Quiet);
        let mut report = reports.remove("log").unwrap();
        report.results.rows[0].name = "7 beams".to_owned();
        let report = Report::new("log", report.noise, report.results);
        reports.insert("log".to_owned(), report);
        let stale = stale_rows(&Documents::from(reports)).unwrap();
        assert_eq!(stale, ["log: no scan", "log: 7 beams"]);
    }

    #[test]
    fn a_page_is_not_made_of_what_is_missing_or_changed() {
        let fails = |spoil: fn(&mut BTreeMap<String, Report>)| {
            let mut spoilt = documents(Verdict::Quiet);
            spoil(&mut spoilt);
            render(&Documents::from(spoilt), "").unwrap_err()
        };
        let missing = fails(|d| drop(d.remove("step"))).to_string();
        assert!(missing.contains("bench step is missing"), "{missing}");
        let changed = fails(|d| d.get_mut("step").unwrap().results.rows.truncate(1)).to_string();
        assert!(changed.contains("bench step was changed"), "{changed}");
        for stray in ["{speed}", "{scan.speed}"] {
            let error = render(&quiet(), stray).unwrap_err();
            assert!(matches!(error, PageError::StrayPlaceholder { .. }), "{error}");
        }
    }
}
