//! A page to draw on: plotters' SVG backend with coordinates finer than a pixel.
//!
//! The backend takes whole numbers only, which turns a slow curve into a
//! staircase. The page is therefore drawn ten times too large, and the view box
//! of the finished SVG scales it back.

use plotters::prelude::{DrawingBackend, FontTransform, IntoFont, RGBColor, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, ShapeStyle};

use rusty_geometry::trig;

use crate::error::PlotError;

/// A place on the page, units of the page (CSS pixels): x right, y down.
pub type Px = [f64; 2];

/// Steps of the backend per unit of the page.
pub(crate) const FINENESS: f64 = 10.0;
/// plotters writes font sizes divided by this number.
const PLOTTERS_FONT_FACTOR: f64 = 1.24;

/// A rectangle of the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Its left edge.
    pub left: f64,
    /// Its upper edge, less than the lower one: y points down.
    pub top: f64,
    /// Its right edge.
    pub right: f64,
    /// Its lower edge.
    pub bottom: f64,
}

impl Rect {
    /// From left to right.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// From top to bottom.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }
}

/// Where a text stands relative to its place, and which way it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Begins there.
    Start,
    /// Has its middle there.
    Middle,
    /// Ends there.
    End,
    /// Has its middle there and runs upwards.
    Upwards,
}

/// The page while it is drawn.
pub struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

/// Draws a page of `width` × `height` units, white and opaque, with a title for
/// those who cannot see it, and returns the SVG.
///
/// # Errors
/// [`PlotError::Draw`] if the drawing backend refuses; it writes to memory only
/// and is not known to.
pub fn paint(
    (width, height): (f64, f64),
    title: &str,
    draw: impl FnOnce(&mut Canvas<'_>) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let body = body((width, height), |canvas| {
        let page = Rect { left: 0.0, top: 0.0, right: width, bottom: height };
        canvas.rectangle(&page, &RGBColor(255, 255, 255))?;
        draw(canvas)
    })?;
    let (w, h) = fine([width, height]);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {w} {h}\" role=\"img\" stroke-linejoin=\"round\">\n\
         <title>{}</title>{body}</svg>\n",
        escaped(title)
    ))
}

/// The elements of what is drawn, without the `<svg>` around them.
pub(crate) fn body(
    size: (f64, f64),
    draw: impl FnOnce(&mut Canvas<'_>) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let mut text = String::new();
    {
        let (w, h) = fine([size.0, size.1]);
        let size = (w.unsigned_abs(), h.unsigned_abs());
        let mut canvas = Canvas { backend: SVGBackend::with_string(&mut text, size) };
        draw(&mut canvas)?;
        canvas.backend.present().map_err(refused)?;
    }
    // The backend's own opening tag knows one size only.
    let body = text.split_once('>').map_or("", |(_, body)| body);
    Ok(body.trim_end().strip_suffix("</svg>").unwrap_or(body).to_owned())
}

impl Canvas<'_> {
    /// A line through `points`; nothing if there are fewer than two.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn line(&mut self, points: &[Px], ink: &RGBColor, width: f64) -> Result<(), PlotError> {
        if points.len() < 2 {
            return Ok(());
        }
        let style = stroke(ink, width);
        self.backend.draw_path(points.iter().map(|&p| fine(p)), &style).map_err(refused)
    }

    /// As [`Canvas::line`], but what lies beneath shines through: many such
    /// lines on top of each other show where most of them are. `opacity` is 0
    /// to 1.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn veil(
        &mut self,
        points: &[Px],
        ink: &RGBColor,
        width: f64,
        opacity: f64,
    ) -> Result<(), PlotError> {
        if points.len() < 2 {
            return Ok(());
        }
        let mut style = stroke(ink, width);
        style.color = ink.mix(opacity);
        self.backend.draw_path(points.iter().map(|&p| fine(p)), &style).map_err(refused)
    }

    /// A line of dashes through `points`, each `dash` long with as much between
    /// two of them, units of the page.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn dashes(
        &mut self,
        points: &[Px],
        ink: &RGBColor,
        width: f64,
        dash: f64,
    ) -> Result<(), PlotError> {
        for part in dashed(points, dash) {
            self.line(&part, ink, width)?;
        }
        Ok(())
    }

    /// A filled polygon.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn polygon(&mut self, corners: &[Px], ink: &RGBColor) -> Result<(), PlotError> {
        let corners = corners.iter().map(|&p| fine(p));
        self.backend.fill_polygon(corners, &ink.filled()).map_err(refused)
    }

    /// A filled polygon that what lies beneath shines through; `opacity` is 0
    /// to 1.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn wash(&mut self, corners: &[Px], ink: &RGBColor, opacity: f64) -> Result<(), PlotError> {
        let corners = corners.iter().map(|&p| fine(p));
        self.backend.fill_polygon(corners, &ink.mix(opacity).filled()).map_err(refused)
    }

    /// A filled circle.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn disc(&mut self, centre: Px, radius: f64, ink: &RGBColor) -> Result<(), PlotError> {
        let radius = (radius * FINENESS) as u32;
        self.backend.draw_circle(fine(centre), radius, &ink.filled(), true).map_err(refused)
    }

    /// A filled rectangle.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn rectangle(&mut self, rect: &Rect, ink: &RGBColor) -> Result<(), PlotError> {
        let (from, to) = (fine([rect.left, rect.top]), fine([rect.right, rect.bottom]));
        self.backend.draw_rect(from, to, &ink.filled(), true).map_err(refused)
    }

    /// A text on one line whose baseline goes through `place`. Characters that
    /// XML cannot hold become spaces.
    ///
    /// # Errors
    /// [`PlotError::Draw`] if the drawing backend refuses.
    pub fn text(
        &mut self,
        place: Px,
        anchor: Anchor,
        size: f64,
        ink: &RGBColor,
        text: &str,
    ) -> Result<(), PlotError> {
        let (h_pos, transform) = match anchor {
            Anchor::Start => (HPos::Left, FontTransform::None),
            Anchor::Middle => (HPos::Center, FontTransform::None),
            Anchor::End => (HPos::Right, FontTransform::None),
            Anchor::Upwards => (HPos::Center, FontTransform::Rotate270),
        };
        // The backend lowers centred text by half the height of an x.
        let lowered = 0.25 * size;
        let at = match anchor {
            Anchor::Upwards => [place[0] - lowered, place[1]],
            _ => [place[0], place[1] - lowered],
        };
        let font = ("sans-serif", size * FINENESS * PLOTTERS_FONT_FACTOR).into_font();
        let style = font.transform(transform).color(ink).pos(Pos::new(h_pos, VPos::Center));
        self.backend.draw_text(&printable(text), &style, fine(at)).map_err(refused)
    }
}

