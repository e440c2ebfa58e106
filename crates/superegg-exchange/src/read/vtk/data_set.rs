//! The parts of a VTK file that are read.

use superegg_geom::glam::DVec3;

/// Chooses arrays by name and number of components.
pub(crate) type Wanted<'a> = &'a dyn Fn(&str, usize) -> bool;

/// The kinds of data sets that have points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    PolyData,
    UnstructuredGrid,
    ImageData,
    StructuredGrid,
    RectilinearGrid,
}

impl Kind {
    /// The name in VTK's XML files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::PolyData => "PolyData",
            Self::UnstructuredGrid => "UnstructuredGrid",
            Self::ImageData => "ImageData",
            Self::StructuredGrid => "StructuredGrid",
            Self::RectilinearGrid => "RectilinearGrid",
        }
    }

    /// The kind of this name in an XML file.
    pub(super) fn by_xml_name(name: &[u8]) -> Option<Self> {
        [Self::PolyData, Self::UnstructuredGrid, Self::ImageData, Self::StructuredGrid, Self::RectilinearGrid]
            .into_iter()
            .find(|kind| kind.name().as_bytes() == name)
    }

    /// The kind of this name, in capitals, in a legacy file.
    pub(super) fn by_legacy_name(name: &str) -> Option<Self> {
        match name {
            "POLYDATA" => Some(Self::PolyData),
            "UNSTRUCTURED_GRID" => Some(Self::UnstructuredGrid),
            "STRUCTURED_POINTS" => Some(Self::ImageData),
            "STRUCTURED_GRID" => Some(Self::StructuredGrid),
            "RECTILINEAR_GRID" => Some(Self::RectilinearGrid),
            _ => None,
        }
    }
}

/// An array of the points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    /// The name.
    pub(crate) name: String,
    /// The numbers of each point, at least 1.
    pub(crate) components: usize,
    /// The numbers, point by point; empty where the array is only listed.
    pub(crate) values: Vec<f64>,
}

/// The parts of a VTK file that are read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DataSet {
    /// The kind.
    pub(crate) kind: Kind,
    /// The title of a legacy file.
    pub(crate) title: String,
    /// The number of points that the file claims.
    pub(crate) count: usize,
    /// The points. Empty in an outline, and for a lattice without an array that is wanted.
    pub(crate) points: Vec<DVec3>,
    /// The smallest distance of neighbours in a lattice.
    pub(crate) spacing: Option<f64>,
    /// All arrays of the points; those that are wanted have values.
    pub(crate) arrays: Vec<Array>,
    /// The array that the file marks as its tensors.
    pub(crate) active_tensors: Option<String>,
    /// The time or time step.
    pub(crate) step: Option<f64>,
}

impl DataSet {
    /// A data set without points.
    pub(super) fn new(kind: Kind) -> Self {
        Self {
            kind,
            title: String::new(),
            count: 0,
            points: Vec::new(),
            spacing: None,
            arrays: Vec::new(),
            active_tensors: None,
            step: None,
        }
    }

    /// The array of this name.
    pub(crate) fn array(&self, name: &str) -> Option<&Array> {
        self.arrays.iter().find(|array| array.name == name)
    }

    /// The data set in words: "PolyData of 6 points with the arrays id, type".
    pub(crate) fn description(&self) -> String {
        let names: Vec<&str> = self.arrays.iter().take(20).map(|array| array.name.as_str()).collect();
        let more = if self.arrays.len() > names.len() { " and others" } else { "" };
        let arrays = match names[..] {
            [] => "without arrays of the points".to_owned(),
            [name] => format!("with the array {name}"),
            _ => format!("with the arrays {}{more}", names.join(", ")),
        };
        format!("{} of {} points {arrays}", self.kind.name(), self.count)
    }
}

/// Whether a field array of this name holds the time or the time step.
pub(super) fn is_step_name(name: &str) -> bool {
    ["TIME", "TimeValue", "CYCLE", "TimeStep"].contains(&name)
}

/// Points in equal steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    /// The first and last index along each axis.
    pub(super) extent: [[i64; 2]; 3],
    /// The point of the indices 0 0 0.
    pub(super) origin: DVec3,
    /// The steps along the axes.
    pub(super) steps: [DVec3; 3],
}

impl Lattice {
    /// All points, x fastest. Their number must have been checked against the file.
    pub(super) fn points(&self) -> impl Iterator<Item = DVec3> {
        let [x, y, z] = self.extent.map(|[first, last]| first..=last);
        let (origin, steps) = (self.origin, self.steps);
        z.flat_map(move |k| {
            let x = x.clone();
            y.clone().flat_map(move |j| {
                x.clone()
                    .map(move |i| origin + steps[0] * i as f64 + steps[1] * j as f64 + steps[2] * k as f64)
            })
        })
    }

    /// The smallest distance of neighbours along the axes that have some; the smallest step if
    /// none has.
    pub(super) fn spacing(&self) -> f64 {
        let lengths = |all: bool| {
            let steps = self.steps.iter().zip(self.extent);
            steps.filter(move |(_, [first, last])| all || first != last).map(|(step, _)| step.length())
        };
        let smallest = lengths(false).fold(f64::INFINITY, f64::min);
        if smallest.is_finite() { smallest } else { lengths(true).fold(f64::INFINITY, f64::min) }
    }
}

/// The number of points of an extent; `None` if it is negative or overflows.
pub(super) fn extent_count(extent: [[i64; 2]; 3]) -> Option<usize> {
    let length = |[first, last]: [i64; 2]| usize::try_from(last.checked_sub(first)?.checked_add(1)?).ok();
    let [x, y, z] = extent.map(length);
    x?.checked_mul(y?)?.checked_mul(z?)
}

/// The points of a grid with these coordinates along its axes, x fastest.
pub(super) fn rectilinear_points(axes: &[Vec<f64>; 3]) -> impl Iterator<Item = DVec3> {
    let [xs, ys, zs] = axes;
    zs.iter().flat_map(move |&z| ys.iter().flat_map(move |&y| xs.iter().map(move |&x| DVec3::new(x, y, z))))
}

/// The smallest step between neighbours of these coordinates.
pub(super) fn rectilinear_spacing(axes: &[Vec<f64>; 3]) -> Option<f64> {
    let steps = axes.iter().flat_map(|axis| axis.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
    steps.filter(|step| *step > 0.0).reduce(f64::min)
}

/// Points from numbers, three each.
pub(super) fn points_of(numbers: &[f64]) -> impl Iterator<Item = DVec3> {
    let (points, _) = numbers.as_chunks();
    points.iter().map(|point| DVec3::from_array(*point))
}
