//! The page.

use std::fmt::Write as _;

use super::benches::{BENCHES, Bench, Source};
use super::documents::{Document, Documents};
use super::error::PageError;
use super::notes::Notes;
use super::{Section, Table};
use crate::report::results_hash;

const HEAD: &str = "\
# Benchmarks

Written by `sim-server bench page --write docs/benchmarks.md`; do not edit. Numbers
come from `docs/benchmarks/latest.json`, explanations from `docs/benchmarks/notes.md`.
Speed here is a ratio to something that was measured in the same run; times are
those of one machine. `cargo build --release`, then any command below measures
its section again.
";

/// The page of these documents and notes. The same documents and notes give the
/// same bytes.
///
/// # Errors
/// [`PageError`] if a bench has no document, one of another form, or one that
/// was changed by hand, or if a note is about nothing.
pub fn render(documents: &Documents, notes: &Notes) -> Result<String, PageError> {
    let sections = parts(documents)?;
    let findings = sections.iter().flat_map(|(_, _, section)| &section.findings);
    let goals = findings.map(|finding| finding.key);
    let known: Vec<&str> = goals.chain(BENCHES.iter().map(|bench| bench.name)).collect();
    notes.check(&known)?;

    let mut page = HEAD.to_owned();
    put_goals(&mut page, &sections, notes);
    for (bench, document, section) in &sections {
        put_section(&mut page, bench, document, section, notes.on(bench.name));
    }
    Ok(page)
}

/// Goals that were missed on a quiet machine and have no note.
///
/// # Errors
/// As [`render`].
pub fn unexplained(documents: &Documents, notes: &Notes) -> Result<Vec<&'static str>, PageError> {
    let mut keys = Vec::new();
    for (_, document, section) in parts(documents)? {
        let missed = section.findings.iter().filter(|finding| !finding.met);
        let silent = missed.filter(|finding| notes.on(finding.key).is_none());
        keys.extend(silent.filter(|_| document.noise.is_quiet()).map(|finding| finding.key));
    }
    Ok(keys)
}

/// Rows that a bench has as of this version and that the documents lack, or the
/// other way round, as `bench: row`.
///
/// # Errors
/// As [`render`].
pub fn stale_rows(documents: &Documents) -> Result<Vec<String>, PageError> {
    let mut stale = Vec::new();
    // Of a document from a file another program knows the rows.
    let ours = |bench: &Bench| matches!(bench.source, Source::Run { .. });
    for (bench, _, section) in parts(documents)?.into_iter().filter(|(bench, ..)| ours(bench)) {
        let firsts = section.tables.iter().flat_map(|table| &table.rows).filter_map(|r| r.first());
        let there: Vec<String> = firsts.cloned().collect();
        let wanted = (bench.rows)();
        let lacking = wanted.iter().filter(|row| !there.contains(row));
        let left_over = there.iter().filter(|row| !wanted.contains(row));
        stale.extend(lacking.chain(left_over).map(|row| format!("{}: {row}", bench.name)));
    }
    Ok(stale)
}

type Part<'a> = (&'static Bench, &'a Document, Section);

/// Every bench that has a document, with it and the section that it makes.
fn parts(documents: &Documents) -> Result<Vec<Part<'_>>, PageError> {
    let mut parts = Vec::new();
    for bench in &BENCHES {
        let Some(document) = documents.of(bench)? else { continue };
        if results_hash(&document.results) != document.results_hash {
            return Err(PageError::Changed { bench: bench.name });
        }
        let section = (bench.section)(&document.results)
            .map_err(|error| PageError::OldDocument { bench: bench.name, error })?;
        parts.push((bench, document, section));
    }
    Ok(parts)
}

