//! The formats that can be read.

/// A format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// LIGGGHTS text dump.
    LiggghtsDump,
    /// LAMMPS text dump.
    LammpsDump,
    /// Text dump that OVITO exported.
    OvitoDump,
    /// LIGGGHTS data file.
    LiggghtsData,
    /// LAMMPS data file.
    LammpsData,
    /// VTK of LIGGGHTS: legacy, .vtp, .vtu.
    LiggghtsVtk,
    /// VTU of MercuryDPM.
    MercuryVtu,
    /// Text of SudoDEM.
    Sudodem,
    /// A table of named columns: CSV or whitespace.
    Table,
    /// Eleven numbers a shape of EMS and Marching-Primitives: .mat, .npy, text.
    Ems,
    /// SuperDec .npz.
    Superdec,
    /// superquadric_parsing: .npz, .npy or JSON with size, shape, rotation, location, tapering.
    SuperquadricParsing,
    /// Vectors of robotology superquadric-lib.
    SuperquadricLib,
    /// JSON dictionaries of sage-superquadric.
    Sage,
    /// Tensors in a VTK file, as Kindlmann's glyphs.
    VtkTensors,
    /// Teem NRRD of seven numbers a tensor.
    TeemNrrd,
    /// The YAML edition of the course (2020 on).
    CourseYaml,
    /// POV-Ray superellipsoids.
    Povray,
    /// A point cloud or mesh vertices: .ply.
    Ply,
    /// A point cloud: rows of x y z.
    Xyz,
    /// A point cloud: an (N, 3) array.
    NpyPoints,
}

impl Format {
    /// All formats.
    pub const ALL: &[Self] = &[
        Self::LiggghtsDump,
        Self::LammpsDump,
        Self::OvitoDump,
        Self::LiggghtsData,
        Self::LammpsData,
        Self::LiggghtsVtk,
        Self::MercuryVtu,
        Self::Sudodem,
        Self::Table,
        Self::Ems,
        Self::Superdec,
        Self::SuperquadricParsing,
        Self::SuperquadricLib,
        Self::Sage,
        Self::VtkTensors,
        Self::TeemNrrd,
        Self::CourseYaml,
        Self::Povray,
        Self::Ply,
        Self::Xyz,
        Self::NpyPoints,
    ];

    /// The name for `--from`.
    pub fn name(self) -> &'static str {
        match self {
            Self::LiggghtsDump => "liggghts",
            Self::LammpsDump => "lammps",
            Self::OvitoDump => "ovito",
            Self::LiggghtsData => "liggghts-data",
            Self::LammpsData => "lammps-data",
            Self::LiggghtsVtk => "liggghts-vtk",
            Self::MercuryVtu => "mercurydpm",
            Self::Sudodem => "sudodem",
            Self::Table => "table",
            Self::Ems => "ems",
            Self::Superdec => "superdec",
            Self::SuperquadricParsing => "superquadric-parsing",
            Self::SuperquadricLib => "superquadric-lib",
            Self::Sage => "sage",
            Self::VtkTensors => "vtk-tensors",
            Self::TeemNrrd => "nrrd",
            Self::CourseYaml => "yaml",
            Self::Povray => "povray",
            Self::Ply => "ply",
            Self::Xyz => "xyz",
            Self::NpyPoints => "npy-points",
        }
    }

    /// The format of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| format.name() == name)
    }

    /// The name of the format in messages: "a LIGGGHTS text dump".
    pub fn description(self) -> &'static str {
        match self {
            Self::LiggghtsDump => "a LIGGGHTS text dump",
            Self::LammpsDump => "a LAMMPS text dump",
            Self::OvitoDump => "a text dump exported by OVITO",
            Self::LiggghtsData => "a LIGGGHTS data file",
            Self::LammpsData => "a LAMMPS data file",
            Self::LiggghtsVtk => "a VTK file of LIGGGHTS",
            Self::MercuryVtu => "a VTK file of MercuryDPM",
            Self::Sudodem => "a text file of SudoDEM",
            Self::Table => "a table of named columns",
            Self::Ems => "a file of eleven numbers a shape (EMS, Marching-Primitives)",
            Self::Superdec => "a SuperDec archive",
            Self::SuperquadricParsing => "a file of superquadric_parsing",
            Self::SuperquadricLib => "a file of superquadric-lib",
            Self::Sage => "a fit of sage-superquadric",
            Self::VtkTensors => "a VTK file of tensors",
            Self::TeemNrrd => "a Teem NRRD file of tensors",
            Self::CourseYaml => "a course scene in YAML",
            Self::Povray => "a POV-Ray scene",
            Self::Ply => "a PLY file",
            Self::Xyz => "a point cloud in text",
            Self::NpyPoints => "a NumPy array of points",
        }
    }
}
