//! Mutants of real inputs for everything that reads what comes from another
//! process or from disk: nothing panics, nothing takes more memory than its
//! input deserves, and what is accepted can be relied on.
//!
//! The same inputs in every run. `RUSTY_FUZZ=N` tries N inputs per target,
//! `RUSTY_FUZZ_SEED=N` others, `RUSTY_FUZZ_INPUT=PATH` only that one.
//! `RUSTY_FUZZ_CORPUS=write` makes the files `real-*` of the corpus again.

use std::fs::File;
use std::os::unix::fs::FileExt as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use rusty_tests::fuzz::memory::Counting;
use rusty_tests::fuzz::mutate::{Dice, mutant};
use rusty_tests::fuzz::{TARGETS, Target, seeds, target};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn variable<T: std::str::FromStr>(name: &str) -> Option<T> {
    std::env::var(name).ok().map(|text| match text.parse() {
        Ok(value) => value,
        Err(_) => panic!("{name}={text} is no number"),
    })
}

/// The input that is being tried, in a file: what ends the whole process leaves
/// it there. Kept open, because closing a file that was cut goes to the disk.
struct Last {
    path: PathBuf,
    file: File,
}

impl Last {
    fn of(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("rusty-fuzz-{name}-{}", std::process::id()));
        let file = File::create(&path).unwrap();
        Self { path, file }
    }

    fn is(&self, bytes: &[u8]) {
        self.file.write_all_at(bytes, 0).unwrap();
        self.file.set_len(bytes.len() as u64).unwrap();
    }
}

/// Runs one input; a failure leaves it in a file and says how to repeat it.
fn check(target: &Target, bytes: &[u8], last: &Last) -> bool {
    last.is(bytes);
    catch_unwind(AssertUnwindSafe(|| target.check(bytes))).unwrap_or_else(|_| {
        let (name, path) = (target.name, last.path.with_extension("failed"));
        std::fs::copy(&last.path, &path).unwrap();
        let path = path.display();
        panic!(
            "{name} fails on {path}; again with\n  \
             RUSTY_FUZZ_INPUT={path} cargo test -p rusty-tests --test fuzz {name}\n\
             and when it is mended keep it in {}",
            seeds::folder(name).display()
        );
    })
}

fn fuzz(name: &str) {
    let target = target(name);
    let last = Last::of(name);
    if let Some(path) = variable::<PathBuf>("RUSTY_FUZZ_INPUT") {
        let accepted = check(target, &std::fs::read(path).unwrap(), &last);
        println!("accepted: {accepted}");
        std::fs::remove_file(last.path).unwrap();
        return;
    }
    let mut inputs = Vec::new();
    for (path, bytes) in seeds::corpus(name) {
        let accepted = check(target, &bytes, &last);
        // Otherwise the mutants would be those of something that is refused at
        // its door.
        let real = path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("real-"));
        assert!(
            accepted || !real,
            "{} is no longer what the programs write: RUSTY_FUZZ_CORPUS=write makes it again",
            path.display()
        );
        inputs.push(bytes);
    }
    let mut dice = Dice::new(variable("RUSTY_FUZZ_SEED").unwrap_or(1));
    let (mut accepted, tried) = (0u32, variable("RUSTY_FUZZ").unwrap_or(target.inputs));
    for _ in 0..tried {
        accepted += u32::from(check(target, &mutant(target, &inputs, &mut dice), &last));
    }
    println!("{name}: {accepted} of {tried} mutants accepted");
    // Mutants that are all refused, or all accepted, test nothing.
    assert!(tried < 200 || (accepted > 0 && accepted < tried), "{accepted} of {tried}");
    std::fs::remove_file(last.path).unwrap();
}

macro_rules! targets {
    ($($name:ident),*) => {
        $(#[test]
        fn $name() {
            fuzz(stringify!($name));
        })*

        #[test]
        fn every_target_is_run() {
            let run = [$(stringify!($name)),*];
            assert_eq!(run, TARGETS.map(|t| t.name));
        }
    };
}

targets!(
    log, score, scenario, world, carmen, mcap, join, reply, brief, answer, answers, frame, tally,
    texts, table, map, svg
);

#[test]
fn the_corpus_is_small_and_has_real_things() {
    let write = std::env::var("RUSTY_FUZZ_CORPUS").is_ok_and(|v| v == "write");
    for (target, name, bytes) in seeds::made() {
        let path = seeds::folder(target).join(name);
        if write {
            std::fs::create_dir_all(seeds::folder(target)).unwrap();
            std::fs::write(&path, bytes).unwrap();
        }
        assert!(path.exists(), "{}: RUSTY_FUZZ_CORPUS=write makes it", path.display());
    }
    let files = TARGETS.iter().flat_map(|t| seeds::corpus(t.name));
    let bytes: usize = files.map(|(_, bytes)| bytes.len()).sum();
    assert!(bytes < 300_000, "the corpus has {bytes} bytes");
}

#[test]
fn memory_is_counted() {
    use rusty_tests::fuzz::memory::measured;
    let (_, peak) = measured(|| drop(std::hint::black_box(vec![1u8; 100_000])));
    assert!((100_000..110_000).contains(&peak), "{peak}");
}
