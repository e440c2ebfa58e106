//! The arguments.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{CommandFactory, Parser, Subcommand, ValueEnum};
use superegg_lang::{ArgKind, Range, find_command, nearest, parse_number, parse_size};
use superegg_render::Output;
use superegg_scene::{Encoding, Filter, Picture, Tone};

use crate::long::shard::ShardArg;

/// A modeller and exact ray tracer for superquadrics.
#[derive(Debug, Parser)]
#[command(
    name = "superegg",
    version,
    args_conflicts_with_subcommands = true,
    before_help = "Without a command: the modeller, a prompt to build scenes at; lines from standard input where that is no terminal.",
    after_help = "Exit codes: 0 fine; 1 errors in the input; 2 wrong usage, or a file that cannot be read or written; 130 stopped by ctrl-c."
)]
pub(crate) struct Args {
    /// A scene to open the modeller with
    pub(crate) scene: Option<PathBuf>,
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Ray trace a scene into a PNG picture
    Render(RenderArgs),
    /// Ray trace the frames of a film, from the keys of a scene or with the camera going round, and make the film
    Animate(AnimateArgs),
    /// Put the shares of a picture together
    Merge(MergeArgs),
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
    /// Run a file of commands as a session, with all that they say and without asking questions
    Run(RunArgs),
    /// Open a window onto a scene
    View(ViewArgs),
}

#[derive(Debug, clap::Args)]
pub(crate) struct RenderArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    /// The picture: .png to look at, or .exr for linear light with depth, normals, colours and instances; the scene's name with .png in
    /// the current folder unless given, - for standard output
    #[arg(short, long, value_name = "OUT.png|.exr")]
    pub(crate) output: Option<PathBuf>,
    /// Width and height in pixels; what the scene sets, or 1280x960, unless given
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<Size>,
    /// Samples a pixel; what the scene sets, or 4, unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Picture::MOST_SAMPLES)))]
    pub(crate) samples: Option<u32>,
    /// Let each pixel take more samples until the standard error of its value on the screen, 0 to 1, is below this; 0 for a fixed number
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = share)]
    pub(crate) noise: Option<f64>,
    /// The most samples that a pixel takes for --noise
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Picture::MOST_SAMPLES)))]
    pub(crate) max_samples: Option<u32>,
    /// How samples are weighted
    #[arg(long, value_enum)]
    pub(crate) filter: Option<FilterArg>,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// How deep objects are opened, 0 to 64, instead of what the scene says
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<u32>,
    /// After so many mirrorings and transmissions a ray sees the sky, 0 to 256
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=256))]
    pub(crate) bounces: Option<u32>,
    /// Threads to use; one for each core unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) develop: DevelopArgs,
    /// Leave the background transparent
    #[arg(long)]
    pub(crate) transparent: bool,
    /// Show something else than light
    #[arg(long, value_enum)]
    pub(crate) view: Option<ViewArg>,
    /// The frame of the scene's keys to render, instead of the scene without them
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) frame: Option<f64>,
    /// Write counts, seconds and memory as JSON to this file
    #[arg(long, value_name = "FILE.json")]
    pub(crate) stats: Option<PathBuf>,
    /// Print nothing but errors and warnings
    #[arg(long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) long: LongArgs,
}

/// How a film becomes a picture.
#[derive(Debug, clap::Args)]
pub(crate) struct DevelopArgs {
    /// How linear values become bytes; what the scene sets, or srgb, unless given
    #[arg(long, value_enum)]
    pub(crate) encoding: Option<EncodingArg>,
    /// Stops by which the picture is brighter, -32 to 32: each doubles the light
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = exposure)]
    pub(crate) exposure: Option<f64>,
    /// How bright light is brought into range
    #[arg(long, value_enum)]
    pub(crate) tone: Option<ToneArg>,
    /// Bits a channel of a PNG file, 8 or 16
    #[arg(long, value_name = "8|16", value_parser = bits)]
    pub(crate) bits: Option<u32>,
}

