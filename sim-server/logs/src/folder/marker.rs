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
    /// The same as date and time.
    #[serde(default)]
    pub started_utc: String,
    /// Command line of the server, for a shell; empty where it is not known.
    #[serde(default)]
    pub command: String,
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
    /// The marker of a run that starts now, by the command line of this process.
    #[must_use]
    pub fn new(run: &str, header: &LogHeader) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let marker = Self::started_at(now.map_or(0, |since| since.as_secs()), run, header);
        Self { command: command_line(std::env::args()), ..marker }
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
        let (run, started_utc) = (run.to_owned(), date_and_time(started_unix_s));
        let command = String::new();
        Self { run, scenario, seed, started_unix_s, started_utc, command, files, end: None }
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

/// Seconds since 1970 as date and time in UTC (days to civil date: H. Hinnant,
/// *chrono-Compatible Low-Level Date Algorithms*).
#[must_use]
pub fn date_and_time(unix_s: u64) -> String {
    let (days, minutes) = (unix_s / 86_400 + 719_468, unix_s / 60 % 1440);
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = year + 400 * era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02}", minutes / 60, minutes % 60)
}

/// Returns the words of a command as a shell reads them, the program without its folder.
fn command_line(words: impl Iterator<Item = String>) -> String {
    let word = |(k, word): (usize, String)| {
        let word = if k == 0 { word.rsplit('/').next().unwrap_or_default() } else { &word[..] };
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./=:,+@%".contains(c);
        match !word.is_empty() && word.chars().all(is_plain) {
            true => word.to_owned(),
            false => format!("'{}'", word.replace('\'', "'\\''")),
        }
    };
    words.enumerate().map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_can_be_given_to_a_shell_again() {
        let words = ["/a/b/sim-server", "launch", "--add", "f=python3 it's.py", ""];
        let line = command_line(words.map(str::to_owned).into_iter());
        assert_eq!(line, r"sim-server launch --add 'f=python3 it'\''s.py' ''");
    }

    #[test]
    fn seconds_become_the_date_of_the_calendar() {
        // Values of `date -u -d @N '+%F %H:%M'`.
        for (unix_s, text) in [
            (0, "1970-01-01 00:00"),
            (951_782_400, "2000-02-29 00:00"),
            (1_709_251_199, "2024-02-29 23:59"),
            (4_107_542_400, "2100-03-01 00:00"),
        ] {
            assert_eq!(date_and_time(unix_s), text);
        }
    }
}
