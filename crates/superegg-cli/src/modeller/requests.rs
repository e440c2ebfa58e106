//! What lines ask of the world: files, folders, pictures, tests.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::SystemTime;

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_lang::{Fault, Recovery, Request, Timeline, format_number, scene_at, write_session};
use superegg_render::{Development, RenderOptions, RenderSettings, render};
use superegg_scene::{Encoding, Picture};
use superegg_trace::CompiledScene;

use crate::commands::intersect::{tell_camera_ray, tell_hit};
use crate::commands::iotest::Grid;
use crate::commands::{available_threads, counted};
use crate::files;
use crate::load::{Loaded, load_into};
use crate::modeller::journal::{LeftBehind, Record, read_records};
use crate::modeller::preview::Canvas;
use crate::modeller::renders::Job;
use crate::modeller::{Modeller, Pending, Said, place_at_argument, tree};
use crate::picture_file::PictureFormat;
use crate::pointless::concerns;

/// So many errors of one file are told one by one.
const MOST_TOLD: usize = 1000;

impl Modeller {
    /// Does what a line asks for. The line is what the undo history calls it.
    pub(super) fn carry_out(&mut self, request: &Request, line: &str) -> Result<(), Fault> {
        match request {
            // Stopping is the reply's; undo and redo are the timeline's.
            Request::Stop | Request::Undo(_) | Request::Redo(_) => Ok(()),
            Request::StopRender => self.stop_render(),
            Request::Source { file, is_forced } => self.source(file.as_deref(), *is_forced, line),
            Request::Save { file, is_forced, as_history } => {
                self.save(file.as_deref(), *is_forced, *as_history)
            }
            Request::Recover(what) => self.recover(*what),
            Request::Show(names) => self.show(names, line),
            Request::History(count) => {
                let skipped =
                    self.typed.len().saturating_sub(count.map_or(usize::MAX, |count| count as usize));
                let lines = self.typed.iter().enumerate().skip(skipped);
                let text =
                    lines.map(|(i, line)| format!("{:>5}  {line}", i + 1)).collect::<Vec<_>>().join("\n");
                self.print(&text);
                Ok(())
            }
            Request::ClearScreen => {
                if self.has_person() {
                    self.print_raw("\x1b[H\x1b[2J\x1b[3J");
                }
                Ok(())
            }
            Request::TellFolder => {
                let folder = std::env::current_dir().map_err(|error| unreadable(&error.into()))?;
                self.print(&folder.display().to_string());
                Ok(())
            }
            Request::ChangeFolder(folder) => self.change_folder(folder.as_deref()),
            Request::ListFolder(folder) => self.list_folder(folder.as_deref()),
            Request::Render { file, size } => self.render(file.as_deref(), *size),
            Request::Preview(frame) => {
                self.preview(*frame).map_err(|fault| place_at_argument(fault, line, 1))
            }
            Request::View => {
                self.viewer()?.open(self.shown());
                Ok(())
            }
            Request::Interact => {
                let viewer = self.viewer()?;
                viewer.open(self.shown());
                viewer.interact();
                Ok(())
            }
            Request::InsideOutside(point) => self.inside_outside(*point),
            Request::Intersect(ray) => {
                let (compiled, camera) = (self.compile()?, self.session().scene().camera);
                let text = match ray {
                    None => tell_camera_ray(&compiled, &camera, false),
                    Some((_, direction)) if *direction == DVec3::ZERO => {
                        let fault = Fault::new("no-direction", "the direction 0 0 0 leads nowhere");
                        return Err(fault.help("the last three numbers are the direction, such as 0 0 -1"));
                    }
                    Some((origin, direction)) => {
                        let ray = Ray::new(*origin, *direction);
                        format!("the ray {}", tell_hit(&compiled, compiled.intersect(&ray, None).as_ref()))
                    }
                };
                self.print(&text);
                Ok(())
            }
        }
    }

