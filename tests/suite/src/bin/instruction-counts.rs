//! Counts the instructions of the core's work and compares them with the budget
//! in `tests/suite/instructions.toml`: exit 0 if none grew (or nothing can be counted
//! here, which it says), 1 if one did.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use clap::Parser;
use rusty_tests::counts::budget::{Budget, REMEDY, compare};
use rusty_tests::counts::callgrind;
use rusty_tests::counts::work::{self, WORK, Work};
use rusty_tests::repository;

/// Count the instructions of the core's work, with valgrind, and compare them
/// with the budget; one that grew by more than 5 % fails.
#[derive(Parser)]
struct Args {
    /// Write what was counted as the new budget
    #[arg(long)]
    write: bool,
    /// The budget [default: tests/suite/instructions.toml of the repository]
    #[arg(long, value_name = "FILE")]
    budget: Option<PathBuf>,
    /// Do one piece of work and nothing else (this program calls itself so)
    #[arg(long, hide = true, value_name = "NAME")]
    run: Option<String>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    if let Some(name) = &args.run {
        return ExitCode::from(u8::from(!work::run(name)));
    }
    if let Some(reason) = cannot_count() {
        println!("instruction counts skipped: {reason}");
        return ExitCode::SUCCESS;
    }
    let done = counted().and_then(|found| {
        let file =
            args.budget.unwrap_or_else(|| repository().join("tests/suite/instructions.toml"));
        if args.write { write(&file, found) } else { check(&file, &found) }
    });
    done.unwrap_or_else(|error| {
        eprintln!("instruction-counts: {error}");
        ExitCode::FAILURE
    })
}

/// Why nothing can be counted here, if so.
fn cannot_count() -> Option<&'static str> {
    if !cfg!(target_arch = "x86_64") {
        Some("the budget is one of x86-64 instructions")
    } else if cfg!(debug_assertions) {
        Some("this is a debug build; use cargo build --release")
    } else if !callgrind::is_there() {
        Some("there is no valgrind; install the package of that name")
    } else {
        None
    }
}

fn counted() -> Result<BTreeMap<String, u64>, String> {
    let program = std::env::current_exe().map_err(|e| format!("where am I? {e}"))?;
    let one = |work: &Work| Ok((work.name.to_owned(), callgrind::count(&program, work.name)?));
    WORK.iter().filter(|work| can_count(work)).map(one).collect()
}

/// Whether this work takes the instructions here that the budget was made with.
fn can_count(work: &Work) -> bool {
    !work.is_wide || has_avx2()
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

fn compiler() -> String {
    let said = Command::new("rustc").arg("--version").current_dir(repository()).output();
    said.map_or("unknown".to_owned(), |o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
}

fn write(file: &std::path::Path, counts: BTreeMap<String, u64>) -> Result<ExitCode, String> {
    if !WORK.iter().all(can_count) {
        return Err("this CPU has no AVX2, and the budget is one of CPUs with it".to_owned());
    }
    let budget = Budget { compiler: compiler(), counts };
    let text = budget.to_text();
    std::fs::write(file, &text).map_err(|e| format!("{}: {e}", file.display()))?;
    print!("{text}");
    Ok(ExitCode::SUCCESS)
}

fn check(file: &std::path::Path, found: &BTreeMap<String, u64>) -> Result<ExitCode, String> {
    let place = |e: String| format!("{}: {e}; write it with: {REMEDY}", file.display());
    let text = std::fs::read_to_string(file).map_err(|e| place(e.to_string()))?;
    let mut budget: Budget = toml::from_str(&text).map_err(|e| place(e.to_string()))?;
    for work in WORK.iter().filter(|work| !can_count(work)) {
        println!("{} skipped: this CPU has no AVX2", work.name);
        budget.counts.remove(work.name);
    }
    let lines = compare(&budget, found);
    for line in &lines {
        let what = WORK.iter().find(|work| work.name == line.name).map_or("", |work| work.what);
        println!("{line}  {what}");
    }
    if !lines.iter().any(|line| line.fails()) {
        return Ok(ExitCode::SUCCESS);
    }
    let here = compiler();
    if here != budget.compiler {
        eprintln!("the budget was written with {}, this is {here}", budget.compiler);
    }
    eprintln!("if that is meant, say so in the change and write a new budget: {REMEDY}");
    Ok(ExitCode::FAILURE)
}
