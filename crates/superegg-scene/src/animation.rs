//! Keys: the numbers of a command at frames, and between them.

use std::sync::Arc;

use imbl::{HashMap, Vector};

/// A word of a keyed command, in the order of its arguments.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum TrackWord {
    /// A number, which each key gives.
    Number,
    /// A word that is the same for all keys.
    Word(Arc<str>),
    /// The name of a primitive or object.
    Entity(Arc<str>),
    /// The name of a light.
    Light(Arc<str>),
}

/// What a track's keys are keys of: a command, its words but for the numbers, and what was selected.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TrackSubject {
    /// The full name of the command.
    pub command: Arc<str>,
    /// Its arguments.
    pub words: Vec<TrackWord>,
    /// The primitive or object that it changes, where it changes what is selected.
    pub selected: Option<Arc<str>>,
    /// The alias of the child that it moves, where it moves the one at the cursor.
    pub cursor: Option<Arc<str>>,
}

impl TrackSubject {
    /// How many numbers each key has.
    pub fn number_count(&self) -> usize {
        self.words.iter().filter(|word| **word == TrackWord::Number).count()
    }

    /// What is equal for all keys of one track: all but the places of numbers, which may be more or fewer.
    fn fixed(&self) -> Self {
        let words = self.words.iter().filter(|word| **word != TrackWord::Number).cloned().collect();
        Self { words, ..self.clone() }
    }

    /// Whether it names or changes this primitive or object.
    pub(crate) fn is_about(&self, name: &str) -> bool {
        self.selected.as_deref() == Some(name)
            || self.words.iter().any(|word| matches!(word, TrackWord::Entity(entity) if **entity == *name))
    }

    pub(crate) fn names_light(&self, name: &str) -> bool {
        self.words.iter().any(|word| matches!(word, TrackWord::Light(light) if **light == *name))
    }

    pub(crate) fn rename(&mut self, name: &str, new: &str) {
        let names = self.words.iter_mut().filter_map(|word| match word {
            TrackWord::Entity(entity) => Some(entity),
            _ => None,
        });
        for held in names.chain(&mut self.selected).filter(|held| ***held == *name) {
            *held = new.into();
        }
    }
}

/// The numbers of a command at a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The frame, any finite number.
    pub frame: f64,
    /// The numbers, in the order of the command's arguments.
    pub numbers: Arc<[f64]>,
}

/// The keys of one command, by frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    subject: TrackSubject,
    /// At least one, frames rising.
    keys: Vector<Key>,
}

impl Track {
    /// What the keys are keys of.
    pub fn subject(&self) -> &TrackSubject {
        &self.subject
    }

    /// The keys, at least one, in the order of their frames.
    pub fn keys(&self) -> impl ExactSizeIterator<Item = &Key> {
        self.keys.iter()
    }

    /// The numbers at a frame: those of the first key before it, of the last one after it, and between two keys each number
    /// by itself along a monotone cubic (Fritsch and Carlson 1980, with the slopes of Fritsch and Butland 1984). So no number leaves the range of the
    /// keys on both sides, and where three keys rise or fall there is no kink. At the first and the last key the slope is 0, as it is outside.
    pub fn numbers_at(&self, frame: f64) -> Vec<f64> {
        let frame = frame + 0.0;
        let after = self.first_after(frame);
        let [Some(before), next] =
            [after.checked_sub(1).and_then(|at| self.keys.get(at)), self.keys.get(after)]
        else {
            return self.keys.front().map_or_else(Vec::new, |key| key.numbers.to_vec());
        };
        let Some(next) = next.filter(|_| before.frame != frame) else { return before.numbers.to_vec() };
        let outer = [after.checked_sub(2).and_then(|at| self.keys.get(at)), self.keys.get(after + 1)];
        (0..before.numbers.len())
            .map(|i| {
                let point = |key: &Key| (key.frame, key.numbers[i]);
                let [first, last] = outer.map(|key| key.map(point));
                interpolate(first, point(before), point(next), last, frame)
            })
            .collect()
    }

