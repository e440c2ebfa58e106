//! The arguments of each subcommand.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::value_parser;
use superegg_scene::Picture;

use crate::annotate::{Annotations, Legend};
use crate::args::data::DataArgs;
use crate::args::values::{
    AovArg, EncodingArg, FilterArg, FrameRange, GridValueArg, LightModelArg, OverwriteArgs, Size, ToneArg,
    bits, depth, exposure, finite, frame_rate, noise_threshold, non_negative, positive,
};
use crate::long::shard::ShardArg;

#[derive(Debug, clap::Args)]
pub(crate) struct RenderArgs {
    /// The scene file, or data of another program
    pub(crate) scene: PathBuf,
    /// Write the picture to this file: .png for screens, or .exr for linear light with depth,
    /// normals, albedo and instance ids; - for standard output; default: the scene's name with .png
    /// in the current folder
    #[arg(short, long, value_name = "OUT.png|.exr")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Keep the text of the scene in the picture file, where 'superegg info OUT.png' finds it; the settings are there always
    #[arg(long)]
    pub(crate) scene_text: bool,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Set the recursion depth of objects, 0 to 64; default: that of the scene
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<u32>,
    /// Set the number of threads; default: one for each core
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Set the depth of pixels without a hit in an .exr; 0 is infinity
    #[arg(long, value_name = "Z", value_parser = non_negative)]
    pub(crate) far_depth: Option<f64>,
    /// Add Cryptomatte to an .exr: how much of each pixel every instance and every object covers, with their names
    #[arg(long)]
    pub(crate) cryptomatte: bool,
    /// Render an AOV (arbitrary output variable, render pass) instead of light
    #[arg(long, value_enum, value_name = "NAME", visible_alias = "view")]
    pub(crate) aov: Option<AovArg>,
    /// Render this frame of the keyframes, or of a data file with several; default: the scene
    /// without keyframes, or the first frame that is not empty
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) frame: Option<f64>,
    /// Write counts, times and memory as JSON to this file
    #[arg(long, value_name = "FILE.json")]
    pub(crate) stats: Option<PathBuf>,
    /// Print only errors and warnings
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) long: LongArgs,
    #[command(flatten)]
    pub(crate) annotations: AnnotationArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
}

/// Annotations on finished pictures.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
#[command(next_help_heading = "Annotations")]
pub(crate) struct AnnotationArgs {
    /// Draw a legend into the PNG picture: the colour map of --color-by with its values, or the
    /// types of --type-colors
    #[arg(long)]
    pub(crate) legend: bool,
    /// Draw a bar into the PNG picture that is as long as a round number of units at the depth of
    /// the camera's target
    #[arg(long)]
    pub(crate) scale_bar: bool,
}

impl AnnotationArgs {
    /// Whether anything is drawn.
    pub(crate) fn is_any(self) -> bool {
        self.legend || self.scale_bar
    }

    /// The size of the middle part of a picture that data fills, so that a legend has room beside it.
    pub(crate) fn framed(self, size: Option<Size>) -> Option<Size> {
        if !self.legend {
            return size;
        }
        let Picture { width, height, .. } = Picture::default();
        let Size { width, height } = size.unwrap_or(Size { width, height });
        Some(Size { width: (width - width / 5).max(1), height })
    }

    /// Checks that there are colours for a legend.
    ///
    /// # Errors
    /// No argument colours data.
    pub(crate) fn check(self, data: &DataArgs) -> Result<()> {
        let is_colored = data.color_by.is_some() || data.type_colors;
        ensure!(
            is_colored || !self.legend,
            "--legend shows what the colours of data mean: name them by --color-by COLUMN or --type-colors"
        );
        Ok(())
    }

    /// The annotations, with the legend of the data if it has one.
    ///
    /// # Errors
    /// There is no legend, and the arguments want one.
    pub(crate) fn with_legend(self, legend: Option<Legend>) -> Result<Annotations> {
        ensure!(
            legend.is_some() || !self.legend,
            "--legend shows the colours of a data file, and this scene has its own colours"
        );
        Ok(Annotations { legend: legend.filter(|_| self.legend), scale_bar: self.scale_bar })
    }
}

