//! The arguments.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Parser, Subcommand, ValueEnum};
use superegg_lang::{ArgKind, Range, find_command, parse_number};
use superegg_render::Encoding;

/// A modeller and exact ray tracer for superquadrics.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Exit codes: 0 fine; 1 errors in the input; 2 wrong usage, or a file that cannot be read or written."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Ray trace a scene into a PNG picture
    Render(RenderArgs),
    /// Find where rays first cross a surface
    Intersect(IntersectArgs),
    /// Test points with the inside-outside function
    Iotest(IotestArgs),
    /// Say what a scene has, or the details of what is named
    Info(InfoArgs),
    /// Read a scene and report its errors and warnings
    Check(CheckArgs),
    /// Measure rays a second, compiling and memory on made and given scenes
    Bench(BenchArgs),
    /// Write a scene for another program
    Export(ExportArgs),
    /// Run a file of commands as a session: help, info, source and save do what they say
    Run(RunArgs),
}

#[derive(Debug, clap::Args)]
pub(crate) struct RenderArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    /// The picture; the scene's name with .png in the current folder unless given, - for standard output
    #[arg(short, long, value_name = "OUT.png")]
    pub(crate) output: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x960")]
    pub(crate) size: Size,
    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) samples: u32,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// How deep objects are opened, 0 to 64, instead of what the scene says
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<u32>,
    /// Threads to use; one for each core unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// How linear values become bytes
    #[arg(long, value_enum, default_value_t = EncodingArg::Srgb)]
    pub(crate) encoding: EncodingArg,
    /// Write counts, seconds and memory as JSON to this file
    #[arg(long, value_name = "FILE.json")]
    pub(crate) stats: Option<PathBuf>,
    /// Print nothing but errors and warnings
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// What of a scene is meant.
#[derive(Debug, clap::Args)]
pub(crate) struct RootArgs {
    /// The object or primitive to take, instead of the one selected last
    #[arg(long, value_name = "NAME")]
    pub(crate) object: Option<String>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct IntersectArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Rays as rows ox,oy,oz,dx,dy,dz under that header, - for standard input; without it the camera's own ray, told in words
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) rays: Option<PathBuf>,
    /// Where the answers go; standard output unless given
    #[arg(short, long, value_name = "OUT.csv")]
    pub(crate) output: Option<PathBuf>,
    /// Meet convex shapes by the f32 lanes instead of the exact f64 path, to compare the two
    #[arg(long)]
    pub(crate) fast: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct IotestArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Points as rows x,y,z under that header, - for standard input; without it a grid
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["step", "half"])]
    pub(crate) points: Option<PathBuf>,
    /// The spacing of the grid
    #[arg(long, value_name = "S", default_value = "0.5", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) step: f64,
    /// How far the grid goes from the origin along each axis
    #[arg(long, value_name = "H", default_value = "5", allow_negative_numbers = true, value_parser = not_negative)]
    pub(crate) half: f64,
    /// Where the answers go; standard output unless given
    #[arg(short, long, value_name = "OUT.csv")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    /// Primitives and objects to show the details of; also 'all' and 'selected'
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CheckArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    /// Count warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct BenchArgs {
    /// What to measure: robot, cloud:N, glyphs:N, fractal:B,D, or a scene file
    #[arg(value_name = "SCENE", default_values = ["robot", "cloud:1000", "cloud:10000", "glyphs:10000", "fractal:20,64"])]
    pub(crate) scenes: Vec<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x960")]
    pub(crate) size: Size,
    /// Each number is the best of so many rounds
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) rounds: u32,
    /// What the random scenes and rays are drawn from
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write the numbers as JSON to this file, - for standard output instead of the table
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
    /// Write the made scenes as NAME.scn into this folder, and measure nothing
    #[arg(long, value_name = "FOLDER")]
    pub(crate) save: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ExportArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Where it goes; the name says the format: .pov is POV-Ray's
    #[arg(short, long, value_name = "OUT.pov")]
    pub(crate) output: PathBuf,
    /// How deep objects are opened, 0 to 64, instead of what the scene says
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<u32>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// The file of commands
    pub(crate) file: PathBuf,
}

/// How linear values become bytes.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum EncodingArg {
    /// The sRGB curve: what screens expect
    Srgb,
    /// 255 times the linear value
    Linear,
}

impl From<EncodingArg> for Encoding {
    fn from(arg: EncodingArg) -> Self {
        match arg {
            EncodingArg::Srgb => Self::Srgb,
            EncodingArg::Linear => Self::Linear,
        }
    }
}

/// A picture's size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Size {
    const LONGEST_SIDE: u32 = 32_768;
    const MOST_PIXELS: u64 = 1 << 27;
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
        let (width, height): (u32, u32) = sides.ok_or("a size is WIDTHxHEIGHT, such as 1280x960")?;
        let is_side = |side| (1..=Self::LONGEST_SIDE).contains(&side);
        if !is_side(width) || !is_side(height) || u64::from(width) * u64::from(height) > Self::MOST_PIXELS {
            return Err(format!(
                "width and height must be 1 to {}, and {} pixels at most",
                Self::LONGEST_SIDE,
                Self::MOST_PIXELS
            ));
        }
        Ok(Self { width, height })
    }
}

fn depth(text: &str) -> Result<u32, String> {
    // The range of the language's own command.
    let range = find_command("setDepth").and_then(|spec| spec.all_args().next()).map(|arg| arg.kind);
    let Some(ArgKind::Number(range)) = range else { return Err("setDepth takes no number".to_owned()) };
    Ok(number_in(text, range)? as u32)
}

fn positive(text: &str) -> Result<f64, String> {
    number_in(text, Range::Positive)
}

fn not_negative(text: &str) -> Result<f64, String> {
    number_in(text, Range::NonNegative)
}

fn number_in(text: &str, range: Range) -> Result<f64, String> {
    let number = parse_number(text).map_err(|error| format!("it {error}"))?;
    if range.contains(number) { Ok(number) } else { Err(format!("it must be {}", range.describe())) }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_arguments_fit_together() {
        Args::command().debug_assert();
    }

    #[test]
    fn sizes() {
        assert!(matches!("1280x960".parse(), Ok(Size { width: 1280, height: 960 })));
        for bad in ["", "x", "10", "0x5", "5x0", "10x-3", "99999x1", "32768x32768", "1x2x3"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }
}