    /// What is selected, for a command that needs something to work on.
    fn root(&self) -> Result<&str, Fault> {
        self.session().selected().ok_or_else(|| {
            Fault::new("selection", "nothing is selected")
                .help("'primitive NAME' or 'object NAME' selects what is to be in the picture")
        })
    }

    fn compile(&self) -> Result<CompiledScene, Fault> {
        let scene = self.session().scene();
        Ok(CompiledScene::compile(scene, Some(self.root()?), scene.depth))
    }

    /// Reads a file, and takes all of it or nothing. What would take the place of unsaved work waits for the person's word.
    fn source(&mut self, file: Option<&str>, is_forced: bool, line: &str) -> Result<(), Fault> {
        let typed = file.map_or_else(|| self.folders.quicksave_to_load(), |file| self.folders.expand(file));
        let path = with_scene_ending_if_there(typed);
        files::check_plain(&path).map_err(|error| missing(&error, file))?;
        let loaded = load_into(&path, self.session().settings, &self.interrupt)
            .map_err(|error| missing(&error, file))?;
        for diagnostic in loaded.diagnostics.iter().take(MOST_TOLD) {
            self.complain(diagnostic);
        }
        if let Some(more) = loaded.diagnostics.len().checked_sub(MOST_TOLD).filter(|more| *more > 0) {
            self.say(Said::Complaint(format!("... and {more} more; 'superegg check' tells them all")));
        }
        if loaded.is_interrupted {
            return Err(Fault::new("interrupted", "the load was broken off; the scene is as it was")
                .help("load it again, and let it end"));
        }
        let errors = counted(loaded.error_count(), "error");
        if loaded.has_errors() && !is_forced {
            let message = format!("'{}' has {errors}; the scene is as it was", path.display());
            let name = file.map_or_else(String::new, |file| format!(" {}", quoted(file)));
            return Err(
                Fault::new("not-loaded", message).help(format!("'load!{name}' takes what is good in it"))
            );
        }
        if loaded.has_errors() {
            self.print(&format!("{}: loaded but for {errors}; 'undo' brings back what was", path.display()));
        }
        let pending = Pending::Load { loaded: Box::new(loaded), path, label: line.trim().to_owned() };
        if self.has_person() && !is_forced && self.timeline.has_unsaved_changes() {
            self.pending = Some(pending);
        } else {
            self.finish(pending);
        }
        Ok(())
    }

    /// Takes what was read, or what was found, in place of the scene.
    pub(super) fn finish(&mut self, pending: Pending) {
        match pending {
            Pending::Leave => {}
            Pending::Load { loaded, path, label } => {
                let Loaded { session, lines, prints, .. } = *loaded;
                prints.iter().for_each(|text| self.print(text));
                self.timeline.replace(session, &label, &lines);
                self.timeline.mark_saved();
                self.write_down(Record::Scene { label: &label, lines: &lines });
                self.write_down(Record::Saved);
                self.known.remember(&path);
                if self.has_person() {
                    let scene = self.session().scene();
                    let text = format!(
                        "{}: {}, {}",
                        path.display(),
                        counted(scene.primitives().count(), "primitive"),
                        counted(scene.objects().count(), "object")
                    );
                    self.print(&text);
                }
                self.scene_file = Some(path);
            }
            Pending::Recover(left) => self.restore(left),
        }
    }

    fn save(&mut self, file: Option<&str>, is_forced: bool, as_history: bool) -> Result<(), Fault> {
        let path = match file {
            Some(file) => with_scene_ending(self.folders.expand(file)),
            None => self.quicksave()?,
        };
        let is_stream = files::is_standard_stream(&path);
        if !is_stream {
            files::check_no_pipe(&path).map_err(|error| unwritable(&error))?;
            if !is_forced {
                let option = if as_history { "--history " } else { "" };
                self.known.check_overwrite(&path).map_err(|why| {
                    let name = quoted(&path.display().to_string());
                    Fault::new("not-ours", why).help(format!("'save! {option}{name}' overwrites it"))
                })?;
            }
        }
        let text = if as_history { self.timeline.typed_lines() } else { write_session(self.session()) };
        files::write(&path, text.as_bytes()).map_err(|error| unwritable(&error))?;
        if is_stream || !path.is_file() {
            return Ok(());
        }
        self.known.remember(&path);
        self.timeline.mark_saved();
        self.write_down(Record::Saved);
        if self.has_person() {
            self.print(&format!("saved as {}", path.display()));
        }
        self.scene_file = Some(path);
        Ok(())
    }

