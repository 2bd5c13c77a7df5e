//! Pictures of maps and drawings, and the walls that they become.

use rusty_floorplan::map_server::{Cell, OCCUPIED_ABOVE, RosMap, pgm, png};
use rusty_floorplan::{svg as drawing, trace};
use rusty_geometry::World;

/// Words of SVG.
pub const WORDS: [&str; 12] = [
    "<g transform='rotate(30)'>",
    "</g>",
    "<use href='#a' x='9'/>",
    "<path d='M0 0C9 9 1e9 1e9 0 0' stroke='red'/>",
    "viewBox='0 0 1 1'",
    "data-metres-per-unit='1e3'",
    "width='1e38cm'",
    "class='door-3'",
    "A 9 9 0 1 1 0 0",
    "marker-mid='url(#a)'",
    "stroke='url(#a)'",
    "scale(1e-30)",
];

/// A PNG or PGM picture.
pub fn map(bytes: &[u8]) -> bool {
    let is_png = bytes.starts_with(png::SIGNATURE);
    let Ok(picture) = (if is_png { png::read(bytes) } else { pgm::read(bytes) }) else {
        return false;
    };
    assert_eq!(picture.grey.len(), picture.width * picture.height);
    let most = (1.0 - OCCUPIED_ABOVE) * f64::from(picture.maxval);
    let cell = |grey: &u16| if f64::from(*grey) < most { Cell::Occupied } else { Cell::Free };
    let cells = picture.grey.iter().map(cell).collect();
    let (origin_m, yaw_rad, width) = ([-1.0, 2.0], 0.0, picture.width);
    let map = RosMap { origin_m, yaw_rad, cell_m: 0.05, width, cells };
    let Ok(traced) = trace::trace(&map, "map") else { return false };
    assert!(traced.max_deviation_cells <= trace::TOLERANCE_CELLS);
    traced.world.check().expect("what is traced passes the check");
    true
}

/// A drawing.
pub fn svg(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let Ok(spec) = drawing::walls(text, "plan") else { return false };
    World::new(spec).is_ok()
}