/// The drawn parts of a dashed line.
fn dashed(points: &[Px], dash: f64) -> Vec<Vec<Px>> {
    let mut parts: Vec<Vec<Px>> = Vec::new();
    // How far the line has come, in dashes and gaps.
    let mut gone = 0.0_f64;
    for pair in points.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let length = trig::hypot(x1 - x0, y1 - y0) / dash;
        // A line this long is none that a page could show.
        if length.is_nan() || length >= 1e5 {
            continue;
        }
        let at = |way: f64| {
            let share = if length > 0.0 { (way / length).clamp(0.0, 1.0) } else { 0.0 };
            [x0 + share * (x1 - x0), y0 + share * (y1 - y0)]
        };
        let mut way = 0.0;
        while way < length {
            let step = (gone.floor() + 1.0 - gone).min(length - way).max(1e-9);
            if (gone.floor() as u64).is_multiple_of(2) {
                match parts.last_mut() {
                    Some(part) if way == 0.0 && part.last() == Some(&pair[0]) => {
                        part.push(at(way + step));
                    }
                    _ => parts.push(vec![at(way), at(way + step)]),
                }
            }
            way += step;
            gone += step;
        }
    }
    parts
}

fn stroke(ink: &RGBColor, width: f64) -> ShapeStyle {
    ink.stroke_width((width * FINENESS).round() as u32)
}

/// A place in steps of the backend. Far outside the page is as good as any other
/// place there, and stays within what renderers can hold.
pub(crate) fn fine(place: Px) -> (i32, i32) {
    let step = |v: f64| (v * FINENESS).round().clamp(-1e6, 1e6) as i32;
    (step(place[0]), step(place[1]))
}

fn refused(error: impl std::fmt::Display) -> PlotError {
    PlotError::Draw { detail: error.to_string() }
}

fn printable(text: &str) -> String {
    let usual = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().map(|c| if usual(c) { c } else { ' ' }).collect()
}

pub(crate) fn escaped(text: &str) -> String {
    printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dashed_line_is_half_there() {
        let parts = dashed(&[[0.0, 0.0], [10.0, 0.0]], 2.0);
        let ends: Vec<(f64, f64)> = parts.iter().map(|p| (p[0][0], p[1][0])).collect();
        assert_eq!(ends, [(0.0, 2.0), (4.0, 6.0), (8.0, 10.0)]);
        // Round a corner the rhythm goes on.
        let parts = dashed(&[[0.0, 0.0], [1.0, 0.0], [1.0, 4.0]], 2.0);
        assert_eq!(parts[0], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        assert_eq!(parts[1], [[1.0, 3.0], [1.0, 4.0]]);
        assert!(dashed(&[[0.0, 0.0], [f64::NAN, 1.0]], 2.0).is_empty());
    }

    #[test]
    fn a_veil_is_transparent() {
        let ink = RGBColor(1, 2, 3);
        let line = [[1.0, 1.0], [5.0, 5.0]];
        let svg = paint((9.0, 9.0), "", |canvas| canvas.veil(&line, &ink, 1.0, 0.25)).unwrap();
        assert!(svg.contains("opacity=\"0.25\""), "{svg}");
    }

    #[test]
    fn a_page_says_its_size_once_and_draws_finer() {
        let ink = RGBColor(0, 0, 0);
        let svg = paint((30.0, 20.0), "a < b & c", |canvas| {
            canvas.line(&[[1.04, 2.0], [3.0, f64::NAN], [f64::INFINITY, -1e300]], &ink, 1.5)?;
            canvas.text([5.0, 5.0], Anchor::Upwards, 10.0, &ink, "tab\there\u{0} <&>")
        })
        .unwrap();
        assert_eq!(svg.matches("<svg").count(), 1);
        assert!(svg.contains(r#"width="30" height="20" viewBox="0 0 300 200""#), "{svg}");
        assert!(svg.contains("<title>a &lt; b &amp; c</title>"), "{svg}");
        assert!(svg.contains(r#"points="10,20 30,0 1000000,-1000000 ""#), "{svg}");
        assert!(svg.contains(r#"stroke-width="15""#), "{svg}");
        assert!(svg.contains("tab here  &lt;&amp;&gt;"), "{svg}");
        assert!(svg.contains(r#"font-size="100""#), "{svg}");
    }
}
