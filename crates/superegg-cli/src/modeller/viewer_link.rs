//! The session and its viewer: snapshots go there, lines come back.

use superegg_lang::Fault;
use superegg_viewer::{FromViewer, Shown, ViewerHandle};

use crate::modeller::{Modeller, Said};

/// The viewer of a session, where it has one.
#[derive(Default)]
pub(super) struct ViewerLink {
    handle: Option<ViewerHandle>,
    /// Why there is none.
    why_not: Option<String>,
    /// Lines that came from there and are still to be put into the editor's history.
    lines: Vec<String>,
}

impl Modeller {
    /// Shows the scene in this viewer from now on.
    pub(crate) fn attach_viewer(&mut self, handle: ViewerHandle) {
        self.viewer.handle = Some(handle);
    }

    /// Goes on without a viewer, and remembers why for whoever asks for it.
    pub(crate) fn do_without_viewer(&mut self, why: String) {
        self.viewer.handle = None;
        self.viewer.why_not = Some(why);
    }

    /// What a viewer is to show now.
    pub(crate) fn shown(&self) -> Shown {
        let session = self.session();
        Shown {
            scene: session.scene().clone(),
            selected: session.selected().map(str::to_owned),
            settings: session.settings.view,
        }
    }

    pub(super) fn show_in_viewer(&self) {
        if let Some(handle) = &self.viewer.handle {
            handle.show(self.shown());
        }
    }

    /// The viewer, for a command that needs it.
    pub(super) fn viewer(&self) -> Result<&ViewerHandle, Fault> {
        self.viewer.handle.as_ref().ok_or_else(|| {
            let why = self.viewer.why_not.as_deref().unwrap_or("a session without a terminal has no window");
            let fault = Fault::new("no-viewer", format!("there is no viewer: {why}"));
            fault.help("'preview' draws the scene in the terminal, 'render' writes a picture").warning()
        })
    }

    /// Carries out what the viewer asks for.
    pub(crate) fn take_from_viewer(&mut self, said: FromViewer) {
        match said {
            FromViewer::Command(line) => {
                self.say(Said::Text(format!("> {line}")));
                self.viewer.lines.push(line.clone());
                self.typed.push(line.clone());
                if let Err(fault) = self.try_enter(&line) {
                    if let Some(handle) = &self.viewer.handle {
                        let help = fault.help.as_ref().map(|help| format!("; {help}")).unwrap_or_default();
                        handle.notice(format!("{}{help}", fault.message));
                    }
                    self.tell_fault(&line, fault);
                }
                // The viewer knows nothing that would have to ask.
                self.pending = None;
                self.show_in_viewer();
            }
            FromViewer::Settings(view) => {
                let mut settings = self.session().settings;
                settings.view = view;
                self.timeline.set_settings(settings);
            }
            FromViewer::Message(text) => self.print(&text),
            FromViewer::KeyboardBack | FromViewer::Closed => {}
        }
    }

    /// The lines that came from the viewer since this was last asked.
    pub(crate) fn drain_viewer_lines(&mut self) -> Vec<String> {
        std::mem::take(&mut self.viewer.lines)
    }
}