    /// The quicksave, with its folder made.
    fn quicksave(&self) -> Result<PathBuf, Fault> {
        let path = self.folders.quicksave().ok_or_else(|| {
            Fault::new("unwritable", "the system tells of no folder for the quicksave")
                .help("name a file: save NAME.scn")
        })?;
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|error| {
            unwritable(&anyhow::Error::from(error).context(format!("cannot make '{}'", folder.display())))
        })?;
        Ok(path)
    }

    fn recover(&mut self, what: Recovery) -> Result<(), Fault> {
        let mut left = self.left_behind();
        if left.is_empty() {
            return Err(Fault::new("nothing-left", "there is no session to recover")
                .help("every session that ended was saved, or has been recovered")
                .warning());
        }
        let number = match what {
            Recovery::Restore(number) | Recovery::Discard(Some(number)) => number as usize,
            Recovery::List | Recovery::Discard(None) => 1,
        };
        if number > left.len() {
            let message = format!("there {} to recover", plural_sessions(left.len()));
            return Err(
                Fault::new("out-of-range", message).help("'recover list' tells of each with its number")
            );
        }
        match what {
            Recovery::List => {
                let told =
                    |(i, left): (usize, &LeftBehind)| format!("{:>3}  {}", i + 1, tell_left_behind(left));
                let text = left.iter().enumerate().map(told).collect::<Vec<_>>().join("\n");
                self.print(&text);
            }
            Recovery::Discard(only) => {
                let gone = if only.is_some() { vec![left.swap_remove(number - 1)] } else { left };
                self.print(&format!("forgotten: {}", counted(gone.len(), "session")));
                gone.into_iter().for_each(LeftBehind::remove);
            }
            Recovery::Restore(_) => {
                let pending = Pending::Recover(left.swap_remove(number - 1));
                if self.has_person() && self.timeline.has_unsaved_changes() {
                    self.pending = Some(pending);
                } else {
                    self.finish(pending);
                }
            }
        }
        Ok(())
    }

    fn restore(&mut self, left: LeftBehind) {
        let recovered = replay(&left.text);
        if self.timeline.undo_count() == 0 && self.journal.is_empty() {
            let settings = self.session().settings;
            self.timeline = recovered;
            self.timeline.set_settings(settings);
            if let Some(trouble) = self.journal.take_over(whole_records(&left.text)) {
                self.say(Said::Complaint(format!("superegg: {trouble}")));
            }
        } else {
            let lines = recovered.typed_lines();
            let mut session = recovered.session().clone();
            session.settings = self.session().settings;
            self.timeline.replace(session, "recover", &lines);
            self.write_down(Record::Scene { label: "recover", lines: &lines });
        }
        let told = tell_left_behind(&left);
        // It stays until this journal has all of it.
        if self.journal.is_written() {
            left.remove();
        }
        self.print(&format!("recovered: {told}"));
    }

    fn show(&mut self, names: &[String], line: &str) -> Result<(), Fault> {
        let selected = [self.root().unwrap_or_default().to_owned()];
        if names.is_empty() && selected[0].is_empty() {
            self.root()?;
        }
        let names = if names.is_empty() { &selected[..] } else { names };
        let mut texts = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let session = self.session();
            let details = session
                .describe(std::slice::from_ref(name))
                .map_err(|fault| place_at_argument(fault, line, i + 1))?;
            let meant: Vec<&str> = match (session.scene().get(name), name.to_ascii_lowercase().as_str()) {
                (Some(_), _) => vec![name],
                (None, "all") => session.scene().entities().map(|(name, _)| name).collect(),
                (None, _) => session.selected().into_iter().collect(),
            };
            texts.push(details);
            texts.extend(meant.iter().map(|name| tree::show(session, name)));
        }
        self.print(&texts.join("\n"));
        Ok(())
    }

    fn change_folder(&mut self, folder: Option<&str>) -> Result<(), Fault> {
        let path = match (folder, &self.folders.home) {
            (Some(folder), _) => self.folders.expand(folder),
            (None, Some(home)) => home.clone(),
            (None, None) => {
                return Err(
                    Fault::new("unreadable", "the system tells of no home folder").help("name a folder")
                );
            }
        };
        std::env::set_current_dir(&path).map_err(|error| {
            unreadable(&anyhow::Error::from(error).context(format!("cannot go to '{}'", path.display())))
        })?;
        // A name that was relative to the old folder would mean another file now.
        self.scene_file = self.scene_file.take().and_then(|file| file.file_name().map(PathBuf::from));
        Ok(())
    }

    fn list_folder(&mut self, folder: Option<&str>) -> Result<(), Fault> {
        let path = folder.map_or_else(|| PathBuf::from("."), |folder| self.folders.expand(folder));
        let entries = std::fs::read_dir(&path).map_err(|error| {
            unreadable(&anyhow::Error::from(error).context(format!("cannot list '{}'", path.display())))
        })?;
        let mut names: Vec<(bool, String)> = entries
            .flatten()
            .map(|entry| (entry.path().is_dir(), entry.file_name().to_string_lossy().into_owned()))
            .filter(|(_, name)| !name.starts_with('.'))
            .collect();
        names.sort_by(|a, b| (!a.0, &a.1).cmp(&(!b.0, &b.1)));
        let lines: Vec<String> =
            names.into_iter().map(|(is_folder, name)| if is_folder { name + "/" } else { name }).collect();
        self.print(&if lines.is_empty() { "the folder is empty".to_owned() } else { lines.join("\n") });
        Ok(())
    }

    fn stop_render(&mut self) -> Result<(), Fault> {
        if self.stop_renders() {
            return Ok(());
        }
        let fault = Fault::new("nothing-left", "nothing is being rendered");
        Err(fault.help("'render' begins a picture; 'stop' alone leaves").warning())
    }

    fn render(&mut self, file: Option<&str>, size: Option<(u32, u32)>) -> Result<(), Fault> {
        let root = self.root()?.to_owned();
        let path = match file {
            Some(file) => picture_place(self.folders.expand(file))?,
            None => {
                let stem = self.scene_file.as_deref().and_then(Path::file_stem).unwrap_or("scene".as_ref());
                let mut name = stem.to_owned();
                name.push(".png");
                picture_place(PathBuf::from(name))?
            }
        };
        files::check_no_pipe(&path)
            .and_then(|()| files::check_writable_place(Some(&path), Path::new("")))
            .map_err(|error| unwritable(&error))?;
        files::check_can_be_made(&path).map_err(|error| unwritable(&error))?;
        self.warn_of_pointless_picture(&root);
        let session = self.session();
        let scene = session.scene().clone();
        let picture = scene.picture;
        let job = Job {
            root,
            name: path.display().to_string(),
            path: std::path::absolute(&path).unwrap_or(path),
            size: size.unwrap_or((picture.width, picture.height)),
            threads: session.settings.threads as usize,
            scene,
        };
        let before = self.renders.push(job);
        if before > 0 {
            self.print(&match before {
                1 => "it begins when the picture before it is done".to_owned(),
                _ => format!("it begins when the {before} pictures before it are done"),
            });
        }
        Ok(())
    }

    /// Tells what makes a picture empty or odd before it is made.
    fn warn_of_pointless_picture(&mut self, root: &str) {
        let scene = self.session().scene();
        let is_empty = scene.object(root).is_ok_and(|object| object.children().len() == 0);
        let looks_along_up = scene.camera.looks_along_up();
        if is_empty {
            self.print(&format!("warning: '{root}' has no children, so there is nothing to see in it"));
        }
        if looks_along_up {
            self.print("warning: the camera looks along its up direction; 'cameraUp x y z' gives another");
        }
    }

    fn preview(&mut self, frame: Option<f64>) -> Result<(), Fault> {
        let root = self.root()?.to_owned();
        self.warn_of_pointless_picture(&root);
        let session = self.session();
        let canvas = Canvas::choose(session.settings.preview);
        let scene = match frame {
            Some(frame) => &scene_at(session, frame)?,
            None => session.scene(),
        };
        let compiled = CompiledScene::compile(scene, Some(&root), scene.depth);
        let (columns, rows) = terminal_size::terminal_size()
            .map_or((80, 24), |(width, height)| (u32::from(width.0), u32::from(height.0)));
        let shape = (scene.picture.width, scene.picture.height);
        let (width, height) = canvas.size_px(shape, columns.max(1), rows.saturating_sub(2).max(1));
        let picture = Picture {
            width,
            height,
            samples: scene.picture.samples.min(4),
            // For a screen, and soon.
            noise: 0.0,
            encoding: Encoding::Srgb,
            bits: 8,
            transparent: false,
            ..scene.picture
        };
        let settings = RenderSettings::of(scene).with_picture(picture).with_layers(false);
        let development = Development::of(&picture);
        let threads = match session.settings.threads {
            0 => available_threads(),
            threads => threads as usize,
        };
        for concern in concerns(&compiled, &settings) {
            self.print(&format!("warning: {concern}"));
        }
        let options = RenderOptions::default().with_threads(threads).with_cancel(&self.interrupt);
        let trouble = |error: &dyn std::fmt::Display| {
            Fault::new("preview", format!("the preview cannot be drawn: {error}"))
                .help("'render' writes a picture")
        };
        let rendered = render(&compiled, &settings, &options).map_err(|error| trouble(&error))?;
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(Fault::new("interrupted", "the preview was broken off").warning());
        }
        let text = canvas.draw(&rendered.film, &development).map_err(|error| trouble(&error))?;
        self.print_raw(&text);
        Ok(())
    }

    fn inside_outside(&mut self, point: Option<DVec3>) -> Result<(), Fault> {
        let compiled = self.compile()?;
        let Some(point) = point else { return self.count_grid(&compiled) };
        let Some(answer) = compiled.query_point_unless(point, &self.interrupt) else {
            return Err(broken_off());
        };
        let verdict = match answer.least {
            _ if answer.inside => "inside",
            Some((0.0, _)) => "on the surface",
            _ => "outside",
        };
        let text = match answer.least {
            None => format!("{verdict}: the point is in no shape's box"),
            Some((value, path)) => {
                format!(
                    "{verdict}: the function is {} for {}",
                    format_number(value),
                    compiled.path_name(&path)
                )
            }
        };
        self.print(&text);
        Ok(())
    }

    fn count_grid(&mut self, compiled: &CompiledScene) -> Result<(), Fault> {
        let view = self.session().settings.view;
        let grid = Grid::new(view.io_step, view.io_half).map_err(|error| {
            Fault::new("out-of-range", error.to_string()).help("for example: set ioStep 0.5")
        })?;
        let (mut inside, mut count) = (0u64, 0u64);
        for point in grid.points() {
            let is_inside = compiled.contains_point_unless(point, &self.interrupt).ok_or_else(broken_off)?;
            inside += u64::from(is_inside);
            count += 1;
        }
        self.print(&format!(
            "{} from {half} to {} in steps of {}: {inside} inside, {} outside",
            counted(count, "point"),
            format_number(view.io_half),
            format_number(view.io_step),
            count - inside,
            half = format_number(-view.io_half),
        ));
        Ok(())
    }
}

