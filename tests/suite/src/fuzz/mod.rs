//! Everything that arrives from another process or from disk, as functions of
//! bytes.
//!
//! A target reads its bytes as the programs here do, asserts what must hold
//! whatever they are, and says whether they were accepted. `tests/fuzz.rs`
//! feeds all of them on stable with mutants of `tests/suite/corpus`; the crate in
//! `tests/fuzz` feeds the same functions guided by coverage.
//!
//! In reading order: [`memory`] (an allocator that counts), [`mutate`],
//! [`seeds`] (the corpus, made from real things), then a file per noun.

pub mod answers;
pub mod carmen;
pub mod floorplan;
pub mod frame;
mod imported;
pub mod join;
pub mod log;
pub mod mcap;
pub mod memory;
pub mod mutate;
pub mod scenario;
pub mod score;
pub mod seeds;
pub mod table;
pub mod texts;
pub mod world;

use memory::measured;

/// One decoder under test.
pub struct Target {
    /// Its name: of the test, of the folder in `tests/suite/corpus`, of the program
    /// in `tests/fuzz`.
    pub name: &'static str,
    /// Reads the bytes, asserts, says whether they were accepted.
    pub run: fn(&[u8]) -> bool,
    /// Makes checksums right again, where there are any.
    pub mend: Option<fn(&mut [u8])>,
    /// Words that mean something to it.
    pub words: &'static [&'static str],
    /// Inputs that a test run tries.
    pub inputs: u32,
    /// Longest input that is tried, bytes.
    pub longest: usize,
    /// Memory that may be in use at once: so much for each byte of input …
    pub bytes_per_byte: usize,
    /// … and this much in addition, bytes.
    pub bytes_beside: usize,
}

impl Target {
    const fn new(name: &'static str, run: fn(&[u8]) -> bool, inputs: u32) -> Self {
        let (longest, bytes_per_byte, bytes_beside) = (1 << 15, 64, 4 << 20);
        let mend = None;
        Self { name, run, mend, words: &[], inputs, longest, bytes_per_byte, bytes_beside }
    }

    /// Runs the target on `bytes` and, where memory is counted, asserts that
    /// it took no more than a multiple of what was given.
    pub fn check(&self, bytes: &[u8]) -> bool {
        let (accepted, peak) = measured(|| (self.run)(bytes));
        let limit = self.bytes_per_byte * bytes.len() + self.bytes_beside;
        assert!(peak <= limit, "{} bytes of input took {peak} bytes of memory", bytes.len());
        accepted
    }
}

/// All of them.
pub const TARGETS: [Target; 17] = [
    Target {
        mend: Some(log::mend),
        words: &["null", "1e999", "nan", "\"kind\":", "simulated", "recorded"],
        ..Target::new("log", log::log, 7500)
    },
    Target { mend: Some(log::mend), ..Target::new("score", score::score, 750) },
    Target { words: &scenario::WORDS, ..Target::new("scenario", scenario::scenario, 3600) },
    Target { words: &world::WORDS, ..Target::new("world", world::world, 7500) },
    Target { words: &carmen::WORDS, ..Target::new("carmen", carmen::carmen, 1200) },
    Target {
        words: &mcap::WORDS,
        // A packed chunk may have 64 MiB, in a vector that doubles.
        bytes_beside: 256 << 20,
        ..Target::new("mcap", mcap::mcap, 1200)
    },
    Target { words: &join::WORDS, ..Target::new("join", join::request, 15000) },
    Target { words: &join::WORDS, ..Target::new("reply", join::reply, 7500) },
    Target { words: &join::WORDS, ..Target::new("brief", join::brief, 4500) },
    Target::new("answer", answers::answer, 15000),
    Target::new("answers", answers::answers, 4500),
    Target::new("frame", frame::frame, 7500),
    Target::new("tally", frame::tally, 7500),
    Target {
        words: &texts::WORDS,
        // A line `0 0 1000000` is a million commands.
        bytes_beside: 64 << 20,
        ..Target::new("texts", texts::texts, 15000)
    },
    Target::new("table", table::table, 1500),
    // A byte of PNG may hold a thousand pixels, each of some bytes.
    Target { bytes_per_byte: 16 << 10, ..Target::new("map", floorplan::map, 7500) },
    Target {
        words: &floorplan::WORDS,
        // A curve may have ten thousand walls.
        bytes_beside: 64 << 20,
        ..Target::new("svg", floorplan::svg, 7500)
    },
];

/// The target of this name.
pub fn target(name: &str) -> &'static Target {
    const ALL: &[Target] = &TARGETS;
    ALL.iter().find(|t| t.name == name).unwrap_or_else(|| panic!("no target is called {name}"))
}
