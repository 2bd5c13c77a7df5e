//! The picture in pixels, with letters on machines that have no fonts.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use crate::error::PlotError;

/// Pixels per unit of the SVG: sharp in print and on dense screens.
const PIXELS_PER_UNIT: f32 = 2.0;

/// Renders SVG text, at two pixels per unit, to the bytes of a PNG file.
///
/// Whatever font the text asks for, the letters are Ubuntu Light, or Hack where
/// that has no such letter; both travel with the program, and no font of the
/// machine is looked at, so that every machine draws the same. Letters that
/// neither has (Chinese, say) are left out.
///
/// # Errors
/// [`PlotError`] if the text is no SVG, or one too large for memory.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    let options = Options { fontdb: fonts().into(), ..Options::default() };
    let tree = Tree::from_str(svg, &options)
        .map_err(|error| PlotError::NotSvg { detail: error.to_string() })?;
    let size = tree.size();
    let (width, height) = (size.width() * PIXELS_PER_UNIT, size.height() * PIXELS_PER_UNIT);
    // A float too large for u32 saturates, and the pixmap refuses it.
    let mut pixels = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
        .ok_or(PlotError::TooLarge { width, height })?;
    let scale = Transform::from_scale(PIXELS_PER_UNIT, PIXELS_PER_UNIT);
    resvg::render(&tree, scale, &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| PlotError::Encode { detail: error.to_string() })
}

/// The embedded fonts, the first of them under every generic name.
fn fonts() -> fontdb::Database {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    fonts.load_font_data(epaint_default_fonts::HACK_REGULAR.to_vec());
    let family = fonts
        .faces()
        .next()
        .and_then(|face| face.families.first())
        .map(|(name, _)| name.clone())
        .unwrap_or_default();
    fonts.set_serif_family(&family);
    fonts.set_sans_serif_family(&family);
    fonts.set_monospace_family(family);
    fonts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(inside: &str) -> String {
        let open = r#"<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20">"#;
        format!("{open}{inside}</svg>")
    }

    #[test]
    fn two_pixels_per_unit() {
        let bytes = png(&square("")).unwrap();
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
        let pixels = Pixmap::decode_png(&bytes).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (80, 40));
    }

    #[test]
    fn letters_are_drawn_without_a_font_of_the_machine() {
        for text in ["map", "−°·θ", "Ж"] {
            let label = format!(r#"<text x="2" y="15" font-family="sans-serif">{text}</text>"#);
            let pixels = Pixmap::decode_png(&png(&square(&label)).unwrap()).unwrap();
            let inked = pixels.pixels().iter().filter(|p| p.alpha() > 128).count();
            assert!(inked > 20, "{text}: {inked} pixels");
        }
    }

    #[test]
    fn what_is_no_svg_or_too_large_is_refused() {
        assert!(matches!(png("<svg"), Err(PlotError::NotSvg { .. })));
        assert!(matches!(png(""), Err(PlotError::NotSvg { .. })));
        let vast = square("").replace("\"40\"", "\"4e9\"").replace("\"20\"", "\"4e9\"");
        assert!(matches!(png(&vast), Err(PlotError::TooLarge { .. })));
    }
}
