//! Loads and compiles the scene of a command.

use std::path::Path;

use anyhow::{Result, anyhow};
use superegg_lang::{Session, scene_at};
use superegg_scene::Scene;
use superegg_trace::CompiledScene;

use crate::args::RootArgs;
use crate::files::scene::{Loaded, load};

/// Loads and compiles a scene and prints its diagnostics.
pub(super) fn load_compiled(scene: &Path, root: &RootArgs) -> Result<(Loaded, CompiledScene)> {
    let loaded = load(scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(root.object.as_deref())?;
    let scene = loaded.session.scene();
    let compiled = CompiledScene::compile(scene, root.as_deref(), scene.depth);
    Ok((loaded, compiled))
}

/// The most instances that are listed one by one.
pub(super) const MOST_INSTANCES: usize = 1 << 21;

/// The error for a scene with too many instances to be listed.
pub(super) fn too_many_instances(scene: &CompiledScene) -> String {
    format!(
        "the scene has {} instances, more than the {MOST_INSTANCES} that can be listed; reduce its depth ('setDepth') or select a part (--object)",
        scene.instance_count()
    )
}

/// The scene at a frame of its keyframes.
pub(super) fn still_at(session: &Session, frame: f64) -> Result<Scene> {
    scene_at(session, frame).map_err(|fault| anyhow!("{}; {}", fault.message, fault.help.unwrap_or_default()))
}
