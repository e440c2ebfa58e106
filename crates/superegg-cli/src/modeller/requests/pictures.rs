//! Renders to files and draws previews.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use superegg_lang::{Fault, FaultCode, scene_at};
use superegg_render::{Development, RenderOptions, render};
use superegg_scene::{Encoding, Picture};
use superegg_trace::CompiledScene;

use crate::files::maker::check_maker;
use crate::files::picture::PictureFormat;
use crate::files::surroundings::settings_with_surroundings;
use crate::files::{self, Overwrite};
use crate::inspect::framing::{framed, framing_note};
use crate::inspect::picture_warnings::picture_warnings;
use crate::modeller::canvas::Canvas;
use crate::modeller::faults::unwritable;
use crate::modeller::render_queue::RenderJob;
use crate::modeller::state::Modeller;
use crate::system::processor::available_threads;

/// The terminal size where the system does not report it, in columns and rows.
const DEFAULT_TERMINAL: (u32, u32) = (80, 24);
/// The maximum samples per pixel of a preview.
const MOST_PREVIEW_SAMPLES: u32 = 4;

impl Modeller {
    /// Cancels all background renders.
    pub(super) fn cancel_renders(&mut self) -> Result<(), Fault> {
        if self.stop_renders() {
            return Ok(());
        }
        let fault = Fault::new(FaultCode::NothingLeft, "nothing is being rendered");
        Err(fault.help("'render' begins a picture; 'stop' alone leaves").warning())
    }

    /// Queues a render of the selected primitive or object. Default file: the name of the scene
    /// file with `.png`. With `is_forced` it replaces a read-only file.
    pub(super) fn render(
        &mut self,
        file: Option<&str>,
        size: Option<(u32, u32)>,
        is_forced: bool,
    ) -> Result<(), Fault> {
        let root = self.selected_root()?.to_owned();
        let path = match file {
            Some(file) => picture_path(self.folders.expand(file))?,
            None => {
                let stem = self.scene_file.as_deref().and_then(Path::file_stem).unwrap_or("scene".as_ref());
                let mut name = stem.to_owned();
                name.push(".png");
                picture_path(PathBuf::from(name))?
            }
        };
        let overwrite = if is_forced { Overwrite::Any } else { Overwrite::Writable };
        files::check_not_pipe(&path)
            .and_then(|()| files::check_output(Some(&path), Path::new(""), overwrite))
            .and_then(|()| files::check_creatable(&path))
            .map_err(|error| unwritable(&error))?;
        let replaced = check_maker(&path, file.is_none(), overwrite).map_err(|error| {
            Fault::new(FaultCode::NotOurs, error.to_string())
                .help("'render NAME' writes another picture, 'render!' replaces this one")
        })?;
        replaced.iter().for_each(|note| self.print(note));
        self.warn_of_empty_picture(&root);
        let session = self.session();
        let scene = self.scene_to_render(session.scene().clone());
        let picture = scene.picture;
        let job = RenderJob {
            root,
            name: path.display().to_string(),
            path: std::path::absolute(&path).unwrap_or(path),
            size: size.unwrap_or((picture.width, picture.height)),
            threads: session.settings.threads as usize,
            scene,
        };
        match self.renders.push(job) {
            0 => {}
            1 => self.print("queued behind 1 picture"),
            ahead => self.print(&format!("queued behind {ahead} pictures")),
        }
        Ok(())
    }

    /// Warns of a root without children and of a camera that looks along its up direction.
    fn warn_of_empty_picture(&mut self, root: &str) {
        let scene = self.session().scene();
        let object = scene.object(root).ok();
        let is_empty = object.is_some_and(|object| object.children().len() == 0);
        let is_hidden = object.is_some_and(|object| object.visible_children().next().is_none());
        let looks_along_up = scene.camera.looks_along_up();
        if is_empty {
            self.print(&format!("warning: '{root}' has no children, so there is nothing to see in it"));
        } else if is_hidden {
            self.print(&format!("warning: all children of '{root}' are hidden; 'unhide' shows them"));
        }
        if looks_along_up {
            self.print("warning: the camera looks along its up direction; 'cameraUp x y z' gives another");
        }
    }

