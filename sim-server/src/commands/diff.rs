//! `diff`: find the first tick, field and bits in which two logs differ.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use rusty_contract::log::{Ending, LogReader, Read, ReadEntry};
use rusty_contract::{Exit, JsonTree as _, outln};
use rusty_logs::compare::{self, Mismatch};
use rusty_study::documents;
use serde::Serialize;

use super::arguments::Output;

#[derive(Args, Clone, Debug)]
pub struct DiffArgs {
    /// First log
    pub a: PathBuf,
    /// Second log
    pub b: PathBuf,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Serialize)]
struct Difference {
    /// Headers, ticks and endings are equal, bit for bit.
    equal: bool,
    /// Fields of the headers that differ.
    headers: Vec<String>,
    /// Ticks that both logs have and that are equal, before the first
    /// difference.
    ticks_equal: u64,
    /// The first value that differs.
    first_difference: Option<Mismatch>,
    /// How they end, where that differs, and damage.
    remarks: Vec<String>,
}

pub fn run(args: &DiffArgs) -> Result<Exit> {
    let found = compare_logs(&args.a, &args.b)?;
    args.output.print_with(&found, || print(args, &found));
    Ok(if found.equal { Exit::Done } else { Exit::NotBitExact })
}

fn print(args: &DiffArgs, d: &Difference) {
    for header in &d.headers {
        outln!("header: {header}");
    }
    for remark in &d.remarks {
        outln!("{remark}");
    }
    match &d.first_difference {
        Some(m) => {
            outln!("first difference: tick {}, {}", m.tick, m.place());
            outln!("  {}: {}", args.a.display(), m.a);
            outln!("  {}: {}", args.b.display(), m.b);
        }
        None if d.equal => outln!("equal: {} ticks, bit for bit", d.ticks_equal),
        None => outln!("the {} ticks that both have are equal", d.ticks_equal),
    }
}

fn compare_logs(a: &Path, b: &Path) -> Result<Difference> {
    let (mut ra, mut rb) = (LogReader::open(a)?, LogReader::open(b)?);
    let (ha, hb) = (ra.header().clone(), rb.header().clone());
    let mut found = Difference {
        equal: true,
        headers: header_differences(&ha, &hb),
        ticks_equal: 0,
        first_difference: None,
        remarks: Vec::new(),
    };
    let names: Vec<String> = ha.answering().map(|p| p.name.clone()).collect();
    loop {
        match (ra.read()?, rb.read()?) {
            (Read::Tick(x), Read::Tick(y)) => {
                for (path, entry, damaged) in [(a, &x, ra.damaged()), (b, &y, rb.damaged())] {
                    note_damage(&mut found, path, entry, damaged);
                }
                let (x, y) = (x.record, y.record);
                found.first_difference = compare::frames(&x, &y, ha.config.dt_s)
                    .or_else(|| compare::replies(x.tick, &names, &x.replies, &y.replies));
                if found.first_difference.is_some() {
                    break;
                }
                found.ticks_equal += 1;
            }
            (Read::End(x), Read::End(y)) => {
                if x != y {
                    found.remarks.push(format!("{}: {}", a.display(), describe(&x)));
                    found.remarks.push(format!("{}: {}", b.display(), describe(&y)));
                }
                break;
            }
            (x, y) => {
                for (path, read) in [(a, x), (b, y)] {
                    if let Read::End(ending) = read {
                        let (path, how) = (path.display(), describe(&ending));
                        found.remarks.push(format!("{path}: {how}, the other goes on"));
                    }
                }
                break;
            }
        }
    }
    for (path, damaged) in [(a, ra.damaged()), (b, rb.damaged())] {
        if let Some(more) = damaged.checked_sub(MOST_NAMED).filter(|more| *more > 0) {
            let path = path.display();
            found.remarks.push(format!("{path}: the checksums of {more} more records fail"));
        }
    }
    found.equal =
        found.headers.is_empty() && found.remarks.is_empty() && found.first_difference.is_none();
    Ok(found)
}

/// Number of damaged records of each log that are named; the others are counted.
const MOST_NAMED: u64 = 100;

fn note_damage(found: &mut Difference, path: &Path, entry: &ReadEntry, damaged: u64) {
    if !entry.intact && damaged <= MOST_NAMED {
        let (path, tick, at) = (path.display(), entry.record.tick, entry.at_byte);
        let remark = format!("{path}: tick {tick}: the checksum of its record (byte {at}) fails");
        found.remarks.push(remark);
    }
}

fn describe(ending: &Ending) -> String {
    match ending {
        Ending::Complete(t) => {
            let digest = rusty_contract::digest::hex(&t.run_digest);
            format!("complete, {} ticks, digest {digest}", t.ticks)
        }
        Ending::Cut { ticks, at_byte, problem } => {
            format!("cut after {ticks} ticks, at byte {at_byte}: {problem}")
        }
    }
}

/// Leaves of the two headers that differ, as `path: a and b`.
fn header_differences(a: &rusty_contract::LogHeader, b: &rusty_contract::LogHeader) -> Vec<String> {
    match (a.to_tree(), b.to_tree()) {
        (Ok(a), Ok(b)) => documents::differences(&a, &b),
        _ => Vec::new(),
    }
}
