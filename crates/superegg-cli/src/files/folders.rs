//! The folders for a user's files, by the rules of the operating system (XDG on Linux).

use std::path::{Path, PathBuf};

use directories::{BaseDirs, ProjectDirs};

/// The folders of one user; `None` where the system has no home folder.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folders {
    pub(crate) home: Option<PathBuf>,
    /// For the state of the program: history and journals.
    pub(crate) state: Option<PathBuf>,
    /// For the data of the user: the quicksave.
    pub(crate) data: Option<PathBuf>,
    /// For settings.
    pub(crate) config: Option<PathBuf>,
}

impl Folders {
    /// The folders of the current user.
    pub(crate) fn of_user() -> Self {
        let project = ProjectDirs::from("", "", "superegg");
        let state = |dirs: &ProjectDirs| dirs.state_dir().unwrap_or(dirs.data_local_dir()).to_owned();
        Self {
            home: BaseDirs::new().map(|dirs| dirs.home_dir().to_owned()),
            state: project.as_ref().map(state),
            data: project.as_ref().map(|dirs| dirs.data_dir().to_owned()),
            config: project.as_ref().map(|dirs| dirs.config_dir().to_owned()),
        }
    }

    /// The folder of the session journals.
    pub(crate) fn journals(&self) -> Option<PathBuf> {
        self.state.as_ref().map(|state| state.join("journals"))
    }

    /// The file of the settings that are kept between sessions.
    pub(crate) fn settings(&self) -> Option<PathBuf> {
        self.config.as_ref().map(|config| config.join("settings.scn"))
    }

    /// The list of the scene files of earlier sessions.
    pub(crate) fn recent(&self) -> Option<PathBuf> {
        self.state.as_ref().map(|state| state.join("recent"))
    }

    /// The file that `save` writes by default.
    pub(crate) fn quicksave(&self) -> Option<PathBuf> {
        self.data.as_ref().map(|data| data.join("quicksave.scn"))
    }

    /// The file that `load` reads by default: the quicksave, or the quicksave of the course program
    /// in the working folder if that is newer or the only one.
    pub(crate) fn quicksave_to_load(&self) -> PathBuf {
        let old = Path::new("data").join("quicksave.scn");
        let modified = |path: &Path| path.metadata().and_then(|metadata| metadata.modified()).ok();
        match self.quicksave() {
            Some(own) if modified(&own) >= modified(&old) => own,
            _ => old,
        }
    }

    /// Expands `~` at the beginning of a typed path to the home folder.
    pub(crate) fn expand(&self, typed: &str) -> PathBuf {
        match (typed.strip_prefix('~'), &self.home) {
            (Some(""), Some(home)) => home.clone(),
            (Some(rest), Some(home)) if rest.starts_with('/') => home.join(&rest[1..]),
            _ => PathBuf::from(typed),
        }
    }
}