/// How long work is divided, and gone on with.
#[derive(Debug, clap::Args)]
pub(crate) struct LongArgs {
    /// Go on with a render that was stopped or killed, from its partial file, OUT.png.part; begin anew where there is none
    #[arg(long)]
    pub(crate) resume: bool,
    /// Render share K of N (1/N to N/N, never 0) into the partial file that -o names; 'superegg merge' puts the shares together. 'auto' takes
    /// the share that a Slurm array or an indexed Kubernetes job means this one to do; auto/N says of how many
    #[arg(long, value_name = "K/N")]
    pub(crate) tiles: Option<ShardArg>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// The partial files: shares of one picture, or what a stopped render left
    #[arg(required = true, value_name = "FILE.part")]
    pub(crate) parts: Vec<PathBuf>,
    /// The picture, .png, or .exr of shares and of what was made for an .exr; - for standard output
    #[arg(short, long, value_name = "OUT.png|.exr")]
    pub(crate) output: PathBuf,
    /// Write the picture even if tiles are missing; they are left black, or transparent
    #[arg(long)]
    pub(crate) partial: bool,
    #[command(flatten)]
    pub(crate) develop: DevelopArgs,
    /// Print nothing but errors and warnings
    #[arg(long)]
    pub(crate) quiet: bool,
}

impl DevelopArgs {
    /// The picture, developed as the arguments say.
    pub(crate) fn change(&self, picture: Picture) -> Picture {
        Picture {
            encoding: self.encoding.map_or(picture.encoding, Into::into),
            exposure: self.exposure.unwrap_or(picture.exposure),
            tone: self.tone.map_or(picture.tone, Into::into),
            bits: self.bits.unwrap_or(picture.bits),
            ..picture
        }
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct AnimateArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    /// Let the camera go round its target once in N frames; frame 0 is seen from where the scene has it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(FrameRange::MOST)))]
    pub(crate) turntable: Option<u32>,
    /// The frames to make, both included; from the first key to the last unless given
    #[arg(long, value_name = "A..B")]
    pub(crate) frames: Option<FrameRange>,
    /// The folder of the frames, or a film in .mp4, .webm or .gif (by ffmpeg) with its frames in a folder beside it; the scene's name with
    /// _frames in the current folder unless given
    #[arg(short, long, value_name = "FOLDER|FILM")]
    pub(crate) output: Option<PathBuf>,
    /// Make share K of N of the frames (1/N to N/N, never 0), every Nth, into the same folder; the same command without --tiles, when all are
    /// there, makes the film. 'auto' takes the share that a Slurm array or an indexed Kubernetes job means this one to do; auto/N says of how many
    #[arg(long, value_name = "K/N")]
    pub(crate) tiles: Option<ShardArg>,
    /// Frames a second of the film
    #[arg(long, value_name = "F", default_value = "24", value_parser = frames_a_second)]
    pub(crate) fps: f64,
    /// Width and height in pixels; what the scene sets, or 1280x960, unless given
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<Size>,
    /// Samples a pixel; what the scene sets, or 4, unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Picture::MOST_SAMPLES)))]
    pub(crate) samples: Option<u32>,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// How deep objects are opened, 0 to 64, instead of what the scene says
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<u32>,
    /// Threads to use; one for each core unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
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
    /// The file of commands, - for standard input
    pub(crate) file: PathBuf,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Open no window; print the frame times of the preview and of the live ray traced view
    #[arg(long)]
    pub(crate) bench: bool,
    /// Width and height of the frames in pixels
    #[arg(long, value_name = "WxH", default_value = "1000x1000", requires = "bench")]
    pub(crate) size: Size,
    /// How many frames
    #[arg(long, value_name = "N", default_value_t = 60, requires = "bench", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) frames: u16,
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

/// How samples are weighted.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FilterArg {
    /// The pixel's own square, evenly
    Box,
    /// A tent that ends one pixel from the centre
    Tent,
    /// A bell of half a pixel
    Gaussian,
    /// The window of Blackman and Harris, 2 pixels to each side
    Blackman,
    /// The cubic of Mitchell and Netravali: sharper
    Mitchell,
}

impl From<FilterArg> for Filter {
    fn from(arg: FilterArg) -> Self {
        match arg {
            FilterArg::Box => Self::Box,
            FilterArg::Tent => Self::Tent,
            FilterArg::Gaussian => Self::Gaussian,
            FilterArg::Blackman => Self::Blackman,
            FilterArg::Mitchell => Self::Mitchell,
        }
    }
}

/// How bright light is brought into range.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ToneArg {
    /// What is above 1 is cut off
    None,
    /// Bent gently by its luminance, 4 becomes white
    Reinhard,
    /// A film's curve: more contrast, bright colours turn white
    Filmic,
}

