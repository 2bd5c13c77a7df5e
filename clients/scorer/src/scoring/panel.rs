//! Beside the map: what is what, and the scores in a table.

use rusty_contract::score::{Score, degrees, metres, seconds};
use rusty_geometry::Material;
use rusty_plot::floor::draw_robot;
use rusty_plot::style::{
    DOOR, GLASS, GRID, INK, Look, RGBColor, SOFT_INK, TRUTH, TRUTH_WIDTH, WALL,
};
use rusty_plot::{Anchor, Canvas, PlotError, Px, Rect};

use super::beliefs::Mark;
use super::map::{View, draw_echo, draw_possible, possible_look};
use super::timeline::Timeline;
use super::trace::RunTrace;

const LEGEND_ROW: f64 = 24.0;
/// Longest entry that somebody else chose a part of, characters.
const LONGEST_ENTRY: usize = 21;
const TABLE_HEAD: f64 = 62.0;
const NOTES: f64 = 88.0;
const TABLE_ROW: f64 = 22.0;
/// Rows of a table that would not fit beside the largest map.
const NARROW_ROW: f64 = 17.0;

/// An entry of the legend.
enum Entry {
    Line(RGBColor, f64),
    Robot { started: bool },
    Scan,
    Possible(Look),
}

/// The panel: entries of the legend, and where its parts begin.
pub(super) struct Panel<'a> {
    trace: &'a RunTrace,
    scores: &'a [Score],
    entries: Vec<(Entry, String)>,
}

