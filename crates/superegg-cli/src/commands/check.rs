//! `superegg check`: errors and warnings of a scene file.

use anyhow::Result;
use superegg_lang::lint;
use superegg_trace::CompiledScene;

use crate::args::CheckArgs;
use crate::console;
use crate::files::scene::load;
use crate::outcome::Outcome;
use crate::text::counted;

pub(crate) fn run(args: &CheckArgs) -> Result<Outcome> {
    let mut loaded = load(&args.scene)?;
    loaded.diagnostics.extend(lint(&loaded.session, &args.scene.display().to_string()));
    loaded.print_diagnostics();

    let errors = loaded.error_count();
    let all: usize = loaded.diagnostics.iter().map(|diagnostic| diagnostic.count).sum();
    let warnings = all - errors;
    let scene = loaded.session.scene();
    let compiled = CompiledScene::compile(scene, loaded.session.selected(), scene.depth);
    console::print(format_args!(
        "{}: {}, {}; {}, {}, {} in the picture",
        args.scene.display(),
        counted(errors, "error"),
        counted(warnings, "warning"),
        counted(scene.primitives().count(), "primitive"),
        counted(scene.objects().count(), "object"),
        counted(compiled.instance_count(), "instance"),
    ))?;
    Ok(Outcome::of_input(errors > 0 || (args.strict && warnings > 0)))
}
