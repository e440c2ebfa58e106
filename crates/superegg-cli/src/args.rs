//! The command-line arguments.

mod color;
mod data;
mod fit;
mod options;
mod values;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use superegg_lang::nearest;

pub(crate) use color::ColorArg;
pub(crate) use data::ImportArgs;
pub(crate) use fit::FitArgs;
pub(crate) use options::{
    AnimateArgs, BenchArgs, CheckArgs, CompletionsArgs, ExportArgs, InfoArgs, IntersectArgs, IotestArgs,
    ManArgs, MeasureArgs, MergeArgs, PictureArgs, RenderArgs, RootArgs, RunArgs, SampleArgs, ViewArgs,
};
pub(crate) use values::FrameRange;

/// A modeller and exact ray tracer for superquadrics.
#[derive(Debug, Parser)]
#[command(
    name = "superegg",
    version,
    override_usage = "superegg [OPTIONS] [SCENE]\n       superegg [OPTIONS] <COMMAND>",
    before_help = "Without a command: start the modeller, a prompt to build scenes; without a terminal it reads lines from standard input.",
    after_help = "Exit codes: 0 success; 1 errors in the input; 2 wrong usage, or a file that cannot be read or written; 130 stopped by ctrl-c."
)]
pub(crate) struct Args {
    /// The scene to open in the modeller
    pub(crate) scene: Option<PathBuf>,
    /// Colour messages: at a terminal, always or never; NO_COLOR, CLICOLOR and CLICOLOR_FORCE are
    /// respected
    #[arg(
        long,
        global = true,
        value_enum,
        value_name = "auto|always|never",
        default_value_t,
        hide_possible_values = true
    )]
    pub(crate) color: ColorArg,
    /// Show the scene as the course program does: with both tests, its grid and its patches
    #[arg(long)]
    pub(crate) course: bool,
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to a PNG or OpenEXR picture
    Render(RenderArgs),
    /// Render the frames of an animation, from keyframes or a turntable, and encode a film
    Animate(AnimateArgs),
    /// Merge the shards of a picture
    Merge(MergeArgs),
    /// Find the first hit of rays
    Intersect(IntersectArgs),
    /// Test points with the inside-outside function
    Iotest(IotestArgs),
    /// Import data of other programs: particles, fits, tensors, point clouds
    Import(ImportArgs),
    /// Fit a superquadric to the points of a cloud or a mesh
    Fit(FitArgs),
    /// Sample points of the surfaces, evenly by area, with normals
    Sample(SampleArgs),
    /// Measure volume, area, centre, inertia and bounding box of each primitive and of the union
    Measure(MeasureArgs),
    /// List the contents of a scene, or the details of primitives and objects
    Info(InfoArgs),
    /// Check a scene for errors and warnings
    Check(CheckArgs),
    /// Measure ray rates, compile times and memory on generated and given scenes
    Bench(BenchArgs),
    /// Export a scene to the format of another program
    Export(ExportArgs),
    /// Run a file of commands as a session, with its output and without questions
    Run(RunArgs),
    /// Open a window onto a scene
    View(ViewArgs),
    /// Print the completions of a shell
    Completions(CompletionsArgs),
    /// Write man pages
    Man(ManArgs),
}

impl Args {
    /// Parses arguments, of which the first is the name of the program. Errors and help have these
    /// colours.
    ///
    /// # Errors
    /// The arguments are wrong, or want help.
    pub(crate) fn parse_with(color: ColorArg, args: &[OsString]) -> Result<Self, clap::Error> {
        let mut command = Self::command().color(color.into());
        let matches = command.try_get_matches_from_mut(args)?;
        let parsed = Self::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
        if let (Some(scene), Some(_)) = (&parsed.scene, &parsed.command) {
            let message =
                format!("'{}' stands before a command; the scene is its first argument", scene.display());
            return Err(command.error(ErrorKind::ArgumentConflict, message));
        }
        Ok(parsed)
    }
}

/// The error for a first word that is no command, file or option; `None` for any other word.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_fit_together() {
        Args::command().debug_assert();
    }

    #[test]
    fn old_names_of_options_still_work() {
        let render = |words: &str| {
            let args = Args::try_parse_from(words.split(' ')).unwrap();
            let Some(Command::Render(args)) = args.command else { panic!("{words}") };
            (format!("{:?}", args.aov), format!("{:?}", args.long.shard))
        };
        for (old, new) in [
            ("render s --view id --tiles 2/3", "render s --aov instance-id --shard 2/3"),
            ("render s --view steps --share auto/8", "render s --aov cost --shard auto/8"),
        ] {
            let [old, new] = [old, new].map(|words| render(&format!("superegg {words}")));
            assert_eq!(old, new);
            assert!(old.0.contains("Some") && old.1.contains("Some"));
        }
        for words in [
            "superegg animate s --tiles 1/2",
            "superegg iotest s --half 2",
            "superegg render s --tone filmic --bits 16",
        ] {
            Args::try_parse_from(words.split(' ')).unwrap();
        }
    }
}
