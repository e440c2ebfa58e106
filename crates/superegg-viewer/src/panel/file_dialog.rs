//! The choice of a file: folders and files of one folder, and a field for the name.

use std::path::{Path, PathBuf};

use egui::{Key, Modal, RichText, ScrollArea, TextEdit, Ui};

/// The purpose of a chosen file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    Open,
    Import,
    Save,
    Export,
    Render,
}

/// The result of a dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Chosen {
    File(PathBuf),
    Cancelled,
}

/// An entry of a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Entry {
    name: String,
    is_folder: bool,
}

/// A dialog.
#[derive(Debug)]
pub(crate) struct FileDialog {
    kind: FileKind,
    folder: PathBuf,
    /// The entries of the folder, or why it cannot be listed.
    entries: Result<Vec<Entry>, String>,
    /// The typed or clicked name.
    name: String,
    /// Files of every kind are listed, and not scenes alone.
    lists_all: bool,
    /// A file that is there, whose replacement is asked about.
    replaces: Option<PathBuf>,
    /// The name has not had the keyboard yet.
    is_new: bool,
}

/// Most entries of a folder that are listed.
const MOST_ENTRIES: usize = 2000;
/// Most recent files that are listed.
const MOST_RECENT: usize = 5;
const SCENE_ENDINGS: [&str; 2] = ["scn", "sqb"];

impl FileKind {
    fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a scene, or data of another program",
            Self::Import => "Import a scene into this one",
            Self::Save => "Save the scene",
            Self::Export => "Export for another program",
            Self::Render => "Render to a picture",
        }
    }

    fn button(self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::Import => "Import",
            Self::Save => "Save",
            Self::Export => "Export",
            Self::Render => "Render",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Save => "name.scn, or name.sqb for the binary form",
            Self::Export => "name.glb, .obj, .ply, .stl, .pov, .vtp, .csv, .vti ...",
            Self::Render => "name.png, or name.exr for linear light with depth, normals, albedo and ids",
            Self::Open | Self::Import => "name",
        }
    }

    fn writes(self) -> bool {
        matches!(self, Self::Save | Self::Export | Self::Render)
    }
}

impl FileDialog {
    /// A dialog in the folder of the session's file, else in the working folder.
    pub(crate) fn new(kind: FileKind, file: Option<&Path>) -> Self {
        let folder = file.and_then(Path::parent).filter(|parent| parent.is_dir());
        let folder = folder.map_or_else(std::env::current_dir, std::path::absolute).unwrap_or_default();
        let picture = file.map(|file| file.with_extension("png"));
        let name = match kind {
            FileKind::Save => file.and_then(Path::file_name),
            FileKind::Render => picture.as_deref().and_then(Path::file_name),
            FileKind::Open | FileKind::Import | FileKind::Export => None,
        };
        let mut dialog = Self {
            kind,
            folder: PathBuf::new(),
            entries: Ok(Vec::new()),
            name: name.unwrap_or_default().to_string_lossy().into_owned(),
            lists_all: kind != FileKind::Save,
            replaces: None,
            is_new: true,
        };
        dialog.go_to(folder);
        dialog
    }

    pub(crate) fn kind(&self) -> FileKind {
        self.kind
    }

    fn go_to(&mut self, folder: PathBuf) {
        self.entries = entries(&folder);
        self.folder = folder;
        self.replaces = None;
    }

    /// Takes the name: goes to a folder, or chooses a file. `None` while there is no result.
    fn accept(&mut self) -> Option<Chosen> {
        let typed = self.name.trim();
        if typed.is_empty() {
            return None;
        }
        let mut path = self.folder.join(typed);
        if path.is_dir() {
            self.name.clear();
            self.go_to(path.canonicalize().unwrap_or(path));
            return None;
        }
        if self.kind == FileKind::Save && path.extension().is_none() {
            path.set_extension(SCENE_ENDINGS[0]);
        }
        if self.kind == FileKind::Render && path.extension().is_none() {
            path.set_extension("png");
        }
        if self.kind.writes() && path.exists() && self.replaces.as_ref() != Some(&path) {
            self.replaces = Some(path);
            return None;
        }
        Some(Chosen::File(path))
    }

    /// Draws the dialog. `None` while there is no result.
    pub(crate) fn show(&mut self, ui: &Ui, recent: &[PathBuf], is_escaped: bool) -> Option<Chosen> {
        let mut chosen = None;
        let room = ui.ctx().content_rect().size();
        let modal = Modal::new(egui::Id::unique("file dialog")).show(ui.ctx(), |ui| {
            ui.set_width((room.x - 60.0).clamp(200.0, 560.0));
            ui.heading(self.kind.title());
            self.folder_row(ui);
            let list_height = (room.y - 240.0).clamp(60.0, 320.0);
            chosen = self.list(ui, list_height);
            if self.kind == FileKind::Open {
                chosen = chosen.take().or(recent_files(ui, recent));
            }
            ui.separator();
            let is_entered = self.name_row(ui);
            if let Some(path) = &self.replaces {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let text = format!("'{name}' is there already.");
                ui.label(RichText::new(text).color(ui.visuals().warn_fg_color));
            }
            ui.horizontal(|ui| {
                let text = if self.replaces.is_some() { "Replace" } else { self.kind.button() };
                if ui.button(text).clicked() || is_entered {
                    chosen = chosen.take().or(self.accept());
                }
                if ui.button("Cancel").clicked() {
                    chosen = Some(Chosen::Cancelled);
                }
                ui.checkbox(&mut self.lists_all, "all files");
            });
        });
        if is_escaped || modal.backdrop_response.clicked() {
            chosen = chosen.or(Some(Chosen::Cancelled));
        }
        chosen
    }

