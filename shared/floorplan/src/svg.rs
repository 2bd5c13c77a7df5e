//! Walls of a drawing in SVG.
//!
//! Source: *Scalable Vector Graphics 1.1*, W3C 2011, as `usvg` resolves it: shapes,
//! transforms, `use`, style sheets and units become paths in one frame. Each line of
//! a path that is drawn is a wall. Text and pictures are ignored.
//!
//! Departures, and why:
//! * The coordinates have 24 bits in `usvg`. They are rounded to a power of ten, so
//!   that 4.1 m is 4.1: to 0.01 mm in a drawing of 20 m, to 0.1 mm in one of 200 m.
//! * Ends that stop at most 1 mm short of another wall are joined to it: no drawing
//!   program puts an end on a slanted line to the bit.
//! * The y axis points up in the world, and down in SVG. The lower left corner of
//!   the drawing is (0, 0).

use rusty_contract::FieldError;
use rusty_contract::config::check_within;
use rusty_geometry::world_spec::MAX_WALLS;
use rusty_geometry::{Material, WallSpec, WorldSpec};
use usvg::roxmltree::{Document, ParsingOptions};
use usvg::tiny_skia_path::{PathSegment, Point};
use usvg::{Color, Group, ImageHrefResolver, Node, Options, Paint, Path, Transform, Tree};

use crate::{bounds_of, snap};

/// Greatest distance of a curve from the walls that replace it, m.
pub const CURVE_TOLERANCE_M: f64 = 1e-3;
/// Farthest that an end is moved onto another wall, m.
pub const JOIN_M: f64 = 1e-3;
/// Attribute of the element `svg` with the length of a user unit, m.
pub const SCALE: &str = "data-metres-per-unit";

/// Metres in a pixel of CSS, of which an inch has 96.
const M_PER_PX: f64 = 0.0254 / 96.0;

