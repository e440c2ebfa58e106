//! Where a user's files of the program go: by the rules of the system, and of XDG where those hold.

use std::path::{Path, PathBuf};

use directories::{BaseDirs, ProjectDirs};

/// The folders of one user; `None` where the system does not tell of a home.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folders {
    pub(crate) home: Option<PathBuf>,
    /// For what the program remembers: history and journals.
    pub(crate) state: Option<PathBuf>,
    /// For what the user keeps: the quicksave.
    pub(crate) data: Option<PathBuf>,
}

impl Folders {
    pub(crate) fn of_user() -> Self {
        let project = ProjectDirs::from("", "", "superegg");
        let state = |dirs: &ProjectDirs| dirs.state_dir().unwrap_or(dirs.data_local_dir()).to_owned();
        Self {
            home: BaseDirs::new().map(|dirs| dirs.home_dir().to_owned()),
            state: project.as_ref().map(state),
            data: project.as_ref().map(|dirs| dirs.data_dir().to_owned()),
        }
    }

    /// Where the journals of sessions are.
    pub(crate) fn journals(&self) -> Option<PathBuf> {
        self.state.as_ref().map(|state| state.join("journals"))
    }

    /// Where `save` goes without a file.
    pub(crate) fn quicksave(&self) -> Option<PathBuf> {
        self.data.as_ref().map(|data| data.join("quicksave.scn"))
    }

    /// What `load` takes without a file: the quicksave, or that of the course program in the working folder where it is newer or the only
    /// one.
    pub(crate) fn quicksave_to_load(&self) -> PathBuf {
        let old = Path::new("data").join("quicksave.scn");
        let modified = |path: &Path| path.metadata().and_then(|metadata| metadata.modified()).ok();
        match self.quicksave() {
            Some(own) if modified(&own) >= modified(&old) => own,
            _ => old,
        }
    }

    /// A file as typed, with `~` at its beginning as the home folder.
    pub(crate) fn expand(&self, typed: &str) -> PathBuf {
        match (typed.strip_prefix('~'), &self.home) {
            (Some(""), Some(home)) => home.clone(),
            (Some(rest), Some(home)) if rest.starts_with('/') => home.join(&rest[1..]),
            _ => PathBuf::from(typed),
        }
    }
}