    /// The place of the first key after a frame.
    fn first_after(&self, frame: f64) -> usize {
        match self.keys.binary_search_by(|key| key.frame.total_cmp(&frame)) {
            Ok(at) => at + 1,
            Err(at) => at,
        }
    }
}

/// The tracks of a scene, in the order in which they began.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracks {
    list: Vector<Track>,
    /// Where each is in the list, by what is equal for all its keys.
    places: HashMap<TrackSubject, usize>,
}

impl PartialEq for Tracks {
    fn eq(&self, other: &Self) -> bool {
        self.list == other.list
    }
}

impl Tracks {
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = &Track> {
        self.list.iter()
    }

    fn find_places_again(&mut self) {
        self.places = self.list.iter().enumerate().map(|(at, track)| (track.subject.fixed(), at)).collect();
    }

    /// Adds a key, or replaces the one at its frame. A track of one key at this frame may go over to another count of numbers.
    ///
    /// # Errors
    /// The other keys of the track have so many numbers.
    pub(crate) fn set(&mut self, subject: TrackSubject, frame: f64, numbers: &[f64]) -> Result<(), usize> {
        // -0 is no frame of its own.
        let frame = frame + 0.0;
        let key = Key { frame, numbers: numbers.into() };
        let fixed = subject.fixed();
        let Some(at) = self.places.get(&fixed).copied() else {
            self.places.insert(fixed, self.list.len());
            self.list.push_back(Track { subject, keys: Vector::unit(key) });
            return Ok(());
        };
        let track = &mut self.list[at];
        let is_only = track.keys.len() == 1 && track.keys[0].frame == frame;
        if track.subject != subject && !is_only {
            return Err(track.subject.number_count());
        }
        track.subject = subject;
        match track.keys.binary_search_by(|key| key.frame.total_cmp(&frame)) {
            Ok(at) => track.keys[at] = key,
            Err(at) => track.keys.insert(at, key),
        }
        Ok(())
    }

    /// Takes away the keys at a frame, or all, of the tracks that are meant. Returns how many there were.
    pub(crate) fn remove(&mut self, frame: Option<f64>, is_meant: impl Fn(&TrackSubject) -> bool) -> usize {
        // Mostly there is none, and a list that is not touched stays shared.
        if !self.list.iter().any(|track| is_meant(&track.subject)) {
            return 0;
        }
        let mut removed = 0;
        for track in self.list.iter_mut().filter(|track| is_meant(&track.subject)) {
            let before = track.keys.len();
            track.keys.retain(|key| frame.is_some_and(|frame| frame != key.frame));
            removed += before - track.keys.len();
        }
        if removed > 0 {
            self.list.retain(|track| !track.keys.is_empty());
            self.find_places_again();
        }
        removed
    }

    pub(crate) fn rename(&mut self, name: &str, new: &str) {
        if !self.list.iter().any(|track| track.subject.is_about(name)) {
            return;
        }
        for track in self.list.iter_mut().filter(|track| track.subject.is_about(name)) {
            track.subject.rename(name, new);
        }
        self.find_places_again();
    }
}

/// A point of a curve: frame and value.
type Point = (f64, f64);

/// The value at a frame between two points, with their neighbours on both sides.
fn interpolate(before: Option<Point>, from: Point, to: Point, after: Option<Point>, frame: f64) -> f64 {
    // Halves, whose differences are finite.
    let half = |(frame, value): Point| (0.5 * frame, 0.5 * value);
    let (start, end) = (half(from), half(to));
    let width = end.0 - start.0;
    let t = ((0.5 * frame - start.0) / width).clamp(0.0, 1.0);
    let rise = end.1 - start.1;
    let slope = |a: Point, b: Point, c: Point| width * monotone_slope(half(a), half(b), half(c));
    let m0 = before.map_or(0.0, |before| slope(before, from, to));
    let m1 = after.map_or(0.0, |after| slope(from, to, after));
    let s = 1.0 - t;
    let value = 2.0 * (start.1 + rise * t * t * (3.0 - 2.0 * t) + m0 * t * s * s - m1 * t * t * s);
    // Where frames are too close for a slope, straight on.
    let value = if value.is_finite() { value } else { from.1 * s + to.1 * t };
    value.clamp(from.1.min(to.1), from.1.max(to.1))
}

