//! The arguments of `superegg fit`.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::value_parser;
use superegg_exchange::read::{ColumnMap, Format};
use superegg_exchange::write::convention::CONVENTIONS;
use superegg_fit::{MOST_PARTS, PartCount};

use crate::args::data::column_map;
use crate::args::values::{OverwriteArgs, outlier_share, positive};

#[derive(Debug, clap::Args)]
pub(crate) struct FitArgs {
    /// The points of one object: a cloud (.ply, .xyz, .txt, .csv, .npy, .vtp, .vtk) or a mesh
    /// (.obj, .stl, .ply with faces), - for standard input
    #[arg(value_name = "CLOUD")]
    pub(crate) cloud: PathBuf,
    /// Write the shape to this file: .scn as text, or .sqb; default: print the parameters only
    #[arg(short, long, value_name = "SCENE.scn|.sqb")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Show the points beside the shape in the scene: grey, outliers red
    #[arg(long, requires = "output")]
    pub(crate) with_cloud: bool,
    /// Write the signed distance of each point from the surface, and the probability that it is an
    /// inlier, to this file; - for standard output
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) residuals: Option<PathBuf>,
    /// Print JSON: parameters, covariance, distances and warnings
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the parameters as another program names and orders them, too
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(CONVENTIONS.iter().map(|convention| convention.name)))]
    pub(crate) convention: Option<String>,
    /// Fit this many shapes, or 'auto' for as many as the points show
    #[arg(long, value_name = "K|auto", default_value = "1", value_parser = part_count)]
    pub(crate) count: PartCount,
    /// Set the initial share of outliers, 0 to 0.9; the fit estimates the final one
    #[arg(long, value_name = "SHARE", default_value_t = 0.2, allow_negative_numbers = true, value_parser = outlier_share)]
    pub(crate) outliers: f64,
    /// Set the range of both exponents, within 0.01 to 8
    #[arg(long, num_args = 2, value_names = ["MIN", "MAX"], default_values_t = [0.05, 2.0], allow_negative_numbers = true, value_parser = positive)]
    pub(crate) exponents: Vec<f64>,
    /// Set the maximum number of points to fit; above it, fit an even random choice of this many
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = value_parser!(u32).range(1000..))]
    pub(crate) points: u32,
    /// Set the seed: the same points, in any order, and the same seed give the same fit
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Take the file as this format; default: recognized by its content
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new([Format::Ply, Format::Xyz, Format::Table, Format::NpyPoints].map(Format::name)))]
    pub(crate) from: Option<String>,
    /// Name the columns of a table, for example "position=x,y,z"
    #[arg(long, value_name = "COLUMNS", value_parser = column_map)]
    pub(crate) columns: Option<ColumnMap>,
    /// Print only errors and warnings
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

fn part_count(text: &str) -> Result<PartCount, String> {
    if text == "auto" {
        return Ok(PartCount::Auto);
    }
    let count = text.parse().ok().filter(|count| (1..=MOST_PARTS).contains(count));
    count.map(PartCount::Exactly).ok_or_else(|| format!("it must be auto or a number from 1 to {MOST_PARTS}"))
}