impl<'a> Panel<'a> {
    pub fn new(trace: &'a RunTrace, scores: &'a [Score], view: &View, time: &Timeline) -> Self {
        let mut entries = Vec::new();
        if trace.ticks_with_truth() > 0 {
            entries.push((Entry::Line(TRUTH, TRUTH_WIDTH), "true path".to_owned()));
            entries.push((Entry::Robot { started: true }, "start".to_owned()));
            entries.push((Entry::Robot { started: false }, "end".to_owned()));
        }
        let drawn = trace.last_scan.as_ref().filter(|_| !view.scan.is_empty());
        if let Some(&at_s) = drawn.and_then(|(tick, _)| trace.time_s.get(*tick)) {
            let at_s = at_s - time.origin_s;
            entries.push((Entry::Scan, format!("scan at {at_s:.2} s")));
        }
        for (k, track) in trace.beliefs.iter().enumerate() {
            let Some(moment) = track.moments.last() else { continue };
            let words = format!("{}, {}", moment.kind, track.name);
            let words = words.chars().take(LONGEST_ENTRY).collect();
            entries.push((Entry::Possible(possible_look(trace, k)), words));
        }
        for (name, (ink, width), is_it) in [
            ("wall", WALL, (|m| m == Material::Wall) as fn(Material) -> bool),
            ("glass", GLASS, |m| m == Material::Glass),
            ("door", DOOR, |m| matches!(m, Material::Door(_))),
        ] {
            if trace.world.walls.iter().any(|wall| is_it(wall.material)) {
                entries.push((Entry::Line(ink, width), name.to_owned()));
            }
        }
        Self { trace, scores, entries }
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
    pub fn draw(
        &self,
        canvas: &mut Canvas<'_>,
        area: &Rect,
        time: &Timeline,
        left_map: bool,
    ) -> Result<(), PlotError> {
        for (k, (entry, name)) in self.entries.iter().enumerate() {
            let rows = self.legend_rows();
            let column = area.left + 0.5 * area.width() * (k / rows) as f64;
            let at = [column, area.top + LEGEND_ROW * ((k % rows) as f64 + 0.5)];
            draw_entry(canvas, at, entry)?;
            canvas.text([at[0] + 44.0, at[1] + 4.5], Anchor::Start, 13.0, &INK, name)?;
        }
        let top = area.top + self.legend_height() + TABLE_HEAD;
        self.draw_head(canvas, area, top)?;
        let mut y = top;
        for (i, name) in self.trace.names.iter().enumerate() {
            self.draw_row(canvas, area, y + 0.5 * self.row(), (i, name))?;
            y += self.row();
        }
        if self.trace.names.is_empty() {
            let at = [area.left, y + 15.0];
            canvas.text(at, Anchor::Start, 13.0, &SOFT_INK, "nobody estimates the pose")?;
            y += self.row();
        }
        self.draw_notes(canvas, area.left, y + 20.0, time, left_map)
    }

    /// Right edges of the columns of figures.
    fn columns(area: &Rect) -> [f64; 4] {
        [-152.0, -101.0, -51.0, 0.0].map(|from_right| area.right + from_right)
    }

    fn draw_head(&self, canvas: &mut Canvas<'_>, area: &Rect, y: f64) -> Result<(), PlotError> {
        let columns = Self::columns(area);
        let size = 12.0;
        for (x, above, below) in [
            (columns[0], "final", "m"),
            (columns[1], "final", "deg"),
            (columns[2], "ATE", "m"),
            (columns[3], "scored", "%"),
        ] {
            canvas.text([x, y - 25.0], Anchor::End, size, &SOFT_INK, above)?;
            canvas.text([x, y - 10.0], Anchor::End, size, &SOFT_INK, below)?;
        }
        canvas.text([area.left, y - 10.0], Anchor::Start, size, &SOFT_INK, "error of")?;
        canvas.line(&[[area.left, y - 3.0], [area.right, y - 3.0]], &SOFT_INK, 1.0)
    }

    fn draw_row(
        &self,
        canvas: &mut Canvas<'_>,
        area: &Rect,
        y: f64,
        (index, name): (usize, &str),
    ) -> Result<(), PlotError> {
        let look = Look::of(index, self.trace.names.len());
        let columns = Self::columns(area);
        canvas.line(&[[area.left, y], [area.left + 28.0, y]], &look.ink, look.width)?;
        look.mark(canvas, [area.left + 14.0, y], 4.2)?;
        let room = columns[0] - 42.0 - (area.left + 36.0);
        // A letter is about 0.55 of its size wide in the wider ones of usual fonts.
        let letters = name.chars().count().max(1) as f64;
        let size = (room / (0.55 * letters)).min(13.0);
        canvas.text([area.left + 36.0, y + 4.5], Anchor::Start, size, &INK, name)?;
        let score = self.scores.iter().find(|score| score.name == name);
        let truths = self.trace.ticks_with_truth() as f64;
        let share = score.filter(|_| truths > 0.0).map(|s| 100.0 * s.scored_ticks as f64 / truths);
        for (x, text) in columns.into_iter().zip([
            number(score.and_then(|s| s.final_position_error_m), metres),
            number(score.and_then(|s| s.final_heading_error_deg), degrees),
            number(score.and_then(|s| s.ate_rmse_m), metres),
            number(share, percent),
        ]) {
            canvas.text([x, y + 4.5], Anchor::End, 13.0, &INK, &text)?;
        }
        let below = y + 0.5 * self.row();
        canvas.line(&[[area.left, below], [area.right, below]], &GRID, 1.0)
    }

    fn draw_notes(
        &self,
        canvas: &mut Canvas<'_>,
        x: f64,
        y: f64,
        time: &Timeline,
        left_map: bool,
    ) -> Result<(), PlotError> {
        let mut notes = Vec::new();
        if !self.trace.names.is_empty() {
            notes.push("ATE: rmse of the position error. Alignment: none.".to_owned());
        }
        if !self.trace.names.is_empty() && self.trace.ticks() > 1 {
            let every = time.mark_every_s;
            notes.push(format!("A mark every {} s, the same on map and errors;", seconds(every)));
            notes.push("the large one is the last estimate.".to_owned());
        }
        if self.trace.has_covariances() {
            notes.push("Ellipses and bands: 95 %, by the covariances reported.".to_owned());
        }
        if !self.trace.beliefs.is_empty() {
            notes.push("Arrowheads: the last belief shown, as received.".to_owned());
        }
        if left_map {
            notes.push("An estimate leaves the map.".to_owned());
        }
        for (k, note) in notes.iter().enumerate() {
            let at = [x, y + 16.0 * k as f64];
            canvas.text(at, Anchor::Start, 12.0, &SOFT_INK, note)?;
        }
        Ok(())
    }
}

fn draw_entry(canvas: &mut Canvas<'_>, at: Px, entry: &Entry) -> Result<(), PlotError> {
    let [x, y] = at;
    match entry {
        Entry::Line(ink, width) => canvas.line(&[[x, y], [x + 32.0, y]], ink, *width),
        Entry::Robot { started } => draw_robot(canvas, [x + 12.0, y], 0.0, *started),
        Entry::Possible(look) => [4.0, 14.0, 24.0].into_iter().try_for_each(|right| {
            draw_possible(canvas, look, [x + right, y], &Mark { share: 1.0, ..Mark::NOWHERE })
        }),
        Entry::Scan => {
            for k in 0..4 {
                draw_echo(canvas, [x + 4.0 + 8.0 * f64::from(k), y])?;
            }
            Ok(())
        }
    }
}

/// Percent without decimals; 100 only if nothing is missing, 0 only if all is.
fn number(value: Option<f64>, shown: fn(f64) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), |v| shown(v).replace('-', "−"))
}

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
