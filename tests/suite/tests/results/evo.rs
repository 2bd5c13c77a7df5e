//! Scores compared with those of evo, on what `export tum` writes: equal to 10⁻⁹ in
//! every figure of every metric. The tables that are printed are in docs/metrics.md.

use rusty_tests::*;

/// Absolute up to 1, relative above.
const TOLERANCE: f64 = 1e-9;

const FIGURES: [&str; 7] = ["rmse", "mean", "median", "std", "min", "max", "sse"];
const PARTS: [&str; 2] = ["translation_m", "rotation_rad"];
/// Field of the score, and the option of evo.
const METRICS: [([&str; 2], &str); 5] = [
    (["ate", "none"], "APE"),
    (["ate", "origin"], "APE `--align_origin`"),
    (["ate", "se2"], "APE `--align`"),
    (["rpe", "per_tick"], "RPE `--delta 1 -u f`"),
    (["rpe", "per_metre"], "RPE `--delta 1 -u m`"),
];

/// The statistics of one metric and part, ours and evo's: a line of the table.
#[track_caller]
fn same(run: &str, metric: &str, part: &str, ours: &Value, theirs: &Value) -> String {
    assert_eq!(ours["count"], theirs["count"], "{run}: {metric}, {part}: count");
    assert!(ours["count"].as_u64().unwrap() > 10, "{run}: {metric}, {part}: {ours}");
    let mut greatest = 0.0_f64;
    for figure in FIGURES {
        let [our, their] = [ours, theirs].map(|of| number(of, figure));
        let off = (our - their).abs() / their.abs().max(1.0);
        assert!(off <= TOLERANCE, "{run}: {metric}, {part}, {figure}: {our:?} and {their:?} (evo)");
        greatest = greatest.max(off);
    }
    let rmse = |of: &Value| format!("{:.12}", number(of, "rmse"));
    let (count, part) = (&ours["count"], part.replace('_', ", "));
    let (their, our) = (rmse(theirs), rmse(ours));
    format!("| {run} | {metric} | {part} | {count} | {their} | {our} | {greatest:.0e} |\n")
}

/// Every estimator of a run, from its log and its scores.
#[track_caller]
fn beside_evo(python: &Path, run: &str, log: &Path, scores: &Value) -> String {
    let out = folder();
    let (log, to) = (arg(&log), arg(out.path()));
    let exported = sim_server(&["export", "tum", log, "-o", to, "--json"]).expect(0).json();
    let truth = out.at("truth.tum");
    let mut lines = String::new();
    for score in scores.as_array().unwrap() {
        let name = text(score, "name");
        let written = list(&exported, "files");
        let file = written.iter().find(|f| f["estimator"] == name).unwrap();
        assert_eq!(file["lines"], score["scored_ticks"], "{name}");
        let theirs = evo::measure(python, &truth, Path::new(text(file, "path")));
        for ([field, by], metric) in METRICS {
            for part in PARTS {
                let [ours, theirs] = [score, &theirs].map(|of| &of[field][by][part]);
                let run = format!("{run}, {name}");
                lines += &same(&run, metric, part, ours, theirs);
            }
        }
    }
    lines
}

fn print(lines: &str) {
    println!("\n| run | metric | part | errors | rmse (evo) | rmse (ours) | greatest difference |");
    println!("|---|---|---|---:|---:|---:|---:|\n{lines}");
}

#[test]
fn the_apartment_is_measured_as_evo_measures_it() {
    let Some(python) = evo::python() else { return };
    let out = folder();
    let add = format!("covariance={}", binary("04_covariance").display());
    // The usual run is nearly a line, which evo turns over in space.
    let set = ["--set", "script.kind=truth-steered-patrol", "--set", "script.leg_s=12.3"];
    let report = launch("evo", out.path(), &[&["--add", &add][..], &set].concat());
    let log = out.at("run.log");
    print(&beside_evo(python, "Apartment", &log, &report["scores"]));
}

#[test]
fn the_intel_lab_is_measured_as_evo_measures_it() {
    let Some(python) = evo::python() else { return };
    let Some(input) = real_data("intel-corrected.log.gz") else { return };
    let out = folder();
    let (log, to) = (out.at("intel.log"), out.at("run"));
    import(&input, &log, &[]).expect(0);
    let report = replay(&log, &to, &[]).expect(0).json();
    print(&beside_evo(python, "Intel", &to.join("run.log"), &report["scores"]));
}
