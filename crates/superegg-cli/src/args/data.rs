//! The arguments that say how data of other programs is read and coloured.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use superegg_exchange::coloring::{ColorBy, Coloring, Colormap};
use superegg_exchange::read::{ColumnMap, Format, ReadOptions};

use crate::args::values::{OverwriteArgs, Size, finite, positive};
use crate::files::data::DataOptions;

#[derive(Debug, clap::Args)]
pub(crate) struct ImportArgs {
    /// The data files; several become one scene, such as a fit and its point cloud
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Write the scene to this file: .scn as text with a named child for each row, or .sqb as
    /// binary columns for large data
    #[arg(short, long, value_name = "SCENE.scn|.sqb")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Read this frame of a file with several, counted from 0; default: the first one that is not
    /// empty
    #[arg(long, value_name = "N")]
    pub(crate) frame: Option<usize>,
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// Print only errors and warnings
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// How data of other programs is read and coloured.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Data files")]
pub(crate) struct DataArgs {
    /// Take the data file as this format; default: recognized by its content
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new(Format::ALL.iter().map(|format| format.name())))]
    pub(crate) from: Option<String>,
    /// Name the columns of a table, for example
    /// "position=x,y,z;semi-axes=a,b,c;exponents=e,n;quaternion=w,x,y,z"
    #[arg(long, value_name = "COLUMNS", value_parser = column_map)]
    pub(crate) columns: Option<ColumnMap>,
    /// Raise smaller semi-axes to this
    #[arg(long, value_name = "X", value_parser = positive)]
    pub(crate) min_axis: Option<f64>,
    /// Set the radius of the spheres that stand for points; default: from their spacing
    #[arg(long, value_name = "R", value_parser = positive)]
    pub(crate) point_radius: Option<f64>,
    /// Colour by this numeric column; 'speed' for the length of vx, vy, vz, 'force' for that of fx,
    /// fy, fz, 'id', or names joined by commas for the length of their vector
    #[arg(long, value_name = "COLUMN", conflicts_with = "type_colors")]
    pub(crate) color_by: Option<String>,
    /// Choose the colour map
    #[arg(long, value_name = "MAP", requires = "color_by", value_parser = PossibleValuesParser::new(Colormap::ALL.iter().map(|map| map.name())))]
    pub(crate) colormap: Option<String>,
    /// Set the values at the ends of the colour map; default: those of the data
    #[arg(long, num_args = 2, value_names = ["A", "B"], requires = "color_by", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) range: Option<Vec<f64>>,
    /// Colour by the column 'type'
    #[arg(long)]
    pub(crate) type_colors: bool,
    /// Repeat a periodic box along its edges, 1x1x1 to 64x64x64
    #[arg(long, value_name = "NxMxK", value_parser = images)]
    pub(crate) images: Option<[u32; 3]>,
    /// Show the edges of the simulation box
    #[arg(long = "box")]
    pub(crate) shows_box: bool,
}

impl DataArgs {
    /// The options of the loader, with a frame and the size of the picture.
    pub(crate) fn options(&self, frame: Option<usize>, size: Option<Size>) -> DataOptions {
        let map = self
            .colormap
            .as_deref()
            .and_then(|name| Colormap::ALL.iter().copied().find(|map| map.name() == name));
        let coloring = match &self.color_by {
            Some(column) => Coloring::ByColumn(ColorBy {
                column: column.clone(),
                map: map.unwrap_or_default(),
                range: self.range.as_deref().and_then(|range| range.try_into().ok()),
            }),
            None if self.type_colors => Coloring::ByType,
            None => Coloring::Own,
        };
        let read = ReadOptions {
            from: self.from.as_deref().and_then(Format::by_name),
            columns: self.columns.clone(),
            extra: coloring.columns(),
            min_axis: self.min_axis,
            point_radius: self.point_radius,
            ..ReadOptions::default()
        };
        let images = self.images.unwrap_or([1; 3]);
        let size = size.map(|Size { width, height }| (width, height));
        DataOptions { read, coloring, frame, images, shows_box: self.shows_box, size }
    }
}

pub(super) fn column_map(text: &str) -> Result<ColumnMap, String> {
    text.parse().map_err(|error: superegg_exchange::read::ReadError| error.to_string())
}

fn images(text: &str) -> Result<[u32; 3], String> {
    let counts: Vec<u32> = text
        .split(['x', 'X'])
        .map(|word| word.parse().ok().filter(|count| (1..=64).contains(count)))
        .collect::<Option<_>>()
        .unwrap_or_default();
    counts.try_into().map_err(|_| "expected three counts from 1 to 64, such as 3x3x1".to_owned())
}
