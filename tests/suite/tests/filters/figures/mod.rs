//! The tables of docs/filters.md are what the commands before them print, digit by digit.
//!
//! `RUSTY_FIGURES=all cargo test --release -p rusty-tests --test filters figures::` runs all
//! commands, and the heading of a section in the place of `all` those of its tables too. Without
//! it, the tables that take long are left out.

mod cell;
mod command;
mod table;

use std::collections::BTreeSet;

use command::Figures;
use rusty_metrics::percentile;
use rusty_tests::*;
use table::Table;

const PAGE: &str = "docs/filters.md";

/// The check of a table.
enum Check {
    /// Its sweeps run in every test; words name the estimator where the rows do not.
    Sweep(&'static [&'static str]),
    /// Its sweeps run with `RUSTY_FIGURES=all`, or the heading of its section.
    LongSweep,
    /// Its replay runs in every test for the first log, with `RUSTY_FIGURES=all` for all.
    Replay([&'static str; 4]),
    /// Not here, for this reason.
    Elsewhere(&'static str),
}
use Check::{Elsewhere, LongSweep, Replay, Sweep};

/// All tables of the page, by section and number in it.
const TABLES: [(&str, usize, Check); 17] = [
    ("Filters", 0, Elsewhere("it has no figures")),
    ("A tour of the Apartment", 0, LongSweep),
    ("A tour of the Apartment", 1, LongSweep),
    ("Global localisation and kidnapping", 0, Sweep(&["mcl"])),
    ("Grid or particles", 0, LongSweep),
    ("Lasers that see little", 0, LongSweep),
    ("Landmarks", 0, LongSweep),
    ("Landmarks", 1, Sweep(&[])),
    ("When a filter does not know", 0, LongSweep),
    ("The motion model at other rates", 0, Elsewhere("it has default values, not results")),
    ("The motion model at other rates", 1, Sweep(&[])),
    ("Maps", 0, Elsewhere("the tests `drivers::` assert and print it")),
    ("Drivers", 0, Elsewhere("`benchmark verify` repeats the file that its command writes")),
    ("Real robots", 0, Replay(["freiburg-101", "intel", "csail", "edmonton"])),
    ("Real robots", 1, Elsewhere("the tests `recordings::` compare it by `hold`")),
    ("Real robots", 2, Elsewhere("the test `mcl::a_real_robot…` compares it by `hold_row`")),
    ("Real robots", 3, Elsewhere("the test `mcl::on_grids…` compares it by `hold_row`")),
];

/// Columns and their fields; a field that ends with `_rad` is shown in degrees.
const COLUMNS: [(&str, &[&str]); 17] = [
    ("ATE rmse", &["ate_rmse_m", "ate_rmse_range_m/0", "ate_rmse_range_m/1"]),
    ("ATE aligned", &["ate_se2_rmse_m", "ate_se2_rmse_range_m/0", "ate_se2_rmse_range_m/1"]),
    ("aligned", &["ate_se2_rmse_m"]),
    ("RPE per metre", &["rpe_per_metre_rmse_m", "rpe_per_metre_rmse_rad"]),
    ("mean NEES of 3", &["nees", "verdict"]),
    (
        "ANEES at the end",
        &["last/anees", "last/verdict", "level_percent", "last/interval/0", "last/interval/1"],
    ),
    ("NIS per degree", &["nis/per_degree", "nis/verdict"]),
    ("answered", &["answered_percent"]),
    ("wrong", &["wrong_percent"]),
    ("found", &["found", "runs"]),
    ("found, after", &["found", "runs", "found_after_s"]),
    ("found, after, median", &["found_after_s"]),
    ("then rmse", &["then_position_rmse_m", "then_heading_rmse_rad"]),
    ("recovered", &["recovered", "kidnapped"]),
    ("recovered, after", &["recovered", "kidnapped", "recovered_after_s"]),
    ("recovered, after, median", &["recovered_after_s"]),
    ("log", &["scored_ticks"]),
];

/// Columns that name the run of a row.
const KEYS: [&str; 6] = ["filter", "estimator", "scenario", "identity", "α of `ekf`", "rate"];

/// Columns of compute times and memory, which depend on the machine.
const MEASURED: [&str; 4] = ["a scan", "a reading", "first scan", "memory"];

/// Beginnings of names on the page, and the names in the commands.
const NAMES: [(&str, &str); 21] = [
    ("view of 20°", "fov_rad=0.35"),
    ("view of 40°", "fov_rad=0.7"),
    ("view of 57°", "fov_rad=1.0"),
    ("range of 1 m", "range_max_m=1.0"),
    ("20 beams", "beams=20"),
    ("`office`, right wheel", "radius_bias_right=0.03"),
    ("`office`, slip", "slip_std=0.1"),
    ("Apartment, 5 people", "people=5"),
    ("Apartment, 20 people", "people=20"),
    ("global", "global.toml"),
    ("fastslam, variant 1", "fastslam-1"),
    ("fastslam, variant 2", "fastslam"),
    ("`grid-localisation`", "grid"),
    ("default", "ekf"),
    ("fitted at 50 Hz", "fitted"),
    ("50 Hz", "ekf.toml"),
    ("10 Hz", "dt_s=0.1"),
    ("Freiburg", "freiburg-101"),
    ("Intel", "intel"),
    ("CSAIL", "csail"),
    ("Edmonton", "edmonton"),
];

fn tables() -> Vec<Table> {
    Table::all(&fs::read_to_string(repository().join(PAGE)).unwrap())
}

/// Returns the name in the commands.
fn name(cell: &str) -> &str {
    let found = NAMES.iter().find(|(begin, _)| cell.starts_with(begin));
    found.map_or(cell.trim_matches('`'), |(_, name)| name)
}

/// Corrects a row; prints each cell that differs.
fn corrected(table: &Table, row: &[String], figures: &Value) -> Vec<String> {
    let cell = |(column, cell): (usize, &String)| {
        let heading = table.heading(column);
        let matching = COLUMNS.iter().filter(|(begin, _)| heading.starts_with(begin));
        let Some((begin, fields)) = matching.max_by_key(|(begin, _)| begin.len()) else {
            let known = MEASURED.into_iter().chain(KEYS);
            assert!(known.into_iter().any(|known| known == heading), "{heading}: no field known");
            return cell.clone();
        };
        // A heading may have figures, too.
        let more = &heading[begin.len()..];
        let new = cell::corrected(&format!("{cell}{more}"), fields, figures);
        let new = new.strip_suffix(more).unwrap_or(&new).to_owned();
        // A name that is not repeated.
        if cell.is_empty() || new == *cell {
            return cell.clone();
        }
        println!("{}, {}, {heading}: {cell:?}, by the command {new:?}", table.place.0, row[0]);
        new
    };
    row.iter().enumerate().map(cell).collect()
}

/// Compares a table with the figures; returns corrected lines for what differs. Rows of
/// recordings that were not replayed are left out.
fn differences(table: &Table, words: &[&str], all: &[Figures]) -> Vec<String> {
    let (mut wrong, mut log) = (Vec::new(), None);
    for row in &table.rows {
        let mut words: Vec<&str> = words.to_vec();
        let cells = table.headings.iter().zip(row).filter(|(_, cell)| !cell.is_empty());
        for (heading, cell) in cells {
            if heading == "log" {
                log = Some(name(cell));
            } else if KEYS.contains(&heading.as_str()) && cell != "–" {
                words.push(name(cell));
            }
        }
        let left = log.iter().fold(all.iter().collect(), Figures::named);
        if left.is_empty() {
            assert!(NAMES.iter().any(|(_, known)| Some(*known) == log), "{log:?} is not known");
            continue;
        }
        let left = words.iter().fold(left, Figures::named);
        let Some(figures) = left.first() else {
            panic!("{:?}: no figures for {words:?}", table.place);
        };
        let new = corrected(table, row, &figures.values);
        wrong.extend((new != *row).then(|| Table::line(&new)));
    }
    wrong
}

/// Fails with the lines to paste into the page.
#[track_caller]
fn expect_none(wrong: &[String]) {
    assert!(wrong.is_empty(), "{PAGE} differs from its commands, expected:\n{}", wrong.join("\n"));
}

#[test]
fn every_table_is_known() {
    let found: Vec<(String, usize)> = tables().into_iter().map(|table| table.place).collect();
    assert_eq!(found, TABLES.map(|(section, number, _)| (section.to_owned(), number)));
}

#[test]
fn commands_print_the_figures_of_the_page() {
    let wanted = std::env::var("RUSTY_FIGURES").unwrap_or_default();
    let with_all = wanted == "all";
    let (mut wrong, none): (_, &[&str]) = (Vec::new(), &[]);
    for (table, (section, number, check)) in tables().iter().zip(TABLES) {
        let sweeps = || table.commands.iter().flat_map(|line| command::sweep(line)).collect();
        let (words, figures): (_, Vec<Figures>) = match check {
            Sweep(words) => (words, sweeps()),
            LongSweep if with_all || wanted == section => (none, sweeps()),
            Replay(logs) => {
                let logs = &logs[..if with_all { logs.len() } else { 1 }];
                let replays = logs.iter().flat_map(|log| command::replay(&table.commands, log));
                (none, replays.collect())
            }
            LongSweep => continue,
            Elsewhere(reason) => {
                println!("{section}, table {number}: not compared here: {reason}");
                continue;
            }
        };
        wrong.extend(differences(table, words, &figures));
    }
    expect_none(&wrong);
}

/// A filter draws, or the world does.
#[test]
fn every_sweep_of_the_page_has_eight_seeds() {
    let commands: BTreeSet<String> = tables().into_iter().flat_map(|t| t.commands).collect();
    let seeds = commands.iter().filter_map(|c| c.split_once("--seeds 0..").map(|(_, end)| end));
    let seeds: Vec<u64> =
        seeds.map(|end| end.split(' ').next().unwrap().parse().unwrap()).collect();
    assert!(seeds.len() >= 10 && seeds.iter().all(|count| *count >= 8), "{seeds:?}");
}

/// Compares cells of the column of a recording in the table of changed copies, by the
/// names of their rows.
#[track_caller]
pub(crate) fn hold(log: &str, cells: &[(String, Vec<f64>)]) {
    let tables = tables();
    let table = tables.iter().find(|t| t.headings[0].is_empty()).unwrap();
    let column = table.headings.iter().position(|heading| name(heading) == log).unwrap();
    let mut wrong = Vec::new();
    for (row, numbers) in cells {
        let found = table.rows.iter().find(|cells| cells[0] == *row);
        let cell = &found.unwrap_or_else(|| panic!("{PAGE} has no row {row:?}"))[column];
        wrong.extend(other(&format!("{log}, {row}"), cell, numbers));
    }
    expect_none(&wrong);
}

/// Compares cells of the row that begins with these names.
#[track_caller]
pub(crate) fn hold_row(names: &[&str], figures: &[Vec<f64>]) {
    let tables = tables();
    let mut rows = tables.iter().flat_map(|table| &table.rows);
    let row = rows.find(|row| row.iter().zip(names).all(|(cell, name)| cell == name));
    let cells = row.unwrap_or_else(|| panic!("{PAGE} has no row {names:?}"))[names.len()..].iter();
    let wrong = cells.zip(figures).filter_map(|(cell, numbers)| other(names[0], cell, numbers));
    expect_none(&wrong.collect::<Vec<_>>());
}

/// Median, least and most, as cells of the page show them.
pub(crate) fn spread(mut values: Vec<f64>) -> Vec<f64> {
    [0.5, 0.0, 1.0].map(|fraction| percentile(&mut values, fraction).unwrap()).to_vec()
}

/// Returns what is expected in the place of a cell, unless its numbers are these.
fn other(place: &str, cell: &str, numbers: &[f64]) -> Option<String> {
    let new = cell::with_numbers(cell, numbers);
    (new != cell).then(|| format!("{place}: {cell:?}, expected {new:?}"))
}
