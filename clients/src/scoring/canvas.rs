//! A page to draw on: plotters' SVG backend with coordinates finer than a pixel.
//!
//! The backend takes whole numbers only, which turns a slow curve into a
//! staircase. The page is therefore drawn ten times too large, and the view box
//! of the finished SVG scales it back.

use plotters::prelude::{DrawingBackend, FontTransform, IntoFont, RGBColor, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, ShapeStyle};

use super::picture::PictureError;

/// A place on the page, units of the page (CSS pixels): x right, y down.
pub(super) type Px = [f64; 2];

/// Steps of the backend per unit of the page.
const FINENESS: f64 = 10.0;
/// plotters writes font sizes divided by this number.
const PLOTTERS_FONT_FACTOR: f64 = 1.24;

/// A rectangle of the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }
}

/// Where a text stands relative to its place, and which way it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
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
pub(super) struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

/// Draws a page of `width` × `height` units, white and opaque, with a title for
/// those who cannot see it, and returns the SVG.
pub(super) fn paint(
    (width, height): (f64, f64),
    title: &str,
    draw: impl FnOnce(&mut Canvas<'_>) -> Result<(), PictureError>,
) -> Result<String, PictureError> {
    let mut text = String::new();
    {
        let (w, h) = fine([width, height]);
        let size = (w.unsigned_abs(), h.unsigned_abs());
        let mut canvas = Canvas { backend: SVGBackend::with_string(&mut text, size) };
        let page = Rect { left: 0.0, top: 0.0, right: width, bottom: height };
        canvas.rectangle(&page, &RGBColor(255, 255, 255))?;
        draw(&mut canvas)?;
        canvas.backend.present().map_err(refused)?;
    }
    // The backend's own opening tag knows one size only.
    let body = text.split_once('>').map_or("", |(_, body)| body);
    let (w, h) = fine([width, height]);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {w} {h}\" role=\"img\" stroke-linejoin=\"round\">\n\
         <title>{}</title>{body}",
        escaped(title)
    ))
}

impl Canvas<'_> {
    /// A line through `points`; nothing if there are fewer than two.
    pub fn line(&mut self, points: &[Px], ink: &RGBColor, width: f64) -> Result<(), PictureError> {
        if points.len() < 2 {
            return Ok(());
        }
        let style = stroke(ink, width);
        self.backend.draw_path(points.iter().map(|&p| fine(p)), &style).map_err(refused)
    }

    /// A filled polygon.
    pub fn polygon(&mut self, corners: &[Px], ink: &RGBColor) -> Result<(), PictureError> {
        let corners = corners.iter().map(|&p| fine(p));
        self.backend.fill_polygon(corners, &ink.filled()).map_err(refused)
    }

    /// A filled circle.
    pub fn disc(&mut self, centre: Px, radius: f64, ink: &RGBColor) -> Result<(), PictureError> {
        let radius = (radius * FINENESS) as u32;
        self.backend.draw_circle(fine(centre), radius, &ink.filled(), true).map_err(refused)
    }

    /// A filled rectangle.
    pub fn rectangle(&mut self, rect: &Rect, ink: &RGBColor) -> Result<(), PictureError> {
        let (from, to) = (fine([rect.left, rect.top]), fine([rect.right, rect.bottom]));
        self.backend.draw_rect(from, to, &ink.filled(), true).map_err(refused)
    }

    /// A text on one line whose baseline goes through `place`. Characters that
    /// XML cannot hold become spaces.
    pub fn text(
        &mut self,
        place: Px,
        anchor: Anchor,
        size: f64,
        ink: &RGBColor,
        text: &str,
    ) -> Result<(), PictureError> {
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

fn stroke(ink: &RGBColor, width: f64) -> ShapeStyle {
    ink.stroke_width((width * FINENESS).round() as u32)
}

/// A place in steps of the backend. Far outside the page is as good as any other
/// place there, and stays within what renderers can hold.
fn fine(place: Px) -> (i32, i32) {
    let step = |v: f64| (v * FINENESS).round().clamp(-1e6, 1e6) as i32;
    (step(place[0]), step(place[1]))
}

fn refused(error: impl std::fmt::Display) -> PictureError {
    PictureError::Draw { detail: error.to_string() }
}

fn printable(text: &str) -> String {
    let usual = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().map(|c| if usual(c) { c } else { ' ' }).collect()
}

fn escaped(text: &str) -> String {
    printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

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
