//! What is what on a map.

use rusty_geometry::Material;
use rusty_plot::floor::draw_robot;
use rusty_plot::style::{DOOR, GLASS, INK, Look, RGBColor, TRUTH, TRUTH_WIDTH, WALL, WHITE};
use rusty_plot::{Canvas, Px};

use super::bars::bars;
use super::beliefs::Mark;
use super::map::{BAR_OPACITY, draw_dotted_arrow, draw_echo, draw_possible, possible_look};
use super::trace::RunTrace;

/// What is drawn of something.
pub(crate) enum Symbol {
    Line(RGBColor, f64),
    Robot {
        started: bool,
    },
    /// The robot as the player draws it.
    Body,
    Scan,
    Jump,
    Possible(Look),
    Bars(Look),
}

impl Symbol {
    /// Draws it to the right of a place, 28 units wide.
    pub fn draw(&self, canvas: &mut Canvas, [x, y]: Px) {
        match self {
            Self::Line(ink, width) => canvas.line(&[[x, y], [x + 28.0, y]], ink, *width),
            Self::Body => {
                canvas.disc([x + 14.0, y], 8.5, &INK);
                canvas.disc([x + 14.0, y], 6.9, &WHITE);
                canvas.line(&[[x + 14.0, y], [x + 22.5, y]], &INK, 1.8);
            }
            Self::Jump => draw_dotted_arrow(canvas, [[x, y], [x + 28.0, y]]),
            Self::Robot { started } => draw_robot(canvas, [x + 9.0, y], 0.0, *started),
            Self::Possible(look) => [5.0, 14.0, 23.0].into_iter().for_each(|right| {
                draw_possible(canvas, look, [x + right, y], &Mark { share: 1.0, ..Mark::NOWHERE });
            }),
            Self::Bars(look) => {
                [6.0, 16.0, 11.0, 4.0].into_iter().enumerate().for_each(|(k, up)| {
                    let (left, bottom) = (x + 7.0 * k as f64, y + 8.0);
                    let (right, top) = (left + 6.0, bottom - up);
                    let bar = [[left, bottom], [right, bottom], [right, top], [left, top]];
                    canvas.wash(&bar, &look.ink, BAR_OPACITY);
                })
            }
            Self::Scan => {
                [4.0, 11.0, 18.0, 25.0]
                    .into_iter()
                    .for_each(|right| draw_echo(canvas, [x + right, y]));
            }
        }
    }
}

/// What the last belief of a track is drawn as.
pub(crate) fn possible_symbol(trace: &RunTrace, track: usize) -> Symbol {
    let look = possible_look(trace, track);
    let last = trace.beliefs[track].moments.last();
    match last.is_some_and(|moment| bars(moment).is_some()) {
        true => Symbol::Bars(look),
        false => Symbol::Possible(look),
    }
}

/// Returns what the map of a run has, with names: the given ones of the robot
/// where it is last, of a scan if one is drawn, and of what filters held possible.
pub(crate) fn key(
    trace: &RunTrace,
    robot: (Symbol, &str),
    scan: Option<String>,
    possible: impl Iterator<Item = (Symbol, String)>,
) -> Vec<(Symbol, String)> {
    let mut key = Vec::new();
    if trace.ticks_with_truth() > 0 {
        key.push((Symbol::Line(TRUTH, TRUTH_WIDTH), "true path".to_owned()));
        key.push((Symbol::Robot { started: true }, "start".to_owned()));
        key.push((robot.0, robot.1.to_owned()));
    }
    if !trace.jumps.is_empty() {
        key.push((Symbol::Jump, "kidnapping".to_owned()));
    }
    key.extend(scan.map(|name| (Symbol::Scan, name)));
    key.extend(possible);
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
