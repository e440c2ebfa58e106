//! Formats by the extension of a file.

use std::path::Path;

use anyhow::{Result, bail};

/// A format that a scene can be exported to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExportFormat {
    PovRay,
    Stl,
    Ply,
    Obj,
    Glb,
    Vtp,
    LiggghtsScript,
    LiggghtsData,
    EmsText,
    EmsNpy,
    Csv,
    Nrrd,
    Vti,
}

impl ExportFormat {
    const KNOWN: [(Self, &str, &str); 13] = [
        (Self::PovRay, "pov", "POV-Ray"),
        (Self::Stl, "stl", "mesh"),
        (Self::Ply, "ply", "mesh with colours"),
        (Self::Obj, "obj", "meshes with names and materials"),
        (Self::Glb, "glb", "glTF"),
        (Self::Vtp, "vtp", "particles for OVITO and ParaView"),
        (Self::LiggghtsScript, "liggghts", "LIGGGHTS input script"),
        (Self::LiggghtsData, "data", "LIGGGHTS data file"),
        (Self::EmsText, "txt", "EMS vectors"),
        (Self::EmsNpy, "npy", "EMS vectors"),
        (Self::Csv, "csv", "table"),
        (Self::Nrrd, "nrrd", "grid"),
        (Self::Vti, "vti", "grid for ParaView"),
    ];

    /// The format of a path.
    ///
    /// # Errors
    /// No format has its extension.
    pub(super) fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        for (format, known, _) in Self::KNOWN {
            if extension.eq_ignore_ascii_case(known) {
                return Ok(format);
            }
        }
        let known: Vec<String> =
            Self::KNOWN.iter().map(|(_, extension, name)| format!(".{extension} ({name})")).collect();
        bail!("'{}' names no format that can be written; end it in {}", path.display(), known.join(", "))
    }
}
