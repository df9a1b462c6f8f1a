//! PNG and JPEG images as points; nothing in them is trusted.

use std::io::Cursor;

use crate::visual::Image;

/// Points of the largest image that is read.
const MOST_POINTS: u64 = 1 << 26;
/// Points on a side of the largest image that is kept; larger ones are halved until they fit.
pub(super) const MOST_SIDE: u32 = 4096;

/// Decodes the image in the bytes of a file, whose content says its format; at most `room` points
/// may be kept.
///
/// # Errors
/// The problem, in words.
pub(super) fn decode(bytes: &[u8], room: u64) -> Result<Image, String> {
    let image = if bytes.starts_with(b"\x89PNG") {
        png(bytes, room)?
    } else if bytes.starts_with(b"\xFF\xD8\xFF") {
        jpeg(bytes, room)?
    } else {
        return Err("is neither a PNG nor a JPEG image".to_owned());
    };
    Ok(fitted(image))
}

/// Looks at the size before anything is unpacked.
fn check_size(width: u64, height: u64, room: u64) -> Result<(), String> {
    if width == 0 || height == 0 || width.saturating_mul(height) > MOST_POINTS {
        return Err(format!("has {width}x{height} points, the maximum is {MOST_POINTS}"));
    }
    let (mut across, mut down) = (width, height);
    while across.max(down) > u64::from(MOST_SIDE) {
        (across, down) = ((across / 2).max(1), (down / 2).max(1));
    }
    if across * down > room {
        return Err(format!("has {width}x{height} points, the images before it leave {room}"));
    }
    Ok(())
}

fn png(bytes: &[u8], room: u64) -> Result<Image, String> {
    let broken = |e: png::DecodingError| format!("is a broken PNG image: {e}");
    let limits = png::Limits { bytes: 1 << 29 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = reader.info().size();
    check_size(u64::from(width), u64::from(height), room)?;
    let size = reader.output_buffer_size().ok_or("is a PNG image that is too large")?;
    let mut points = vec![0; size];
    let info = reader.next_frame(&mut points).map_err(broken)?;
    let count = width as usize * height as usize;
    let samples = info.color_type.samples();
    let mut rgba = Vec::with_capacity(4 * count);
    for p in points.chunks_exact(samples).take(count) {
        rgba.extend(match *p {
            [grey] => [grey, grey, grey, 255],
            [grey, alpha] => [grey, grey, grey, alpha],
            [r, g, b] => [r, g, b, 255],
            [r, g, b, a, ..] => [r, g, b, a],
            [] => [255; 4],
        });
    }
    // A palette that was not expanded, or rows that are missing.
    if samples == 0 || rgba.len() != 4 * count {
        return Err("is a PNG image of an unknown kind".to_owned());
    }
    Ok(Image { width, height, rgba })
}

fn jpeg(bytes: &[u8], room: u64) -> Result<Image, String> {
    use zune_jpeg::JpegDecoder;
    use zune_jpeg::zune_core::bytestream::ZCursor;
    use zune_jpeg::zune_core::colorspace::ColorSpace;
    use zune_jpeg::zune_core::options::DecoderOptions;
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGBA)
        .set_max_width(1 << 16)
        .set_max_height(1 << 16)
        // A picture that is cut short shows no more than it has.
        .set_strict_mode(true);
    let broken = |e: zune_jpeg::errors::DecodeErrors| format!("is a broken JPEG image: {e}");
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let (width, height) = decoder.dimensions().ok_or("is a JPEG image without a size")?;
    check_size(width as u64, height as u64, room)?;
    let rgba = decoder.decode().map_err(broken)?;
    let (width, height) = (u32::try_from(width), u32::try_from(height));
    match (width, height) {
        (Ok(width), Ok(height))
            if rgba.len() as u64 == 4 * u64::from(width) * u64::from(height) =>
        {
            Ok(Image { width, height, rgba })
        }
        _ => Err("is a JPEG image of an unknown kind".to_owned()),
    }
}

/// The image, halved until it has no more than [`MOST_SIDE`] points on a side.
fn fitted(mut image: Image) -> Image {
    while image.width.max(image.height) > MOST_SIDE {
        image = image.halved(|_, bytes| {
            let sum: u16 = bytes.map(u16::from).iter().sum();
            u8::try_from(sum / 4).unwrap_or(u8::MAX)
        });
    }
    image
}

#[cfg(test)]
mod tests {
    use super::{Image, MOST_POINTS, check_size, decode, fitted};

    #[test]
    fn a_long_image_is_halved_until_it_fits() {
        let image = Image { width: 9000, height: 1, rgba: [10, 20, 30, 255].repeat(9000) };
        let small = fitted(image);
        assert_eq!((small.width, small.height), (2250, 1));
        assert!(small.rgba.chunks(4).all(|p| p == [10, 20, 30, 255]));
    }

    #[test]
    fn what_is_no_image_is_told() {
        let why = |bytes: &[u8]| decode(bytes, MOST_POINTS).unwrap_err();
        assert!(why(b"GIF89a").contains("neither"));
        assert!(why(b"\x89PNG\r\n\x1a\n").contains("broken PNG"));
        assert!(why(b"\xFF\xD8\xFF\xE0").contains("JPEG"));
        assert!(why(b"").contains("neither"));
    }

    #[test]
    fn what_is_kept_of_an_image_must_have_room() {
        assert!(check_size(1 << 13, 1 << 13, 1 << 24).is_ok(), "a quarter of it is kept");
        assert!(check_size(1 << 13, 1 << 13, (1 << 24) - 1).is_err());
        assert!(check_size(1 << 14, 1 << 14, u64::MAX).is_err());
        assert!(check_size(0, 1, u64::MAX).is_err());
    }
}
