//! The report of a run: one file of hypertext that needs nothing else.
//!
//! In reading order:
//!
//! * `figures`: the map and the charts over time;
//! * `compute`: how long answers took, as a chart;
//! * `data`: the run, for the player; `beliefs`: what filters held possible; `drawn`: how
//!   an estimator is drawn;
//! * `sensors`: what the small sensors read;
//! * `table`: the scores; `key`: what is what on the map;
//! * `page.css`, `player.js`: how it looks, and the player, which draws with the code of
//!   the viewer's page ([`rusty_plot::assets`]). Without it the page is complete: it then
//!   shows the whole run and its end.
//!
//! The page requests nothing: its policy forbids it. Names that others
//! chose are shown, never run. The same run gives the same bytes.

mod beliefs;
mod compute;
mod data;
mod drawn;
mod figures;
mod key;
mod sensors;
mod table;

use std::fmt::Write as _;

use rusty_contract::log::{LogHeader, Source};
use rusty_contract::score::{ScoreReport, seconds};
use rusty_plot::assets::{DRAW_JS, LOOK_CSS, one_script};
use rusty_plot::escaped;
use rusty_plot::style::ON_DARK;

use crate::scoring::trace::{RunTrace, Whole};
use figures::Figures;

/// Writes the report of a run: its header, what was kept of it, and its scores.
pub fn html(header: &LogHeader, trace: &RunTrace, scores: &ScoreReport) -> String {
    let figures = Figures::of(header, trace);
    let times = compute::draw(&trace.names, &scores.scores);
    let mut page = String::with_capacity(1 << 18);
    write_head(&mut page, trace);
    write_title(&mut page, header, trace, scores);
    page.push_str("<main>\n");
    section(&mut page, "map", "Map", &map_part(trace, &figures));
    section(&mut page, "errors", "Errors over time", &errors_part(trace, &figures));
    page.push_str("<div class=\"pair\">\n");
    section(&mut page, "consistency", "Consistency", &consistency_part(trace, &figures));
    section(&mut page, "times", "Compute time", &times);
    page.push_str("</div>\n");
    if let Some(sensors) = sensors::draw(trace) {
        section(&mut page, "readings", "Small sensors", &sensors);
    }
    section(&mut page, "scores", "Scores", &table::table(&trace.names, scores));
    page.push_str("</main>\n");
    let _ = write!(
        page,
        "<footer><p>A link to a tick is this page's address and \
         <code>#tick=700</code>.</p></footer>\n\
         <script type=\"application/json\" id=\"data\">{}</script>\n\
         <script type=\"module\" nonce=\"{}\">\n{}</script>\n</body>\n</html>\n",
        figures.data,
        nonce(trace),
        one_script(&[DRAW_JS, include_str!("player.js")])
    );
    page
}

/// What the page's own script is known by. A person who chose a name in this run
/// could not know the digest.
fn nonce(trace: &RunTrace) -> String {
    let digest = trace.digest.chars().filter(char::is_ascii_hexdigit);
    "run".chars().chain(digest).collect()
}

fn write_head(page: &mut String, trace: &RunTrace) {
    let mut dark = String::new();
    for (light, ink) in ON_DARK {
        let _ = writeln!(dark, "  svg [fill=\"{light}\"] {{ fill: {ink}; }}");
        let _ = writeln!(dark, "  svg [stroke=\"{light}\"] {{ stroke: {ink}; }}");
    }
    let seed = trace.seed.map_or_else(String::new, |seed| format!(" · seed {seed}"));
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'unsafe-inline'; script-src 'nonce-{}'\">\n\
         <title>{}{seed}</title>\n<style>\n{LOOK_CSS}{}\
         @media screen and (prefers-color-scheme: dark) {{\n{dark}}}\n</style>\n</head>\n<body>\n",
        nonce(trace),
        escaped(&trace.scenario),
        include_str!("page.css")
    );
}

