//! `run.json`: what a run's folder says of its run.

use std::fs;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use rusty_contract::log::LogReader;
use rusty_contract::{LogHeader, Replacement};
use serde::{Deserialize, Serialize};

use rusty_engine::run::OUT;

/// The file by which a run's folder is known.
pub(super) const MARKER: &str = "run.json";
/// What server, logger, scorer and `export` write into a run's folder.
const OURS: [&str; 9] = [
    MARKER,
    "run.log",
    "run.log.again",
    "run.csv",
    "tum",
    "score.json",
    "report.html",
    "report.svg",
    "report.png",
];

/// What a run's folder says of its run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Marker {
    /// Name of the run.
    pub run: String,
    /// Name of its scenario.
    pub scenario: String,
    /// Seed; null for a recording and for a blind log.
    pub seed: Option<u64>,
    /// When it was started, seconds since 1970 in UTC.
    pub started_unix_s: u64,
    /// Names in the folder that belong to the run; `map.*` stands for `map` and
    /// for all names that start with `map.`.
    pub files: Vec<String>,
    /// The end; null while the run lasts, and if its server was killed.
    pub end: Option<RunEnd>,
}

/// How a run ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunEnd {
    /// done, interrupted or aborted.
    pub ended: String,
    /// Complete ticks.
    pub ticks: u64,
    /// Run digest.
    pub digest: String,
}

impl Marker {
    /// The marker of a run that starts now.
    #[must_use]
    pub fn new(run: &str, header: &LogHeader) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        Self::started_at(now.map_or(0, |since| since.as_secs()), run, header)
    }

    fn started_at(started_unix_s: u64, run: &str, header: &LogHeader) -> Self {
        let mut files: Vec<String> = OURS.map(str::to_owned).to_vec();
        for participant in &header.roster {
            let name = &participant.name;
            files.extend([name.clone(), format!("{name}.txt"), format!("{name}.beliefs")]);
            let words = participant.command.iter().skip(1);
            let named = words.flat_map(|word| word.split(OUT).skip(1));
            let first = named.filter_map(|rest| rest.strip_prefix('/')?.split('/').next());
            files.extend(first.filter(|name| !name.is_empty()).map(|name| format!("{name}.*")));
        }
        let (scenario, seed) = (header.config.scenario.clone(), header.seed());
        Self { run: run.to_owned(), scenario, seed, started_unix_s, files, end: None }
    }

    /// Reads the marker of a folder; of one from before there were markers, what
    /// its log says. `None`: it is not the folder of a run.
    #[must_use]
    pub fn of(folder: &Path) -> Option<Self> {
        let json = rusty_contract::input::read(&folder.join(MARKER)).ok();
        if let Some(marker) = json.and_then(|json| serde_json::from_slice(&json).ok()) {
            return Some(marker);
        }
        let log = folder.join("run.log");
        let header = LogReader::open(&log).ok()?.header().clone();
        let changed = fs::metadata(&log).ok()?.modified().ok()?;
        let started = changed.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let run = folder.file_name().unwrap_or_default().to_string_lossy();
        Some(Self::started_at(started, &run, &header))
    }

    /// Whether an entry of the folder belongs to the run.
    pub(super) fn covers(&self, name: &str) -> bool {
        let name = Replacement::target_of(name).unwrap_or(name);
        self.files.iter().any(|file| match file.strip_suffix(".*") {
            Some(stem) => {
                name.strip_prefix(stem).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            }
            None => name == file,
        })
    }
}
