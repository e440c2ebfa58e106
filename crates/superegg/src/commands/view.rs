//! `superegg view`: a window onto a scene, without a prompt.

use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use anyhow::{Context, Result};
use superegg_lang::{Effect, Fault, Session};
use superegg_scene::{Scene, ViewSettings};
use superegg_viewer::{FrameTimes, FromViewer, Shown, Viewer, ViewerHandle, bench_preview, bench_trace};

use crate::args::ViewArgs;
use crate::commands::{Outcome, counted};
use crate::load::{Mode, load};
use crate::say;

pub(crate) fn run(args: &ViewArgs) -> Result<Outcome> {
    let loaded = load(&args.scene, Mode::Scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let outcome = Outcome::of(&loaded);
    if args.bench {
        bench(args, loaded.session.scene(), root.as_deref())?;
        return Ok(outcome);
    }
    let viewer = Viewer::new().context("the viewer cannot start")?;
    let mut desk = Desk::new(loaded.session, root);
    let (out, from_viewer) = mpsc::channel();
    let handle = viewer.handle();
    let first = desk.shown();
    let session: JoinHandle<()> = std::thread::Builder::new()
        .name("session".to_owned())
        .spawn(move || desk.serve(&from_viewer, &handle))
        .context("cannot start the session's thread")?;
    let exit_code = i32::from(outcome != Outcome::Fine);
    let session = Arc::new(Mutex::new(Some(session)));
    // It ends when the window is closed.
    let wait = |session: &Mutex<Option<JoinHandle<()>>>| {
        let session = session.lock().unwrap_or_else(PoisonError::into_inner).take();
        session.map(JoinHandle::join)
    };
    let session_after_loss = Arc::clone(&session);
    viewer.run(Some(first), out, move || {
        wait(&session_after_loss);
        std::process::exit(exit_code);
    });
    wait(&session);
    Ok(outcome)
}

/// The session behind the window: it carries out what the panel and the keys ask for, and shows what came of it.
struct Desk {
    session: Session,
    /// Shown instead of what is selected, until a command selects something.
    root: Option<String>,
    settings: ViewSettings,
    past: Vec<Session>,
    future: Vec<Session>,
}

impl Desk {
    fn new(session: Session, root: Option<String>) -> Self {
        Self { session, root, settings: ViewSettings::default(), past: Vec::new(), future: Vec::new() }
    }

    fn shown(&self) -> Shown {
        let selected = self.root.clone().or_else(|| self.session.selected().map(str::to_owned));
        Shown { scene: self.session.scene().clone(), selected, settings: self.settings }
    }

    fn serve(&mut self, from_viewer: &Receiver<FromViewer>, viewer: &ViewerHandle) {
        for what in from_viewer {
            match what {
                FromViewer::Command(line) => match self.carry_out(&line) {
                    Ok(text) => {
                        viewer.show(self.shown());
                        // Where the output has gone there is nobody to tell.
                        let _ = say::out(format_args!("> {line}"));
                        if let Some(text) = text {
                            let _ = say::out(text);
                        }
                    }
                    Err(fault) => {
                        let help = fault.help.map(|help| format!("; {help}")).unwrap_or_default();
                        say::complain(format_args!("> {line}\nerror: {}{help}", fault.message));
                        viewer.notice(format!("{}{help}", fault.message));
                    }
                },
                FromViewer::Settings(settings) => self.settings = settings,
                FromViewer::Say(text) => {
                    let _ = say::out(text);
                }
                // There is no prompt to go back to.
                FromViewer::KeyboardBack => viewer.quit(),
                FromViewer::Closed => {
                    viewer.quit();
                    return;
                }
            }
        }
    }

    /// A line, `undo` and `redo` among them. Returns what it printed.
    fn carry_out(&mut self, line: &str) -> Result<Option<String>, Fault> {
        let nothing = |what: &str| Fault::new("nothing-to-do", format!("there is nothing to {what}"));
        match line {
            "undo" => {
                let before = self.past.pop().ok_or_else(|| nothing("undo"))?;
                self.future.push(std::mem::replace(&mut self.session, before));
                Ok(None)
            }
            "redo" => {
                let after = self.future.pop().ok_or_else(|| nothing("redo"))?;
                self.past.push(std::mem::replace(&mut self.session, after));
                Ok(None)
            }
            _ => {
                let before = self.session.clone();
                let effect = self.session.run_line(line)?;
                if self.session != before {
                    if self.session.selected() != before.selected() {
                        self.root = None;
                    }
                    self.past.push(before);
                    self.future.clear();
                }
                Ok(if let Effect::Print(text) = effect { Some(text) } else { None })
            }
        }
    }
}

fn bench(args: &ViewArgs, scene: &Scene, root: Option<&str>) -> Result<()> {
    let size = (args.size.width, args.size.height);
    let frames = usize::from(args.frames);
    say::out(format_args!("{}x{}, {}", size.0, size.1, counted(frames, "frame")))?;
    let preview = bench_preview(scene, root, size, frames).context("the preview cannot be drawn")?;
    say::out(format_args!(
        "preview on {}: {} ms to open {}, {}; {} and {} in the picture, {} coarser than their own patches",
        preview.device,
        preview.open_ms.round(),
        counted(preview.instances, "instance"),
        frame_text(&preview.times),
        counted(preview.stats.instances, "instance"),
        counted(preview.stats.triangles, "triangle"),
        preview.stats.coarser,
    ))?;
    let traced = bench_trace(scene, root, size, frames);
    say::out(format_args!(
        "ray traced on {}: {} ms to compile; at every pixel {}",
        counted(traced.threads, "thread"),
        traced.compile_ms.round(),
        frame_text(&traced.full),
    ))?;
    say::out(format_args!(
        "ray traced while turned: {}, one ray for {} x {} pixels at the end",
        frame_text(&traced.live),
        traced.coarseness,
        traced.coarseness,
    ))
}

fn frame_text(times: &FrameTimes) -> String {
    format!(
        "{:.1} ms a frame ({:.1} frames a second; one of twenty takes {:.1} ms or more)",
        times.median_ms,
        1e3 / times.median_ms.max(1e-3),
        times.slow_ms
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_undone_and_redone_one_by_one() {
        let mut desk = Desk::new(Session::default(), None);
        let mut states = vec![desk.session.clone()];
        for line in ["primitive ball", "setColor 1 0 0", "light sun 1 2 3", "camera 1 2 3 0 0 0"] {
            assert!(desk.carry_out(line).is_ok(), "{line}");
            states.push(desk.session.clone());
        }
        // What changes nothing, or fails, is no step.
        assert!(desk.carry_out("primitive ball").is_ok() && desk.carry_out("setColor 7 0 0").is_err());
        for state in states.iter().rev().skip(1) {
            assert!(desk.carry_out("undo").is_ok());
            assert_eq!(desk.session, *state);
        }
        assert!(desk.carry_out("undo").is_err());
        for state in &states[1..] {
            assert!(desk.carry_out("redo").is_ok());
            assert_eq!(desk.session, *state);
        }
        assert!(desk.carry_out("redo").is_err());
    }
}
