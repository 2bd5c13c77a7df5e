//! The tables of the page: the scores, a column for each estimator, and the
//! errors at the chosen tick.

use std::fmt::Write as _;
use std::ops::Range;

use rusty_contract::score::{
    ComputeTimes, Consistency, Durations, Figures, PoseErrors, Score, ScoreReport, degrees,
    duration, metres,
};
use rusty_plot::style::{Look, figure};
use rusty_plot::{Drawing, Layer, escaped};

use crate::scoring::bands;
use crate::scoring::trace::RunTrace;

/// What stands where there is nothing to say.
const UNSCORED: &str = "unscored";

/// The most estimators that fit next to each other on paper.
const MOST_COLUMNS: usize = 6;

/// A cell: its text (of our own making, so it is not escaped), and the number in
/// it that is the better the smaller it is.
struct Cell {
    text: String,
    value: Option<f64>,
}

/// A row: its name, and how a score fills a cell of it.
type Row = (&'static str, fn(&Score) -> Cell);

/// The groups of rows, in the order in which one asks for them.
const GROUPS: [(&str, &[Row]); 6] = [
    (
        "Where it ended",
        &[
            ("alignment", |s| plain(s.alignment.word().to_owned())),
            ("final position error", |s| number(judged(s).final_position_error_m, "m")),
            ("final heading error", |s| angle(judged(s).final_heading_error_rad)),
            ("drift, of the distance driven", |s| match s.drift_percent {
                Some(_) => number(s.drift_percent, "%"),
                None => plain("–".to_owned()),
            }),
        ],
    ),
    (
        "Over the run",
        &[
            ("mean position error", |s| number(judged(s).mean_position_error_m, "m")),
            ("position error, 95th percentile", |s| number(judged(s).p95_position_error_m, "m")),
            ("greatest position error", |s| number(judged(s).max_position_error_m, "m")),
            ("heading error, rmse", |s| angle(judged(s).rmse_heading_error_rad)),
            ("greatest heading error", |s| angle(judged(s).max_heading_error_rad)),
            ("ticks scored", |s| plain(s.scored_ticks.to_string())),
            ("ticks without an estimate", |s| plain(s.unscored_ticks.to_string())),
            ("ticks with a wrong estimate", |s| plain(s.wrong_ticks.to_string())),
        ],
    ),
    (
        "Trajectory error, rmse",
        &[
            ("ATE, alignment none", |s| match &s.ate.none {
                Some(errors) => poses(Some(errors)),
                None => number(s.ate_rmse_m, "m"),
            }),
            ("ATE, alignment origin", |s| poses(s.ate.origin.as_ref())),
            ("ATE, alignment SE(2)", |s| poses(s.ate.se2.as_ref())),
            ("RPE per tick", |s| match &s.rpe.per_tick {
                Some(errors) => poses(Some(errors)),
                None => pair(s.rpe_rmse_m, s.rpe_rmse_deg),
            }),
            ("RPE per metre", |s| poses(s.rpe.per_metre.as_ref())),
        ],
    ),
    (
        "Consistency",
        &[
            ("NEES", |s| verdict(s.nees.as_ref())),
            ("NEES, mean, and where it should be", |s| mean(s.nees.as_ref())),
            ("NEES, ticks in the band", |s| within(s.nees.as_ref())),
            ("NIS", |s| verdict(s.nis.as_ref())),
            ("NIS, mean, and where it should be", |s| mean(s.nis.as_ref())),
        ],
    ),
    (
        "Finding the robot",
        &[
            ("found after", |s| match &s.convergence {
                Some(found) => after(found.after_s),
                None => unscored(),
            }),
            ("position rmse from there on", |s| {
                number(s.convergence.as_ref().and_then(|c| c.position_rmse_m), "m")
            }),
            ("found again after a kidnapping", recoveries),
        ],
    ),
    (
        "Compute time per tick",
        &[
            ("reported, median and 99 %", |s| times(s, |c| c.reported)),
            ("observed, median and 99 %", |s| times(s, |c| c.observed)),
        ],
    ),
];

fn plain(text: String) -> Cell {
    Cell { text, value: None }
}

fn unscored() -> Cell {
    plain(format!("<span class=\"none\">{UNSCORED}</span>"))
}

fn number(value: Option<f64>, unit: &str) -> Cell {
    match value {
        Some(v) => Cell { text: format!("{} {unit}", shown(v, unit)), value },
        None => unscored(),
    }
}

fn angle(radians: Option<f64>) -> Cell {
    number(radians.map(f64::to_degrees), "°")
}

/// The errors by which an estimator is judged.
fn judged(score: &Score) -> Figures {
    score.figures(score.alignment)
}

fn shown(value: f64, unit: &str) -> String {
    let number = if unit == "m" { metres } else { degrees };
    number(value).replace('-', "−")
}

fn pair(metres: Option<f64>, degrees: Option<f64>) -> Cell {
    match (metres, degrees) {
        (Some(m), Some(deg)) => Cell {
            text: format!("{} m <small>{} °</small>", shown(m, "m"), shown(deg, "°")),
            value: metres,
        },
        _ => number(metres, "m"),
    }
}

fn poses(errors: Option<&PoseErrors>) -> Cell {
    let metres = errors.map(|e| e.translation_m.rmse);
    pair(metres, errors.map(|e| e.rotation_rad.rmse.to_degrees()))
}

fn verdict(consistency: Option<&Consistency>) -> Cell {
    consistency.map_or_else(unscored, |c| {
        let word = c.verdict.word();
        plain(format!("<span class=\"{word}\">{word}</span>"))
    })
}

fn mean(consistency: Option<&Consistency>) -> Cell {
    consistency.map_or_else(unscored, |c| {
        let [low, high] = c.interval;
        let level = 100.0 * c.level;
        plain(format!(
            "{} <small>{} to {}, {level:.0} %</small>",
            figure(Some(c.mean)),
            figure(Some(low)),
            figure(Some(high))
        ))
    })
}

fn within(consistency: Option<&Consistency>) -> Cell {
    consistency.map_or_else(unscored, |c| plain(format!("{:.1} %", 100.0 * c.share_within)))
}

fn after(after_s: Option<f64>) -> Cell {
    match after_s {
        Some(s) => Cell { text: format!("{s:.2} s"), value: after_s },
        None => plain("never".to_owned()),
    }
}

fn recoveries(score: &Score) -> Cell {
    match &score.convergence {
        None => unscored(),
        Some(found) if found.recoveries.is_empty() => {
            plain("<span class=\"none\">not kidnapped</span>".to_owned())
        }
        Some(found) => {
            let each = found.recoveries.iter().map(|r| {
                format!("{} <small>tick {}</small>", after(r.after_s).text, r.kidnapped_at_tick)
            });
            plain(each.collect::<Vec<_>>().join("<br>"))
        }
    }
}

fn times(score: &Score, of: fn(&ComputeTimes) -> Durations) -> Cell {
    match score.compute.as_ref().map(of) {
        Some(d) => plain(format!("{} <small>{}</small>", duration(d.p50_s), duration(d.p99_s))),
        None => plain("<span class=\"none\">not in a log</span>".to_owned()),
    }
}

/// The scores: a column for each estimator, in as many tables as paper needs.
pub(super) fn table(names: &[String], report: &ScoreReport) -> String {
    if names.is_empty() {
        return "<p>Nobody estimated the pose.</p>\n".to_owned();
    }
    let scores: Vec<Option<&Score>> =
        names.iter().map(|name| report.scores.iter().find(|s| s.name == *name)).collect();
    let tables = names.len().div_ceil(MOST_COLUMNS);
    let most = names.len().div_ceil(tables);
    let mut text = String::new();
    for first in (0..names.len()).step_by(most) {
        let columns = first..names.len().min(first + most);
        let which = match tables {
            1 => "Scores".to_owned(),
            _ => format!("Scores, estimators {} to {}", first + 1, columns.end),
        };
        let _ = write!(
            text,
            "<div class=\"wide\" role=\"region\" aria-label=\"{which}\" tabindex=\"0\">\n\
             <table class=\"scores\">\n<thead><tr><td></td>"
        );
        for i in columns.clone() {
            let mark = swatch("head", i, names.len());
            let _ =
                write!(text, "<th scope=\"col\">{mark}<span>{}</span></th>", escaped(&names[i]));
        }
        text.push_str("</tr></thead>\n");
        write_groups(&mut text, &scores, columns);
        text.push_str("</table>\n</div>\n");
    }
    if names.len() > 1 {
        text.push_str("<p class=\"soft\">Bold: the least of all estimators.</p>\n");
    }
    text
}

/// The rows of some of the estimators, compared with all of them.
fn write_groups(text: &mut String, scores: &[Option<&Score>], columns: Range<usize>) {
    let across = columns.len() + 1;
    for (group, rows) in GROUPS {
        let _ = write!(
            text,
            "<tbody>\n<tr><th scope=\"rowgroup\" colspan=\"{across}\"><span>{group}</span></th></tr>\n"
        );
        for (name, fill) in rows {
            let cells: Vec<Cell> =
                scores.iter().map(|score| score.map_or_else(unscored, fill)).collect();
            write_row(text, name, &cells, columns.clone());
        }
        text.push_str("</tbody>\n");
    }
}

fn write_row(text: &mut String, name: &str, cells: &[Cell], columns: Range<usize>) {
    let values = || cells.iter().filter_map(|cell| cell.value);
    // Where all are the same none of them is the least.
    let (least, most) = (values().min_by(f64::total_cmp), values().max_by(f64::total_cmp));
    let least = least.filter(|_| least != most);
    let _ = write!(text, "<tr><th scope=\"row\">{name}</th>");
    for cell in &cells[columns] {
        match cell.value.is_some() && cell.value == least {
            true => {
                let _ = write!(text, "<td><b>{}</b></td>", cell.text);
            }
            false => {
                let _ = write!(text, "<td>{}</td>", cell.text);
            }
        }
    }
    text.push_str("</tr>\n");
}

/// The errors at a stop, and who is shown: a row for each estimator.
pub(super) fn readout(trace: &RunTrace, shown: usize) -> String {
    let mut text = "<table class=\"readout\" id=\"readout\">\n<caption>At this tick</caption>\n\
                    <thead><tr><th scope=\"col\">shown</th>\
                    <th scope=\"col\">position error, m</th><th scope=\"col\">heading error, °</th>\
                    <th scope=\"col\">NEES</th></tr></thead>\n<tbody>\n"
        .to_owned();
    if trace.names.is_empty() {
        text.push_str("<tr><th scope=\"row\">nobody estimates the pose</th></tr>\n");
    }
    for (i, name) in trace.names.iter().enumerate() {
        let stop = trace.stops.get(shown);
        let both = stop.and_then(|stop| stop.estimate(i).zip(stop.truth));
        let cells = both.map(|(estimate, truth)| {
            let believed = &estimate.pose_in_world;
            [
                Some(rusty_metrics::position_error_m(believed, &truth)),
                Some(rusty_metrics::heading_error_rad(believed, &truth).to_degrees()),
                bands::nees(&truth, estimate, &trace.reference),
            ]
        });
        let [position, heading, nees] = cells.unwrap_or_default();
        let cell = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
        };
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\"><label><input type=\"checkbox\" class=\"toggle\" \
             autocomplete=\"off\" checked disabled>{}<span>{}</span></label></th><td>{}</td><td>{}</td><td>{}</td></tr>",
            swatch("row", i, trace.names.len()),
            escaped(name),
            cell(position, 3),
            cell(heading, 2),
            cell(nees, 2)
        );
    }
    text.push_str("</tbody>\n</table>\n");
    text
}

/// How an estimator is drawn. `place` keeps the names of drawings apart.
fn swatch(place: &str, estimator: usize, count: usize) -> String {
    let look = Look::of(estimator, count);
    let mut drawing = Drawing::new((30.0, 16.0), &format!("{place}-{estimator}"));
    drawing.layer(&Layer::default(), |canvas| {
        look.swatch(canvas, [1.0, 8.0], 28.0, 4.6);
    });
    // Next to its name; a page that is read aloud needs no line.
    drawing.finish("", "", "class=\"swatch\" aria-hidden=\"true\"")
}