fn put_goals(page: &mut String, sections: &[Part<'_>], notes: &Notes) {
    page.push_str("\n## Goals\n\n");
    let findings = || {
        sections.iter().flat_map(|(_, document, section)| {
            section.findings.iter().map(move |finding| (*document, finding))
        })
    };
    let row = |(document, finding): (&Document, &super::Finding)| {
        let verdict = match (finding.met, document.noise.is_quiet()) {
            (true, true) => "met",
            (false, true) => "**missed**",
            // What a disturbed machine says is written down, not believed.
            (true, false) => "met?",
            (false, false) => "missed?",
        };
        vec![finding.goal.to_owned(), finding.found.clone(), verdict.to_owned()]
    };
    let rows = findings().map(row).collect();
    put_table(page, &Table { columns: vec!["goal", "found", ""], rows });
    if findings().any(|(document, _)| !document.noise.is_quiet()) {
        page.push_str(
            "\nWhere a question mark stands, the machine was disturbed while it measured; see \
             the section.\n",
        );
    }
    for (_, finding) in findings() {
        if let Some(note) = notes.on(finding.key) {
            let _ = write!(page, "\n**{}.** {note}\n", finding.goal);
        }
    }
}

fn put_section(
    page: &mut String,
    bench: &Bench,
    document: &Document,
    section: &Section,
    note: Option<&str>,
) {
    let _ = write!(page, "\n## {}\n\n{}\n", section.title, section.about);
    for table in &section.tables {
        page.push('\n');
        put_table(page, table);
    }
    if let Some(note) = note {
        let _ = write!(page, "\n{note}\n");
    }
    let _ = write!(
        page,
        "\n`{}`, results `{}`. Measured on {}. {}\n",
        plain_command(bench, &document.command),
        document.results_hash,
        machine(document),
        noise(document)
    );
}

/// The command without what concerns its output alone.
fn plain_command(bench: &Bench, command: &str) -> String {
    let of_output = ["--json", "--accept-noise", "--quiet", "-q"];
    let words = command.split_whitespace().filter(|word| !of_output.contains(word));
    let kept: Vec<&str> = words.collect();
    if kept.is_empty() { format!("sim-server bench {}", bench.name) } else { kept.join(" ") }
}

fn machine(document: &Document) -> String {
    let m = &document.machine;
    let kind = if m.is_virtual { " of a virtual machine" } else { "" };
    let governor =
        m.governor.as_deref().map_or(String::new(), |governor| format!(", governor {governor}"));
    format!(
        "{}, {} cores{kind}, {:.0} GB, {}{governor}, sim-server {} ({})",
        m.cpu.as_deref().unwrap_or("a CPU without a name"),
        m.cores,
        m.memory_bytes as f64 / 1e9,
        m.kernel,
        m.version,
        m.profile
    )
}

fn noise(document: &Document) -> String {
    let noise = &document.noise;
    match (noise.verdict.as_str(), noise.reasons.join("; ")) {
        ("quiet", _) => "The machine was quiet.".to_owned(),
        ("noisy", why) => format!("The machine was noisy: {why}."),
        (_, why) => format!("**Not to be believed**: {why}."),
    }
}

/// A table; all columns but the first to the right.
fn put_table(page: &mut String, table: &Table) {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let heads: Vec<String> = table.columns.iter().map(|head| (*head).to_owned()).collect();
    page.push_str(&line(&heads));
    let rule = |column: usize| if column == 0 { "|---" } else { "|---:" };
    page.extend((0..heads.len()).map(rule));
    page.push_str("|\n");
    for row in &table.rows {
        page.push_str(&line(row));
    }
}

#[cfg(test)]
mod tests {
    use super::super::benches::bench;
    use super::*;
    use crate::noise::NoiseMeter;
    use crate::quantiles::Quantiles;
    use crate::report::Report;
    use crate::{scan, start, step};
    use serde_json::{Value, json};
    use std::time::Duration;

    /// The document that a bench prints for these results.
    fn printed(bench: &'static str, results: Value, verdict: &str) -> Value {
        let report = Report::new(bench, NoiseMeter::begin().finish(), results);
        let mut document = serde_json::to_value(report).unwrap();
        document["command"] = json!(format!("sim-server bench {bench} --json --accept-noise"));
        document["noise"]["verdict"] = json!(verdict);
        document
    }

    fn documents(verdict: &str) -> Value {
        let plan = scan::Plan { time: Duration::ZERO, walls: vec![64], ..scan::Plan::default() };
        let scanned = scan::run(&plan, |_, _| {}).unwrap();
        let stepped = step::run(Duration::ZERO).unwrap();
        let ticked = json!({"wait": "balanced", "pin": [], "ticks": 1, "repeat": 1, "rows": []});
        let swept = json!({"jobs": 2, "cases": []});
        let logged = json!({"ticks": 1, "synced": false, "rows": []});
        let idled = json!({"wait": "balanced", "seconds": 1.0, "rows": []});
        let started = start::Results {
            to_first_frame: Quantiles::of(&mut [31_000_000]),
            to_end: Quantiles::of(&mut [80_000_000]),
            server_peak_resident_bytes: 12_000_000,
        };
        json!({
            "latency": printed("latency", ticked, verdict),
            "scan": printed("scan", serde_json::to_value(scanned).unwrap(), verdict),
            "step": printed("step", serde_json::to_value(stepped).unwrap(), verdict),
            "sweep": printed("sweep", swept, verdict),
            "log": printed("log", logged, verdict),
            "idle": printed("idle", idled, verdict),
            "start": printed("start", serde_json::to_value(started).unwrap(), verdict),
        })
    }

    fn read(documents: &Value) -> Documents {
        serde_json::from_value(documents.clone()).unwrap()
    }

    #[test]
    fn what_the_benches_print_becomes_the_page() {
        let quiet = documents("quiet");
        let notes = Notes::parse("## scan-growth\nBecause.\n## step\nSee there.\n");
        let page = render(&read(&quiet), &notes).unwrap();
        assert_eq!(page, render(&read(&quiet), &notes).unwrap());
        for text in [
            "| ≤ 15 ns per beam in the Apartment with 180 beams |",
            "\n**from 64 to 32,768 walls the cost of a beam grows ≤ 2 ×.** Because.\n",
            "| rooms-constant-64, 180 |",
            "| the server takes ≤ 20 MB at most with the Apartment | 12.0 MB | met |",
            "\nSee there.\n\n`sim-server bench step`, results `",
            "The machine was quiet.",
        ] {
            assert!(page.contains(text), "{text:?} is not on the page:\n{page}");
        }
        // One size of world: the growth is unknown, so missed, but explained.
        assert!(!unexplained(&read(&quiet), &notes).unwrap().contains(&"scan-growth"));
        assert!(unexplained(&read(&quiet), &Notes::default()).unwrap().contains(&"scan-growth"));
        assert_eq!(unexplained(&read(&documents("noisy")), &notes).unwrap(), [""; 0]);

        let stale = stale_rows(&read(&quiet)).unwrap();
        // The other sizes of worlds, and all rows of latency, sweep, log and idle.
        assert_eq!(stale.len(), 3 * 2 * 2 * 2 + 15 + 2 + 3 + 8, "{stale:?}");
        assert!(stale.contains(&"scan: segments-area-512, 1080".to_owned()));
    }

    #[test]
    fn a_page_is_not_made_of_what_is_missing_changed_or_old() {
        let good = documents("quiet");
        let fails = |spoil: fn(&mut Value)| {
            let mut spoilt = good.clone();
            spoil(&mut spoilt);
            render(&read(&spoilt), &Notes::default()).unwrap_err()
        };
        let missing = fails(|d| drop(d.as_object_mut().unwrap().remove("step")));
        assert!(matches!(missing, PageError::Missing { bench: "step" }), "{missing}");
        let changed = fails(|d| d["step"]["results"]["parts"][0]["ns"]["median"] = json!(0.5));
        assert!(matches!(changed, PageError::Changed { bench: "step" }), "{changed}");
        let old = fails(|d| {
            d["step"]["results"] = json!({"rounds": 3});
            d["step"]["results_hash"] = json!(results_hash(&json!({"rounds": 3})));
        });
        assert!(matches!(old, PageError::OldDocument { bench: "step", .. }), "{old}");
        let stray = render(&read(&good), &Notes::parse("## scan-speed\nx\n")).unwrap_err();
        assert!(matches!(stray, PageError::StrayNote { .. }), "{stray}");
        assert!(bench("scan").is_some() && bench("scan-speed").is_none());
    }
}
