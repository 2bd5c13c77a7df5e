//! Drawing: a page, axes, floor plans; as SVG, and the same in pixels.
//!
//! In reading order:
//!
//! * [`error`]: why there is no picture;
//! * [`canvas`]: a page to draw on;
//! * [`layers`]: a drawing in parts that a page of hypertext can move;
//! * [`style`]: colours, widths and marks;
//! * [`axes`]: a frame with round numbers, linear or logarithmic in one direction
//!   or both;
//! * [`polyline`]: long lines made short, and cut at a frame;
//! * [`floor`]: walls, paths and robots, seen from above;
//! * [`ellipse`]: what holds 95 % of a normal distribution;
//! * [`page`]: titles, legends and rows of figures;
//! * [`mod@png`]: a page in pixels, with a built-in font;
//! * [`assets`]: the script and the style that hypertext pages have in common.
//!
//! All drawings are made with these: the scorer a run, a sweep
//! what became of many. Nothing here reads a clock, a file or a font of the
//! machine: the same calls give the same bytes.

pub mod assets;
pub mod axes;
pub mod canvas;
pub mod ellipse;
pub mod error;
pub mod floor;
pub mod layers;
pub mod page;
#[cfg(feature = "png")]
pub mod png;
pub mod polyline;
pub mod style;

pub use axes::{Axes, Axis, Step};
pub use canvas::{Anchor, Canvas, Px, RGBColor, Rect, escaped, paint, shortened};
pub use error::PlotError;
pub use layers::{Drawing, Layer};
#[cfg(feature = "png")]
pub use png::png;
pub use style::Look;
