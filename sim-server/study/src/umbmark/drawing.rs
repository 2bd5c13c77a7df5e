//! A UMBmark, drawn: two laps, and where all of them ended, before and after.

use rusty_contract::score::metres;
use rusty_plot::floor::{Extent, draw_robot};
use rusty_plot::style::{INK, Look, RGBColor, SOFT_INK, ZERO};
use rusty_plot::{Anchor, Axes, Canvas, PlotError, Px, Rect, Step, paint, polyline};

use super::lap::{Return, Way};
use super::report::Report;

const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 530.0;
const LEFT: f64 = 72.0;
const SIDE: f64 = 320.0;
const GAP: f64 = 76.0;
const TOP: f64 = 150.0;
/// Corners of a drawn circle.
const CORNERS: u32 = 96;

/// Draws a UMBmark as the text of an SVG file: the programmed square with the
/// true path of the first lap each way; the returns of all laps, with their
/// centres of gravity and a circle of radius E_max,syst; and the same with the
/// estimate by exact arcs applied, on a scale of its own.
///
/// # Errors
/// [`PlotError::Draw`] if the drawing backend refuses; it writes to memory only
/// and is not known to.
pub fn drawing(report: &Report) -> Result<String, PlotError> {
    let title = format!("UMBmark of {}", report.scenario);
    let details = format!(
        "square of {} m · {} laps each way · slip {} per tick · E_b = {:.5} ± {:.5} (true {:.5}) \
         · E_d = {:.5} ± {:.5} (true {:.5})",
        report.square.side_m,
        report.runs,
        report.slip_std,
        report.estimate.exact.factors.wheelbase,
        report.estimate.exact.standard_errors.wheelbase,
        report.truth.wheelbase,
        report.estimate.exact.factors.diameters,
        report.estimate.exact.standard_errors.diameters,
        report.truth.diameters
    );
    let frame = |place: u32| {
        let left = LEFT + (SIDE + GAP) * f64::from(place);
        Rect { left, top: TOP, right: left + SIDE, bottom: TOP + SIDE }
    };
    paint((WIDTH, HEIGHT), &title, |canvas| {
        canvas.text([LEFT, 36.0], Anchor::Start, 23.0, &INK, &title)?;
        canvas.text([LEFT, 60.0], Anchor::Start, 14.0, &SOFT_INK, &details)?;
        draw_legend(canvas)?;
        draw_laps(canvas, frame(0), report)?;
        let before = (&report.returns[..], report.estimate.e_max_syst_m);
        draw_returns(canvas, frame(1), before, "ends, as believed at first")?;
        let after = &report.corrected_by_exact;
        let after = (&after.returns[..], after.e_max_syst_m);
        draw_returns(canvas, frame(2), after, "ends, with the estimate applied")
    })
}

fn look(way: Way) -> Look {
    Look::of(usize::from(way == Way::CounterClockwise), 2)
}

fn draw_legend(canvas: &mut Canvas<'_>) -> Result<(), PlotError> {
    let (mut x, y) = (LEFT, 94.0);
    for (way, text) in Way::BOTH.into_iter().zip(["clockwise", "counter-clockwise"]) {
        let look = look(way);
        canvas.line(&[[x, y - 4.0], [x + 32.0, y - 4.0]], &look.ink, 2.0)?;
        look.mark(canvas, [x + 16.0, y - 4.0], 4.0)?;
        canvas.text([x + 42.0, y], Anchor::Start, 13.0, &INK, text)?;
        x += 70.0 + 7.2 * text.len() as f64;
    }
    canvas.dashes(&[[x, y - 4.0], [x + 32.0, y - 4.0]], &SOFT_INK, 1.4, 5.0)?;
    canvas.text(
        [x + 42.0, y],
        Anchor::Start,
        13.0,
        &INK,
        "programmed square; circle of E_max,syst",
    )?;
    x += 330.0;
    look(Way::Clockwise).mark(canvas, [x, y - 4.0], 7.5)?;
    canvas.text([x + 16.0, y], Anchor::Start, 13.0, &INK, "centre of gravity")
}

fn draw_labels(canvas: &mut Canvas<'_>, frame: Rect, title: &str) -> Result<(), PlotError> {
    let (across, down) = (0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom));
    canvas.text([frame.left, frame.top - 9.0], Anchor::Start, 13.0, &INK, title)?;
    canvas.text([across, frame.bottom + 37.0], Anchor::Middle, 13.0, &INK, "x (m)")?;
    canvas.text([frame.left - 50.0, down], Anchor::Upwards, 13.0, &INK, "y (m)")
}

