//! The names of files in scenes: where such a file is searched, and how it is named in another folder's scene.
//!
//! One rule holds for `load`, `include`, `environment` and `setTexture`: a name is searched in the working folder, and then
//! beside the file that has the line. Where a name as written is in neither folder, a `\` in it separates folders as `/` does,
//! so that scenes from Windows are read everywhere. Files that a scene loads or includes may lie in other folders; the names in
//! them are changed when they are read, so that one folder is enough to find everything.
//!
//! The names in the scene of a session are seen from the folder in which the session began. A name that is typed in another
//! working folder is changed to be one of them, so that it means the same file wherever `cd` leads.

use std::io;
use std::path::{Component, Path, PathBuf};

use superegg_lang::{Fault, FaultCode, Session, rename_files, rename_in_line};
use superegg_scene::Scene;

use crate::files::folders::Folders;

/// A file that a scene in `folder` names: in the working folder, else in `folder`.
pub(crate) fn found(name: &str, folder: Option<&Path>) -> PathBuf {
    found_in(&Folders::of_user().expand(name), folder.unwrap_or(Path::new("")))
}

/// As [`found`], for an expanded name.
pub(super) fn found_in(name: &Path, folder: &Path) -> PathBuf {
    // The prefix makes '-' a file, not standard input.
    existing(Path::new("."), name)
        .or_else(|| existing(folder, name))
        .unwrap_or_else(|| Path::new(".").join(name))
}

/// The path of a file in a folder, if it exists: of the name as written, else with `/` for each `\`.
fn existing(folder: &Path, name: &Path) -> Option<PathBuf> {
    let exists = |path: PathBuf| path.exists().then_some(path);
    exists(folder.join(name)).or_else(|| {
        let name = name.to_str().filter(|name| name.contains('\\'))?;
        exists(folder.join(name.replace('\\', "/")))
    })
}

/// A typed path, with `/` for each `\` if a file of that name exists and none of the typed one.
pub(crate) fn existing_or_typed(path: PathBuf) -> PathBuf {
    existing(Path::new(""), &path).unwrap_or(path)
}

/// The fault of a line that names a file which cannot be read.
pub(super) fn unreadable(error: &anyhow::Error) -> Fault {
    Fault::new(FaultCode::Unreadable, format!("{error:#}")).help(if is_not_found(error) {
        "correct the name, or put the file there: it is searched in the working folder, then beside this file"
    } else {
        "correct the file, or name another one"
    })
}

/// Whether a file is missing, and not wrong or protected.
pub(crate) fn is_not_found(error: &anyhow::Error) -> bool {
    let mut causes = error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>());
    causes.any(|cause| cause.kind() == io::ErrorKind::NotFound)
}

/// The folder of a file.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Gives the files of a scene in `folder` the names that they have in a scene in `top`: the path to one beneath `top` begins
/// there, any other path stays as it is. The working folder is "". Returns whether any name is another now.
pub(crate) fn rename_for(session: &mut Session, folder: &Path, top: &Path) -> bool {
    if folder == top {
        return false;
    }
    session.rename_files(&mut |name| {
        let beside = beside(name, folder)?;
        let seen = beside.strip_prefix(top).unwrap_or(&beside);
        seen.to_str().map(str::to_owned)
    })
}

/// The path of a file that is found in `folder` and not in the working folder.
fn beside(name: &str, folder: &Path) -> Option<PathBuf> {
    let name = Folders::of_user().expand(name);
    let is_beside = !name.is_absolute() && existing(Path::new("."), &name).is_none();
    if is_beside { existing(folder, &name) } else { None }
}

/// The name by which a file of a scene in `from` is found from a scene in `to`, wherever the program runs; `None` if the name
/// stays, as that of a file which cannot be found does. Both are `None` or "" for the working folder.
pub(crate) fn name_for_saving(name: &str, from: Option<&Path>, to: &Path) -> Option<String> {
    let file = found(name, from);
    if file.exists() { name_seen_from(to, name, &file) } else { None }
}

/// The path of a file that a scene names as seen from a folder.
pub(crate) fn path_seen_from(folder: &Path, name: &str) -> PathBuf {
    existing_or_typed(folder.join(Folders::of_user().expand(name)))
}

/// The name in `folder` of a file, which need not exist; `None` if that is `name`, which may also be a whole path.
pub(crate) fn name_seen_from(folder: &Path, name: &str, file: &Path) -> Option<String> {
    let whole = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path));
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let there = path_seen_from(folder, name);
    let (folder, file) = (whole(folder).ok()?, whole(file).ok()?);
    if Folders::of_user().expand(name).is_absolute() || whole(&there).is_ok_and(|there| there == file) {
        return None;
    }
    let is_right = |seen: &PathBuf| folder.join(seen).exists() || !file.exists();
    let seen = relative(&file, &folder).filter(is_right).unwrap_or_else(|| file.clone());
    // A name may have a '\' on other systems.
    seen.to_str().map(|seen| if cfg!(windows) { seen.replace('\\', "/") } else { seen.to_owned() })
}

/// The lines of a text with other names for the pictures that they name, as [`rename_in_line`].
pub(crate) fn rename_in_lines(text: &str, new_name: &mut dyn FnMut(&str) -> Option<String>) -> String {
    text.lines().map(|line| rename_in_line(line, &mut *new_name) + "\n").collect()
}

/// Gives the files that a scene in `folder` names their paths from there, for a scene that is used in any working folder.
pub(crate) fn use_paths(scene: &mut Scene, folder: &Path) {
    rename_files(scene, &mut |name| {
        let path = path_seen_from(folder, name);
        Some(path.to_str()?.to_owned())
    });
}

/// The path of a file as seen from a folder, both absolute and without `..`; `None` where nothing but the root is common.
fn relative(file: &Path, folder: &Path) -> Option<PathBuf> {
    let common = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let is_name = |component: &Component<'_>| matches!(component, Component::Normal(_));
    if !file.components().take(common).any(|component| is_name(&component)) {
        return None;
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    Some(up.chain(file.components().skip(common)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_folders() {
        let seen = |file: &str, folder: &str| {
            relative(Path::new(file), Path::new(folder)).map(|path| path.display().to_string())
        };
        assert_eq!(seen("/a/b/c.png", "/a/b").as_deref(), Some("c.png"));
        assert_eq!(seen("/a/b/c.png", "/a").as_deref(), Some("b/c.png"));
        assert_eq!(seen("/a/c.png", "/a/b/d").as_deref(), Some("../../c.png"));
        assert_eq!(seen("/x/c.png", "/a/b"), None);
    }
}
