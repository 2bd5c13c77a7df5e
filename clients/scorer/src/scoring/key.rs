//! What is what on a map.

use rusty_geometry::Material;
use rusty_plot::floor::draw_robot;
use rusty_plot::style::{DOOR, GLASS, Look, RGBColor, TRUTH, TRUTH_WIDTH, WALL};
use rusty_plot::{Canvas, Px};

use super::beliefs::Mark;
use super::map::{draw_echo, draw_possible};
use super::trace::RunTrace;

/// What is drawn of something.
pub(crate) enum Symbol {
    Line(RGBColor, f64),
    Robot { started: bool },
    Scan,
    Possible(Look),
}

impl Symbol {
    /// Draws it to the right of a place, 28 units wide.
    pub fn draw(&self, canvas: &mut Canvas, [x, y]: Px) {
        match self {
            Self::Line(ink, width) => canvas.line(&[[x, y], [x + 28.0, y]], ink, *width),
            Self::Robot { started } => draw_robot(canvas, [x + 9.0, y], 0.0, *started),
            Self::Possible(look) => [5.0, 14.0, 23.0].into_iter().for_each(|right| {
                draw_possible(canvas, look, [x + right, y], &Mark { share: 1.0, ..Mark::NOWHERE });
            }),
            Self::Scan => {
                [4.0, 11.0, 18.0, 25.0]
                    .into_iter()
                    .for_each(|right| draw_echo(canvas, [x + right, y]));
            }
        }
    }
}

/// Returns what the map of a run has, with names: the given ones of the robot
/// where it is last, of a scan if one is drawn, and of what filters held possible.
pub(crate) fn key(
    trace: &RunTrace,
    robot: &str,
    scan: Option<String>,
    possible: impl Iterator<Item = (String, Look)>,
) -> Vec<(Symbol, String)> {
    let mut key = Vec::new();
    if trace.ticks_with_truth() > 0 {
        key.push((Symbol::Line(TRUTH, TRUTH_WIDTH), "true path".to_owned()));
        key.push((Symbol::Robot { started: true }, "start".to_owned()));
        key.push((Symbol::Robot { started: false }, robot.to_owned()));
    }
    key.extend(scan.map(|name| (Symbol::Scan, name)));
    key.extend(possible.map(|(name, look)| (Symbol::Possible(look), name)));
    let has = |is_it: fn(Material) -> bool| trace.world.walls.iter().any(|w| is_it(w.material));
    for (name, (ink, width), is_there) in [
        ("wall", WALL, has(|m| m == Material::Wall)),
        ("glass", GLASS, has(|m| m == Material::Glass)),
        ("door", DOOR, has(|m| matches!(m, Material::Door(_)))),
    ] {
        if is_there {
            key.push((Symbol::Line(ink, width), name.to_owned()));
        }
    }
    key
}
