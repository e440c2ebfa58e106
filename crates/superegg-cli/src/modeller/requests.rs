//! Runs the commands that need more than the session: files, folders, renders, tests and the
//! viewer.

mod export;
mod files;
mod pictures;
mod queries;
mod recover;

use superegg_lang::{Fault, Request};

use crate::modeller::faults::at_argument;
use crate::modeller::state::{Modeller, Pending};

/// Runs the request of a line. The undo history shows the line as the name of the change.
pub(super) fn run_request(modeller: &mut Modeller, request: &Request, line: &str) -> Result<(), Fault> {
    match request {
        // The caller ends the session; the timeline undoes and redoes.
        Request::Stop | Request::Undo(_) | Request::Redo(_) => Ok(()),
        Request::StopRender => modeller.cancel_renders(),
        Request::Source { file, is_forced } => modeller.load(file.as_deref(), *is_forced, line),
        Request::New => {
            modeller.finish_or_confirm(Pending::New { label: line.trim().to_owned() }, false);
            Ok(())
        }
        Request::Export { file, is_forced } => modeller.export(file, *is_forced),
        Request::Include(file) => modeller.include(file, line),
        Request::Save { file, is_forced, as_history } => {
            modeller.save(file.as_deref(), *is_forced, *as_history)
        }
        Request::Recover(action) => modeller.recover(*action),
        Request::Show(names) => modeller.show(names, line),
        Request::History(count) => {
            modeller.print_history(*count);
            Ok(())
        }
        Request::ClearScreen => {
            modeller.clear_screen();
            Ok(())
        }
        Request::PrintFolder => modeller.print_folder(),
        Request::ChangeFolder(folder) => modeller.change_folder(folder.as_deref()),
        Request::ListFolder(folder) => modeller.list_folder(folder.as_deref()),
        Request::Frame(name) => modeller.frame(name.as_deref(), line),
        Request::Render { file, size, is_forced } => modeller.render(file.as_deref(), *size, *is_forced),
        Request::Preview(frame) => modeller.preview(*frame).map_err(|fault| at_argument(fault, line, 1)),
        Request::View => {
            modeller.viewer.require()?.open(modeller.snapshot());
            Ok(())
        }
        Request::Interact => {
            let viewer = modeller.viewer.require()?;
            viewer.open(modeller.snapshot());
            viewer.interact();
            Ok(())
        }
        Request::InsideOutside(point) => modeller.inside_outside(*point),
        Request::Intersect(ray) => modeller.intersect(*ray),
    }
}
