//! `doctor`: check which promises hold on this machine, in this build.

use anyhow::Result;
use rusty_bench::machine;
use rusty_contract::{Exit, TextTable, outln};
use rusty_engine::confine;
use rusty_link::memory_state;
use rusty_sim::{GOLDENS, Golden};
use serde::Serialize;

use super::arguments::Output;

#[derive(Debug, Serialize)]
struct Checkup {
    /// Every golden run has its digest.
    same_bits: bool,
    goldens: Vec<Examined>,
    build: Build,
    shared_memory: Memory,
    /// Whether participants can be confined (`sandbox = "required"`).
    sandbox: Sandbox,
    verdict: String,
}

/// A golden run that was simulated here.
#[derive(Debug, Serialize)]
struct Examined {
    name: &'static str,
    pins: &'static str,
    expected: String,
    /// The digest on this machine, or an error.
    found: String,
    ok: bool,
}

/// The program and its machine.
#[derive(Debug, Serialize)]
struct Build {
    version: &'static str,
    /// "debug" (checks of arithmetic on) or "release".
    profile: &'static str,
    arch: &'static str,
    os: &'static str,
    /// Instructions the compiler was allowed to use beyond the oldest CPU of
    /// this kind, of those that tempt it into other roundings.
    compiled_for: Vec<&'static str>,
    /// Name of the CPU, if the kernel has it.
    cpu: Option<String>,
}

#[derive(Debug, Serialize)]
struct Memory {
    path: &'static str,
    writable: bool,
    problem: Option<String>,
    free_bytes: u64,
}

#[derive(Debug, Serialize)]
struct Sandbox {
    landlock_abi: u32,
    /// Requirements of `sandbox = "required"` that are missing.
    lacks: Option<String>,
}

/// Exits with 4 if a bit differs, 1 if shared memory cannot be used.
pub fn run(output: &Output) -> Result<Exit> {
    let goldens = examine(&GOLDENS);
    let state = memory_state();
    let shared_memory = Memory {
        path: state.path,
        writable: state.problem.is_none(),
        problem: state.problem,
        free_bytes: state.free_bytes,
    };
    let kernel = confine::kernel();
    let sandbox = Sandbox { landlock_abi: kernel.landlock_abi, lacks: kernel.lacks() };
    let wrong = goldens.iter().filter(|golden| !golden.ok).count();
    let (exit, verdict) = judge(wrong, goldens.len(), &shared_memory);
    let checkup =
        Checkup { same_bits: wrong == 0, goldens, build: build(), shared_memory, sandbox, verdict };
    output.print_with(&checkup, || print(&checkup));
    Ok(exit)
}

/// Simulates every run of `goldens` and compares its digest.
fn examine(goldens: &[Golden]) -> Vec<Examined> {
    let one = |golden: &Golden| {
        let found = golden.found();
        Examined {
            name: golden.name,
            pins: golden.pins,
            expected: golden.expected.to_owned(),
            ok: found.as_deref() == Ok(golden.expected),
            found: found.unwrap_or_else(|error| error.to_string()),
        }
    };
    goldens.iter().map(one).collect()
}

/// The exit code and the sentence for `wrong` digests of `all`.
fn judge(wrong: usize, all: usize, memory: &Memory) -> (Exit, String) {
    if wrong > 0 {
        let verdict = format!(
            "Not the same bits: {wrong} of {all} worlds come out differently here, so no digest, \
             log or score of this build can be compared with one from elsewhere; build again with \
             the toolchain and Cargo.lock of the repository, and if it stays so, report this table."
        );
        return (Exit::NotBitExact, verdict);
    }
    match &memory.problem {
        Some(problem) => (
            Exit::Failed,
            format!(
                "The golden worlds have their bits, but no run can start: {} cannot be \
                 written ({problem}); mount a tmpfs there that this user may write.",
                memory.path
            ),
        ),
        None => (
            Exit::Done,
            "The golden worlds have the same bits here as wherever this check passes, and shared \
             memory can be used: runs with the same configuration, seed and commands can be \
             compared between these machines bit by bit."
                .to_owned(),
        ),
    }
}

fn build() -> Build {
    let features = [
        ("fma", cfg!(target_feature = "fma")),
        ("avx", cfg!(target_feature = "avx")),
        ("avx2", cfg!(target_feature = "avx2")),
        ("avx512f", cfg!(target_feature = "avx512f")),
    ];
    Build {
        version: env!("CARGO_PKG_VERSION"),
        profile: if cfg!(debug_assertions) { "debug" } else { "release" },
        arch: std::env::consts::ARCH,
        os: std::env::consts::OS,
        compiled_for: features.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect(),
        cpu: std::fs::read_to_string("/proc/cpuinfo").ok().as_deref().and_then(machine::cpu_name),
    }
}

fn print(c: &Checkup) {
    let mut table = TextTable::new("golden run  expected  found  result");
    for g in &c.goldens {
        let word = if g.ok { "ok" } else { "WRONG" };
        table.row(&[&g.name, &g.expected, &g.found, &word]);
        if !g.ok {
            table.row(&[&"", &format!("it pins {}", g.pins)]);
        }
    }
    outln!("{table}");
    let Build { version, profile, arch, os, compiled_for, cpu } = &c.build;
    outln!("");
    outln!("same bits      {}", if c.same_bits { "yes" } else { "no" });
    let beyond = match compiled_for.as_slice() {
        [] => "any CPU of this kind".to_owned(),
        some => format!("CPUs with {}", some.join(", ")),
    };
    outln!("build          sim-server {version}, {profile}, {arch} {os}, for {beyond}");
    outln!("CPU            {}", cpu.as_deref().unwrap_or("the kernel does not name it"));
    let m = &c.shared_memory;
    let can = m.problem.as_deref().map_or("can be written", |problem| problem);
    outln!("shared memory  {}: {can}, {:.1} MB free", m.path, m.free_bytes as f64 / 1e6);
    let gate = c.sandbox.lacks.as_deref().unwrap_or("participants can be confined");
    outln!("sandbox        Landlock ABI {}: {gate}", c.sandbox.landlock_abi);
    outln!("\n{}", c.verdict);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn memory(problem: Option<&str>) -> Memory {
        let problem = problem.map(str::to_owned);
        Memory { path: "/dev/shm", writable: problem.is_none(), problem, free_bytes: 1 }
    }

    #[test]
    fn a_digest_that_differs_in_one_digit_is_found() {
        let mut doctored = GOLDENS;
        doctored[3].expected = "e6741934d85d60b9bb4fd3446d09a753";
        let wrong: Vec<Examined> = examine(&doctored).into_iter().filter(|g| !g.ok).collect();
        assert_eq!(wrong.len(), 1);
        assert_eq!(
            (wrong[0].name, wrong[0].found.as_str()),
            (GOLDENS[3].name, GOLDENS[3].expected)
        );

        let (exit, verdict) = judge(wrong.len(), doctored.len(), &memory(None));
        assert_eq!(exit, Exit::NotBitExact);
        let counted = format!("1 of {} worlds", GOLDENS.len());
        assert!(verdict.contains(&counted), "{verdict}");
    }

    #[test]
    fn wrong_bits_weigh_more_than_shared_memory() {
        assert_eq!(judge(0, 8, &memory(None)).0, Exit::Done);
        let (exit, verdict) = judge(0, 8, &memory(Some("Permission denied")));
        assert!(exit == Exit::Failed && verdict.contains("Permission denied"), "{verdict}");
        assert_eq!(judge(1, 8, &memory(Some("Permission denied"))).0, Exit::NotBitExact);
    }
}