/// "is 1 session", "are 2 sessions".
fn plural_sessions(count: usize) -> String {
    let verb = if count == 1 { "is" } else { "are" };
    format!("{verb} {}", counted(count, "session"))
}

/// When a session was left, how much of it there is, and how it ended.
pub(super) fn tell_left_behind(left: &LeftBehind) -> String {
    let ago =
        left.modified.and_then(|at| SystemTime::now().duration_since(at).ok()).map_or(0, |ago| ago.as_secs());
    let when = match ago {
        0..60 => "just now".to_owned(),
        60..3600 => format!("{} min ago", ago / 60),
        3600..86_400 => format!("{} h ago", ago / 3600),
        _ => format!("{} days ago", ago / 86_400),
    };
    let last = left.last_change().map(|line| format!(", the last: {line}")).unwrap_or_default();
    format!("{}, {when}{last}", counted(left.change_count(), "change"))
}

/// The session that a journal tells of.
fn replay(text: &str) -> Timeline {
    let mut timeline = Timeline::default();
    for record in read_records(text).unwrap_or_default() {
        match record {
            Record::Line(line) => {
                // It went well the first time.
                let _ = timeline.run_line(line);
            }
            Record::Scene { label, lines } => {
                let (session, _) = superegg_lang::load_text(label, lines);
                timeline.replace(session, label, lines);
            }
            Record::Saved => timeline.mark_saved(),
        }
    }
    timeline
}