/// The settings of a picture, which override those of the scene.
#[derive(Debug, clap::Args)]
pub(crate) struct PictureArgs {
    /// Set width and height in pixels; default: the size of the scene, or 1280x960
    #[arg(short, long, value_name = "WxH")]
    pub(crate) size: Option<Size>,
    /// Set the samples per pixel; default: those of the scene, or 4
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(Picture::MOST_SAMPLES)))]
    pub(crate) samples: Option<u32>,
    /// Sample each pixel until the standard error of its value (0 to 1, as displayed) is below this
    /// noise threshold; 0 for a fixed number of samples
    #[arg(long, value_name = "T", visible_alias = "noise-threshold", allow_negative_numbers = true, value_parser = noise_threshold)]
    pub(crate) noise: Option<f64>,
    /// Set the maximum samples per pixel for --noise
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(Picture::MOST_SAMPLES)))]
    pub(crate) max_samples: Option<u32>,
    /// Choose the reconstruction filter
    #[arg(long, value_enum)]
    pub(crate) filter: Option<FilterArg>,
    /// Choose how light reaches surfaces; default: that of the scene, or course
    #[arg(long, value_enum)]
    pub(crate) light: Option<LightModelArg>,
    /// Set the maximum number of reflections and refractions of a path, 0 to 256; after them a ray
    /// sees the sky
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(0..=256))]
    pub(crate) bounces: Option<u32>,
    #[command(flatten)]
    pub(crate) develop: DevelopArgs,
    /// Make the background transparent
    #[arg(long)]
    pub(crate) transparent: bool,
}

impl PictureArgs {
    /// The picture settings, overridden by the arguments.
    pub(crate) fn apply(&self, picture: Picture) -> Picture {
        let (width, height) =
            self.size.map_or((picture.width, picture.height), |size| (size.width, size.height));
        Picture {
            width,
            height,
            samples: self.samples.unwrap_or(picture.samples),
            noise: self.noise.unwrap_or(picture.noise),
            most_samples: self.max_samples.unwrap_or(picture.most_samples),
            filter: self.filter.map_or(picture.filter, Into::into),
            light_model: self.light.map_or(picture.light_model, Into::into),
            bounces: self.bounces.unwrap_or(picture.bounces),
            transparent: self.transparent || picture.transparent,
            ..self.develop.apply(picture)
        }
    }

    /// The warning about an option that has no effect on this picture, which the arguments were applied to.
    pub(crate) fn warning(&self, picture: &Picture) -> Option<&'static str> {
        let is_unused = self.max_samples.is_some() && picture.noise == 0.0;
        is_unused.then_some("--max-samples has no effect without --noise")
    }
}

/// The conversion of a film to a picture.
#[derive(Debug, clap::Args)]
pub(crate) struct DevelopArgs {
    /// Choose the encoding of linear values as bytes; default: that of the scene, or srgb
    #[arg(long, value_enum)]
    pub(crate) encoding: Option<EncodingArg>,
    /// Set the exposure in stops, -32 to 32; each stop doubles the light
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = exposure)]
    pub(crate) exposure: Option<f64>,
    /// Choose the tone mapping
    #[arg(long, value_enum, visible_alias = "tone-mapping")]
    pub(crate) tone: Option<ToneArg>,
    /// Set the bits per channel of a PNG file
    #[arg(long, value_name = "8|16", visible_alias = "bit-depth", value_parser = bits)]
    pub(crate) bits: Option<u32>,
    /// Dither a PNG file of 8 bits, so that gradients have no bands
    #[arg(long)]
    pub(crate) dither: bool,
    /// Denoise the finished picture by Open Image Denoise, a library that must be installed
    #[arg(long)]
    pub(crate) denoise: bool,
}

impl DevelopArgs {
    /// The picture settings, overridden by the arguments.
    pub(crate) fn apply(&self, picture: Picture) -> Picture {
        Picture {
            encoding: self.encoding.map_or(picture.encoding, Into::into),
            exposure: self.exposure.unwrap_or(picture.exposure),
            tone: self.tone.map_or(picture.tone, Into::into),
            bits: self.bits.unwrap_or(picture.bits),
            dither: self.dither || picture.dither,
            denoise: self.denoise || picture.denoise,
            ..picture
        }
    }
}

