//! Next to the map: the legend, and the scores in a table.

use rusty_contract::score::{Score, degrees, metres, seconds};
use rusty_plot::page::Rows;
use rusty_plot::style::{INK, Look, SOFT_INK};
use rusty_plot::{Anchor, Canvas, Rect};

use super::key::{Symbol, key, possible_symbol};
use super::map::View;
use super::timeline::Timeline;
use super::trace::RunTrace;

const LEGEND_ROW: f64 = 24.0;
/// Longest entry with a part that a user chose, characters.
const LONGEST_ENTRY: usize = 21;
const TABLE_HEAD: f64 = 62.0;
const NOTES: f64 = 88.0;
const TABLE_ROW: f64 = 22.0;
/// Rows of a table that would not fit next to the largest map.
const NARROW_ROW: f64 = 17.0;

/// The panel: entries of the legend, and where its parts begin.
pub(super) struct Panel<'a> {
    trace: &'a RunTrace,
    scores: &'a [Score],
    entries: Vec<(Symbol, String)>,
}

impl<'a> Panel<'a> {
    pub fn new(trace: &'a RunTrace, scores: &'a [Score], view: &View, time: &Timeline) -> Self {
        let drawn = trace.last_scan.as_ref().filter(|_| !view.scan.is_empty());
        let at_s = drawn.and_then(|(tick, _)| trace.time_s.get(*tick));
        let scan = at_s.map(|at_s| format!("scan at {}", time.words(at_s - time.origin_s)));
        let possible = trace.beliefs.iter().enumerate().filter_map(|(k, track)| {
            let words = format!("{}, {}", track.moments.last()?.kind, track.name);
            Some((possible_symbol(trace, k), words.chars().take(LONGEST_ENTRY).collect()))
        });
        Self {
            trace,
            scores,
            entries: key(trace, (Symbol::Robot { started: false }, "end"), scan, possible),
        }
    }

    fn has(&self, is_it: fn(&Symbol) -> bool) -> bool {
        self.entries.iter().any(|(symbol, _)| is_it(symbol))
    }

    fn row(&self) -> f64 {
        if self.trace.names.len() > 10 { NARROW_ROW } else { TABLE_ROW }
    }

    fn legend_rows(&self) -> usize {
        self.entries.len().div_ceil(2)
    }

    fn legend_height(&self) -> f64 {
        self.legend_rows() as f64 * LEGEND_ROW
    }

    /// The least height at which nothing is cut off.
    pub fn height(&self) -> f64 {
        let rows = self.trace.names.len().max(1) as f64;
        self.legend_height() + TABLE_HEAD + rows * self.row() + NOTES
    }

    /// Draws the panel. `left_map`: a believed path leaves the map.
    pub fn draw(&self, canvas: &mut Canvas, area: &Rect, time: &Timeline, left_map: bool) {
        for (k, (symbol, name)) in self.entries.iter().enumerate() {
            let rows = self.legend_rows();
            let column = area.left + 0.5 * area.width() * (k / rows) as f64;
            let at = [column, area.top + LEGEND_ROW * ((k % rows) as f64 + 0.5)];
            symbol.draw(canvas, at);
            canvas.text([at[0] + 44.0, at[1] + 4.5], Anchor::Start, 13.0, &INK, name);
        }
        let top = area.top + self.legend_height() + TABLE_HEAD;
        let columns = [-152.0, -101.0, -51.0, 0.0].map(|from_right| area.right + from_right);
        let rows = Rows { x: [area.left, area.right], columns: &columns, height: self.row() };
        rows.draw_head(
            canvas,
            top - 3.0,
            &[&["final", "m"], &["final", "deg"], &["ATE", "m"], &["scored", "%"]],
        );
        canvas.text([area.left, top - 10.0], Anchor::Start, 12.0, &SOFT_INK, "error of");
        let mut y = top;
        for (i, name) in self.trace.names.iter().enumerate() {
            let look = Look::of(i, self.trace.names.len());
            rows.draw(canvas, y + 0.5 * self.row(), (&look, name), &self.figures(name));
            y += self.row();
        }
        if self.trace.names.is_empty() {
            let at = [area.left, y + 15.0];
            canvas.text(at, Anchor::Start, 13.0, &SOFT_INK, "nobody estimates the pose");
            y += self.row();
        }
        self.draw_notes(canvas, area.left, y + 20.0, time, left_map)
    }

    /// The figures of an estimator.
    fn figures(&self, name: &str) -> [String; 4] {
        let score = self.scores.iter().find(|score| score.name == name);
        let truths = self.trace.ticks_with_truth() as f64;
        let share = score.filter(|_| truths > 0.0).map(|s| 100.0 * s.scored_ticks as f64 / truths);
        let number = |value: Option<f64>, text: fn(f64) -> String| {
            value.map_or_else(|| "–".to_owned(), text)
        };
        [
            number(score.and_then(|s| s.final_position_error_m), metres),
            number(score.and_then(|s| s.final_heading_error_deg), degrees),
            number(score.and_then(|s| s.ate_rmse_m), metres),
            number(share, percent),
        ]
    }

    fn draw_notes(&self, canvas: &mut Canvas, x: f64, y: f64, time: &Timeline, left_map: bool) {
        let mut notes = Vec::new();
        if !self.trace.names.is_empty() {
            notes.push("ATE: rmse of the position error. Alignment: none.".to_owned());
        }
        if !self.trace.names.is_empty() && self.trace.tick_count() > 1 {
            let (every, unit) = (seconds(time.mark_every_s), time.unit());
            notes.push(format!("A mark every {every} {unit}, the same on map and errors;"));
            notes.push("the large one is the last estimate.".to_owned());
        }
        if self.trace.has_covariances() {
            notes.push("Ellipses and bands: 95 %, by the covariances reported.".to_owned());
        }
        for (what, is_there) in [
            ("Bars", self.has(|symbol| matches!(symbol, Symbol::Bars(_)))),
            ("Arrowheads", self.has(|symbol| matches!(symbol, Symbol::Possible(_)))),
        ] {
            if is_there {
                notes.push(format!("{what}: the last belief shown, as received."));
            }
        }
        if left_map {
            notes.push("An estimate leaves the map.".to_owned());
        }
        for (k, note) in notes.iter().enumerate() {
            let at = [x, y + 16.0 * k as f64];
            canvas.text(at, Anchor::Start, 12.0, &SOFT_INK, note);
        }
    }
}

/// Percent without decimals; 100 only if nothing is missing, 0 only if all is.
fn percent(share: f64) -> String {
    match share {
        s if s > 99.0 && s < 100.0 => ">99".to_owned(),
        s if s > 0.0 && s < 1.0 => "<1".to_owned(),
        s => format!("{s:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::percent;

    #[test]
    fn a_hundred_percent_means_all() {
        let texts = [100.0, 99.99, 50.4, 0.01, 0.0].map(percent);
        assert_eq!(texts, ["100", ">99", "50", "<1", "0"]);
    }
}
