//! Denoising of finished pictures by Open Image Denoise, a C library that is loaded when it is wanted.
//!
//! The library gets linear light and, where the film has them, the albedo and the normal of first hits. It runs on the
//! processor, so that a picture does not depend on the graphics card. A film is denoised after its last tile, when its file is
//! made: partial files have the samples.

use std::borrow::Cow;

use superegg_render::{Film, Output, RenderSettings};
use thiserror::Error;

/// Why a picture cannot be denoised.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DenoiseError {
    /// The library cannot be loaded.
    #[error(
        "denoising needs the library Open Image Denoise 2, which cannot be loaded ({reason}): install it (Fedora: oidn-libs, \
         Arch: openimagedenoise, Homebrew: open-image-denoise, or 'pip install pyoidn'), and name its file in {} if it is in no \
         folder of the system; or leave out --denoise and 'set denoise on'",
        VARIABLE
    )]
    Missing {
        /// The reason of the system.
        reason: String,
    },
    /// The library reports an error.
    #[error("Open Image Denoise: {0}")]
    Failed(String),
}

/// The environment variable with the path of the library.
const VARIABLE: &str = "SUPEREGG_OIDN";

/// The settings for a render whose picture is denoised if they ask for that: with the layers that guide it.
///
/// # Errors
/// The picture is to be denoised, and the library is missing.
pub fn prepared(settings: RenderSettings) -> Result<RenderSettings, DenoiseError> {
    check(&settings)?;
    let layers = settings.keeps_layers() || is_wanted(&settings);
    Ok(settings.with_layers(layers))
}

/// Checks that a picture of these settings can be denoised, if it is to be.
///
/// # Errors
/// The library is missing.
pub(crate) fn check(settings: &RenderSettings) -> Result<(), DenoiseError> {
    if is_wanted(settings) { library::Library::load().map(drop) } else { Ok(()) }
}

/// Whether the settings ask for denoising. Outputs that are no light are not denoised.
pub(crate) fn is_wanted(settings: &RenderSettings) -> bool {
    settings.picture.denoise && settings.output == Output::Light
}

/// Whether the picture of a film is denoised: its settings ask for that, and it lacks no pixel.
pub(crate) fn applies(film: &Film, settings: &RenderSettings) -> bool {
    is_wanted(settings) && film.sample_counts().all(|count| count > 0)
}

/// The film, denoised if its settings ask for that. A film that lacks pixels stays as it is.
///
/// # Errors
/// The library is missing or fails.
pub fn denoised<'f>(film: &'f Film, settings: &RenderSettings) -> Result<Cow<'f, Film>, DenoiseError> {
    if !applies(film, settings) {
        return Ok(Cow::Borrowed(film));
    }
    let library = library::Library::load()?;
    // A sample that is no number would spread.
    let finite = |values: [f32; 3]| values.map(|value| if value.is_finite() { value } else { 0.0 });
    let color: Vec<[f32; 3]> = film.colors().iter().map(|color| finite(*color)).collect();
    let guides = film.has_layers().then(|| {
        let albedo = film.pixels().map(|pixel| finite(pixel.albedo)).collect();
        let normal = film.pixels().map(|pixel| finite(pixel.normal)).collect();
        [albedo, normal]
    });
    let size = (film.width() as usize, film.height() as usize);
    let clean = library.denoise(size, &color, guides.as_ref())?;
    let mut film = film.clone();
    let positions = (0..film.height()).flat_map(|y| (0..size.0 as u32).map(move |x| (x, y)));
    for ((x, y), color) in positions.zip(clean) {
        if let Some(pixel) = film.pixel(x, y) {
            film.set(x, y, superegg_render::Pixel { color, ..pixel });
        }
    }
    Ok(Cow::Owned(film))
}

/// The functions of the library that are used here.
mod library {
    // The functions of a C library can only be loaded and called so. Each call is checked against the library's documentation of
    // version 2, whose functions keep their types for as long as the number in the name of the file stays.
    #![allow(unsafe_code)]

    use std::ffi::{CStr, c_char, c_int, c_void};
    use std::ptr;

    use crate::denoise::{DenoiseError, VARIABLE};

    /// A device or a filter.
    type Object = *mut c_void;

    const CPU: c_int = 1;
    /// Three f32 a pixel.
    const FLOAT3: c_int = 3;

    /// The loaded library. The functions are valid while it is.
    pub(super) struct Library {
        new_device: unsafe extern "C" fn(c_int) -> Object,
        set_device_bool: unsafe extern "C" fn(Object, *const c_char, bool),
        commit_device: unsafe extern "C" fn(Object),
        release_device: unsafe extern "C" fn(Object),
        device_error: unsafe extern "C" fn(Object, *mut *const c_char) -> c_int,
        new_filter: unsafe extern "C" fn(Object, *const c_char) -> Object,
        set_image: unsafe extern "C" fn(
            Object,
            *const c_char,
            *mut c_void,
            c_int,
            usize,
            usize,
            usize,
            usize,
            usize,
        ),
        set_filter_bool: unsafe extern "C" fn(Object, *const c_char, bool),
        commit_filter: unsafe extern "C" fn(Object),
        execute_filter: unsafe extern "C" fn(Object),
        release_filter: unsafe extern "C" fn(Object),
        _library: libloading::Library,
    }