/// Returns the walls of a drawing as a world, which is not checked.
///
/// # Errors
/// [`FieldError`] names the part of the drawing that cannot be used.
pub fn walls(text: &str, name: &str) -> Result<WorldSpec, FieldError> {
    let parsing = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let not_svg = |error: String| {
        FieldError::new("SVG", error, "cannot be read", "save the drawing as plain SVG")
    };
    let document =
        Document::parse_with_options(text, parsing).map_err(|e| not_svg(e.to_string()))?;
    let options = Options {
        style_sheet: Some(style_sheet(&document)?),
        // No other file is opened.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    let tree = Tree::from_xmltree(&document, &options).map_err(|e| not_svg(e.to_string()))?;
    let m_per_px = scale(&document, &tree)?;
    let height_px = f64::from(tree.size().height());
    let size_m = m_per_px * height_px.max(f64::from(tree.size().width()));
    let mut steps_per_m = 1e6;
    while size_m * steps_per_m > f64::from(1 << 21) {
        steps_per_m /= 10.0;
    }
    let mut tracer = Tracer { m_per_px, height_px, steps_per_m, walls: Vec::new() };
    tracer.group(tree.root())?;
    let walls = tracer.walls;
    if walls.is_empty() {
        let remedy = "draw the walls with a stroke; text and pictures are not read";
        return Err(FieldError::new("lines", 0, "make no wall", remedy));
    }
    let mut spec = WorldSpec {
        name: name.to_owned(),
        bounds: bounds_of(&walls),
        walls,
        landmarks: Vec::new(),
    };
    snap::join_ends(&mut spec, JOIN_M);
    Ok(spec)
}

/// Metres in a pixel: by the scale attribute, or by the physical size of the drawing.
fn scale(document: &Document<'_>, tree: &Tree) -> Result<f64, FieldError> {
    let root = document.root_element();
    let remedy = format!(
        "write {SCALE}=\"0.01\" into the element <svg> if a user unit is 1 cm, or give the \
         width and height of the floor in mm, cm or in"
    );
    if let Some(text) = root.attribute(SCALE) {
        let wrong = |_| FieldError::new(SCALE, text, "is not a number", remedy);
        let metres: f64 = text.trim().parse().map_err(wrong)?;
        check_within(SCALE, metres, 1e-6, 1e3)?;
        let view = root.attribute("viewBox").unwrap_or_default();
        let sides: Vec<f64> = view
            .split([' ', ',', '\t', '\n'])
            .filter_map(|word| word.parse().ok())
            .filter(|side: &f64| *side > 0.0 || view.is_empty())
            .collect();
        // Pixels in a user unit; the last two numbers are width and height.
        let px = match sides.as_slice() {
            [.., wide, high] => {
                let size = tree.size();
                (f64::from(size.width()) / wide).min(f64::from(size.height()) / high)
            }
            _ => 1.0,
        };
        return Ok(metres / px);
    }
    let is_physical = |side: &str| {
        let text = root.attribute(side).unwrap_or_default().trim();
        ["mm", "cm", "in"].iter().any(|unit| text.ends_with(unit))
    };
    if is_physical("width") && is_physical("height") {
        return Ok(M_PER_PX);
    }
    let [wide, high] = ["width", "height"].map(|side| root.attribute(side).unwrap_or("none"));
    let (size, problem) = (format!("{wide} × {high}"), "gives no size in the world");
    Err(FieldError::new("width and height", size, problem, remedy))
}

/// Draws what is named as a material in its colour.
///
/// A class or an id names the material of its element and of all elements inside.
fn style_sheet(document: &Document<'_>) -> Result<String, FieldError> {
    let (mut own, mut inside) = (String::new(), String::new());
    for (mark, attribute) in [('.', "class"), ('#', "id")] {
        let elements = document.descendants();
        let names = elements.filter_map(|node| node.attribute(attribute));
        let mut names: Vec<&str> = names.flat_map(str::split_whitespace).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            if let Some(Color { red, green, blue }) = colour(attribute, name)? {
                let style = format!("{{stroke:#{red:02x}{green:02x}{blue:02x} !important}}\n");
                own += &format!("{mark}{name} {style}");
                inside += &format!("{mark}{name} * {style}");
            }
        }
    }
    // Of important rules the first counts: an element's own before its group's.
    Ok(own + &inside)
}

/// The colour of the material that a class or an id names: `wall`, `glass`, `door`
/// (number 0) or `door-3`.
fn colour(attribute: &str, name: &str) -> Result<Option<Color>, FieldError> {
    let number = match name {
        "wall" => return Ok(Some(Color::black())),
        "glass" => return Ok(Some(Color::new_rgb(0, 255, 255))),
        "door" => "0",
        _ => match name.strip_prefix("door-") {
            Some(number) if number.bytes().all(|b| b.is_ascii_digit()) => number,
            _ => return Ok(None),
        },
    };
    let wrong = |_| {
        let remedy = "give a number from 0 to 255, e.g. door-3";
        FieldError::new(attribute, name, "names a door without a usable number", remedy)
    };
    number.parse().map(|door| Some(Color::new_rgb(255, 0, door))).map_err(wrong)
}

/// The material of a path; `None` if it is not seen, or white without a stroke.
fn material(path: &Path) -> Option<Material> {
    let paint = match (path.stroke(), path.fill()) {
        (Some(stroke), _) => stroke.paint(),
        (None, Some(fill)) if *fill.paint() != Paint::Color(Color::white()) => fill.paint(),
        _ => return None,
    };
    path.is_visible().then_some(match paint {
        Paint::Color(Color { red: 0, green: 255, blue: 255 }) => Material::Glass,
        Paint::Color(Color { red: 255, green: 0, blue }) => Material::Door(*blue),
        _ => Material::Wall,
    })
}

fn too_many(lines: usize) -> FieldError {
    FieldError::new("lines", lines, "make too many walls", "simplify or split the drawing")
}

/// Walls, while they are collected.
struct Tracer {
    m_per_px: f64,
    height_px: f64,
    steps_per_m: f64,
    walls: Vec<WallSpec>,
}