fn draw_laps(canvas: &mut Canvas<'_>, frame: Rect, report: &Report) -> Result<(), PlotError> {
    let l = report.square.side_m;
    let first = |way: Way| report.returns.iter().find(|r| r.way == way);
    let mut extent = Extent::default();
    Way::BOTH.into_iter().for_each(|way| extent.include([l, way.sign() * l]));
    let paths = || Way::BOTH.into_iter().filter_map(first);
    paths().flat_map(|r| &r.path_m).for_each(|&at| extent.include(at));
    extent = extent.grown(0.06 * extent.size());
    let axes = Axes::equal(frame, extent.x(), extent.y());
    let step = Step::of(axes.x[1] - axes.x[0], 7.0);
    axes.draw_grid(canvas, step, step)?;
    for way in Way::BOTH {
        let s = way.sign() * l;
        let square = [[0.0, 0.0], [l, 0.0], [l, s], [0.0, s], [0.0, 0.0]];
        canvas.dashes(&square.map(|at| axes.px(at)), &SOFT_INK, 1.4, 5.0)?;
    }
    for lap in paths() {
        let look = look(lap.way);
        let line: Vec<Px> = lap.path_m.iter().map(|&at| axes.px(at)).collect();
        for part in polyline::clip(&polyline::thin(&line), &frame) {
            canvas.line(&part, &look.ink, 2.2)?;
        }
        if let Some(&end) = lap.path_m.last() {
            look.mark(canvas, axes.px(end), 5.0)?;
        }
    }
    draw_robot(canvas, axes.px([0.0, 0.0]), 0.0, true)?;
    axes.draw_frame(canvas, Some(step), step)?;
    draw_labels(canvas, frame, "true path of the first lap each way")
}

fn draw_returns(
    canvas: &mut Canvas<'_>,
    frame: Rect,
    (returns, e_max_syst_m): (&[Return], f64),
    title: &str,
) -> Result<(), PlotError> {
    let farthest = returns.iter().flat_map(|r| [r.x_m.abs(), r.y_m.abs()]).fold(0.0, f64::max);
    // Never so narrow that rounding looks like something.
    let half = (1.15 * farthest.max(e_max_syst_m)).max(1e-6);
    let axes = Axes::equal(frame, [-half, half], [-half, half]);
    let step = Step::of(2.0 * half, 5.0);
    axes.draw_grid(canvas, step, step)?;
    for line in [[[-half, 0.0], [half, 0.0]], [[0.0, -half], [0.0, half]]] {
        canvas.line(&line.map(|at| axes.px(at)), &ZERO, 1.0)?;
    }
    let circle: Vec<Px> = (0..=CORNERS)
        .map(|k| {
            let turn = core::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
            let (s, c) = rusty_geometry::trig::sin_cos(turn);
            axes.px([e_max_syst_m * c, e_max_syst_m * s])
        })
        .collect();
    canvas.dashes(&circle, &SOFT_INK, 1.4, 5.0)?;
    for way in Way::BOTH {
        draw_way(canvas, &axes, returns, way)?;
    }
    axes.draw_frame(canvas, Some(step), step)?;
    let title = format!("{title}: E_max,syst = {} m", metres(e_max_syst_m));
    draw_labels(canvas, frame, &title)
}

fn draw_way(
    canvas: &mut Canvas<'_>,
    axes: &Axes,
    returns: &[Return],
    way: Way,
) -> Result<(), PlotError> {
    let own: Vec<[f64; 2]> =
        returns.iter().filter(|r| r.way == way).map(|r| [r.x_m, r.y_m]).collect();
    let look = look(way);
    let n = own.len().max(1) as f64;
    let mean = |axis: usize| own.iter().map(|p| p[axis]).sum::<f64>() / n;
    let centre = axes.px([mean(0), mean(1)]);
    let ink: &RGBColor = &look.ink;
    canvas.line(&[axes.px([0.0, 0.0]), centre], ink, 1.2)?;
    look.mark(canvas, centre, 7.5)?;
    // On top of it: few laps with little slip end all in one place.
    for &at in &own {
        look.mark(canvas, axes.px(at), 3.4)?;
    }
    Ok(())
}