/// Resumption and division of long renders.
#[derive(Debug, clap::Args)]
pub(crate) struct LongArgs {
    /// Resume a stopped or killed render from its partial file, OUT.png.part; start again if there
    /// is none
    #[arg(long)]
    pub(crate) resume: bool,
    /// Render shard K of N (1/N to N/N) into the partial file named by -o; 'superegg merge' merges
    /// the shards. 'auto' takes the shard of this job in a Slurm array or an indexed Kubernetes
    /// job; auto/N sets the number of shards
    #[arg(long, value_name = "K/N", visible_alias = "tiles", alias = "share")]
    pub(crate) shard: Option<ShardArg>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// The partial files: shards of one picture, or the checkpoint of a stopped render
    #[arg(required = true, value_name = "FILE.part")]
    pub(crate) parts: Vec<PathBuf>,
    /// Write the picture to this file: .png, or .exr if the partial files are shards or come from
    /// an .exr render; - for standard output
    #[arg(short, long, value_name = "OUT.png|.exr")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Write the picture even if tiles are missing; missing tiles are black or transparent
    #[arg(long)]
    pub(crate) partial: bool,
    #[command(flatten)]
    pub(crate) develop: DevelopArgs,
    /// Set the depth of pixels without a hit in an .exr; 0 is infinity
    #[arg(long, value_name = "Z", value_parser = non_negative)]
    pub(crate) far_depth: Option<f64>,
    /// Print only errors and warnings
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct AnimateArgs {
    /// The scene file, a data file with several frames, or one of a series numbered by step
    pub(crate) scene: PathBuf,
    /// Orbit the camera once around its target in N frames, from its position in the scene
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(FrameRange::MOST)))]
    pub(crate) turntable: Option<u32>,
    /// Render these frames, both included; default: from the first keyframe to the last
    #[arg(long, value_name = "A..B")]
    pub(crate) frames: Option<FrameRange>,
    /// Write the frames into this folder, or encode a film .mp4, .webm or .gif (by ffmpeg) with its
    /// frames in a folder beside it; default: the scene's name with _frames in the current folder
    #[arg(short, long, value_name = "FOLDER|FILM")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Render shard K of N of the frames (1/N to N/N), every Nth, into the same folder; the same
    /// command without --shard encodes the film when all frames exist. 'auto' takes the shard of
    /// this job in a Slurm array or an indexed Kubernetes job; auto/N sets the number of shards
    #[arg(long, value_name = "K/N", visible_alias = "tiles", alias = "share")]
    pub(crate) shard: Option<ShardArg>,
    /// Set the frame rate of the film in frames per second
    #[arg(long, value_name = "F", default_value = "24", value_parser = frame_rate)]
    pub(crate) fps: f64,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Set the recursion depth of objects, 0 to 64; default: that of the scene
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<u32>,
    /// Set the number of threads; default: one for each core
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print only errors and warnings
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) annotations: AnnotationArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
}

/// The root of the picture.
#[derive(Debug, clap::Args)]
pub(crate) struct RootArgs {
    /// Select this object or primitive; default: the last selection of the scene
    #[arg(long, value_name = "NAME")]
    pub(crate) object: Option<String>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct IntersectArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// The rays: the same as --rays
    #[arg(value_name = "RAYS.csv", conflicts_with = "rays")]
    pub(crate) ray_file: Option<PathBuf>,
    /// Read rays from this file, rows of ox,oy,oz,dx,dy,dz below a header, in any order; other
    /// columns are kept; - for standard input; default: describe the hit of the central camera ray
    /// in words
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) rays: Option<PathBuf>,
    /// Write the hits to this file; default: standard output
    #[arg(short, long, value_name = "OUT.csv")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Intersect convex shapes with the f32 kernels instead of the f64 reference path, for
    /// comparison
    #[arg(long)]
    pub(crate) fast: bool,
    /// Test at most so many boxes and shapes for a ray; more are an error; default: 4000000
    #[arg(long, value_name = "BOXES", conflicts_with = "fast")]
    pub(crate) limit: Option<u64>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct IotestArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// The points: the same as --points
    #[arg(value_name = "POINTS.csv", conflicts_with_all = ["points", "step", "extent"])]
    pub(crate) point_file: Option<PathBuf>,
    /// Read points from this file, rows of x,y,z below a header, in any order; other columns are
    /// kept; - for standard input; default: a grid
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["step", "extent"])]
    pub(crate) points: Option<PathBuf>,
    /// Set the spacing of the grid
    #[arg(long, value_name = "S", default_value = "0.5", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) step: f64,
    /// Set the extent of the grid from the origin along each axis
    #[arg(long, value_name = "H", visible_alias = "half", default_value = "5", allow_negative_numbers = true, value_parser = non_negative)]
    pub(crate) extent: f64,
    /// List every primitive that holds the point: their number, and their paths with blanks between
    #[arg(long)]
    pub(crate) all: bool,
    /// Add the signed distance to the surface, its proven error and the primitive that it belongs to
    #[arg(long)]
    pub(crate) distance: bool,
    /// Test at most so many boxes for a point; more are an error; default: 4000000
    #[arg(long, value_name = "BOXES")]
    pub(crate) limit: Option<u64>,
    /// Write the results to this file; default: standard output
    #[arg(short, long, value_name = "OUT.csv")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SampleArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Set the number of points
    #[arg(short = 'n', long, value_name = "N", default_value_t = 10_000, value_parser = value_parser!(u32).range(1..=20_000_000))]
    pub(crate) count: u32,
    /// Write the points to this file; the extension determines the format; - for CSV on standard
    /// output
    #[arg(short, long, value_name = "OUT.ply|.csv|.xyz|.npy")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Set the seed: the same scene, number and seed give the same points
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Leave out points inside other primitives
    #[arg(long)]
    pub(crate) union: bool,
    /// Print only errors and warnings
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct MeasureArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Set the number of samples for the union; 0 for none
    #[arg(short = 'n', long, value_name = "N", default_value_t = 100_000, value_parser = value_parser!(u32).range(0..=100_000_000))]
    pub(crate) samples: u32,
    /// Set the seed of the samples
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Set the maximum number of instances to list; above it, print totals only
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub(crate) rows: u32,
}