impl Tracer {
    fn group(&mut self, group: &Group) -> Result<(), FieldError> {
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) => self.path(path)?,
                Node::Image(_) | Node::Text(_) => {}
            }
        }
        Ok(())
    }

    fn path(&mut self, path: &Path) -> Result<(), FieldError> {
        let Some(material) = material(path) else { return Ok(()) };
        let place = |point: Point| self.place(point, path.abs_transform());
        let mut lines: Vec<Vec<[f64; 2]>> = Vec::new();
        for segment in path.data().segments() {
            if let PathSegment::MoveTo(to) = segment {
                lines.push(vec![place(to)]);
                continue;
            }
            // Every path begins with a move.
            let Some(line) = lines.last_mut() else { continue };
            let (begin, from) = (line[0], line[line.len() - 1]);
            if line.len() > MAX_WALLS {
                return Err(too_many(line.len()));
            }
            match segment {
                PathSegment::MoveTo(to) | PathSegment::LineTo(to) => line.push(place(to)),
                PathSegment::QuadTo(a, to) => {
                    // The same curve as a cubic one.
                    let (a, to) = (place(a), place(to));
                    let third = |v: [f64; 2]| [0, 1].map(|k| v[k] + (a[k] - v[k]) * 2.0 / 3.0);
                    curve([from, third(from), third(to), to], line);
                }
                PathSegment::CubicTo(a, b, to) => {
                    curve([from, place(a), place(b), place(to)], line);
                }
                PathSegment::Close => line.push(begin),
            }
        }
        for line in lines {
            let line: Vec<[f64; 2]> = line.into_iter().map(|at| self.rounded(at)).collect();
            let walls = line.windows(2).filter(|ends| ends[0] != ends[1]);
            self.walls.extend(walls.map(|e| WallSpec { a: e[0], b: e[1], material }));
        }
        if self.walls.len() > MAX_WALLS {
            return Err(too_many(self.walls.len()));
        }
        Ok(())
    }

    /// A point of a path in the world, m.
    fn place(&self, point: Point, to_px: Transform) -> [f64; 2] {
        let Transform { sx, kx, ky, sy, tx, ty } = to_px;
        let [x, y, sx, kx, ky, sy, tx, ty] =
            [point.x, point.y, sx, kx, ky, sy, tx, ty].map(f64::from);
        let (right, down) = (sx * x + kx * y + tx, ky * x + sy * y + ty);
        [self.m_per_px * right, self.m_per_px * (self.height_px - down)]
    }

    fn rounded(&self, at: [f64; 2]) -> [f64; 2] {
        // Adding zero makes a negative zero positive.
        at.map(|v| (v * self.steps_per_m).round() / self.steps_per_m + 0.0)
    }
}

/// Adds points of a cubic Bézier curve after its first one.
///
/// Their number is by the bound of Wang (1984): n = √(3/4 · M / tolerance) chords,
/// where M is the largest second difference of the control points.
fn curve(control: [[f64; 2]; 4], corners: &mut Vec<[f64; 2]>) {
    let [a, b, c, d] = control;
    let bend = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        let [x, y] = [0, 1].map(|k| p[k] - 2.0 * q[k] + r[k]);
        (x * x + y * y).sqrt()
    };
    let bend = bend(a, b, c).max(bend(b, c, d));
    let chords = (0.75 * bend / CURVE_TOLERANCE_M).sqrt().ceil().clamp(1.0, 1e4);
    for k in 1..=chords as usize {
        let t = k as f64 / chords;
        let mix = |p: [f64; 2], q: [f64; 2]| [0, 1].map(|k| (1.0 - t) * p[k] + t * q[k]);
        let (ab, bc, cd) = (mix(a, b), mix(b, c), mix(c, d));
        corners.push(mix(mix(ab, bc), mix(bc, cd)));
    }
}

#[cfg(test)]
mod tests;