/// What the run was, and what identifies it.
fn write_title(page: &mut String, header: &LogHeader, trace: &RunTrace, scores: &ScoreReport) {
    let seed = trace.seed.map_or_else(|| "none".to_owned(), |seed| seed.to_string());
    let digest = match trace.digest.as_str() {
        "" => "not known",
        digest => digest,
    };
    let facts: String =
        facts(header, trace).iter().map(|fact| format!("<li>{}</li>", escaped(fact))).collect();
    let unscored = scores.unscored.as_ref().map_or_else(String::new, |why| {
        format!("<p class=\"note\">Unscored: {}.</p>\n", escaped(why))
    });
    let findings: String = header
        .findings()
        .iter()
        .map(|finding| {
            format!("<p class=\"note\">Finding: {}.</p>\n", escaped(&finding.to_string()))
        })
        .collect();
    let started = trace.origin.as_ref().map_or_else(String::new, |origin| {
        let command = match origin.command.as_str() {
            "" => String::new(),
            command => format!(" · <code>{}</code>", escaped(command)),
        };
        format!(" · started {} UTC{command}", escaped(&origin.started_utc))
    });
    let _ = write!(
        page,
        "<header>\n<h1>{}</h1>\n<dl class=\"identity\"><div><dt>seed</dt><dd>{}</dd></div>\
         <div><dt>digest</dt><dd><code>{}</code></dd></div></dl>\n\
         <ul class=\"facts\">{facts}</ul>\n<p class=\"origin\">{}{started}</p>\n{unscored}{findings}\
         <p class=\"note\" id=\"trouble\" role=\"alert\" hidden></p>\n</header>\n",
        escaped(&trace.scenario),
        escaped(&seed),
        escaped(digest),
        escaped(&header.writer)
    );
}

fn facts(header: &LogHeader, trace: &RunTrace) -> Vec<String> {
    let Whole { ticks, ticks_with_truth, driven_m } = trace.whole();
    let config = &header.config;
    let mut facts = vec![match &header.source {
        Source::Simulated => "simulated".to_owned(),
        Source::Forked { at_tick, .. } => format!("simulated, changed at tick {at_tick}"),
        Source::Recorded { format, file, .. } => format!("recorded by a robot ({format}, {file})"),
        Source::Blind { of, .. } => format!("handed out without its truth ({of})"),
    }];
    facts.push(match ticks {
        1 => "1 tick".to_owned(),
        ticks => format!("{ticks} ticks"),
    });
    if let (Some(first), Some(last)) = (trace.time_s.first(), trace.time_s.last()) {
        // The nominal times of the log, where the stamps of the recording stand still.
        let unit_s = if trace.is_in_ticks { config.dt_s } else { 1.0 };
        let span_s = unit_s * (last - first) + config.dt_s;
        if span_s.is_finite() {
            facts.push(format!("{span_s:.1} s"));
        }
    }
    if header.seed().is_some() {
        facts.push(format!("time step {} s", seconds(config.dt_s)));
    }
    if ticks_with_truth > 1 {
        facts.push(format!("{driven_m:.1} m driven"));
    }
    if ticks_with_truth < ticks {
        facts.push(format!("{ticks_with_truth} ticks with a known truth"));
    }
    if !trace.world.name.is_empty() {
        facts.push(format!("world {}", trace.world.name));
    }
    let lidar = &trace.lidar;
    facts.push(format!("{} beams, {} m", lidar.beams, lidar.range_max_m));
    if trace.thinned_from.is_some() {
        facts.push(format!("paths drawn from {} ticks", trace.tick_count()));
    }
    if (trace.stops.len() as u64) < ticks {
        facts.push(format!("{} ticks to look at", trace.stops.len()));
    }
    if !trace.reference.is_none() {
        facts.push(trace.reference.to_string());
    }
    facts
}

fn section(page: &mut String, id: &str, title: &str, inside: &str) {
    let _ = write!(
        page,
        "<section aria-labelledby=\"h-{id}\">\n<h2 id=\"h-{id}\">{title}</h2>\n{inside}</section>\n"
    );
}

