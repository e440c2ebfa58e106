//! A scene in any format: the format by the ending of a file's name, and the settings of all formats.

use std::path::Path;

use superegg_scene::Scene;
use thiserror::Error;

use super::ems::{to_ems_npy, to_ems_text};
use super::enlarge::enlargement;
use super::flatten::flatten;
use super::gltf::to_glb;
use super::grid::{Grid, GridValue};
use super::liggghts::{to_data_file, to_input_script};
use super::meshes::Tolerance;
use super::obj::to_obj;
use super::ply::{Precision, to_ply};
use super::povray::{self, PovError};
use super::stl::to_stl;
use super::table::to_csv;
use super::vtp::to_vtp;
use super::written::{WriteError, Written};

/// A format that a scene can be exported to.
///
/// ```
/// use superegg_exchange::write::export::ExportFormat;
/// assert_eq!(ExportFormat::of("cup.GLB")?, ExportFormat::Glb);
/// assert!(ExportFormat::of("cup.jpg").unwrap_err().to_string().contains(".glb (glTF)"));
/// # Ok::<(), superegg_exchange::write::export::ExportError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExportFormat {
    /// A POV-Ray scene.
    PovRay,
    /// A mesh of triangles without colours.
    Stl,
    /// A mesh with colours.
    Ply,
    /// Meshes with names and materials.
    Obj,
    /// glTF 2.0, binary.
    Glb,
    /// Particles for OVITO and ParaView.
    Vtp,
    /// A LIGGGHTS input script.
    LiggghtsScript,
    /// A LIGGGHTS data file.
    LiggghtsData,
    /// Vectors of the EMS fits as text.
    EmsText,
    /// Vectors of the EMS fits as a NumPy array.
    EmsNpy,
    /// A table of instances.
    Csv,
    /// A grid of values.
    Nrrd,
    /// A grid of values for ParaView.
    Vti,
}

/// Formats by the ending of a file's name, with a description.
const FORMATS: [(ExportFormat, &str, &str); 13] = [
    (ExportFormat::PovRay, "pov", "POV-Ray"),
    (ExportFormat::Stl, "stl", "mesh"),
    (ExportFormat::Ply, "ply", "mesh with colours"),
    (ExportFormat::Obj, "obj", "meshes with names and materials"),
    (ExportFormat::Glb, "glb", "glTF"),
    (ExportFormat::Vtp, "vtp", "particles for OVITO and ParaView"),
    (ExportFormat::LiggghtsScript, "liggghts", "LIGGGHTS input script"),
    (ExportFormat::LiggghtsData, "data", "LIGGGHTS data file"),
    (ExportFormat::EmsText, "txt", "EMS vectors"),
    (ExportFormat::EmsNpy, "npy", "EMS vectors"),
    (ExportFormat::Csv, "csv", "table"),
    (ExportFormat::Nrrd, "nrrd", "grid"),
    (ExportFormat::Vti, "vti", "grid for ParaView"),
];

impl ExportFormat {
    /// The format of a file's name.
    ///
    /// # Errors
    /// No format has the name's ending.
    pub fn of(file: impl AsRef<Path>) -> Result<Self, ExportError> {
        let file = file.as_ref();
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let found = FORMATS.iter().find(|(_, known, _)| ending.eq_ignore_ascii_case(known));
        found.map(|(format, _, _)| *format).ok_or_else(|| ExportError::Format {
            file: file.display().to_string(),
            known: FORMATS.map(|(_, ending, description)| format!(".{ending} ({description})")).join(", "),
        })
    }
}

/// The settings of an export. A format ignores those that it has no use for.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportOptions {
    /// The number of levels that objects are opened; `None` for that of the scene.
    pub depth: Option<u32>,
    /// The greatest distance between meshes and exact surfaces.
    pub tolerance: Tolerance,
    /// The type of the coordinates of .ply and .obj.
    pub precision: Precision,
    /// The number of samples of a grid along its longest side, 4 to 512.
    pub grid: usize,
    /// The value of a grid.
    pub value: GridValue,
    /// The name of the file of materials that an .obj file refers to.
    pub materials: String,
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self {
            depth: None,
            tolerance: Tolerance::Relative(1e-3),
            precision: Precision::default(),
            grid: 64,
            value: GridValue::Distance,
            materials: "materials.mtl".to_owned(),
        }
    }
}

/// Why a scene cannot be exported.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ExportError {
    /// No format has the ending of the file's name.
    #[error("'{file}' names no format that can be written; end it in {known}")]
    Format {
        /// The name.
        file: String,
        /// The formats that can be written.
        known: String,
    },
    /// The format cannot hold the scene.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// POV-Ray cannot hold the scene.
    #[error(transparent)]
    PovRay(#[from] PovError),
}

/// The content below a name of a scene, in a format.
///
/// # Errors
/// As those of the format's own writer.
///
/// ```
/// use superegg_exchange::write::export::{ExportFormat, ExportOptions, export};
/// use superegg_lang::load_text;
///
/// let (session, _) = load_text("ball.scn", "primitive ball\nobject all\naddPrimitive ball");
/// let written = export(session.scene(), "all", ExportFormat::Stl, &ExportOptions::default())?;
/// let triangles = u32::from_le_bytes(written.bytes[80..84].try_into().unwrap()) as usize;
/// assert_eq!(written.bytes.len(), 84 + 50 * triangles);
/// # Ok::<(), superegg_exchange::write::export::ExportError>(())
/// ```
pub fn export(
    scene: &Scene,
    root: &str,
    format: ExportFormat,
    options: &ExportOptions,
) -> Result<Written, ExportError> {
    let depth = options.depth.unwrap_or(scene.depth);
    let ExportOptions { tolerance, precision, grid, value, materials, .. } = options;
    let instances = || flatten(scene, root, depth);
    let grid = || Grid::new(scene, &instances()?, *value, *grid);
    Ok(match format {
        ExportFormat::PovRay => {
            let factor = enlargement(scene, root, depth);
            let mut losses = povray::losses(scene);
            if factor != 1.0 {
                losses.push(format!("POV-Ray loses shadows of shapes so small: all lengths in the file are {factor} times those of the scene"));
            }
            let text = povray::to_povray_enlarged(scene, root, depth, factor)?;
            Written { bytes: text.into_bytes(), companion: None, losses }
        }
        ExportFormat::Stl => to_stl(scene, &instances()?, *tolerance)?,
        ExportFormat::Ply => to_ply(scene, &instances()?, *tolerance, *precision)?,
        ExportFormat::Obj => to_obj(scene, &instances()?, *tolerance, *precision, materials)?,
        ExportFormat::Glb => to_glb(scene, &instances()?, *tolerance)?,
        ExportFormat::Vtp => to_vtp(scene, &instances()?),
        ExportFormat::LiggghtsScript => to_input_script(scene, &instances()?),
        ExportFormat::LiggghtsData => to_data_file(scene, &instances()?),
        ExportFormat::EmsText => to_ems_text(scene, &instances()?),
        ExportFormat::EmsNpy => to_ems_npy(scene, &instances()?),
        ExportFormat::Csv => to_csv(scene, &instances()?),
        ExportFormat::Nrrd => grid()?.to_nrrd(),
        ExportFormat::Vti => grid()?.to_vti(),
    })
}