/// A journal without what was cut off at its end.
fn whole_records(text: &str) -> &str {
    text.rfind('\n').map_or("", |end| &text[..=end])
}

fn broken_off() -> Fault {
    Fault::new("interrupted", "the test was broken off")
        .help("'setDepth' opens a fractal less deep")
        .warning()
}

fn unreadable(error: &anyhow::Error) -> Fault {
    Fault::new("unreadable", format!("{error:#}")).help("'dir' lists the working folder, 'cd' changes it")
}

fn unwritable(error: &anyhow::Error) -> Fault {
    Fault::new("unwritable", format!("{error:#}")).help("name a file in a folder that can be written to")
}

fn missing(error: &anyhow::Error, file: Option<&str>) -> Fault {
    let is_absent = error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == std::io::ErrorKind::NotFound);
    let fault = Fault::new("unreadable", format!("{error:#}"));
    fault.help(match file {
        None => "there is no quicksave yet: 'save' makes one, 'load FILE' loads a file",
        Some(_) if is_absent => "'dir' lists the working folder, 'pwd' tells which it is",
        Some(_) => "name a scene file, a text of commands, that you may read",
    })
}

/// A file name as it can be typed.
fn quoted(file: &str) -> String {
    if file.contains(|c: char| c.is_whitespace() || c == '#') {
        format!("\"{file}\"")
    } else {
        file.to_owned()
    }
}

