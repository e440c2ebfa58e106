//! The events of a window, without requests that newer ones replace.

use std::collections::VecDeque;
use std::sync::mpsc::Receiver;

use superegg_viewer::FromViewer;

/// The events of a window in their order. Only the newest of the waiting requests for frames
/// counts, so that a slider does not queue up loads.
pub(super) struct Inbox {
    events: Receiver<FromViewer>,
    waiting: VecDeque<FromViewer>,
}

impl Inbox {
    pub(super) fn new(events: Receiver<FromViewer>) -> Self {
        Self { events, waiting: VecDeque::new() }
    }
}

impl Iterator for Inbox {
    type Item = FromViewer;

    /// Waits for the next event. `None` when the window is gone.
    fn next(&mut self) -> Option<FromViewer> {
        if self.waiting.is_empty() {
            self.waiting.push_back(self.events.recv().ok()?);
        }
        self.waiting.extend(self.events.try_iter());
        drop_older_frames(&mut self.waiting);
        self.waiting.pop_front()
    }
}

fn drop_older_frames(waiting: &mut VecDeque<FromViewer>) {
    let is_frame = |event: &FromViewer| matches!(event, FromViewer::Frame(_));
    let mut left = waiting.iter().filter(|event| is_frame(event)).count();
    waiting.retain(|event| {
        let is_older = is_frame(event) && left > 1;
        left -= usize::from(is_frame(event));
        !is_older
    });
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn of_waiting_frames_the_newest_counts_and_all_else_keeps_its_order() {
        let (sender, events) = channel();
        let mut inbox = Inbox::new(events);
        let command = |text: &str| FromViewer::Command(text.to_owned());
        for frame in 0..1000 {
            sender.send(FromViewer::Frame(frame)).unwrap();
            if frame % 500 == 250 {
                sender.send(command(&frame.to_string())).unwrap();
            }
        }
        assert_eq!(inbox.next(), Some(command("250")));
        // While that one was carried out.
        sender.send(FromViewer::Frame(7)).unwrap();
        sender.send(FromViewer::KeyboardBack).unwrap();
        assert_eq!(inbox.next(), Some(command("750")));
        assert_eq!(inbox.next(), Some(FromViewer::Frame(7)));
        assert_eq!(inbox.next(), Some(FromViewer::KeyboardBack));
        sender.send(FromViewer::Frame(3)).unwrap();
        assert_eq!(inbox.next(), Some(FromViewer::Frame(3)));
        drop(sender);
        assert_eq!(inbox.next(), None);
    }
}
