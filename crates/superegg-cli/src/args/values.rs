//! The types and parsers of argument values.

use std::str::FromStr;

use clap::ValueEnum;
use superegg_exchange::write::grid::GridValue;
use superegg_lang::{ArgKind, Range, find_command, parse_number, parse_size};
use superegg_render::Output;
use superegg_scene::{Encoding, Filter, LightModel, Tone};

use crate::files::Overwrite;

/// The encoding of linear values as bytes.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum EncodingArg {
    /// The sRGB curve, for screens
    Srgb,
    /// Linear: 255 times the value
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

/// A reconstruction filter.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FilterArg {
    /// Equal weights within the pixel
    Box,
    /// A tent with a radius of one pixel
    Tent,
    /// A Gaussian with a standard deviation of half a pixel
    Gaussian,
    /// A Blackman-Harris window with a radius of 2 pixels
    Blackman,
    /// The Mitchell-Netravali cubic: sharper
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

/// How light reaches a surface.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum LightModelArg {
    /// Straight from the lights, with constant ambient light
    Course,
    /// By any number of surfaces, and from the sky (path tracing)
    Path,
}

impl From<LightModelArg> for LightModel {
    fn from(arg: LightModelArg) -> Self {
        match arg {
            LightModelArg::Course => Self::Course,
            LightModelArg::Path => Self::Path,
        }
    }
}

/// A tone mapping curve.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ToneArg {
    /// Clip values above 1
    None,
    /// Compress by luminance; 4 becomes white
    Reinhard,
    /// A film curve: more contrast, each channel by itself
    Filmic,
    /// The curve of ACES: bright colours turn white
    Aces,
    /// AgX: soft contrast, bright colours fade to white without a turn of hue
    Agx,
}

impl From<ToneArg> for Tone {
    fn from(arg: ToneArg) -> Self {
        match arg {
            ToneArg::None => Self::None,
            ToneArg::Reinhard => Self::Reinhard,
            ToneArg::Filmic => Self::Filmic,
            ToneArg::Aces => Self::Aces,
            ToneArg::Agx => Self::Agx,
        }
    }
}

/// An AOV (arbitrary output variable): a quantity other than light.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum AovArg {
    /// The surface normal n, as 0.5 + 0.5 n
    Normal,
    /// The depth: white for the nearest, black for the farthest point
    Depth,
    /// The colour of the surface, without light
    Albedo,
    /// A colour for each instance
    #[value(alias = "id")]
    InstanceId,
    /// The number of boxes and shapes that a ray tests: black for none, white for the maximum
    #[value(alias = "steps")]
    Cost,
    /// Ambient occlusion alone
    Ao,
}

impl From<AovArg> for Output {
    fn from(arg: AovArg) -> Self {
        match arg {
            AovArg::Normal => Self::Normal,
            AovArg::Depth => Self::Depth,
            AovArg::Albedo => Self::Albedo,
            AovArg::InstanceId => Self::Id,
            AovArg::Cost => Self::Steps,
            AovArg::Ao => Self::Occlusion,
        }
    }
}

/// The value of a grid.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum GridValueArg {
    /// The signed distance, negative inside
    Distance,
    /// The inside-outside value, each in its primitive's own space
    InsideOutside,
}

impl From<GridValueArg> for GridValue {
    fn from(arg: GridValueArg) -> Self {
        match arg {
            GridValueArg::Distance => Self::Distance,
            GridValueArg::InsideOutside => Self::InsideOutside,
        }
    }
}

/// Whether an output may replace any file.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct OverwriteArgs {
    /// Replace existing files even if they are read-only, or frames that another program made
    #[arg(long)]
    force: bool,
}

impl From<OverwriteArgs> for Overwrite {
    fn from(args: OverwriteArgs) -> Self {
        if args.force { Self::Any } else { Self::Writable }
    }
}

/// A picture size in pixels.
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

/// A range of frames, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange {
    pub(crate) first: u32,
    /// At least `first`.
    pub(crate) last: u32,
}

impl FrameRange {
    /// The maximum frame number.
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

/// A recursion depth, in the range of the command `setDepth`.
pub(super) fn depth(text: &str) -> Result<u32, String> {
    let range = find_command("setDepth").and_then(|spec| spec.all_args().next()).map(|arg| arg.kind);
    let Some(ArgKind::Number(range)) = range else { return Err("setDepth takes no number".to_owned()) };
    Ok(number_in(text, range)? as u32)
}

/// A noise threshold from 0 to 1.
pub(super) fn noise_threshold(text: &str) -> Result<f64, String> {
    number_in(text, Range::Within(0.0, 1.0))
}

/// A share of outliers from 0 to 0.9.
pub(super) fn outlier_share(text: &str) -> Result<f64, String> {
    number_in(text, Range::Within(0.0, 0.9))
}

/// An exposure in stops.
pub(super) fn exposure(text: &str) -> Result<f64, String> {
    number_in(text, Range::Within(-32.0, 32.0))
}

/// The bits per channel of a PNG file.
pub(super) fn bits(text: &str) -> Result<u32, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("it must be 8 or 16".to_owned()),
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    number_in(text, Range::Positive)
}

pub(super) fn non_negative(text: &str) -> Result<f64, String> {
    number_in(text, Range::NonNegative)
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    number_in(text, Range::Any)
}

/// A frame rate in frames per second.
pub(super) fn frame_rate(text: &str) -> Result<f64, String> {
    number_in(text, Range::AboveTo(0.0, 1000.0))
}

fn number_in(text: &str, range: Range) -> Result<f64, String> {
    let number = parse_number(text).map_err(|error| format!("it {error}"))?;
    if range.contains(number) { Ok(number) } else { Err(format!("it must be {}", range.describe())) }
}

#[cfg(test)]
mod tests {
    use super::*;

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
