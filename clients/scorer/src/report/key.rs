//! What is what on the map, as a list.

use std::fmt::Write as _;

use rusty_geometry::Material;
use rusty_plot::floor::draw_robot;
use rusty_plot::style::{DOOR, GLASS, RGBColor, TRUTH, TRUTH_WIDTH, WALL};
use rusty_plot::{Canvas, Drawing, Layer, PlotError};

use super::beliefs::Beliefs;
use crate::scoring::beliefs::Mark;
use crate::scoring::map::{draw_echo, draw_possible};
use crate::scoring::trace::RunTrace;

/// Size of what stands before a word.
const SIZE: (f64, f64) = (30.0, 22.0);

/// The list, without what this map does not have.
pub(super) fn list(trace: &RunTrace) -> Result<String, PlotError> {
    let mut list = "<ul class=\"key\">\n".to_owned();
    let mut entry = |name: &str, draw: &dyn Fn(&mut Canvas<'_>) -> Result<(), PlotError>| {
        let mut drawing = Drawing::new(SIZE, &format!("key-{name}").replace(' ', "-"));
        drawing.layer(&Layer::default(), draw)?;
        // Beside its name; who hears the page needs no drawing.
        let svg = drawing.finish("", "", "class=\"swatch\" aria-hidden=\"true\"");
        let _ = writeln!(list, "<li>{svg}<span>{name}</span></li>");
        Ok::<(), PlotError>(())
    };
    let line = |canvas: &mut Canvas<'_>, (ink, width): (RGBColor, f64)| {
        canvas.line(&[[1.0, 11.0], [29.0, 11.0]], &ink, width)
    };
    if trace.ticks_with_truth() > 0 {
        entry("true path", &|canvas| line(canvas, (TRUTH, TRUTH_WIDTH)))?;
        entry("start", &|canvas| draw_robot(canvas, [10.0, 11.0], 0.0, true))?;
        entry("robot", &|canvas| draw_robot(canvas, [10.0, 11.0], 0.0, false))?;
        if trace.stops.iter().any(|stop| stop.has_scan) {
            entry("latest scan", &|canvas| {
                [5.0, 12.0, 19.0, 26.0].into_iter().try_for_each(|x| draw_echo(canvas, [x, 11.0]))
            })?;
        }
    }
    for (name, look) in Beliefs::of(trace).entries() {
        entry(&name, &|canvas| {
            [6.0, 15.0, 24.0].into_iter().try_for_each(|x| {
                draw_possible(canvas, &look, [x, 11.0], &Mark { share: 1.0, ..Mark::NOWHERE })
            })
        })?;
    }
    let has = |is_it: fn(Material) -> bool| trace.world.walls.iter().any(|w| is_it(w.material));
    if has(|m| m == Material::Wall) {
        entry("wall", &|canvas| line(canvas, WALL))?;
    }
    if has(|m| m == Material::Glass) {
        entry("glass", &|canvas| line(canvas, GLASS))?;
    }
    if has(|m| matches!(m, Material::Door(_))) {
        entry("door", &|canvas| line(canvas, DOOR))?;
    }
    list.push_str("</ul>\n");
    Ok(list)
}