    fn folder_row(&mut self, ui: &mut Ui) {
        let mut next = None;
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("the folder above").clicked() {
                next = self.folder.parent().map(Path::to_owned);
            }
            if ui.button("Home").on_hover_text("your home folder").clicked() {
                next = std::env::home_dir();
            }
            ui.add(egui::Label::new(RichText::new(self.folder.display().to_string()).monospace()).truncate());
        });
        if let Some(folder) = next {
            self.go_to(folder);
        }
    }

    /// The entries. A click names one, a double click chooses it.
    fn list(&mut self, ui: &mut Ui, height: f32) -> Option<Chosen> {
        let (mut clicked, mut is_chosen) = (None, false);
        ScrollArea::vertical().id_salt("files").max_height(height).min_scrolled_height(height).show(
            ui,
            |ui| {
                ui.set_min_width(ui.available_width());
                let entries = match &self.entries {
                    Ok(entries) => entries,
                    Err(reason) => {
                        ui.label(RichText::new(reason).color(ui.visuals().warn_fg_color));
                        return;
                    }
                };
                for entry in entries.iter().filter(|entry| self.lists_all || entry.is_scene_or_folder()) {
                    let text = if entry.is_folder { format!("{}/", entry.name) } else { entry.name.clone() };
                    let response = ui.selectable_label(self.name == entry.name, text);
                    if response.clicked() {
                        clicked = Some(entry.clone());
                    }
                    is_chosen |= response.double_clicked();
                }
            },
        );
        if let Some(entry) = clicked {
            self.replaces = None;
            if entry.is_folder {
                self.go_to(self.folder.join(entry.name));
                return None;
            }
            self.name = entry.name;
        }
        if is_chosen { self.accept() } else { None }
    }

    /// The field of the name. Returns whether Enter was pressed in it.
    fn name_row(&mut self, ui: &mut Ui) -> bool {
        let field = TextEdit::singleline(&mut self.name).hint_text(self.kind.hint());
        let response = ui.add(field.desired_width(f32::INFINITY));
        if std::mem::take(&mut self.is_new) {
            response.request_focus();
        }
        if response.changed() {
            self.replaces = None;
        }
        let is_entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if is_entered {
            response.request_focus();
        }
        is_entered
    }
}

impl Entry {
    fn is_scene_or_folder(&self) -> bool {
        let ending = Path::new(&self.name).extension().and_then(|ending| ending.to_str());
        self.is_folder
            || ending
                .is_some_and(|ending| SCENE_ENDINGS.iter().any(|scene| scene.eq_ignore_ascii_case(ending)))
    }
}

fn recent_files(ui: &mut Ui, recent: &[PathBuf]) -> Option<Chosen> {
    let mut chosen = None;
    if !recent.is_empty() {
        ui.separator();
        ui.weak("recent files");
    }
    for path in recent.iter().take(MOST_RECENT) {
        if ui.selectable_label(false, path.display().to_string()).clicked() {
            chosen = Some(Chosen::File(path.clone()));
        }
    }
    chosen
}

/// The visible entries of a folder, folders first, or why it cannot be listed.
fn entries(folder: &Path) -> Result<Vec<Entry>, String> {
    let listed =
        std::fs::read_dir(folder).map_err(|error| format!("the folder cannot be listed: {error}"))?;
    let mut entries: Vec<Entry> = listed
        .flatten()
        .filter_map(|entry| {
            // A name that is not UTF-8 cannot be named in a line.
            let name = entry.file_name().into_string().ok()?;
            let is_folder = entry.path().is_dir();
            (!name.starts_with('.')).then_some(Entry { name, is_folder })
        })
        .collect();
    entries.sort_by_key(|entry| (!entry.is_folder, entry.name.to_lowercase()));
    entries.truncate(MOST_ENTRIES);
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_files_folders_and_replacements() {
        let folder = std::env::temp_dir().join(format!("superegg-dialog-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("sub")).unwrap();
        for name in ["b.scn", "A.SQB", "c.png", ".hidden"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        let folder = folder.canonicalize().unwrap();
        let dialog = |kind| FileDialog::new(kind, Some(&folder.join("b.scn")));
        let mut open = dialog(FileKind::Open);
        let names: Vec<String> = open.entries.clone().unwrap().into_iter().map(|entry| entry.name).collect();
        assert_eq!(names, ["sub", "A.SQB", "b.scn", "c.png"]);
        assert_eq!(open.accept(), None);
        "sub".clone_into(&mut open.name);
        assert_eq!(open.accept(), None);
        assert_eq!((&open.folder, open.name.as_str()), (&folder.join("sub"), ""));
        "../c.png".clone_into(&mut open.name);
        assert_eq!(open.accept(), Some(Chosen::File(folder.join("sub/../c.png"))));

        // The session's own name comes first, and a file that is there is asked about once.
        let mut save = dialog(FileKind::Save);
        assert_eq!((save.accept(), save.name.as_str(), save.replaces.is_some()), (None, "b.scn", true));
        assert_eq!(save.accept(), Some(Chosen::File(folder.join("b.scn"))));
        "new".clone_into(&mut save.name);
        assert_eq!(save.accept(), Some(Chosen::File(folder.join("new.scn"))));
        let listed = save.entries.clone().unwrap().iter().filter(|entry| entry.is_scene_or_folder()).count();
        assert_eq!((listed, save.lists_all), (3, false));
        save.go_to(folder.join("nothing"));
        assert!(save.entries.is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
