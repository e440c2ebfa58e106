//! The settings that are kept between sessions: a file of `set` commands.

use std::path::PathBuf;

use anyhow::{Context, Result};
use superegg_lang::Session;

use crate::files;

/// The kept settings and their file.
#[derive(Debug, Default)]
pub(crate) struct KeptSettings {
    /// `None` where the system has no folder for settings.
    path: Option<PathBuf>,
    is_course: bool,
}

impl KeptSettings {
    /// Reads the file. What it does not set, or sets wrongly, has its default.
    pub(crate) fn read(path: Option<PathBuf>) -> Self {
        let text = path.as_ref().and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default();
        let mut session = Session::default();
        for line in text.lines() {
            // A file of another version may have settings that are unknown here.
            let _ = session.run_line(line);
        }
        Self { path, is_course: session.settings.view.course }
    }

    /// Whether the viewer begins as the course program does.
    pub(crate) fn is_course(&self) -> bool {
        self.is_course
    }

    /// Takes a value as the current one without keeping it, such as that of an option.
    pub(crate) fn set_current(&mut self, is_course: bool) {
        self.is_course = is_course;
    }

    /// Keeps the value if it has changed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn keep(&mut self, is_course: bool) -> Result<()> {
        if self.is_course == is_course {
            return Ok(());
        }
        self.is_course = is_course;
        let path = self.path.as_ref().context("the system has no folder for settings")?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make the folder '{}'", folder.display()))?;
        }
        let word = if is_course { "on" } else { "off" };
        files::write(path, format!("# superegg settings\nset course {word}\n").as_bytes())
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
        assert!(!read().is_course());
        let mut kept = read();
        kept.set_current(true);
        kept.keep(true).unwrap();
        assert!(!path.exists());
        kept.keep(false).unwrap();
        assert!(!read().is_course());
        kept.keep(true).unwrap();
        assert!(read().is_course());
        std::fs::write(&path, "set unknown 1\nset course on\n\u{0}").unwrap();
        assert!(read().is_course());
        assert!(KeptSettings::default().keep(true).is_err());
    }
}
