//! The figures that the commands of a page print.

use rusty_tests::*;

/// The longest that a command may take; it only ends what hangs.
const LIMIT: Duration = Duration::from_secs(7200);

/// The figures of an estimator under one setting of a command.
pub struct Figures {
    command: String,
    estimator: String,
    /// Values of the swept fields.
    settings: Vec<Value>,
    /// Fields of the overview of a sweep.
    pub values: Value,
}

impl Figures {
    /// Keeps those that a word of the page names: by the estimator, a setting or a part of
    /// the command.
    pub fn named<'a>(all: Vec<&'a Self>, word: &&str) -> Vec<&'a Self> {
        let ways: [fn(&Self, &str) -> bool; 3] = [
            |figures, word| figures.estimator == word,
            |figures, word| figures.settings.iter().any(|value| value == word),
            |figures, word| figures.command.contains(word),
        ];
        let kept = ways.map(|way| all.iter().filter(|f| way(f, word)).copied().collect());
        kept.into_iter().find(|kept: &Vec<_>| !kept.is_empty()).unwrap_or_default()
    }
}

/// Runs lines of a page in a folder; returns the document that the last one prints.
fn document(lines: &str, folder: &Path) -> Value {
    let path = format!("{}:{}", arg(binaries()), std::env::var("PATH").unwrap());
    let mut shell = Command::new("bash");
    shell.current_dir(folder).env("PATH", path);
    shell.args(["-c", &format!("set -e\n{} --json", lines.trim_end().replace('\n', " >&2\n"))]);
    Process::spawn(&mut shell).wait_within(LIMIT).expect(0).json()
}

/// Runs a sweep as it is written on the page.
pub fn sweep(command: &str) -> Vec<Figures> {
    let report = &document(command, &repository())["report"];
    let pairs = list(report, "overview").iter().zip(list(report, "consistency"));
    let figures = pairs.map(|(overview, consistency)| {
        let mut values = overview.clone();
        assert_eq!(overview["estimator"], consistency["estimator"]);
        values["last"] = consistency["last"].clone();
        values["nis"] = consistency["nis"].clone();
        for part in ["answered", "wrong"] {
            values[format!("{part}_percent")] = overview[part].as_f64().map(|p| 100.0 * p).into();
        }
        values["level_percent"] = json!(100.0 * number(consistency, "level"));
        // The mean over a run has no use where the robot was carried away, and without that
        // there is no recovery.
        let is_kidnapped = number(overview, "kidnapped") > 0.0;
        values[if is_kidnapped { "nees" } else { "recovered" }] = Value::Null;
        let settings = list(overview, "parameters").iter().map(|pair| pair[1].clone());
        Figures {
            command: command.to_owned(),
            estimator: text(overview, "estimator").to_owned(),
            settings: settings.collect(),
            values,
        }
    });
    figures.collect()
}

/// Imports a recording and replays it by the lines of the page, which are for the log
/// `intel`. Returns nothing, with a printed reason, on a machine without the recording.
pub fn replay(lines: &[String], log: &str) -> Vec<Figures> {
    let file = format!("{log}-corrected.log.gz");
    let Some(recording) = real_data(&file) else { return Vec::new() };
    let (place, command) = (folder(), lines.join("\n").replace("intel", log));
    fs::copy(recording, place.at(file)).unwrap();
    let report = document(&command, place.path());
    let figures = list(&report, "scores").iter().map(|score| {
        let [none, se2] = ["none", "se2"].map(|by| number(&score["ate"][by], "translation_m.rmse"));
        let per_metre = &score["rpe"]["per_metre"];
        let values = json!({
            "scored_ticks": score["scored_ticks"],
            "ate_rmse_m": none,
            "ate_se2_rmse_m": se2,
            "rpe_per_metre_rmse_m": per_metre["translation_m"]["rmse"],
            "rpe_per_metre_rmse_rad": per_metre["rotation_rad"]["rmse"],
            "nees": score["nees"]["mean"],
            "verdict": score["nees"]["verdict"],
        });
        let (estimator, settings) = (text(score, "name").to_owned(), Vec::new());
        Figures { command: command.clone(), estimator, settings, values }
    });
    figures.collect()
}