/// A figure with a line below it.
pub(crate) fn figure(svg: &str, caption: &str) -> String {
    format!("<figure>\n{svg}<figcaption>{caption}</figcaption>\n</figure>\n")
}

fn map_part(trace: &RunTrace, figures: &Figures) -> String {
    let mut caption = "Seen from above.".to_owned();
    if !trace.names.is_empty() {
        caption.push_str(
            "<span class=\"still\"> Marks at equal times, the same on map and charts.</span>\
             <span class=\"live\"> Faded: the rest of the run.</span>",
        );
    }
    if trace.has_covariances() {
        caption
            .push_str(" The position lies in its ellipse with 95 %, by the covariance reported.");
    }
    caption.push_str(&figures.possible);
    if trace.from_log && trace.beliefs.is_empty() {
        caption.push_str(
            " What filters held possible is not part of a log: give the files that have it              with <code>--beliefs</code>.",
        );
    }
    if figures.left_map {
        caption.push_str(" An estimate leaves the map.");
    }
    let most = trace.stops.len().saturating_sub(1);
    let [width_m, height_m] = figures.size_m;
    let drawings = format!(
        "<canvas id=\"map\" role=\"img\" aria-label=\"Map\" \
         style=\"aspect-ratio: {width_m:.2} / {height_m:.2}\"></canvas>\n{}\
         <div id=\"control\" class=\"bar\" role=\"toolbar\" aria-label=\"Time and map\" hidden>\
         <button id=\"play\" type=\"button\" aria-keyshortcuts=\"Space\">Play</button>\
         <label>Pace <select id=\"pace\" autocomplete=\"off\"></select></label>\
         <label class=\"seek\"><span>Tick</span>\
         <input type=\"range\" id=\"tick\" autocomplete=\"off\" min=\"0\" max=\"{most}\" \
         step=\"1\" value=\"{}\"></label>\
         <button id=\"in\" type=\"button\" aria-label=\"Zoom in\">+</button>\
         <button id=\"out\" type=\"button\" aria-label=\"Zoom out\">−</button>\
         <button id=\"fit\" type=\"button\">Fit</button></div>\n\
         <p class=\"now\"><output id=\"now\" for=\"tick\">{}</output></p>\n",
        figures.map, figures.shown, figures.now
    );
    let mut part =
        format!("<div class=\"split\">\n{}<div class=\"beside\">\n", figure(&drawings, &caption));
    if !figures.possible.is_empty() {
        part.push_str("<p class=\"now\"><output id=\"beliefs\" for=\"tick\">");
        part.push_str(&escaped(&figures.possible_now));
        part.push_str("</output></p>\n");
    }
    part.push_str(&table::readout(trace, figures.shown));
    part.push_str(&key::list(trace));
    part.push_str("</div>\n</div>\n");
    part
}

fn errors_part(trace: &RunTrace, figures: &Figures) -> String {
    let band = match trace.has_covariances() {
        true => " Bands: 95 %, by the covariances reported.",
        false => "",
    };
    let kidnapped = match trace.kidnapped_at.is_empty() {
        true => "",
        false => " Dashes: the robot was put elsewhere.",
    };
    let [position, heading] = &figures.errors;
    format!(
        "<div class=\"charts\">\n{}{}</div>\n",
        figure(position, &format!("Distance between estimate and truth.{band}{kidnapped}")),
        figure(heading, &format!("Counter-clockwise is positive.{band}"))
    )
}

fn consistency_part(trace: &RunTrace, figures: &Figures) -> String {
    match &figures.nees {
        Some(nees) => figure(
            nees,
            "The squared error of the pose in units of its own covariance (NEES). Of an \
             estimator that knows how wrong it is, 95 % lie in the band (χ² with three degrees \
             of freedom, 0.216 to 9.348) and the mean is 3: above it is overconfident, below \
             conservative.",
        ),
        None if trace.has_covariances() => {
            "<p>No tick has both a covariance and a truth: unscored.</p>\n".to_owned()
        }
        None => "<p>No estimator of this run reported a covariance: unscored. An estimate with \
                 a covariance is compared with it here.</p>\n"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_beliefs;
