//! Pictures of surroundings from files: Radiance HDR and OpenEXR.

use image::ImageFormat;
use thiserror::Error;

use crate::environment::map::EnvironmentPixels;

/// Why a file is no picture of surroundings.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EnvironmentError {
    /// The file is of another kind.
    #[error("it is neither a Radiance picture (.hdr) nor an OpenEXR picture (.exr)")]
    Kind,
    /// The file is damaged.
    #[error("it cannot be read as {kind}: {reason}")]
    Damaged {
        /// The kind of the file.
        kind: &'static str,
        /// Why it cannot be read.
        reason: String,
    },
    /// The picture has no pixels, or too many.
    #[error(
        "it has {width} x {height} pixels; expected 1 to 134217728, and not far more than its bytes can hold"
    )]
    Size {
        /// Its width.
        width: usize,
        /// Its height.
        height: usize,
    },
}

impl EnvironmentPixels {
    /// Reads a Radiance picture (RGBE) or the colours of an OpenEXR picture, recognized by their first bytes.
    ///
    /// # Errors
    /// The file is of another kind, damaged, or too large.
    pub fn of_file(bytes: &[u8]) -> Result<Self, EnvironmentError> {
        let (width, height, colors) = if bytes.starts_with(b"#?") {
            of_radiance(bytes)?
        } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            of_exr(bytes)?
        } else {
            return Err(EnvironmentError::Kind);
        };
        Self::new(width, height, colors).ok_or(EnvironmentError::Size { width, height })
    }
}

type Pixels = (usize, usize, Vec<[f32; 3]>);

/// An OpenEXR picture has at most this many pixels, and more for each of its bytes: one colour takes next to nothing.
#[cfg(feature = "exr")]
const MOST_UNSEEN: usize = 1 << 23;
#[cfg(feature = "exr")]
const MOST_PER_BYTE: usize = 64;

fn of_radiance(bytes: &[u8]) -> Result<Pixels, EnvironmentError> {
    let picture = image::load_from_memory_with_format(bytes, ImageFormat::Hdr);
    let picture = picture
        .map_err(|error| EnvironmentError::Damaged { kind: "a Radiance picture", reason: error.to_string() })?
        .into_rgb32f();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Ok((width, height, picture.pixels().map(|pixel| pixel.0).collect()))
}

#[cfg(feature = "exr")]
fn of_exr(bytes: &[u8]) -> Result<Pixels, EnvironmentError> {
    use exr::prelude::{MetaData, ReadChannels, ReadLayers, Vec2, read};
    let damaged = |error: exr::error::Error| EnvironmentError::Damaged {
        kind: "an OpenEXR picture",
        reason: error.to_string(),
    };
    // Memory is reserved by the sizes that the file claims.
    let claimed = MetaData::read_from_buffered(std::io::Cursor::new(bytes), false).map_err(damaged)?;
    for Vec2(width, height) in claimed.headers.iter().map(|header| header.layer_size) {
        if width.saturating_mul(height) > MOST_UNSEEN + MOST_PER_BYTE * bytes.len() {
            return Err(EnvironmentError::Size { width, height });
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0f32; 3]; size.area()]),
            |(width, pixels), position: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
                pixels[position.y() * *width + position.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(damaged)?;
    let size = image.layer_data.size;
    Ok((size.width(), size.height(), image.layer_data.channel_data.pixels.1))
}

#[cfg(not(feature = "exr"))]
fn of_exr(_: &[u8]) -> Result<Pixels, EnvironmentError> {
    let reason = "the program was built without OpenEXR".to_owned();
    Err(EnvironmentError::Damaged { kind: "an OpenEXR picture", reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_formats_are_read_and_bad_files_are_errors() {
        // A Radiance picture without run lengths: 2 x 1 pixels of 1 and 0.25, by RGBE.
        let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
        hdr.extend([128, 128, 128, 129, 128, 64, 0, 127]);
        let of = |bytes: &[u8]| format!("{:?}", EnvironmentPixels::of_file(bytes).unwrap());
        let made =
            |width, height, colors| format!("{:?}", EnvironmentPixels::new(width, height, colors).unwrap());
        assert_eq!(of(&hdr), made(2, 1, vec![[1.0; 3], [0.25, 0.125, 0.0]]));
        #[cfg(feature = "exr")]
        {
            use crate::film::buffer::Film;
            use crate::film::pixel::Pixel;
            let film = Film::of_pixels(3, 2, vec![Pixel { color: [0.5, 7.0, 0.25], ..Pixel::EMPTY }; 6]);
            let file = crate::film::exr::exr_file(&film, 0.0, &[]).unwrap();
            assert_eq!(of(&file), made(3, 2, vec![[0.5, 7.0, 0.25]; 6]));
            // A small file that claims 65536 x 65536 pixels.
            let name = b"dataWindow\0box2i\0\x10\0\0\0";
            let mut large = file;
            let at = large.windows(name.len()).position(|part| part == name).unwrap() + name.len() + 8;
            large[at..at + 8].copy_from_slice(&[0xff, 0xff, 0, 0, 0xff, 0xff, 0, 0]);
            assert!(EnvironmentPixels::of_file(&large).is_err());
        }
        for bad in
            [&b"P6 1 1 255 abc"[..], b"#?RADIANCE\n\n-Y 9 +X 9\n\x01", &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]]
        {
            assert!(EnvironmentPixels::of_file(bad).is_err());
        }
    }
}
