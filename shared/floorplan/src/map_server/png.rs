//! Pictures of maps in the PNG format.

use std::io::Cursor;

use png::{Decoder, DecodingError, Limits, Transformations};
use rusty_contract::FieldError;

use super::pgm::{MAX_PIXELS, Picture};

/// First bytes of every PNG file.
pub const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Most pixels in a row.
const MAX_SIDE: usize = 1 << 16;

/// Reads a picture. Its grey is the mean of the colours of a pixel, of which 8 bits
/// count; opacity is ignored.
///
/// # Errors
/// [`FieldError`] names the part of the file that cannot be read.
pub fn read(bytes: &[u8]) -> Result<Picture, FieldError> {
    let failed = |error: DecodingError| {
        FieldError::new("PNG", error, "cannot be decoded", "save or copy the picture again")
    };
    let limits = Limits { bytes: 8 * MAX_PIXELS };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let header = decoder.read_header_info().map_err(failed)?;
    let (width, height) = (header.width as usize, header.height as usize);
    let fits = width <= MAX_SIDE && width * height <= MAX_PIXELS;
    if !fits || header.interlaced {
        let (size, problem) = (format!("{width} × {height}"), "is too large, or interlaced");
        let remedy = format!(
            "crop the map to {MAX_PIXELS} pixels, {MAX_SIDE} in a row, and save it without \
             interlacing"
        );
        return Err(FieldError::new("size", size, problem, remedy));
    }
    let mut reader = decoder.read_info().map_err(failed)?;
    let channels = reader.output_color_type().0.samples();
    // The last of two or four channels is opacity.
    let colours = if channels < 3 { 1 } else { 3 };
    // Row by row: memory for what is there, not for what the header promises.
    let mut grey = Vec::new();
    while let Some(row) = reader.next_row().map_err(failed)? {
        let pixels = row.data().chunks_exact(channels);
        grey.extend(
            pixels.map(|pixel| pixel[..colours].iter().map(|v| u16::from(*v)).sum::<u16>()),
        );
    }
    if grey.len() != width * height {
        let (problem, remedy) = ("are not those of the header", "save or copy the picture again");
        return Err(FieldError::new("pixels", grey.len(), problem, remedy));
    }
    Ok(Picture { width, height, maxval: 255 * colours as u16, grey })
}
