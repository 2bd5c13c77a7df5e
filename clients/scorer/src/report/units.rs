//! Units of the page.

use rusty_plot::Axes;
use rusty_plot::layers::STEPS_PER_UNIT;

/// Units of the page per metre of the map.
pub(super) fn units_per_m(axes: &Axes) -> f64 {
    axes.frame.width() / (axes.x.range[1] - axes.x.range[0])
}

/// A length of the page as coordinates of a drawing have it.
pub(super) fn steps(units: f64) -> f64 {
    units * STEPS_PER_UNIT
}
