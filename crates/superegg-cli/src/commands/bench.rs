//! `superegg bench`: ray rates, compile times and memory on reproducible scenes.

mod generated_scene;
mod measure;
mod row;

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use superegg_lang::{Session, load_text};

use crate::args::BenchArgs;
use crate::console;
use crate::files;
use crate::files::scene::load;
use crate::outcome::Outcome;
use generated_scene::GeneratedScene;
use measure::{Subject, measure};
use row::{HEADER, LEGEND};

/// The scene called `robot`: `scenes/crane_arm.scn`, here too so that the crate is complete.
const ROBOT: &str = include_str!("bench/crane_arm.scn");

pub(crate) fn run(args: &BenchArgs) -> Result<Outcome> {
    match &args.save {
        Some(folder) => save_scenes(args, folder)?,
        None => measure_scenes(args)?,
    }
    Ok(Outcome::Fine)
}

/// Writes the generated scenes into a folder.
fn save_scenes(args: &BenchArgs, folder: &Path) -> Result<()> {
    for name in &args.scenes {
        let text = scene_text(name, args.seed)?;
        let file = folder.join(format!("{}.scn", name.replace([':', ','], "_")));
        files::check_output(Some(&file), Path::new(""), args.overwrite.into())?;
        files::write(&file, text.as_bytes())?;
        console::print(file.display())?;
    }
    Ok(())
}

/// Measures the scenes; prints the table as it grows and writes the JSON file.
fn measure_scenes(args: &BenchArgs) -> Result<()> {
    files::check_output(args.json.as_deref(), Path::new(""), args.overwrite.into())?;
    let prints_table = !args.json.as_deref().is_some_and(files::is_standard_stream);
    let mut rows = Vec::new();
    for name in &args.scenes {
        let row = measure(name, subject(name, args.seed)?, rows.is_empty(), args)?;
        if prints_table {
            if rows.is_empty() {
                console::print(HEADER)?;
            }
            console::print(row.line())?;
        }
        rows.push(row);
    }
    if prints_table {
        console::print(LEGEND)?;
    }
    if let Some(path) = &args.json {
        files::write(path, format!("{}\n", serde_json::to_string_pretty(&rows)?).as_bytes())?;
    }
    Ok(())
}

/// The scene of a name: `robot`, a generated scene or a file.
fn subject(name: &str, seed: u64) -> Result<Subject> {
    let of_session = |session: &Session, folder: Option<&Path>| Subject {
        scene: session.scene().clone(),
        root: session.selected().map(str::to_owned),
        folder: folder.map(Path::to_owned),
    };
    if name == "robot" {
        return Ok(of_session(&load_text("robot", ROBOT).0, None));
    }
    if let Some(generated) = GeneratedScene::parse(name)? {
        let root = Some(generated_scene::ROOT.to_owned());
        return Ok(Subject { scene: generated.scene(seed)?, root, folder: None });
    }
    if !Path::new(name).exists() {
        bail!("'{name}' is neither a file nor one of robot, cloud:N, glyphs:N, fractal:B,D");
    }
    let path = Path::new(name);
    let loaded = load(path)?;
    loaded.print_diagnostics();
    Ok(of_session(&loaded.session, path.parent()))
}

/// The commands of `robot` or of a generated scene.
fn scene_text(name: &str, seed: u64) -> Result<String> {
    if name == "robot" {
        return Ok(ROBOT.to_owned());
    }
    GeneratedScene::parse(name)?
        .map(|generated| generated.text(seed))
        .ok_or_else(|| anyhow!("'{name}' is none of robot, cloud:N, glyphs:N, fractal:B,D"))
}
