//! Why there is no picture.

use thiserror::Error;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlotError {
    /// The text to be rendered is no SVG.
    #[error("picture: the text is no SVG ({detail}); give it as `svg` made it")]
    NotSvg {
        /// What the parser says, with the place.
        detail: String,
    },
    /// The picture does not fit into memory.
    #[error("picture: {width} × {height} pixels are too many; make the SVG smaller")]
    TooLarge {
        /// Its width, pixels.
        width: f32,
        /// Its height, pixels.
        height: f32,
    },
    /// The pixels cannot be written as PNG.
    #[error("picture: writing PNG failed: {detail}; use the SVG instead")]
    Encode {
        /// What the encoder says.
        detail: String,
    },
}
