//! A file opened for reading: its format and its frames.

use std::io::{Read, SeekFrom};

use super::error::ReadError;
use super::format::Format;
use super::frame::Frame;
use super::import::{Import, Input};
use super::options::ReadOptions;
use super::{
    clouds, course_yaml, data, dump, fits, liggghts_vtk, mercury, meshes, nrrd, povray, sudodem, table, vtk,
    vtk_programs, vtk_tensors, xyz,
};

/// The number of bytes that decide the format.
const HEAD: u64 = 1 << 16;
/// The largest file of a format that is read as a whole, in bytes.
pub(crate) const MOST_BYTES: u64 = 8 << 30;

/// Finds whether the first bytes of a file are of a module's formats. [`ReadError::Ambiguous`] if
/// they fit several that mean different things.
type Recognizer = fn(&[u8]) -> Result<Option<Format>, ReadError>;

/// The recognizers of the modules: those of strict signatures before those of plain numbers. A
/// module adds its own here, one a line.
const RECOGNIZERS: &[Recognizer] = &[
    dump::recognize,
    vtk_programs::recognize_head,
    nrrd::recognize,
    clouds::recognize,
    data::recognize,
    course_yaml::recognize,
    povray::recognize,
    sudodem::recognize,
    fits::recognize,
    table::recognize,
    xyz::recognize,
];

/// A file whose format and frames are known.
#[derive(Debug)]
pub struct Source<R> {
    input: R,
    format: Format,
    frames: Vec<Frame>,
}

/// Recognizes the format of a stream by its content and lists its frames. A format in `options`
/// is taken as it is.
///
/// # Errors
/// The stream cannot be read, no format fits, or several do that mean different things.
///
/// ```
/// use std::io::Cursor;
/// use superegg_exchange::read::{Content, Format, ReadOptions, open};
///
/// let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n\
///             ITEM: ATOMS id x y z shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2\n\
///             7 0 0 0 .1 .2 .3 1 0 0 0 8 2\n";
/// let options = ReadOptions::default();
/// let mut source = open(Cursor::new(dump), &options)?;
/// assert_eq!((source.format(), source.frames().len()), (Format::LiggghtsDump, 1));
/// let Content::Particles(grains) = source.read(0, &options)?.content else { panic!() };
/// assert_eq!(grains.exponents, [[1.0, 0.25]]);
/// # Ok::<(), superegg_exchange::read::ReadError>(())
/// ```
pub fn open<R: Input>(mut input: R, options: &ReadOptions) -> Result<Source<R>, ReadError> {
    let mut head = Vec::new();
    input.seek(SeekFrom::Start(0))?;
    input.by_ref().take(HEAD).read_to_end(&mut head)?;
    let format = match options.from {
        Some(format) => format,
        // The arrays of a VTK file may be named far behind its head.
        None if vtk::is_vtk(&head) => {
            let end = input.seek(SeekFrom::End(0))?;
            vtk_programs::recognize(&whole(&mut input, &Frame::whole(end))?)
        }
        None => recognize(&head, options).map_err(|error| explained(error, &head, &mut input))?,
    };
    let frames = list_frames(&mut input, format)?;
    Ok(Source { input, format, frames })
}

/// The format of a file with these first bytes, if it is one of another program; also where the
/// meaning of its numbers is in doubt.
pub fn sniff(head: &[u8]) -> Option<Format> {
    match recognize(head, &ReadOptions::default()) {
        Ok(format) => Some(format),
        Err(ReadError::Ambiguous { candidates, .. }) => {
            candidates.first().and_then(|name| Format::by_name(name))
        }
        Err(_) => None,
    }
}

/// The format of a file with these first bytes. Named columns make a table of what else is none.
fn recognize(head: &[u8], options: &ReadOptions) -> Result<Format, ReadError> {
    for recognizer in RECOGNIZERS {
        let is_named = options.columns.is_some();
        match recognizer(head) {
            Ok(None) => {}
            Ok(Some(Format::Xyz | Format::Ems | Format::SuperquadricLib)) if is_named => {
                return Ok(Format::Table);
            }
            Err(ReadError::Ambiguous { .. }) if is_named => return Ok(Format::Table),
            Ok(Some(format)) => return Ok(format),
            Err(error) => return Err(error),
        }
    }
    options.columns.as_ref().map(|_| Format::Table).ok_or(ReadError::Unrecognized)
}

