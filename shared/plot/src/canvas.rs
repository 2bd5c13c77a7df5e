//! A page to draw on: SVG text with coordinates finer than a pixel.
//!
//! The page is drawn ten times too large in whole numbers, which are short, and
//! the view box of the finished SVG scales it back.

use std::fmt::{self, Write as _};

/// A place on the page, units of the page (CSS pixels): x right, y down.
pub type Px = [f64; 2];

/// Steps of a drawing per unit of the page.
pub(crate) const FINENESS: f64 = 10.0;

/// A colour: red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RGBColor(pub u8, pub u8, pub u8);

impl fmt::Display for RGBColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02X}{:02X}{:02X}", self.0, self.1, self.2)
    }
}

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
#[derive(Default)]
pub struct Canvas {
    text: String,
}

/// Draws a page of `width` × `height` units, white and opaque, with a title for
/// those who cannot see it, and returns the SVG.
#[must_use]
pub fn paint((width, height): (f64, f64), title: &str, draw: impl FnOnce(&mut Canvas)) -> String {
    let body = elements(|canvas| {
        let page = Rect { left: 0.0, top: 0.0, right: width, bottom: height };
        canvas.rectangle(&page, &RGBColor(255, 255, 255));
        draw(canvas);
    });
    let (w, h) = fine([width, height]);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {w} {h}\" role=\"img\" stroke-linejoin=\"round\">\n\
         <title>{}</title>\n{body}</svg>\n",
        escaped(title)
    )
}

/// The elements of what is drawn, without the `<svg>` around them.
pub(crate) fn elements(draw: impl FnOnce(&mut Canvas)) -> String {
    let mut canvas = Canvas::default();
    draw(&mut canvas);
    canvas.text
}

impl Canvas {
    /// A line through `points`; nothing if there are fewer than two.
    pub fn line(&mut self, points: &[Px], ink: &RGBColor, width: f64) {
        self.stroke(points, ink, width, "");
    }

    /// As [`Canvas::line`], but what lies beneath shines through: many such
    /// lines on top of each other show where most of them are. `opacity` is 0
    /// to 1.
    pub fn veil(&mut self, points: &[Px], ink: &RGBColor, width: f64, opacity: f64) {
        self.stroke(points, ink, width, &format!(" opacity=\"{opacity}\""));
    }

    /// A line of dashes through `points`, each `dash` long with as much between
    /// two of them, units of the page.
    pub fn dashes(&mut self, points: &[Px], ink: &RGBColor, width: f64, dash: f64) {
        let dash = dash * FINENESS;
        self.stroke(points, ink, width, &format!(" stroke-dasharray=\"{dash}\""));
    }

    fn stroke(&mut self, points: &[Px], ink: &RGBColor, width: f64, more: &str) {
        if points.len() < 2 {
            return;
        }
        let (points, width) = (listed(points), (width * FINENESS).round());
        self.element(&format!(
            "polyline fill=\"none\"{more} stroke=\"{ink}\" stroke-width=\"{width}\" \
             points=\"{points}\""
        ));
    }

    /// A filled polygon.
    pub fn polygon(&mut self, corners: &[Px], ink: &RGBColor) {
        self.element(&format!("polygon fill=\"{ink}\" points=\"{}\"", listed(corners)));
    }

    /// A filled polygon that what lies beneath shines through; `opacity` is 0
    /// to 1.
    pub fn wash(&mut self, corners: &[Px], ink: &RGBColor, opacity: f64) {
        let corners = listed(corners);
        self.element(&format!("polygon opacity=\"{opacity}\" fill=\"{ink}\" points=\"{corners}\""));
    }

    /// A filled polygon with an edge, both of which what lies beneath shines through;
    /// opacities of the inside and of the edge are 0 to 1.
    pub fn band(&mut self, corners: &[Px], ink: &RGBColor, [inside, edge]: [f64; 2]) {
        let corners = listed(corners);
        self.element(&format!(
            "polygon fill-opacity=\"{inside}\" fill=\"{ink}\" stroke-opacity=\"{edge}\" \
             stroke=\"{ink}\" stroke-width=\"{FINENESS}\" points=\"{corners}\""
        ));
    }

