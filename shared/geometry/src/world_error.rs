//! Why a floor plan was refused.

use thiserror::Error;

use crate::gap::Gap;

/// What is wrong with a world, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WorldError {
    /// The text is not a world file.
    #[error(
        "world file ({format}): {detail}; a world is `name`, `bounds` = [x_min, y_min, x_max, \
         y_max] and `walls`, each with `a` = [x, y], `b` = [x, y] and `material`"
    )]
    Text {
        /// "TOML" or "JSON".
        format: &'static str,
        /// What the parser said, with the place.
        detail: String,
    },
    /// The world cannot be written in that format.
    #[error("world {name:?}: cannot be written as {format}: {detail}; check the world first")]
    Write {
        /// The world's name.
        name: String,
        /// "TOML" or "JSON".
        format: &'static str,
        /// What the writer said.
        detail: String,
    },
    /// The name is empty, too long or not printable.
    #[error(
        "world: `name` = {name:?} must be 1 to {limit} characters without control characters; \
         choose a short name"
    )]
    Name {
        /// The name as given.
        name: String,
        /// The longest name allowed, in characters.
        limit: usize,
    },
    /// The bounds are not a box, or too far out.
    #[error(
        "world {name:?}: `bounds` = {bounds:?} must be [x_min, y_min, x_max, y_max] in metres, \
         x_min < x_max, y_min < y_max, each within ±{limit_m} m; correct the four numbers"
    )]
    Bounds {
        /// The world's name.
        name: String,
        /// The bounds as given, metres.
        bounds: [f64; 4],
        /// The largest coordinate allowed, metres.
        limit_m: f64,
    },
    /// More walls than the limit.
    #[error(
        "world {name:?}: {count} walls, at most {limit} are allowed; simplify or split the plan"
    )]
    TooManyWalls {
        /// The world's name.
        name: String,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A landmark cannot be used.
    #[error(
        "world {name:?}: landmark {landmark}: {problem}; give each landmark a number of its own \
         and a place within the bounds"
    )]
    Landmark {
        /// The world's name.
        name: String,
        /// Index of the landmark, from 0.
        landmark: usize,
        /// What is wrong.
        problem: String,
    },
    /// A coordinate is NaN or infinite.
    #[error(
        "world {name:?}: wall {wall} from {a:?} to {b:?} has a coordinate that is not finite; \
         give both ends in metres"
    )]
    NotFinite {
        /// The world's name.
        name: String,
        /// Index of the wall, from 0.
        wall: usize,
        /// Its end `a`, metres.
        a: [f64; 2],
        /// Its end `b`, metres.
        b: [f64; 2],
    },
    /// A wall is too short to have a direction.
    #[error(
        "world {name:?}: wall {wall} from {a:?} to {b:?} is {length_m:e} m long, shorter than \
         {limit_m:e} m; remove it or move an end"
    )]
    TooShort {
        /// The world's name.
        name: String,
        /// Index of the wall, from 0.
        wall: usize,
        /// Its end `a`, metres.
        a: [f64; 2],
        /// Its end `b`, metres.
        b: [f64; 2],
        /// Its length, metres.
        length_m: f64,
        /// The shortest length allowed, metres.
        limit_m: f64,
    },
    /// A wall leaves the bounds.
    #[error(
        "world {name:?}: wall {wall}, end `{end}` at {point:?} lies outside `bounds` = \
         {bounds:?}; move the end or widen the bounds"
    )]
    OutOfBounds {
        /// The world's name.
        name: String,
        /// Index of the wall, from 0.
        wall: usize,
        /// Which end, 'a' or 'b'.
        end: char,
        /// Where it is, metres.
        point: [f64; 2],
        /// The bounds, metres.
        bounds: [f64; 4],
    },
    /// Two walls almost meet.
    #[error("world {name:?}: {gap}")]
    Gap {
        /// The world's name.
        name: String,
        /// The first gap, in order of walls and ends.
        gap: Gap,
    },
    /// The search for gaps takes too long.
    #[error(
        "world {name:?}: looking for gaps between its {count} walls takes more than {limit} \
         comparisons; join walls that continue each other, leave out walls that run close along \
         each other, or split the plan"
    )]
    GapsNotChecked {
        /// The world's name.
        name: String,
        /// How many walls there are.
        count: usize,
        /// How many comparisons are made at most.
        limit: u64,
    },
}
