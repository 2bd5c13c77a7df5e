//! How long answers took: for each estimator the median, the 99th percentile
//! and the longest, as it says itself and as the server saw it.

use rusty_contract::score::{Durations, Score};
use rusty_plot::style::{INK, Look, SOFT_INK, WHITE};
use rusty_plot::{Anchor, Axes, Axis, Canvas, Drawing, Layer, Rect, shortened};

use super::figure;

const WIDTH: f64 = 480.0;
const LEFT: f64 = 84.0;
const TOP: f64 = 10.0;
/// Height of an estimator's rows: its name, and the two.
const NAME: f64 = 20.0;
const ROW: f64 = 18.0;
const EACH: f64 = NAME + 2.0 * ROW + 8.0;

/// The part of the page that is about compute times.
pub(super) fn draw(names: &[String], scores: &[Score]) -> String {
    let times: Vec<(usize, &Score)> = names
        .iter()
        .enumerate()
        .filter_map(|(i, name)| Some((i, scores.iter().find(|s| s.name == *name)?)))
        .filter(|(_, score)| score.compute.is_some())
        .collect();
    if times.is_empty() {
        return "<p>Not part of a log: how long answers took is known in a living run \
                   alone.</p>\n"
            .to_owned();
    }
    let height = TOP + EACH * times.len() as f64;
    let frame = Rect { left: LEFT, top: TOP, right: WIDTH - 14.0, bottom: height };
    let durations = || {
        let both = times.iter().filter_map(|(_, score)| score.compute);
        both.flat_map(|c| [c.reported, c.observed]).flat_map(|d| [d.p50_s, d.p99_s, d.max_s])
    };
    let shown = |s: f64| (s * 1e6).max(0.1);
    let least = durations().map(shown).fold(f64::INFINITY, f64::min);
    let most = durations().map(shown).fold(0.0, f64::max);
    let x = Axis::log([0.7 * least, 1.5 * most.max(10.0 * least)]);
    let axes = Axes { frame, x, y: Axis::plain([0.0, 1.0]) };
    let mut drawing = Drawing::new((WIDTH, height + 48.0), "compute");
    drawing.layer(&Layer::of("ground"), |canvas| {
        axes.draw_grid(canvas);
        axes.draw_frame(canvas, true);
        axes.draw_titles(canvas, "", "time to an answer (µs)", "");
    });
    for (place, (i, score)) in times.iter().enumerate() {
        let Some(compute) = score.compute else { continue };
        let look = Look::of(*i, names.len());
        let top = TOP + EACH * place as f64;
        drawing.layer(&Layer::of(format!("e e{i}")), |canvas| {
            let at = [frame.left + 8.0, top + 15.0];
            canvas.text(at, Anchor::Start, 13.0, &INK, &shortened(&score.name, 46));
            for (row, what, durations) in
                [(0.0, "reported", compute.reported), (1.0, "observed", compute.observed)]
            {
                let y = top + NAME + ROW * (row + 0.5);
                let at = [frame.left - 9.0, y + 4.2];
                canvas.text(at, Anchor::End, 12.0, &SOFT_INK, what);
                let px = |s: f64| axes.px([shown(s), 0.0])[0];
                draw_durations(canvas, &look, y, &durations, px);
            }
        });
    }
    let who: Vec<&str> = times.iter().map(|(_, score)| score.name.as_str()).collect();
    let text = format!("Median, 99th percentile and longest time of: {}", who.join(", "));
    let svg = drawing.finish("Compute time", &text, "");
    let caption = "Mark: median. Line: up to 99 % of all answers. Stroke: the longest. Reported is \
                   from taking a frame to answering it, observed from publishing it to the \
                   answer's arrival.";
    figure(&svg, caption)
}

fn draw_durations(
    canvas: &mut Canvas,
    look: &Look,
    y: f64,
    durations: &Durations,
    px: impl Fn(f64) -> f64,
) {
    let [p50, p99, max] = [durations.p50_s, durations.p99_s, durations.max_s].map(px);
    canvas.line(&[[p99, y], [max, y]], &look.ink, 1.0);
    canvas.line(&[[max, y - 5.0], [max, y + 5.0]], &look.ink, 1.6);
    canvas.line(&[[p50, y], [p99, y]], &WHITE, 7.0);
    canvas.line(&[[p50, y], [p99, y]], &look.ink, 5.0);
    look.mark(canvas, [p50, y], 5.0)
}
