//! Loads and compiles the scene of a command.

use std::path::Path;

use anyhow::{Result, anyhow};
use superegg_lang::{Session, scene_at};
use superegg_scene::Scene;
use superegg_trace::CompiledScene;

use crate::args::RootArgs;
use crate::files;
use crate::files::scene::{Loaded, load};

/// Loads and compiles a scene and prints its diagnostics, after a check that `output` can be
/// written.
pub(super) fn load_compiled(
    scene: &Path,
    root: &RootArgs,
    output: Option<&Path>,
) -> Result<(Loaded, CompiledScene)> {
    files::check_output(output, scene)?;
    let loaded = load(scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(root.object.as_deref())?;
    let scene = loaded.session.scene();
    let compiled = CompiledScene::compile(scene, root.as_deref(), scene.depth);
    Ok((loaded, compiled))
}

/// The scene at a frame of its keyframes.
pub(super) fn still_at(session: &Session, frame: f64) -> Result<Scene> {
    scene_at(session, frame).map_err(|fault| anyhow!("{}; {}", fault.message, fault.help.unwrap_or_default()))
}