    /// Draws the scene, or the scene at a frame, in the terminal.
    pub(super) fn preview(&mut self, frame: Option<f64>) -> Result<(), Fault> {
        let root = self.selected_root()?.to_owned();
        self.warn_of_empty_picture(&root);
        let session = self.session();
        let canvas = Canvas::choose(session.settings.preview);
        let scene = match frame {
            Some(frame) => scene_at(session, frame)?,
            None => session.scene().clone(),
        };
        let scene = &self.scene_to_render(scene);
        let compiled = CompiledScene::compile(scene, Some(&root), scene.depth);
        let picture = preview_picture(scene.picture, canvas);
        let framed = framed(scene, &compiled, (picture.width, picture.height));
        let scene = framed.as_ref().unwrap_or(scene);
        let note = framed.as_ref().map(framing_note);
        let unreadable = |error: anyhow::Error| {
            Fault::new(FaultCode::Preview, format!("{error:#}"))
                .help("'environment FILE' names another picture, 'unenvironment' none")
        };
        let settings = settings_with_surroundings(scene, None).map_err(unreadable)?;
        let settings = settings.with_picture(picture).with_layers(false);
        let development = Development::of(&picture);
        let threads = match session.settings.threads {
            0 => available_threads(),
            threads => threads as usize,
        };
        note.iter().for_each(|note| self.print(note));
        for warning in picture_warnings(&compiled, &settings) {
            self.print(&format!("warning: {warning}"));
        }
        let options = RenderOptions::default().with_threads(threads).with_cancel(&self.interrupt);
        let cannot_draw = |error: &dyn std::fmt::Display| {
            Fault::new(FaultCode::Preview, format!("the preview cannot be drawn: {error}"))
                .help("'render' writes a picture")
        };
        let rendered = render(&compiled, &settings, &options).map_err(|error| cannot_draw(&error))?;
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(Fault::new(FaultCode::Interrupted, "the preview was interrupted").warning());
        }
        let text = canvas.draw(&rendered.film, &development).map_err(|error| cannot_draw(&error))?;
        self.print_raw(&text);
        Ok(())
    }
}

/// The picture settings of a preview: a small 8-bit sRGB picture with few samples.
fn preview_picture(picture: Picture, canvas: Canvas) -> Picture {
    let (columns, rows) = terminal_size::terminal_size()
        .map_or(DEFAULT_TERMINAL, |(width, height)| (u32::from(width.0), u32::from(height.0)));
    let size = (picture.width, picture.height);
    let (width, height) = canvas.size_px(size, columns.max(1), rows.saturating_sub(2).max(1));
    Picture {
        width,
        height,
        samples: picture.samples.min(MOST_PREVIEW_SAMPLES),
        noise: 0.0,
        encoding: Encoding::Srgb,
        bits: 8,
        transparent: false,
        ..picture
    }
}

/// The path of a picture: adds `.png` to a name without an extension, and rejects unknown formats
/// and existing files that are not pictures.
fn picture_path(path: PathBuf) -> Result<PathBuf, Fault> {
    let path = if path.extension().is_none() && !path.is_dir() { path.with_extension("png") } else { path };
    let format = PictureFormat::of(&path).ok().filter(|_| path.extension().is_some()).ok_or_else(|| {
        let message = format!("'{}' is no name for a picture", path.display());
        Fault::new(FaultCode::NotAPicture, message).help(format!("names end in {}", PictureFormat::ENDINGS))
    })?;
    let is_other = path.is_file()
        && path.metadata().is_ok_and(|m| m.len() > 0)
        && !files::begins_with(&path, format.signature());
    if is_other {
        let message = format!("'{}' exists and is no picture", path.display());
        return Err(Fault::new(FaultCode::NotAPicture, message).help("take another name"));
    }
    Ok(path)
}