impl From<ToneArg> for Tone {
    fn from(arg: ToneArg) -> Self {
        match arg {
            ToneArg::None => Self::None,
            ToneArg::Reinhard => Self::Reinhard,
            ToneArg::Filmic => Self::Filmic,
        }
    }
}

/// What is shown instead of light.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ViewArg {
    /// 0.5 + 0.5 n of each part of the normal
    Normal,
    /// White for the nearest to black for the farthest in the picture
    Depth,
    /// A colour for each instance
    Id,
    /// How many boxes and shapes a ray asks: black for none to white for the most in the picture
    Steps,
    /// Ambient occlusion alone
    Ao,
}

impl From<ViewArg> for Output {
    fn from(arg: ViewArg) -> Self {
        match arg {
            ViewArg::Normal => Self::Normal,
            ViewArg::Depth => Self::Depth,
            ViewArg::Id => Self::Id,
            ViewArg::Steps => Self::Steps,
            ViewArg::Ao => Self::Occlusion,
        }
    }
}

/// A picture's size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (width, height) = parse_size(text)?;
        Ok(Self { width, height })
    }
}

/// Frames of a film, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange {
    pub(crate) first: u32,
    /// Not before the first.
    pub(crate) last: u32,
}

impl FrameRange {
    /// The last frame that there can be.
    pub(crate) const MOST: u32 = 999_999;
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| {
            let number = word.parse().ok().filter(|number| *number <= Self::MOST);
            number.ok_or_else(|| format!("frames are A..B, such as 0..47, from 0 to {}", Self::MOST))
        };
        let (first, last) = text.split_once("..").unwrap_or((text, text));
        let (first, last) = (number(first)?, number(last)?);
        if first > last {
            Err(format!("frame {first} does not come before frame {last}"))
        } else {
            Ok(Self { first, last })
        }
    }
}

/// What to say of a first word that is neither a command nor a file, nor an option.
pub(crate) fn unknown_command(word: &str) -> Option<String> {
    let names: Vec<String> = Args::command().get_subcommands().map(|c| c.get_name().to_owned()).collect();
    if word.starts_with('-')
        || names.iter().any(|name| name == word)
        || [word.to_owned(), format!("{word}.scn")].iter().any(|file| Path::new(file).exists())
    {
        return None;
    }
    let help = match nearest(word, names.iter().map(String::as_str)) {
        Some(near) => format!("did you mean 'superegg {near}'?"),
        None => "'superegg --help' lists the commands".to_owned(),
    };
    Some(format!("there is no command and no scene '{word}'; {help}"))
}

fn depth(text: &str) -> Result<u32, String> {
    // The range of the language's own command.
    let range = find_command("setDepth").and_then(|spec| spec.all_args().next()).map(|arg| arg.kind);
    let Some(ArgKind::Number(range)) = range else { return Err("setDepth takes no number".to_owned()) };
    Ok(number_in(text, range)? as u32)
}

fn share(text: &str) -> Result<f64, String> {
    number_in(text, Range::Within(0.0, 1.0))
}

fn exposure(text: &str) -> Result<f64, String> {
    number_in(text, Range::Within(-32.0, 32.0))
}

fn bits(text: &str) -> Result<u32, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("it must be 8 or 16".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    number_in(text, Range::Positive)
}

fn finite(text: &str) -> Result<f64, String> {
    number_in(text, Range::Any)
}

fn frames_a_second(text: &str) -> Result<f64, String> {
    number_in(text, Range::AboveTo(0.0, 1000.0))
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
    use super::*;

    #[test]
    fn the_arguments_fit_together() {
        Args::command().debug_assert();
    }

    #[test]
    fn ranges_of_frames() {
        assert_eq!("0..47".parse(), Ok(FrameRange { first: 0, last: 47 }));
        assert_eq!("7".parse(), Ok(FrameRange { first: 7, last: 7 }));
        for bad in ["", "..", "1..", "5..4", "-1..4", "0..1000000", "1.5..2", "0..1..2", "a..b"] {
            assert!(bad.parse::<FrameRange>().is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes() {
        assert!(matches!("1280x960".parse(), Ok(Size { width: 1280, height: 960 })));
        for bad in ["", "x", "10", "0x5", "5x0", "10x-3", "99999x1", "32768x32768", "1x2x3"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }
}