    /// A filled circle.
    pub fn disc(&mut self, centre: Px, radius: f64, ink: &RGBColor) {
        let ((x, y), radius) = (fine(centre), (radius * FINENESS).round());
        self.element(&format!("circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{ink}\""));
    }

    /// A filled rectangle.
    pub fn rectangle(&mut self, rect: &Rect, ink: &RGBColor) {
        let place = placed(rect);
        self.element(&format!("rect {place} fill=\"{ink}\""));
    }

    /// A text on one line whose baseline goes through `place`. Characters that
    /// XML cannot hold become spaces.
    pub fn text(&mut self, place: Px, anchor: Anchor, size: f64, ink: &RGBColor, text: &str) {
        let ((x, y), size) = (fine(place), (size * FINENESS).round());
        let (anchor, turn) = match anchor {
            Anchor::Start => ("start", String::new()),
            Anchor::Middle => ("middle", String::new()),
            Anchor::End => ("end", String::new()),
            Anchor::Upwards => ("middle", format!(" transform=\"rotate(-90, {x}, {y})\"")),
        };
        let _ = write!(
            self.text,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" font-family=\"sans-serif\" \
             font-size=\"{size}\" fill=\"{ink}\"{turn}>\n{}\n</text>\n",
            escaped(text)
        );
    }

    fn element(&mut self, inside: &str) {
        let _ = writeln!(self.text, "<{inside}/>");
    }
}

fn listed(points: &[Px]) -> String {
    points.iter().map(|&p| fine(p)).map(|(x, y)| format!("{x},{y} ")).collect()
}

/// Place and size of a rectangle, as attributes.
pub(crate) fn placed(rect: &Rect) -> String {
    let ((x, y), (right, bottom)) = (fine([rect.left, rect.top]), fine([rect.right, rect.bottom]));
    let (width, height) = ((right - x).max(0), (bottom - y).max(0));
    format!("x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"")
}

/// A place in steps of the drawing. Far outside the page is as good as any other
/// place there, and stays within what renderers can hold.
pub(crate) fn fine(place: Px) -> (i32, i32) {
    let step = |v: f64| (v * FINENESS).round().clamp(-1e6, 1e6) as i32;
    (step(place[0]), step(place[1]))
}

/// Text as it may be in an element or an attribute of SVG or hypertext.
/// Characters that they cannot hold become spaces.
#[must_use]
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}

/// A text of at most `most` characters; a longer one ends with an ellipsis.
#[must_use]
pub fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dashed_line_is_half_there() {
        let ink = RGBColor(1, 2, 3);
        let line = [[1.0, 1.0], [5.0, 5.0]];
        let svg = paint((9.0, 9.0), "", |canvas| canvas.dashes(&line, &ink, 1.0, 2.0));
        assert!(svg.contains("stroke-dasharray=\"20\""), "{svg}");
    }

    #[test]
    fn a_veil_is_transparent() {
        let ink = RGBColor(1, 2, 3);
        let line = [[1.0, 1.0], [5.0, 5.0]];
        let svg = paint((9.0, 9.0), "", |canvas| canvas.veil(&line, &ink, 1.0, 0.25));
        assert!(svg.contains("opacity=\"0.25\""), "{svg}");
    }

    #[test]
    fn a_page_says_its_size_once_and_draws_finer() {
        let ink = RGBColor(0, 0, 0);
        let svg = paint((30.0, 20.0), "a < b & c", |canvas| {
            canvas.line(&[[1.04, 2.0], [3.0, f64::NAN], [f64::INFINITY, -1e300]], &ink, 1.5);
            canvas.text([5.0, 5.0], Anchor::Upwards, 10.0, &ink, "tab\there\u{0} <&>");
        });
        assert_eq!(svg.matches("<svg").count(), 1);
        assert!(svg.contains(r#"width="30" height="20" viewBox="0 0 300 200""#), "{svg}");
        assert!(svg.contains("<title>a &lt; b &amp; c</title>"), "{svg}");
        assert!(svg.contains(r#"points="10,20 30,0 1000000,-1000000 ""#), "{svg}");
        assert!(svg.contains(r#"stroke-width="15""#), "{svg}");
        assert!(svg.contains("tab here  &lt;&amp;&gt;"), "{svg}");
        assert!(svg.contains(r#"font-size="100""#), "{svg}");
    }
}
