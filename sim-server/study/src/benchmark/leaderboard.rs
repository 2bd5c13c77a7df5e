//! Several results in a table.

use std::fmt;

use rusty_contract::TextTable;
use serde::Serialize;

use super::error::BenchmarkError;
use super::result::BenchmarkResult;
use super::standings::{Place, Side};
use super::suite::Suite;
use super::track::Track;

/// An entry in a track.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// The track.
    pub track: Track,
    /// Name of the entry.
    pub entry: String,
    /// File of its result; of a baseline the first.
    pub file: String,
    /// Whether it is the reference of the track, with which all are compared.
    pub is_reference: bool,
    /// Scenarios in which it is better than the reference, in which neither is shown to be,
    /// and in which it is worse.
    pub scenarios: [usize; 3],
    /// Geometric mean over the scenarios of the mean figure over the reference's; less than
    /// 1 is better. Runs without a figure do not count here.
    pub relative_error: Option<f64>,
    /// Ticks that were answered, over those that the baseline answered that answered most.
    pub answered: Option<f64>,
    /// Whether the kernel confined it.
    pub confined: bool,
    /// Whether it could read files that were named for it.
    pub with_files: bool,
    /// Runs that failed.
    pub failed: usize,
    /// Runs without a figure that did not fail.
    pub without: usize,
    /// Median over the runs of the 99th percentile of the compute time as reported, s.
    pub compute_p99_s: Option<f64>,
}

/// Returns the standings of all entries of the results, track by track, the best first: by
/// scenarios better less worse, then by relative error. Baselines are those of the first.
///
/// # Errors
/// [`BenchmarkError::OtherSuite`] if two results are of other runs.
pub fn leaderboard(
    suite: &Suite,
    results: &[(String, BenchmarkResult)],
) -> Result<Vec<Standing>, BenchmarkError> {
    let Some((_, first)) = results.first() else { return Ok(Vec::new()) };
    let mut all: Vec<Standing> = Vec::new();
    for (place, (file, result)) in results.iter().enumerate() {
        if result.selection != first.selection {
            return Err(BenchmarkError::OtherSuite {
                path: file.clone(),
                expected: described(first),
                found: described(result),
                remedy: "compare results of the same scenarios, tracks, seeds and key",
            });
        }
        for entry in result.entries_at(place) {
            let tracks = Track::ALL.into_iter();
            let name = &entry.name;
            all.extend(tracks.filter_map(|track| standing(suite, result, (file, name), track)));
        }
    }
    all.sort_by(|a, b| {
        let surplus = |s: &Standing| s.scenarios[0] as i64 - s.scenarios[2] as i64;
        let error = |s: &Standing| s.relative_error.unwrap_or(f64::INFINITY);
        let by_wins = surplus(b).cmp(&surplus(a));
        a.track.cmp(&b.track).then(by_wins).then(error(a).total_cmp(&error(b)))
    });
    Ok(all)
}

fn described(result: &BenchmarkResult) -> String {
    let selection = &result.selection;
    let tracks: Vec<&str> = selection.tracks.iter().map(|t| t.word()).collect();
    let key = selection.key.as_ref().map_or(String::new(), |key| format!(", key {key:?}"));
    let scenarios = selection.scenarios.join(" ");
    format!("{} seeds of {scenarios} ({}){key}", selection.seeds, tracks.join(" "))
}

fn standing(
    suite: &Suite,
    result: &BenchmarkResult,
    (file, entry): (&str, &str),
    track: Track,
) -> Option<Standing> {
    let verdicts = result.verdicts.iter();
    let verdicts = || verdicts.clone().filter(|v| v.track == track && v.decides && v.is_reference);
    let own: Vec<_> = verdicts().filter(|v| v.entry == entry).collect();
    let is_reference = verdicts().any(|v| v.baseline == entry);
    if own.is_empty() && !is_reference {
        return None;
    }
    let count = |side: Option<Side>| own.iter().filter(|v| v.better == side).count();
    let ratios: Vec<f64> = own
        .iter()
        .filter_map(|v| match v.means {
            [Some(reference), Some(own)] if reference > 0.0 && own > 0.0 => Some(own / reference),
            _ => None,
        })
        .collect();
    let logarithms = ratios.iter().map(|ratio| rusty_geometry::trig::ln(*ratio)).sum::<f64>();
    let mean = rusty_geometry::trig::exp(logarithms / ratios.len() as f64);
    let scores = result.scores.iter().filter(|s| s.track == track && s.entry == entry);
    let decisive = scores.filter(|s| {
        let mut first = result.verdicts.iter().filter(|v| v.decides && v.track == track);
        first.any(|v| v.scenario == s.scenario && v.metric == s.metric)
    });
    let (failed, without) =
        decisive.fold((0, 0), |(failed, without), s| (failed + s.failed, without + s.without));
    let runs = result.runs.iter().filter(|r| r.entry == entry && r.map == track.map());
    let mut compute: Vec<f64> = runs.filter_map(|r| r.compute_p99_s).collect();
    Some(Standing {
        track,
        entry: entry.to_owned(),
        file: file.to_owned(),
        is_reference,
        scenarios: [count(Some(Side::Entry)), count(None), count(Some(Side::Baseline))],
        relative_error: match is_reference {
            true => Some(1.0),
            false => (!ratios.is_empty()).then_some(mean),
        },
        answered: answered(suite, result, entry, track),
        confined: result.confined,
        with_files: result.entries.iter().any(|e| e.name == entry && !e.files.is_empty()),
        failed,
        without,
        compute_p99_s: rusty_metrics::percentile(&mut compute, 0.5),
    })
}

/// Answered ticks of an entry in a track, over the most that a baseline answered there.
fn answered(suite: &Suite, result: &BenchmarkResult, entry: &str, track: Track) -> Option<f64> {
    let (mut own, mut most) = (0.0, 0.0);
    for block in result.selection.blocks(suite).filter(|(_, of)| *of == track) {
        let place = Place::new(suite, block, &result.runs);
        for run in place.runs_of(entry) {
            own += run.answered_ticks as f64;
            most += place.most_answered(run) as f64;
        }
    }
    (most > 0.0).then(|| own / most)
}

/// The standings as a text for people.
pub struct LeaderboardText<'a>(pub &'a [Standing]);

impl fmt::Display for LeaderboardText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = TextTable::new(
            "track  entry  >better  >undecided  >worse  >relative error  >answered  >failed  \
             >without  >compute p99  file",
        );
        for s in self.0 {
            let [better, undecided, worse] = s.scenarios.map(|n| n.to_string());
            let [better, undecided, worse] = match s.is_reference {
                true => ["reference".to_owned(), String::new(), String::new()],
                false => [better, undecided, worse],
            };
            let error = s.relative_error.map_or("–".to_owned(), |e| format!("{e:.3}"));
            let answered = s.answered.map_or("–".to_owned(), |a| format!("{:.0} %", 100.0 * a));
            let confined = if s.confined { "" } else { " (unconfined)" };
            let files = if s.with_files { " (with files)" } else { "" };
            let entry = format!("{}{confined}{files}", s.entry);
            let compute =
                s.compute_p99_s.map_or("–".to_owned(), |t| format!("{:.3} ms", 1e3 * t));
            table.row(&[
                &s.track.word(),
                &entry,
                &better,
                &undecided,
                &worse,
                &error,
                &answered,
                &s.failed,
                &s.without,
                &compute,
                &s.file,
            ]);
        }
        write!(
            f,
            "{table}\nbetter, undecided, worse: scenarios, compared with the reference of the \
             track, seed by seed at 95 %; answered: ticks, over the most that a baseline answered"
        )
    }
}
