//! A UMBmark, drawn: two laps, and where all of them ended, before and after.

use rusty_contract::score::metres;
use rusty_plot::ellipse::circle;
use rusty_plot::floor::{Extent, draw_line, draw_robot};
use rusty_plot::page::{Legend, draw_title};
use rusty_plot::style::{Look, SOFT_INK, ZERO};
use rusty_plot::{Axes, Canvas, Px, Rect, paint};

use super::lap::{Return, Way};
use super::report::Report;

const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 530.0;
const LEFT: f64 = 72.0;
const SIDE: f64 = 320.0;
const GAP: f64 = 76.0;
const TOP: f64 = 150.0;

/// Draws a UMBmark as the text of an SVG file: the programmed square with the
/// true path of the first lap each way; the returns of all laps, with their
/// centres of gravity and a circle of radius E_max,syst; and the same with the
/// estimate by exact arcs applied, on a separate scale.
pub fn drawing(report: &Report) -> String {
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
        draw_title(canvas, LEFT, &title, &details);
        draw_legend(canvas);
        draw_laps(canvas, frame(0), report);
        let before = (&report.returns[..], report.estimate.e_max_syst_m);
        draw_returns(canvas, frame(1), before, "ends, as believed at first");
        let after = &report.corrected_by_exact;
        let after = (&after.returns[..], after.e_max_syst_m);
        draw_returns(canvas, frame(2), after, "ends, with the estimate applied")
    })
}

fn look(way: Way) -> Look {
    Look::of(usize::from(way == Way::CounterClockwise), 2)
}

fn draw_legend(canvas: &mut Canvas) {
    let mut legend = Legend { at: [LEFT, 90.0] };
    for (way, text) in Way::BOTH.into_iter().zip(["clockwise", "counter-clockwise"]) {
        legend.estimator(canvas, text, &look(way));
    }
    legend.entry(canvas, "programmed square; circle of E_max,syst", |canvas, [x, y]| {
        canvas.dashes(&[[x, y], [x + Legend::SWATCH, y]], &SOFT_INK, 1.4, 5.0);
    });
    legend.entry(canvas, "centre of gravity", |canvas, [x, y]| {
        look(Way::Clockwise).mark(canvas, [x + 16.0, y], 7.5);
    });
}

fn draw_laps(canvas: &mut Canvas, frame: Rect, report: &Report) {
    let l = report.square.side_m;
    let first = |way: Way| report.returns.iter().find(|r| r.way == way);
    let mut extent = Extent::default();
    Way::BOTH.into_iter().for_each(|way| extent.include([l, way.sign() * l]));
    let paths = || Way::BOTH.into_iter().filter_map(first);
    paths().flat_map(|r| &r.path_m).for_each(|&at| extent.include(at));
    extent = extent.grown(0.06 * extent.size());
    let axes = Axes::equal(frame, extent.x(), extent.y(), 7.0);
    axes.draw_grid(canvas);
    for way in Way::BOTH {
        let s = way.sign() * l;
        let square = [[0.0, 0.0], [l, 0.0], [l, s], [0.0, s], [0.0, 0.0]];
        canvas.dashes(&square.map(|at| axes.px(at)), &SOFT_INK, 1.4, 5.0);
    }
    for lap in paths() {
        let look = look(lap.way);
        draw_line(canvas, &axes, &lap.path_m, (&look.ink, 2.2));
        if let Some(&end) = lap.path_m.last() {
            look.mark(canvas, axes.px(end), 5.0);
        }
    }
    draw_robot(canvas, axes.px([0.0, 0.0]), 0.0, true);
    axes.draw_frame(canvas, true);
    axes.draw_titles(canvas, "true path of the first lap each way", "x (m)", "y (m)");
}

fn draw_returns(
    canvas: &mut Canvas,
    frame: Rect,
    (returns, e_max_syst_m): (&[Return], f64),
    title: &str,
) {
    let farthest = returns.iter().flat_map(|r| [r.x_m.abs(), r.y_m.abs()]).fold(0.0, f64::max);
    // Never so narrow that rounding looks like something.
    let half = (1.15 * farthest.max(e_max_syst_m)).max(1e-6);
    let axes = Axes::equal(frame, [-half, half], [-half, half], 5.0);
    axes.draw_grid(canvas);
    for line in [[[-half, 0.0], [half, 0.0]], [[0.0, -half], [0.0, half]]] {
        canvas.line(&line.map(|at| axes.px(at)), &ZERO, 1.0);
    }
    let around: Vec<Px> =
        circle([0.0; 2], e_max_syst_m).into_iter().map(|at| axes.px(at)).collect();
    canvas.dashes(&around, &SOFT_INK, 1.4, 5.0);
    for way in Way::BOTH {
        draw_way(canvas, &axes, returns, way);
    }
    axes.draw_frame(canvas, true);
    let title = format!("{title}: E_max,syst = {} m", metres(e_max_syst_m));
    axes.draw_titles(canvas, &title, "x (m)", "y (m)");
}

fn draw_way(canvas: &mut Canvas, axes: &Axes, returns: &[Return], way: Way) {
    let own: Vec<[f64; 2]> =
        returns.iter().filter(|r| r.way == way).map(|r| [r.x_m, r.y_m]).collect();
    let look = look(way);
    let n = own.len().max(1) as f64;
    let mean = |axis: usize| own.iter().map(|p| p[axis]).sum::<f64>() / n;
    let centre = axes.px([mean(0), mean(1)]);
    canvas.line(&[axes.px([0.0, 0.0]), centre], &look.ink, 1.2);
    look.mark(canvas, centre, 7.5);
    // On top of it: few laps with little slip end all in one place.
    for &at in &own {
        look.mark(canvas, axes.px(at), 3.4);
    }
}
