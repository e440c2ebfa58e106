//! `superegg import`: data of other programs as a scene file.

use anyhow::Result;
use superegg_lang::write_session;

use crate::args::ImportArgs;
use crate::console;
use crate::files;
use crate::files::binary_scene;
use crate::files::data::load_files;
use crate::outcome::Outcome;

pub(crate) fn run(args: &ImportArgs) -> Result<Outcome> {
    for file in &args.files {
        files::check_output(Some(&args.output), file, args.overwrite.into())?;
    }
    let loaded = load_files(&args.files, &args.data.options(args.frame, None))?;
    for note in &loaded.notes {
        if !args.quiet || note.is_warning() {
            console::warn(format_args!("superegg: {note}"));
        }
    }
    let session = &loaded.session;
    if binary_scene::has_extension(&args.output) {
        binary_scene::write(&args.output, session.scene(), session.selected())?;
    } else {
        files::write(&args.output, write_session(session).as_bytes())?;
    }
    if !args.quiet && !files::is_standard_stream(&args.output) {
        console::print(format_args!("{}: written", args.output.display()))?;
    }
    Ok(Outcome::Fine)
}
