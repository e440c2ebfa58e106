//! Encodes frames as a film with ffmpeg.

use std::ffi::{OsStr, OsString};
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::commands::animate::frame_folder::FrameFolder;
use crate::files::temporary::TemporaryFile;

/// A film format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FilmFormat {
    /// H.264, supported by every player.
    Mp4,
    /// VP9, for browsers; supports transparency.
    WebM,
    /// 256 colours, in a loop.
    Gif,
}

impl FilmFormat {
    /// The known extensions, for messages.
    pub(crate) const EXTENSIONS: &str = ".mp4, .webm or .gif";

    /// The format of a path by its extension.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mp4" => Some(Self::Mp4),
            "webm" => Some(Self::WebM),
            "gif" => Some(Self::Gif),
            _ => None,
        }
    }

    /// Encodes the frames, completely or not at all.
    ///
    /// # Errors
    /// ffmpeg is not installed or fails. The frames stay, and the error has the command.
    pub(crate) fn encode(
        self,
        path: &Path,
        folder: &FrameFolder,
        frames: impl ExactSizeIterator<Item = u32>,
        fps: f64,
        transparent: bool,
    ) -> Result<()> {
        let cannot_write = || format!("cannot write '{}'", path.display());
        let frame_folder = std::path::absolute(folder.path()).with_context(cannot_write)?;
        let film = std::path::absolute(path).with_context(cannot_write)?;
        // It has the film's extension, which determines ffmpeg's format.
        let unfinished = TemporaryFile::beside(&film).with_context(cannot_write)?;
        let mut args = self.arguments(&frame_folder, frames, fps, transparent);
        let by_hand = shell_command(&args, &file_address(&film));
        args.push(file_address(unfinished.path_for_writer()));
        let ran = Command::new("ffmpeg").args(&args).stdin(Stdio::null()).stdout(Stdio::null()).output();
        match ran {
            Ok(output) if output.status.success() => unfinished.commit().with_context(cannot_write),
            Ok(output) => {
                let errors = String::from_utf8_lossy(&output.stderr);
                let last = errors.trim().lines().last().unwrap_or("it reports no reason");
                bail!(
                    "ffmpeg cannot make '{}': {last}\nthe frames are in '{}'; by hand: {by_hand}",
                    path.display(),
                    folder.path().display()
                )
            }
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "ffmpeg, which encodes the film, is not installed; the frames are in '{}'. With ffmpeg run the same command \
                 again, or: {by_hand}",
                folder.path().display()
            ),
            Err(error) => Err(error).context("cannot run ffmpeg"),
        }
    }

    /// The arguments of ffmpeg without the name of the film. The folder is absolute.
    fn arguments(
        self,
        folder: &Path,
        mut frames: impl ExactSizeIterator<Item = u32>,
        fps: f64,
        transparent: bool,
    ) -> Vec<OsString> {
        let count = frames.len();
        let first = frames.next().unwrap_or(0);
        // H.264 and VP9 need even sizes; the colours are those of high definition (BT.709).
        let plain = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv";
        let colors = "-colorspace bt709 -color_primaries bt709 -color_trc bt709";
        let codec = match self {
            Self::Mp4 => {
                format!("-vf {plain} {colors} -c:v libx264 -crf 16 -pix_fmt yuv420p -movflags +faststart")
            }
            Self::WebM => {
                let pixels = if transparent { "yuva420p" } else { "yuv420p" };
                format!("-vf {plain} {colors} -c:v libvpx-vp9 -crf 20 -b:v 0 -pix_fmt {pixels}")
            }
            Self::Gif => "-vf split[a][b];[a]palettegen[p];[b][p]paletteuse -loop 0".to_owned(),
        };
        let mut args: Vec<OsString> =
            format!("-y -hide_banner -loglevel error -framerate {fps} -start_number {first} -i")
                .split(' ')
                .map(OsString::from)
                .collect();
        // Escape percent signs, which ffmpeg reads as a number pattern.
        let folder = folder.to_string_lossy().replace('%', "%%");
        args.push(file_address(&Path::new(&folder).join(FrameFolder::PATTERN)));
        args.extend(["-frames:v".into(), count.to_string().into()]);
        args.extend(codec.split(' ').map(OsString::from));
        args
    }
}

/// An absolute path as ffmpeg takes it for nothing but a file: no name is an option, a device or an
/// address of the network.
fn file_address(path: &Path) -> OsString {
    let mut address = OsString::from("file:");
    address.push(path);
    address
}

/// The command as typed in a shell.
fn shell_command(args: &[OsString], film: &OsStr) -> String {
    let mut text = String::from("ffmpeg");
    for word in args.iter().map(|word| word.to_string_lossy()).chain([film.to_string_lossy()]) {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./%:+=,".contains(c);
        let quoted = format!("'{}'", word.replace('\'', "'\\''"));
        text.push(' ');
        text.push_str(if word.chars().all(is_plain) { &word } else { &quoted });
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shown_command_can_be_typed() {
        let args = FilmFormat::Mp4.arguments(Path::new("/my 100% film"), 3..8, 12.5, false);
        let text = shell_command(&args, &file_address(Path::new("/it's.mp4")));
        assert!(
            text.starts_with("ffmpeg -y -hide_banner -loglevel error -framerate 12.5 -start_number 3 -i 'file:/my 100%% film/frame_%04d.png' -frames:v 5 "),
            "{text}"
        );
        assert!(text.ends_with(r"'file:/it'\''s.mp4'"), "{text}");
    }

    #[test]
    fn the_extension_determines_the_format() {
        for (name, format) in [
            ("a.MP4", Some(FilmFormat::Mp4)),
            ("b.webm", Some(FilmFormat::WebM)),
            ("c.gif.png", None),
            ("gif", None),
        ] {
            assert_eq!(FilmFormat::of(Path::new(name)), format, "{name}");
        }
    }
}
