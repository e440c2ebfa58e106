//! The tracks of a scene, found by their subjects and by the names in them.

use std::sync::Arc;

use imbl::{HashMap, OrdMap, OrdSet};

use crate::animation::{Track, TrackSubject};

/// The tracks of a scene, in the order in which they were created. Cloning takes constant time, and a
/// change takes time for the tracks that it concerns, not for all.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracks {
    /// By a number that rises with the time of creation.
    list: OrdMap<u64, Track>,
    next: u64,
    /// The number of each track, by its subject without numbers.
    number_of: HashMap<TrackSubject, u64>,
    /// The numbers of the tracks that name something.
    about: HashMap<About, OrdSet<u64>>,
}

/// Something that a track names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum About {
    /// A primitive or object.
    Entity(Arc<str>),
    /// A child of an object.
    Child(Arc<str>, Arc<str>),
    Light(Arc<str>),
}

impl About {
    fn all_of(subject: &TrackSubject) -> impl Iterator<Item = Self> {
        let entities = subject.entities().cloned().map(Self::Entity);
        let child = subject.selected.clone().zip(subject.cursor.clone());
        let lights = subject.lights().cloned().map(Self::Light);
        entities.chain(child.map(|(object, alias)| Self::Child(object, alias))).chain(lights)
    }
}

impl PartialEq for Tracks {
    fn eq(&self, other: &Self) -> bool {
        self.list.len() == other.list.len() && self.iter().eq(other.iter())
    }
}

impl Tracks {
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = &Track> {
        self.list.values()
    }

    /// Adds a key, or replaces the one at its frame. The count of numbers may change if that is the
    /// only key of the track.
    ///
    /// # Errors
    /// The count of numbers in the other keys of the track, if it differs.
    pub(crate) fn set(&mut self, subject: TrackSubject, frame: f64, numbers: &[f64]) -> Result<(), usize> {
        let fixed = subject.without_numbers();
        // The names of a subject are not among its numbers, so those of the track stay the same.
        if let Some(track) = self.number_of.get(&fixed).and_then(|number| self.list.get_mut(number)) {
            return track.set(subject, frame, numbers);
        }
        self.insert(self.next, Track::new(subject, frame, numbers));
        self.next += 1;
        Ok(())
    }

    fn insert(&mut self, number: u64, track: Track) {
        self.number_of.insert(track.subject().without_numbers(), number);
        for about in About::all_of(track.subject()) {
            self.about.entry(about).or_default().insert(number);
        }
        self.list.insert(number, track);
    }

    fn take(&mut self, number: u64) -> Option<Track> {
        let track = self.list.remove(&number)?;
        self.number_of.remove(&track.subject().without_numbers());
        for about in About::all_of(track.subject()) {
            let left = self.about.get_mut(&about).map(|numbers| {
                numbers.remove(&number);
                numbers.len()
            });
            if left == Some(0) {
                self.about.remove(&about);
            }
        }
        Some(track)
    }

    /// Removes the keys at a frame, or at all frames, of the matching tracks. Returns their count.
    pub(crate) fn remove(&mut self, frame: Option<f64>, matches: impl Fn(&TrackSubject) -> bool) -> usize {
        let numbers: Vec<u64> = self
            .list
            .iter()
            .filter(|(_, track)| matches(track.subject()))
            .map(|(number, _)| *number)
            .collect();
        let mut removed = 0;
        for number in numbers {
            let Some(track) = self.list.get_mut(&number) else { continue };
            removed += track.remove(frame);
            if track.keys().len() == 0 {
                self.take(number);
            }
        }
        removed
    }

    /// Removes the tracks that name a primitive or object.
    pub(crate) fn remove_entity(&mut self, name: &str) {
        self.remove_about(&About::Entity(name.into()));
    }

    /// Removes the tracks of a child.
    pub(crate) fn remove_child(&mut self, object: &str, alias: &str) {
        self.remove_about(&About::Child(object.into(), alias.into()));
    }

    /// Removes the tracks that name a light.
    pub(crate) fn remove_light(&mut self, name: &str) {
        self.remove_about(&About::Light(name.into()));
    }

    fn remove_about(&mut self, about: &About) {
        for number in self.about.get(about).cloned().unwrap_or_default() {
            self.take(number);
        }
    }

    /// Renames a primitive or object in all tracks.
    pub(crate) fn rename(&mut self, name: &str, new: &str) {
        self.change_about(&About::Entity(name.into()), |track| track.rename(name, new));
    }

    /// Renames a child in all tracks.
    pub(crate) fn rename_child(&mut self, object: &str, alias: &str, new: &str) {
        self.change_about(&About::Child(object.into(), alias.into()), |track| track.rename_child(new));
    }

    fn change_about(&mut self, about: &About, change: impl Fn(&mut Track)) {
        for number in self.about.get(about).cloned().unwrap_or_default() {
            if let Some(mut track) = self.take(number) {
                change(&mut track);
                self.insert(number, track);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::TrackWord;

    #[test]
    fn a_track_keeps_its_count_of_numbers() {
        let subject = |count: usize| TrackSubject {
            command: "light".into(),
            words: [vec![TrackWord::Light("l".into())], vec![TrackWord::Number; count]].concat(),
            selected: None,
            cursor: None,
        };
        let mut tracks = Tracks::default();
        tracks.set(subject(3), 0.0, &[1.0; 3]).unwrap();
        tracks.set(subject(6), -0.0, &[1.0; 6]).unwrap();
        tracks.set(subject(6), 5.0, &[2.0; 6]).unwrap();
        assert_eq!(tracks.set(subject(3), 5.0, &[1.0; 3]), Err(6));
        assert_eq!(tracks.iter().len(), 1);
        assert_eq!((tracks.remove(Some(5.0), |_| true), tracks.remove(None, |_| false)), (1, 0));
        assert_eq!((tracks.remove(None, |_| true), tracks.iter().len()), (1, 0));
    }

    #[test]
    fn tracks_are_found_by_what_they_name() {
        let subject = |command: &str, selected: &str, cursor: Option<&str>| TrackSubject {
            command: command.into(),
            words: vec![TrackWord::Number],
            selected: Some(selected.into()),
            cursor: cursor.map(Into::into),
        };
        let mut tracks = Tracks::default();
        for (command, selected, cursor) in
            [("c", "a", None), ("d", "b", Some("x")), ("d", "b", Some("y")), ("c", "b", None)]
        {
            tracks.set(subject(command, selected, cursor), 0.0, &[1.0]).unwrap();
        }
        tracks.rename("b", "z");
        let names = |tracks: &Tracks| {
            let of = |track: &Track| {
                let cursor = track.subject().cursor.as_deref().unwrap_or_default();
                format!("{}{cursor}", track.subject().selected.as_deref().unwrap())
            };
            tracks.iter().map(of).collect::<Vec<_>>()
        };
        assert_eq!(names(&tracks), ["a", "zx", "zy", "z"]);
        tracks.rename_child("z", "x", "w");
        tracks.rename_child("b", "y", "v");
        assert_eq!(names(&tracks), ["a", "zw", "zy", "z"]);
        tracks.rename_child("z", "w", "x");
        let before = tracks.clone();
        tracks.remove_child("z", "x");
        tracks.remove_child("b", "y");
        tracks.remove_entity("a");
        assert_eq!((names(&tracks), before.iter().len()), (vec!["zy".to_owned(), "z".to_owned()], 4));
        tracks.remove_entity("z");
        assert!(tracks == Tracks::default() && tracks.about.is_empty() && tracks.number_of.is_empty());
    }
}
