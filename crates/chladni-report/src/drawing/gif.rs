//! Moving pictures: GIF files with one palette of 256 colours, which repeat endlessly.

use chladni_frf::{Error, ErrorKind, Result};
use gif::{Encoder, EncodingError, Frame, Repeat};
use std::borrow::Cow;

/// A GIF file of pictures of `width` × `height` px.
///
/// * `frames`: indices of `palette`, row by row from the top
/// * `delay_cs`: time of each picture, hundredths of a second
///
/// # Errors
/// Those of the encoder, which are internal errors.
pub(crate) fn gif(
    [width, height]: [u16; 2],
    palette: &[[u8; 3]; 256],
    frames: &[Vec<u8>],
    delay_cs: u16,
) -> Result<Vec<u8>> {
    let mut out = Vec::new();
    let mut write = || -> std::result::Result<(), EncodingError> {
        let mut encoder = Encoder::new(&mut out, width, height, palette.as_flattened())?;
        encoder.set_repeat(Repeat::Infinite)?;
        for pixels in frames {
            encoder.write_frame(&Frame {
                width,
                height,
                delay: delay_cs,
                buffer: Cow::Borrowed(pixels),
                ..Frame::default()
            })?;
        }
        Ok(())
    };
    write().map_err(|error| Error::new(ErrorKind::Internal, format!("a GIF: {error}")))?;
    Ok(out)
}
