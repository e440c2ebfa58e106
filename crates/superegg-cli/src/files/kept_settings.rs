//! The settings that are kept between sessions: a file of `set` commands.

use std::path::PathBuf;

use anyhow::{Context, Result};
use superegg_lang::Session;
use superegg_scene::{Theme, ViewSettings};

use crate::files;

/// The kept settings and their file.
#[derive(Debug, Default)]
pub(crate) struct KeptSettings {
    /// `None` where the system has no folder for settings.
    path: Option<PathBuf>,
    current: Kept,
}

/// The values that are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Kept {
    /// Whether the viewer begins as the course program does.
    pub(crate) is_course: bool,
    pub(crate) theme: Theme,
}

impl Kept {
    pub(crate) fn of(view: &ViewSettings) -> Self {
        Self { is_course: view.course, theme: view.theme }
    }

    /// The `set` commands of the file.
    fn lines(self) -> String {
        let course = if self.is_course { "on" } else { "off" };
        let theme = match self.theme {
            Theme::System => "system",
            Theme::Light => "light",
            Theme::Dark => "dark",
        };
        format!("# superegg settings\nset course {course}\nset theme {theme}\n")
    }
}

impl KeptSettings {
    /// Reads the file. A setting that it lacks, or sets wrongly, has its default.
    pub(crate) fn read(path: Option<PathBuf>) -> Self {
        let text = path.as_ref().and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default();
        let mut session = Session::default();
        for line in text.lines() {
            // A file of another version may have settings that are unknown here.
            let _ = session.run_line(line);
        }
        Self { path, current: Kept::of(&session.settings.view) }
    }

    /// The values as they are kept.
    pub(crate) fn current(&self) -> Kept {
        self.current
    }

    /// Takes values as the current ones without keeping them, such as those of options.
    pub(crate) fn set_current(&mut self, current: Kept) {
        self.current = current;
    }

    /// Keeps the values if one has changed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn keep(&mut self, current: Kept) -> Result<()> {
        if self.current == current {
            return Ok(());
        }
        self.current = current;
        let path = self.path.as_ref().context("the system has no folder for settings")?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make the folder '{}'", folder.display()))?;
        }
        files::write(path, current.lines().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_kept_and_the_value_of_an_option_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config").join("settings.scn");
        let read = || KeptSettings::read(Some(path.clone()));
        let (plain, course) = (Kept::default(), Kept { is_course: true, theme: Theme::Light });
        assert_eq!(read().current(), plain);
        let mut kept = read();
        kept.set_current(course);
        kept.keep(course).unwrap();
        assert!(!path.exists());
        kept.keep(plain).unwrap();
        assert_eq!(read().current(), plain);
        for theme in [Theme::System, Theme::Light, Theme::Dark] {
            let current = Kept { theme, ..course };
            kept.keep(current).unwrap();
            assert_eq!(read().current(), current);
        }
        std::fs::write(&path, "set unknown 1\nset course on\n\u{0}").unwrap();
        assert!(read().current().is_course);
        assert!(KeptSettings::default().keep(course).is_err());
    }
}
