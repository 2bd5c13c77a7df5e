//! Pictures of maps in the PNG format.

use std::io::Cursor;

use png::{Decoder, DecodingError, Limits, Transformations};
use rusty_contract::FieldError;

use super::pgm::{MAX_PIXELS, Picture};

/// First bytes of every PNG file.
pub const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

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
    if width.saturating_mul(height) > MAX_PIXELS {
        let (size, problem) = (format!("{width} × {height}"), "is too large for a map");
        let remedy = format!("crop the map to {MAX_PIXELS} pixels");
        return Err(FieldError::new("size", size, problem, remedy));
    }
    let mut reader = decoder.read_info().map_err(failed)?;
    let channels = reader.output_color_type().0.samples();
    let mut samples = vec![0; width * height * channels];
    reader.next_frame(&mut samples).map_err(failed)?;
    // The last of two or four channels is opacity.
    let colours = if channels < 3 { 1 } else { 3 };
    let grey = |pixel: &[u8]| pixel[..colours].iter().map(|v| u16::from(*v)).sum();
    let grey = samples.chunks_exact(channels).map(grey).collect();
    Ok(Picture { width, height, maxval: 255 * colours as u16, grey })
}