    /// The names of the library's file.
    const FILES: &[&str] = if cfg!(windows) {
        &["OpenImageDenoise.dll"]
    } else if cfg!(target_vendor = "apple") {
        &[
            "libOpenImageDenoise.2.dylib",
            "/opt/homebrew/lib/libOpenImageDenoise.2.dylib",
            "/usr/local/lib/libOpenImageDenoise.2.dylib",
        ]
    } else {
        &["libOpenImageDenoise.so.2"]
    };

    impl Library {
        /// Loads the library: the file that the environment names, else one of the system.
        pub(super) fn load() -> Result<Self, DenoiseError> {
            let missing = |error: libloading::Error| DenoiseError::Missing { reason: error.to_string() };
            // SAFETY: loading runs the initialization of the library, which is made for programs that load it so.
            let open = |file: &std::ffi::OsStr| unsafe { libloading::Library::new(file) };
            let library = match std::env::var_os(VARIABLE).filter(|file| !file.is_empty()) {
                Some(file) => {
                    let of_variable = |error: &dyn std::fmt::Display| DenoiseError::Missing {
                        reason: format!("{VARIABLE} is '{}': {error}", file.display()),
                    };
                    // A name without a folder would be searched in the folders of the system.
                    let path = std::path::absolute(&file).map_err(|error| of_variable(&error))?;
                    let library = open(path.as_os_str()).map_err(|error| of_variable(&error))?;
                    return Self::of(library).map_err(|error| of_variable(&error));
                }
                None => {
                    let mut opened = FILES.iter().map(|file| open(file.as_ref()));
                    let first = opened.next().unwrap_or_else(|| open("".as_ref()));
                    opened.fold(first, |found, next| found.or_else(|error| next.map_err(|_| error)))
                }
            };
            Self::of(library.map_err(missing)?).map_err(missing)
        }

        fn of(library: libloading::Library) -> Result<Self, libloading::Error> {
            // SAFETY: the types are those of the library's header; version 1 lacks `oidnSetFilterBool` and is refused.
            unsafe {
                Ok(Self {
                    set_filter_bool: *library.get(b"oidnSetFilterBool\0")?,
                    new_device: *library.get(b"oidnNewDevice\0")?,
                    set_device_bool: *library.get(b"oidnSetDeviceBool\0")?,
                    commit_device: *library.get(b"oidnCommitDevice\0")?,
                    release_device: *library.get(b"oidnReleaseDevice\0")?,
                    device_error: *library.get(b"oidnGetDeviceError\0")?,
                    new_filter: *library.get(b"oidnNewFilter\0")?,
                    set_image: *library.get(b"oidnSetSharedFilterImage\0")?,
                    commit_filter: *library.get(b"oidnCommitFilter\0")?,
                    execute_filter: *library.get(b"oidnExecuteFilter\0")?,
                    release_filter: *library.get(b"oidnReleaseFilter\0")?,
                    _library: library,
                })
            }
        }

        /// The denoised colours of a picture, from its own and perhaps the albedo and the normal of each pixel, row by row.
        pub(super) fn denoise(
            &self,
            (width, height): (usize, usize),
            color: &[[f32; 3]],
            guides: Option<&[Vec<[f32; 3]>; 2]>,
        ) -> Result<Vec<[f32; 3]>, DenoiseError> {
            let mut output = vec![[0.0; 3]; width * height];
            let inputs = [c"color", c"albedo", c"normal"];
            let images: Vec<(&CStr, *mut c_void)> = inputs
                .into_iter()
                .zip(std::iter::once(color).chain(guides.into_iter().flatten().map(Vec::as_slice)))
                .map(|(name, pixels)| {
                    assert!(pixels.len() == width * height, "an image has the pixels of its size");
                    (name, pixels.as_ptr().cast_mut().cast())
                })
                .chain([(c"output", output.as_mut_ptr().cast())])
                .collect();
            // SAFETY: the objects are released once, below, and used before. Each image has `width * height` pixels of three f32
            // without gaps (checked above, and by the length of `output`) and lives until the end of this function; the library
            // writes to that of the name `output` alone, which is not borrowed meanwhile. Names end with a zero byte.
            unsafe {
                let device = (self.new_device)(CPU);
                if device.is_null() {
                    return Err(self.error(device));
                }
                // Threads stay where the system puts them: other work runs beside.
                (self.set_device_bool)(device, c"setAffinity".as_ptr(), false);
                (self.commit_device)(device);
                let filter = (self.new_filter)(device, c"RT".as_ptr());
                if !filter.is_null() {
                    for (name, pixels) in images {
                        (self.set_image)(filter, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0);
                    }
                    (self.set_filter_bool)(filter, c"hdr".as_ptr(), true);
                    (self.commit_filter)(filter);
                    (self.execute_filter)(filter);
                    (self.release_filter)(filter);
                }
                let error = self.error_of(device);
                (self.release_device)(device);
                match error {
                    Some(error) => Err(error),
                    None => Ok(output),
                }
            }
        }

        /// The error of a device, or of none.
        fn error(&self, device: Object) -> DenoiseError {
            self.error_of(device).unwrap_or_else(|| DenoiseError::Failed("it has no device".to_owned()))
        }

        fn error_of(&self, device: Object) -> Option<DenoiseError> {
            let mut text = ptr::null();
            // SAFETY: `device` is null, for the error of the thread, or not released yet. The text, if there is one, ends with
            // a zero byte and is valid until the next call for this device.
            unsafe {
                let code = (self.device_error)(device, &raw mut text);
                (code != 0).then(|| {
                    DenoiseError::Failed(match text.is_null() {
                        true => format!("error {code}"),
                        false => CStr::from_ptr(text).to_string_lossy().into_owned(),
                    })
                })
            }
        }
    }
}
