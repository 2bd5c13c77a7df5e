//! Grey pictures in the PGM format, text (P2) and binary (P5).
//!
//! Source: J. Poskanzer, *pgm(5)*, Netpbm. Of several pictures in one file the
//! first is read.

use rusty_contract::FieldError;

/// The most pixels of a picture, 6.7 · 10⁷: a square of 410 m in cells of 5 cm. A
/// large building has some 10⁶.
pub const MAX_PIXELS: usize = 1 << 26;

/// A picture as it is in the file: the first row is the uppermost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// White, 1 to 65535; black is 0.
    pub maxval: u16,
    /// Row by row from the top.
    pub grey: Vec<u16>,
}

/// What is left to read of a file.
struct Reader<'a> {
    bytes: &'a [u8],
    place: usize,
}

impl Reader<'_> {
    /// The next number; spaces and comments before it are skipped.
    fn number(&mut self, field: &str, most: usize) -> Result<usize, FieldError> {
        let mut in_comment = false;
        while let Some(byte) = self.bytes.get(self.place) {
            match byte {
                b'\n' | b'\r' => in_comment = false,
                b'#' => in_comment = true,
                _ if in_comment || byte.is_ascii_whitespace() => {}
                _ => break,
            }
            self.place += 1;
        }
        let rest = &self.bytes[self.place.min(self.bytes.len())..];
        let token = rest.split(|b| b.is_ascii_whitespace() || *b == b'#').next().unwrap_or(rest);
        self.place += token.len();
        let text = String::from_utf8_lossy(&token[..token.len().min(20)]).into_owned();
        let whole = str::from_utf8(token).unwrap_or("not text");
        let remedy = || format!("give a whole number, at most {most}, or save the picture again");
        match whole.parse::<usize>() {
            Ok(value) if value <= most => Ok(value),
            Ok(_) => Err(FieldError::new(field, text, "is too large", remedy())),
            Err(_) if token.is_empty() => {
                let problem = "is missing: the file ends before it";
                Err(FieldError::new(field, "nothing", problem, remedy()))
            }
            Err(_) => Err(FieldError::new(field, text, "is no number", remedy())),
        }
    }
}

/// Reads a picture.
///
/// # Errors
/// [`FieldError`] names the part of the file that cannot be read.
pub fn read(bytes: &[u8]) -> Result<Picture, FieldError> {
    let magic = &bytes[..bytes.len().min(2)];
    let is_text = match magic {
        b"P2" => true,
        b"P5" => false,
        _ => {
            let found = String::from_utf8_lossy(magic).escape_default().to_string();
            let remedy = "save the picture as PGM (\"P2\" or \"P5\") or PNG";
            return Err(FieldError::new("first two bytes", found, "are not those of PGM", remedy));
        }
    };
    let mut reader = Reader { bytes, place: 2 };
    let width = reader.number("width", MAX_PIXELS)?;
    let height = reader.number("height", MAX_PIXELS)?;
    let pixels = width.saturating_mul(height);
    if pixels == 0 || pixels > MAX_PIXELS {
        let remedy = format!("give it 1 to {MAX_PIXELS} pixels");
        let size = format!("{width} × {height}");
        return Err(FieldError::new("size", size, "is no size of a map", remedy));
    }
    let maxval = reader.number("maxval", usize::from(u16::MAX))? as u16;
    if maxval == 0 {
        return Err(FieldError::new("maxval", 0, "leaves no grey", "give it 1 to 65535"));
    }
    let grey = match is_text {
        true => text(&mut reader, pixels, maxval)?,
        false => binary(&reader, pixels, maxval)?,
    };
    Ok(Picture { width, height, maxval, grey })
}

fn text(reader: &mut Reader<'_>, pixels: usize, maxval: u16) -> Result<Vec<u16>, FieldError> {
    // Each takes two bytes at least; the promise of a short file is not believed.
    let left = reader.bytes.len().saturating_sub(reader.place) / 2 + 1;
    let mut grey = Vec::with_capacity(pixels.min(left));
    for pixel in 0..pixels {
        let value = reader.number(&format!("pixel {pixel}"), usize::from(maxval))?;
        grey.push(value as u16);
    }
    Ok(grey)
}