/// The slope at the middle one of three points: a harmonic mean of those on both sides, 0 at a peak or a flat place.
fn monotone_slope(a: Point, b: Point, c: Point) -> f64 {
    let (h0, h1) = (b.0 - a.0, c.0 - b.0);
    let (d0, d1) = ((b.1 - a.1) / h0, (c.1 - b.1) / h1);
    if d0 == 0.0 || d1 == 0.0 || (d0 > 0.0) != (d1 > 0.0) {
        return 0.0;
    }
    // The weights as shares, which are finite for any frames.
    let w0 = (2.0 * (h1 / 3.0) + h0 / 3.0) / (h0 + h1);
    ((w0 / d0) + (1.0 - w0) / d1).recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(keys: &[Point]) -> Track {
        let words = vec![TrackWord::Number];
        let subject = TrackSubject { command: "c".into(), words, selected: None, cursor: None };
        let mut tracks = Tracks::default();
        for (frame, value) in keys {
            tracks.set(subject.clone(), *frame, &[*value]).unwrap();
        }
        tracks.list[0].clone()
    }

    #[test]
    fn keys_are_met_exactly_and_what_is_outside_stays() {
        let keys = [(48.0, 90.0), (-3.0, 0.1), (0.0, 7.0)];
        let track = track(&keys);
        for (frame, value) in keys {
            assert_eq!(track.numbers_at(frame), [value]);
        }
        assert_eq!((track.numbers_at(-1e300), track.numbers_at(1e300)), (vec![0.1], vec![90.0]));
        assert_eq!(track.keys().map(|key| key.frame).collect::<Vec<_>>(), [-3.0, 0.0, 48.0]);
    }

    #[test]
    fn two_keys_ease_and_even_ones_are_straight() {
        let eased = track(&[(0.0, 0.0), (48.0, 90.0)]);
        assert_eq!(eased.numbers_at(24.0), [45.0]);
        assert!(eased.numbers_at(1.0)[0] < 0.2 && eased.numbers_at(47.0)[0] > 89.8);
        let even = track(&[(0.0, 0.0), (10.0, 1.0), (20.0, 2.0), (30.0, 3.0)]);
        assert!((even.numbers_at(13.0)[0] - 1.3).abs() < 1e-12);
    }

    #[test]
    fn no_number_leaves_the_range_of_its_neighbours_and_none_turns_back() {
        let mut state = 1971u64;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let odd = [0.0, -0.0, 1e308, -1e308, f64::MAX, -f64::MAX, 5e-324, 1e-300, 1.0];
        for round in 0..3000 {
            let mut keys: Vec<Point> = (0..2 + round % 4)
                .map(|_| {
                    let mut number = || {
                        let plain = 20.0 * random() - 10.0;
                        if random() < 0.2 { odd[(random() * 9.0) as usize] } else { plain }
                    };
                    (number(), number())
                })
                .collect();
            let track = track(&keys);
            keys = track.keys().map(|key| (key.frame, key.numbers[0])).collect();
            for pair in keys.windows(2) {
                let (from, to) = (pair[0], pair[1]);
                let mut last = from.1;
                for i in 0..=16 {
                    let t = f64::from(i) / 16.0;
                    let value = track.numbers_at(from.0 * (1.0 - t) + to.0 * t)[0];
                    assert!((from.1.min(to.1)..=from.1.max(to.1)).contains(&value), "{keys:?} {t} {value}");
                    let slack = 1e-12 * value.abs().max(last.abs());
                    let is_on = if to.1 >= from.1 { value >= last - slack } else { value <= last + slack };
                    assert!(is_on, "{keys:?} {t}: {last} {value}");
                    last = value;
                }
            }
        }
    }

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
}
