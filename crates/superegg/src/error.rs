//! The one error type of the facade.

use std::io;
use std::path::PathBuf;

use superegg_geom::ShapeError;
use superegg_lang::Diagnostic;
use superegg_render::{EnvironmentError, ExrError, ImageError, RenderError, TextureError};
use superegg_scene::SceneError;
use thiserror::Error;

/// Why a model cannot be built, read, rendered or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The semi-axes or exponents of a shape are out of range.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A change that the scene refuses; the scene is as it was.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A name that the modelling language cannot write.
    #[error("'{0}' cannot be a name: a name is one word without blanks and #")]
    Name(String),
    /// The text has errors: one diagnostic each, with file, line and column.
    #[error("{}", first_of(.0))]
    Text(Vec<Diagnostic>),
    /// A picture with these settings cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The picture cannot be encoded as PNG.
    #[error(transparent)]
    Png(#[from] ImageError),
    /// The picture cannot be encoded as OpenEXR.
    #[error(transparent)]
    Exr(#[from] ExrError),
    /// The name of a picture file ends in neither `.png` nor `.exr`.
    #[error("'{}' is no picture file that can be written: expected a name that ends in .png or .exr", .0.display())]
    Ending(PathBuf),
    /// A file that the scene names is not a picture for a surface.
    #[error("'{}' cannot be a texture: {error}", path.display())]
    Texture {
        /// The file.
        path: PathBuf,
        /// The reason.
        #[source]
        error: TextureError,
    },
    /// A file that the scene names is not a picture of an environment.
    #[error("'{}' cannot be an environment: {error}", path.display())]
    Environment {
        /// The file.
        path: PathBuf,
        /// The reason.
        #[source]
        error: EnvironmentError,
    },
    /// A file cannot be read or written.
    #[error("cannot {action} '{}': {error}", path.display())]
    File {
        /// `read` or `write`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The reason.
        #[source]
        error: io::Error,
    },
}

fn first_of(diagnostics: &[Diagnostic]) -> String {
    match diagnostics {
        [] => "the text has errors".to_owned(),
        [only] => only.to_string(),
        [first, others @ ..] => format!("{first}\n({} more)", others.len()),
    }
}