fn binary(reader: &Reader<'_>, pixels: usize, maxval: u16) -> Result<Vec<u16>, FieldError> {
    // One byte of white space ends the header.
    let body = reader.bytes.get(reader.place + 1..).unwrap_or_default();
    let bytes_each = if maxval < 256 { 1 } else { 2 };
    let Some(body) = body.get(..pixels * bytes_each) else {
        let problem = format!("are fewer than the {} of {pixels} pixels", pixels * bytes_each);
        let remedy = "the file was cut off: save or copy it again";
        return Err(FieldError::new("bytes of pixels", body.len(), problem, remedy));
    };
    let grey: Vec<u16> = match bytes_each {
        1 => body.iter().map(|byte| u16::from(*byte)).collect(),
        _ => body.as_chunks().0.iter().copied().map(u16::from_be_bytes).collect(),
    };
    match grey.iter().position(|value| *value > maxval) {
        None => Ok(grey),
        Some(pixel) => {
            let (field, remedy) = (format!("pixel {pixel}"), "correct maxval in the file's head");
            let problem = format!("is brighter than maxval, {maxval}");
            Err(FieldError::new(field, grey[pixel], problem, remedy))
        }
    }
}

/// The file (P5) of a picture with one byte a pixel, row by row from the top.
pub fn write(width: usize, height: usize, comment: &str, grey: &[u8]) -> Vec<u8> {
    let mut bytes = format!("P5\n# {comment}\n{width} {height}\n255\n").into_bytes();
    bytes.extend_from_slice(grey);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(bytes: &[u8]) -> Vec<u16> {
        read(bytes).unwrap().grey
    }

    #[test]
    fn all_forms_give_the_same_pixels() {
        assert_eq!(grey(b"P5\n3 2\n255\n\x00\x01\x20\x0a\xff\x80"), [0, 1, 32, 10, 255, 128]);
        assert_eq!(grey(b"P2 3 2 255 0 1 32 10 255 128"), [0, 1, 32, 10, 255, 128]);
        let commented = b"P2# a\n#b\n3 #c\n2\r\n# d e\n255\n0 1# x\n32\n10 255\t128\n";
        assert_eq!(grey(commented), [0, 1, 32, 10, 255, 128]);
        assert_eq!(grey(b"P5 2 1 1000 \x03\xe8\x00\x01"), [1000, 1]);
        assert_eq!(grey(b"P2 2 1 000000000000000000000255 255 0000000000000000000007"), [255, 7]);
        // The byte after maxval ends the head, whatever the first pixel is.
        assert_eq!(grey(b"P5 2 1 255\n# "), [35, 32]);
    }

    #[test]
    fn what_was_written_is_read() {
        let pixels: Vec<u8> = (0..=255).collect();
        let picture = read(&write(32, 8, "by a test", &pixels)).unwrap();
        assert_eq!((picture.width, picture.height, picture.maxval), (32, 8, 255));
        assert!(picture.grey.iter().zip(&pixels).all(|(a, b)| *a == u16::from(*b)));
    }

    #[test]
    fn what_is_no_picture_is_named() {
        for (bytes, expected) in [
            (&b""[..], "first two bytes = : are not those of PGM"),
            (b"P6 1 1 255 \x00\x00\x00", "first two bytes = P6"),
            (b"\x89PNG", "are not those of PGM; save the picture as PGM"),
            (b"P5", "width = nothing: is missing"),
            (b"P5 -3 2 255 ", "width = -3: is no number"),
            (b"P5 3 x 255 ", "height = x: is no number"),
            (b"P5 0 2 255 ", "size = 0"),
            (b"P5 60000 60000 255 ", "size = 60000"),
            (b"P5 99999999999999999999 1 255 ", "width = 99999999999999999999"),
            (b"P2 00000000000000000001x 1 255 0", "width = 00000000000000000001: is no number"),
            (b"P5 1 1 0 \x00", "maxval = 0: leaves no grey"),
            (b"P5 1 1 65536 \x00", "maxval = 65536: is too large"),
            (b"P5 3 2 255 \x00\x00", "bytes of pixels = 2: are fewer than the 6"),
            (b"P5 2 1 1000 \x03\xe8\x00", "bytes of pixels = 3: are fewer than the 4"),
            (b"P5 2 1 100 \x64\x65", "pixel 1 = 101: is brighter than maxval, 100"),
            (b"P2 2 1 100 100", "pixel 1 = nothing: is missing"),
            (b"P2 2 1 100 100 101", "pixel 1 = 101: is too large"),
            (b"P2 60000 1000 255 1", "pixel 1 = nothing"),
        ] {
            let error = read(bytes).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}, not {expected}");
        }
    }
}