#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// The scene file; or a picture of superegg, .png or .exr, which says how it was made
    pub(crate) scene: PathBuf,
    /// Show the details of these primitives and objects; 'all' and 'selected' are names too
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
    /// The scenes to measure: robot, cloud:N, glyphs:N, fractal:B,D, or a scene file
    #[arg(value_name = "SCENE", default_values = ["robot", "cloud:1000", "cloud:10000", "glyphs:10000", "fractal:20,64"])]
    pub(crate) scenes: Vec<String>,
    /// Set width and height in pixels
    #[arg(short, long, value_name = "WxH", default_value = "1280x960")]
    pub(crate) size: Size,
    /// Set the number of rounds; each figure is the best of them
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = value_parser!(u32).range(1..=1000))]
    pub(crate) rounds: u32,
    /// Set the seed of random scenes and rays
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write the figures as JSON to this file; - for standard output instead of the table
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Write the generated scenes as NAME.scn into this folder, and measure nothing
    #[arg(long, value_name = "FOLDER")]
    pub(crate) save: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ExportArgs {
    /// The scene file
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    /// Write to this file; the extension determines the format: .pov for POV-Ray; .stl, .ply, .obj,
    /// .glb for meshes; .vtp for OVITO and ParaView; .liggghts and .data for LIGGGHTS; .txt and .npy
    /// for EMS vectors; .csv for a table; .nrrd and .vti for a grid of values
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
    /// Set the recursion depth of objects, 0 to 64; default: that of the scene
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<u32>,
    /// Set the greatest distance between a mesh and the exact surface, as a part of the largest
    /// semi-axis of each instance
    #[arg(long, value_name = "T", default_value = "1e-3", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) tolerance: f64,
    /// Take the tolerance in world units
    #[arg(long)]
    pub(crate) absolute: bool,
    /// Write coordinates of .ply and .obj as float64; default: float32, which all programs read
    #[arg(long)]
    pub(crate) double: bool,
    /// Set the number of samples of a grid along its longest side, 4 to 512
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = value_parser!(u16).range(4..=512))]
    pub(crate) grid: u16,
    /// Set the value of a grid
    #[arg(long, value_enum, default_value = "distance")]
    pub(crate) value: GridValueArg,
}

#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// The file of commands, - for standard input
    pub(crate) file: PathBuf,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// The scene file, or data of another program; default: a new scene
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) root: RootArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// Show the scene as the course program does: with both tests, its grid and its patches
    #[arg(long)]
    pub(crate) course: bool,
    /// Open no window; print the frame times of the preview and of the live ray traced view
    #[arg(long, requires = "scene")]
    pub(crate) bench: bool,
    /// Set width and height of the frames in pixels
    #[arg(short, long, value_name = "WxH", default_value = "1000x1000", requires = "bench")]
    pub(crate) size: Size,
    /// Set the number of frames
    #[arg(long, value_name = "N", default_value_t = 60, requires = "bench", value_parser = value_parser!(u16).range(1..))]
    pub(crate) frames: u16,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// Write superegg.1 and a page for each command into this folder
    #[arg(value_name = "FOLDER")]
    pub(crate) folder: PathBuf,
    #[command(flatten)]
    pub(crate) overwrite: OverwriteArgs,
}
