//! Series of data: the frames of one file, or files numbered by step.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use superegg_exchange::coloring::{ColorKey, Coloring};
use superegg_exchange::read::Format;
use superegg_geom::Aabb;
use superegg_lang::Session;
use superegg_scene::Scene;

use crate::annotate::Legend;
use crate::files::binary_scene::open_input;
use crate::files::data::{self, DataOptions, FileKind, LoadedData};

/// Frames of data that are shown one after the other, with one camera and one range of colours.
pub(crate) struct Series {
    /// The file and the frame in it.
    frames: Vec<(PathBuf, usize)>,
    options: DataOptions,
    /// A scene with the camera, the light and the background of all frames.
    view: Scene,
    /// The legend of all frames.
    pub(crate) legend: Option<Legend>,
    /// The name of the object that holds the particles of each frame.
    pub(crate) root: String,
}

impl Series {
    /// The series that a file is, or that its siblings with other numbers are; `None` if it is no
    /// data or has one frame only.
    ///
    /// # Errors
    /// A file cannot be read.
    pub(crate) fn of(path: &Path, options: &DataOptions) -> Result<Option<Self>> {
        if !path.is_file() {
            return Ok(None);
        }
        let mut input = open_input(path)?;
        if data::kind_of(&mut *input, options)? != FileKind::Data {
            return Ok(None);
        }
        let source = data::open_source(input, &options.read)
            .with_context(|| format!("cannot read '{}'", path.display()))?;
        // A scene has a camera and lights of its own, and keys if it moves.
        if matches!(source.format(), Format::CourseYaml | Format::Povray) {
            return Ok(None);
        }
        let in_file = source.frames().len();
        let frames: Vec<(PathBuf, usize)> = if in_file > 1 {
            (0..in_file).map(|frame| (path.to_owned(), frame)).collect()
        } else {
            siblings(path).into_iter().map(|file| (file, 0)).collect()
        };
        if frames.len() < 2 {
            return Ok(None);
        }
        let mut series = Self {
            frames,
            options: options.clone(),
            view: Scene::default(),
            legend: None,
            root: data::scene_name(path),
        };
        series.frame_all()?;
        Ok(Some(series))
    }

    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    /// Sets the camera and the range of colours from the first, the middle and the last frame.
    fn frame_all(&mut self) -> Result<()> {
        let mut bounds = Aabb::EMPTY;
        let mut key = ColorKey::None;
        for frame in [0, self.len() / 2, self.len() - 1] {
            let loaded = self.load(frame)?;
            bounds = bounds.union(&loaded.bounds);
            key = key.union(loaded.key);
        }
        if let (Coloring::ByColumn(by), ColorKey::Range(range)) = (&mut self.options.coloring, &key) {
            by.range = Some(*range);
        }
        self.legend = Legend::of(&self.options.coloring, &key);
        data::frame(&mut self.view, &bounds, &self.options);
        Ok(())
    }

    fn load(&self, index: usize) -> Result<LoadedData> {
        let (path, frame) = &self.frames[index];
        let mut input = open_input(path)?;
        let options = DataOptions { frame: Some(*frame), ..self.options.clone() };
        data::load_named(path, &self.root, &mut *input, &options)
    }

    /// The scene of a frame.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn scene(&self, index: usize) -> Result<Scene> {
        Ok(self.seen(&self.load(index)?.session).scene().clone())
    }

    /// A session with the camera, the light and the background of all frames. A frame without
    /// particles has none of its own.
    pub(crate) fn seen(&self, session: &Session) -> Session {
        let mut scene = session.scene().clone();
        scene.set_up(self.view.up());
        scene.background = self.view.background;
        let root = session.selected().map(str::to_owned);
        Session::with_scene(scene, root.as_deref()).with_view_of(&self.view)
    }

    /// The index of a frame of a file.
    pub(crate) fn index_of(&self, path: &Path, frame: usize) -> Option<usize> {
        self.frames.iter().position(|(file, held)| file.file_name() == path.file_name() && *held == frame)
    }
}

/// The files of the same folder whose names differ in the last number only, in the order of that
/// number; the file itself if its name has none.
fn siblings(path: &Path) -> Vec<PathBuf> {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let Some((before, _, after)) = split_number(name) else { return vec![path.to_owned()] };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut found: Vec<(u64, PathBuf)> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            let held = entry.file_name().to_str()?.to_owned();
            let (start, number, end) = split_number(&held)?;
            (start == before && end == after).then(|| (number, folder.join(&held)))
        })
        .collect();
    found.sort();
    found.into_iter().map(|(_, file)| file).collect()
}

/// A name as the text before its last number, that number, and the text after it. The number is
/// before the extension.
fn split_number(name: &str) -> Option<(&str, u64, &str)> {
    let stem = name.find('.').unwrap_or(name.len());
    let end = name[..stem].rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = name[..end]
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |at| at + name[at..].chars().next().map_or(1, char::len_utf8));
    Some((&name[..start], name[start..end].parse().ok()?, &name[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_number_before_the_extension_is_the_step() {
        assert_eq!(split_number("known_100.vtp"), Some(("known_", 100, ".vtp")));
        assert_eq!(split_number("run2_0007_a.vtk"), Some(("run2_", 7, "_a.vtk")));
        assert_eq!(split_number("é12.dump"), Some(("é", 12, ".dump")));
        assert_eq!(split_number("dump.liggghts2"), None);
        assert_eq!(split_number("99999999999999999999999.x"), None);
    }
}
