//! A drawing in layers: parts of a page of hypertext that can be moved, hidden
//! and recoloured after they were drawn.
//!
//! A layer becomes a group (`<g>`) of the drawing. It may have classes, a place
//! it was moved to, and a frame beyond which nothing of it is seen. Coordinates
//! in the drawing are [`STEPS_PER_UNIT`] times those of the page.

use crate::canvas::{Canvas, FINENESS, Px, Rect, elements, escaped, fine, placed};

/// Coordinates in the text of a drawing per unit of the page.
pub const STEPS_PER_UNIT: f64 = FINENESS;

/// A drawing while its layers are added, the lowest first.
pub struct Drawing {
    size: (f64, f64),
    /// No other drawing of the same document has it.
    id: String,
    text: String,
    frames: Vec<Rect>,
}

/// The position of a layer in its drawing.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// Classes, separated by spaces.
    pub class: String,
    /// Where it was moved to, as SVG's `transform` has it (in the coordinates
    /// of the drawing); empty: it was not.
    pub transform: String,
    /// Nothing of the layer is seen outside of this. It does not move along.
    pub frame: Option<Rect>,
}

impl Layer {
    /// A layer with these classes.
    #[must_use]
    pub fn of(class: impl Into<String>) -> Self {
        Self { class: class.into(), ..Self::default() }
    }

    /// Cut at a frame.
    #[must_use]
    pub fn within(self, frame: Rect) -> Self {
        Self { frame: Some(frame), ..self }
    }

    /// Moved: what is drawn at x is found at `matrix` · x + `to`, and `matrix`
    /// is given by its columns, in units of the page.
    #[must_use]
    pub fn moved(self, [a, b, c, d]: [f64; 4], to: Px) -> Self {
        let [e, f] = to.map(|v| v * FINENESS);
        let transform = format!("matrix({a:.4} {b:.4} {c:.4} {d:.4} {e:.1} {f:.1})");
        Self { transform, ..self }
    }
}

impl Drawing {
    /// An empty drawing, without ground, of `width` × `height` units. `id` is
    /// made of letters; no other drawing of the document has the same.
    #[must_use]
    pub fn new(size: (f64, f64), id: &str) -> Self {
        Self { size, id: id.to_owned(), text: String::new(), frames: Vec::new() }
    }

    /// Adds a layer on top of those before.
    pub fn layer(&mut self, layer: &Layer, draw: impl FnOnce(&mut Canvas)) {
        let inside = elements(draw);
        let attribute = |name: &str, value: &str| match value {
            "" => String::new(),
            value => format!(" {name}=\"{}\"", escaped(value)),
        };
        let (class, moved) =
            (attribute("class", &layer.class), attribute("transform", &layer.transform));
        match layer.frame {
            // The group around it holds the frame still while the layer moves.
            Some(frame) => {
                let path = self.clip_path(frame);
                self.text.push_str(&format!(
                    "<g clip-path=\"url(#{path})\"><g{class}{moved}>{inside}</g></g>\n"
                ));
            }
            None => self.text.push_str(&format!("<g{class}{moved}>{inside}</g>\n")),
        }
    }

    /// The name of the path that cuts at `frame`; defined where it is new.
    fn clip_path(&mut self, frame: Rect) -> String {
        let known = self.frames.iter().position(|f| *f == frame);
        let name = format!("{}-frame-{}", self.id, known.unwrap_or(self.frames.len()));
        if known.is_none() {
            self.frames.push(frame);
            let place = placed(&frame);
            self.text.push_str(&format!("<clipPath id=\"{name}\"><rect {place}/></clipPath>\n"));
        }
        name
    }

    /// The drawing as an element of a document: as wide as its place there. For
    /// those who cannot see it it has a title and a description. `attributes`
    /// are added to it as they are.
    #[must_use]
    pub fn finish(self, title: &str, description: &str, attributes: &str) -> String {
        let Self { size, id, text, .. } = self;
        let (w, h) = fine([size.0, size.1]);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" id=\"{id}\" viewBox=\"0 0 {w} {h}\" \
             role=\"img\" aria-labelledby=\"{id}-title {id}-text\" stroke-linejoin=\"round\" \
             {attributes}>\n<title id=\"{id}-title\">{}</title>\n\
             <desc id=\"{id}-text\">{}</desc>\n{text}</svg>\n",
            escaped(title),
            escaped(description)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png;
    use crate::style::INK;

    #[test]
    fn layers_are_groups_that_were_moved_and_cut() {
        let frame = Rect { left: 10.0, top: 20.0, right: 30.0, bottom: 50.0 };
        let mut drawing = Drawing::new((100.0, 60.0), "a");
        let dot = |canvas: &mut Canvas| canvas.disc([0.0, 0.0], 4.0, &INK);
        drawing.layer(&Layer::of("ground"), dot);
        for _ in 0..2 {
            let layer = Layer::of("x \"<").within(frame).moved([1.0, 0.0, 0.0, 2.0], [5.0, 6.5]);
            drawing.layer(&layer, dot);
        }
        let text = drawing.finish("a < b", "more & more", "data-x=\"1\"");
        for part in [
            "viewBox=\"0 0 1000 600\"",
            "data-x=\"1\"",
            "<title id=\"a-title\">a &lt; b</title>",
            "<desc id=\"a-text\">more &amp; more</desc>",
            "<g class=\"ground\">",
            "<g class=\"x &quot;&lt;\" transform=\"matrix(1.0000 0.0000 0.0000 2.0000 50.0 65.0)\">",
            "<rect x=\"100\" y=\"200\" width=\"200\" height=\"300\"/>",
        ] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
        assert_eq!((text.matches("<clipPath").count(), text.matches("<svg").count()), (1, 1));
        assert_eq!(text.matches("url(#a-frame-0)").count(), 2);
        assert!(png(&text).is_ok(), "{text}");
    }
}
