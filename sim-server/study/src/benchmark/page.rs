//! Several results as a page: the leaderboard, and the figures of every scenario drawn.

use std::fmt::Write as _;

use rusty_plot::assets::LOOK_CSS;
use rusty_plot::page::{Legend, draw_title};
use rusty_plot::style::Look;
use rusty_plot::{escaped, paint};

use super::leaderboard::{LeaderboardText, Standing};
use super::result::BenchmarkResult;
use super::standings::Place;
use super::suite::{Suite, SuiteScenario};
use super::track::Track;
use crate::page::{Distribution, MARGIN_LEFT, TOP, WIDTH, draw_distributions, frame};
use crate::versus::Metric;

const HEIGHT: f64 = 200.0;
/// After [`LOOK_CSS`]. Drawings are white in the dark, too, and wider than a phone.
const STYLE: &str = "body { max-width: 1240px; padding: 1rem; } h2 { overflow-wrap: anywhere; } \
                     pre, .drawing { overflow-x: auto; } \
                     svg { display: block; min-width: 44rem; max-width: 100%; height: auto; }";

/// Returns the page, a complete file of hypertext without scripts. `results` are those of
/// the leaderboard.
#[must_use]
pub fn page(
    suite: &Suite,
    results: &[(String, BenchmarkResult)],
    standings: &[Standing],
) -> String {
    let title = format!("sim-server benchmark, suite {}", suite.version);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'unsafe-inline'\">\n<title>{title}</title>\n\
         <style>\n{LOOK_CSS}{STYLE}</style>\n</head>\n\
         <body>\n<h1>{title}</h1>\n<pre>{}</pre>\n",
        preformatted(&LeaderboardText(standings).to_string())
    );
    let Some((_, first)) = results.first() else { return page + "</body>\n</html>\n" };
    for (scenario, track) in first.selection.blocks(suite) {
        let heading = format!("{}, {}: {}", scenario.name, track.word(), scenario.about);
        let drawing = drawing(suite, results, scenario, track);
        let _ = writeln!(
            page,
            "<h2>{}</h2>\n<div class=\"drawing\">\n{drawing}</div>",
            escaped(&heading)
        );
    }
    for (file, result) in results {
        let digest = &result.suite_digest;
        let confined = if result.confined { "confined" } else { "not confined" };
        let part = if result.selection.whole { "whole suite" } else { "part of the suite" };
        let heading = format!("{file}: {part}, {confined}, suite {digest}, {}", result.writer);
        let text = preformatted(&result.to_string());
        let _ = writeln!(page, "<h2>{}</h2>\n<pre>{}</pre>", escaped(&heading), text);
    }
    page + "</body>\n</html>\n"
}

/// Escapes a text whose lines stay.
fn preformatted(text: &str) -> String {
    text.lines().map(escaped).collect::<Vec<_>>().join("\n")
}

/// Draws the figures of all entries in a scenario, metric by metric.
fn drawing(
    suite: &Suite,
    results: &[(String, BenchmarkResult)],
    scenario: &SuiteScenario,
    track: Track,
) -> String {
    let metrics = scenario.metrics(track);
    let scored = |result: &BenchmarkResult, name: &str| {
        let mut scores = result.scores.iter();
        scores.any(|s| s.scenario == scenario.name && s.track == track && s.entry == name)
    };
    let mut shown: Vec<(&BenchmarkResult, &str)> = Vec::new();
    for (place, (_, result)) in results.iter().enumerate() {
        let own = result.entries_at(place).filter(|e| scored(result, &e.name));
        shown.extend(own.map(|e| (result, e.name.as_str())));
    }
    let title = format!("{}, {}", scenario.name, track.word());
    let top = TOP + 44.0;
    paint((WIDTH, top + HEIGHT + 68.0), &title, |canvas| {
        draw_title(canvas, MARGIN_LEFT, &title, "share of the runs; failed runs count as never");
        let mut legend = Legend { at: [MARGIN_LEFT, TOP + 2.0] };
        for (place, (_, name)) in shown.iter().enumerate() {
            legend.estimator(canvas, name, &Look::of(place, shown.len()));
        }
        for (column, metric) in metrics.iter().enumerate() {
            let distribution = |(place, (result, name)): (usize, &(&BenchmarkResult, &str))| {
                let look = Look::of(place, shown.len());
                let place = Place::new(suite, (scenario, track), &result.runs);
                // NaN of a run without a figure.
                let value = |run| place.figure(run, *metric).unwrap_or(f64::NAN);
                let values = place.runs_of(name).map(|run| metric.scale() * value(run)).collect();
                Distribution { look, values }
            };
            let all: Vec<Distribution> = shown.iter().enumerate().map(distribution).collect();
            let heading = format!("{}{}", metric.words(), unit(*metric));
            let frame = frame(column, metrics.len(), top, HEIGHT);
            draw_distributions(canvas, frame, &all, (&heading, ""));
        }
    })
}

fn unit(metric: Metric) -> String {
    match metric.shown_unit().trim() {
        "" => String::new(),
        unit => format!(" ({unit})"),
    }
}
