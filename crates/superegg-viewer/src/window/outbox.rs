//! Messages to the session.

use std::sync::mpsc::Sender;

use crate::protocol::FromViewer;

/// The sender to the session.
#[derive(Debug)]
pub(super) struct Outbox {
    out: Sender<FromViewer>,
    is_closed: bool,
}

impl Outbox {
    pub(super) fn new(out: Sender<FromViewer>) -> Self {
        Self { out, is_closed: false }
    }

    pub(super) fn send(&mut self, message: FromViewer) {
        self.is_closed |= self.out.send(message).is_err();
    }

    pub(super) fn command(&mut self, line: String) {
        self.send(FromViewer::Command(line));
    }

    /// Sends the lines of one action, which one undo takes back.
    pub(super) fn lines(&mut self, lines: Vec<String>) {
        self.change(&lines.join("; "), lines);
    }

    /// Sends lines as one change with this name in the history.
    pub(super) fn change(&mut self, label: &str, mut lines: Vec<String>) {
        if lines.len() == 1 {
            self.command(lines.remove(0));
        } else if !lines.is_empty() {
            self.send(FromViewer::Change { label: label.to_owned(), lines });
        }
    }

    /// The session has dropped the receiver. It needs no window any more.
    pub(super) fn is_closed(&self) -> bool {
        self.is_closed
    }
}