/// The error for a file that is not recognized: the kind of a mesh, and what reads it.
fn explained<R: Input>(error: ReadError, head: &[u8], input: &mut R) -> ReadError {
    let length = input.seek(SeekFrom::End(0)).unwrap_or(0);
    match (&error, meshes::mesh_kind(head, length)) {
        (ReadError::Unrecognized, Some(kind)) => ReadError::File(format!(
            "this is {kind}: its triangles are not superquadrics; 'superegg fit' fits superquadrics to .stl, .obj and .ply"
        )),
        _ => error,
    }
}

/// The frames of a file; one for formats that have no others.
fn list_frames<R: Input>(input: &mut R, format: Format) -> Result<Vec<Frame>, ReadError> {
    match format {
        Format::LiggghtsDump | Format::LammpsDump | Format::OvitoDump => dump::frames(input),
        _ => Ok(vec![Frame::whole(input.seek(SeekFrom::End(0))?)]),
    }
}

/// Reads one frame of a file of this format.
fn read_frame<R: Input>(
    input: &mut R,
    format: Format,
    frame: &Frame,
    options: &ReadOptions,
) -> Result<Import, ReadError> {
    // One arm for each format: `Format::X => x::read(&whole(input, frame)?, options)`.
    match format {
        Format::LiggghtsDump | Format::LammpsDump | Format::OvitoDump => {
            dump::read(input, frame, format, options)
        }
        Format::LiggghtsVtk => liggghts_vtk::read(&whole(input, frame)?, options),
        Format::MercuryVtu => mercury::read(&whole(input, frame)?, options),
        Format::VtkTensors => vtk_tensors::read(&whole(input, frame)?, options),
        Format::TeemNrrd => nrrd::read(&whole(input, frame)?, options),
        Format::Ems => fits::read_ems(&whole(input, frame)?, options),
        Format::Superdec => fits::read_superdec(&whole(input, frame)?, options),
        Format::SuperquadricParsing => fits::read_parts(&whole(input, frame)?, options),
        Format::SuperquadricLib => fits::read_superquadric_lib(&whole(input, frame)?, options),
        Format::Sage => fits::read_sage(&whole(input, frame)?, options),
        Format::CourseYaml => course_yaml::read(&whole(input, frame)?, options),
        Format::Povray => povray::read(&whole(input, frame)?, options),
        Format::Ply => clouds::read_ply(&whole(input, frame)?, options),
        Format::NpyPoints => clouds::read_npy(&whole(input, frame)?, options),
        Format::LiggghtsData | Format::LammpsData => data::read(input, format, frame, options),
        Format::Sudodem => sudodem::read(input, frame, options),
        Format::Table => table::read(input, frame, options),
        Format::Xyz => xyz::read(input, frame, options),
    }
}

/// The bytes of a frame.
fn whole<R: Input>(input: &mut R, frame: &Frame) -> Result<Vec<u8>, ReadError> {
    if frame.end - frame.start > MOST_BYTES {
        return Err(ReadError::File(format!("the file is larger than {MOST_BYTES} bytes")));
    }
    let mut bytes = Vec::new();
    input.seek(SeekFrom::Start(frame.start))?;
    input.by_ref().take(frame.end - frame.start).read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl<R: Input> Source<R> {
    /// The format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The frames in their order; at least one.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Reads one frame.
    ///
    /// # Errors
    /// There is no such frame, the stream cannot be read, or the content is wrong.
    pub fn read(&mut self, frame: usize, options: &ReadOptions) -> Result<Import, ReadError> {
        let Some(frame) = self.frames.get(frame) else {
            let message = format!("there is no frame {frame}; the file has {}", self.frames.len());
            return Err(ReadError::File(message));
        };
        read_frame(&mut self.input, self.format, frame, options)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_no_data() {
        for scene in [
            "",
            "primitive egg\nsize 1 1 1.3\n",
            "# superegg scene\nobject a\n  child egg 0 0 0\n",
            "sphere 1 2 3",
            "color 1 0 0\nlight a 1 2 3\n",
        ] {
            assert_eq!(sniff(scene.as_bytes()), None, "{scene:?}");
        }
    }
}