/// Adds .scn to a name without an ending, but for what is there already and is no plain file.
fn with_scene_ending(path: PathBuf) -> PathBuf {
    let is_special = files::is_standard_stream(&path) || (path.exists() && !path.is_file());
    if path.extension().is_some() || is_special { path } else { path.with_extension("scn") }
}

/// The file of this name, or with .scn where only that is there.
fn with_scene_ending_if_there(path: PathBuf) -> PathBuf {
    let mut longer = path.clone().into_os_string();
    longer.push(".scn");
    let longer = PathBuf::from(longer);
    if !path.exists() && longer.is_file() { longer } else { path }
}

/// The place of a picture: of a format that there is, and not in the place of anything else.
fn picture_place(path: PathBuf) -> Result<PathBuf, Fault> {
    let path = if path.extension().is_none() && !path.is_dir() { path.with_extension("png") } else { path };
    let format = PictureFormat::of(&path).ok().filter(|_| path.extension().is_some()).ok_or_else(|| {
        let message = format!("'{}' is no name for a picture", path.display());
        Fault::new("not-a-picture", message).help(format!("names end in {}", PictureFormat::ENDINGS))
    })?;
    let is_other = path.is_file()
        && path.metadata().is_ok_and(|m| m.len() > 0)
        && !files::begins_with(&path, format.mark());
    if is_other {
        let message = format!("'{}' is there already and is no picture", path.display());
        return Err(Fault::new("not-a-picture", message).help("take another name"));
    }
    Ok(path)
}
