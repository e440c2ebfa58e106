//! Keyframes: the numbers of a command at frames, and their interpolation.

use std::sync::Arc;

use imbl::Vector;

/// An argument of a keyed command.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum TrackWord {
    /// A number. Each key has its own.
    Number,
    /// A word that is the same in all keys.
    Word(Arc<str>),
    /// The name of a primitive or object.
    Entity(Arc<str>),
    /// The name of a light.
    Light(Arc<str>),
}

/// The subject of a track: a command, its arguments except for the numbers, and the selection.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TrackSubject {
    /// The full name of the command.
    pub command: Arc<str>,
    /// The arguments of the command, in order.
    pub words: Vec<TrackWord>,
    /// The primitive or object that the command changes; `None` if it does not change the selected
    /// one.
    pub selected: Option<Arc<str>>,
    /// The alias of the child that the command moves; `None` if it moves no child.
    pub cursor: Option<Arc<str>>,
}

impl TrackSubject {
    /// The count of numbers in each key.
    pub fn number_count(&self) -> usize {
        self.words.iter().filter(|word| **word == TrackWord::Number).count()
    }

    /// The part that identifies a track: everything except the numbers, whose count may differ.
    pub(crate) fn without_numbers(&self) -> Self {
        let words = self.words.iter().filter(|word| **word != TrackWord::Number).cloned().collect();
        Self { words, ..self.clone() }
    }

    /// The primitives and objects that the subject names or changes; one may come twice.
    pub(crate) fn entities(&self) -> impl Iterator<Item = &Arc<str>> {
        let named = self.words.iter().filter_map(|word| match word {
            TrackWord::Entity(name) => Some(name),
            TrackWord::Number | TrackWord::Word(_) | TrackWord::Light(_) => None,
        });
        named.chain(&self.selected)
    }

    /// The lights that the subject names.
    pub(crate) fn lights(&self) -> impl Iterator<Item = &Arc<str>> {
        self.words.iter().filter_map(|word| match word {
            TrackWord::Light(name) => Some(name),
            TrackWord::Number | TrackWord::Word(_) | TrackWord::Entity(_) => None,
        })
    }

    /// Whether the subject names or changes this primitive or object.
    pub fn is_about(&self, name: &str) -> bool {
        self.entities().any(|entity| **entity == *name)
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
    /// The frame; any finite number.
    pub frame: f64,
    /// The numbers, in the order of the arguments.
    pub numbers: Arc<[f64]>,
}

/// The keyframes of one command, in the order of their frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    subject: TrackSubject,
    /// At least one, in rising order of frames.
    keys: Vector<Key>,
}

impl Track {
    /// A track of one key.
    pub(crate) fn new(subject: TrackSubject, frame: f64, numbers: &[f64]) -> Self {
        Self { subject, keys: Vector::unit(Key { frame: frame + 0.0, numbers: numbers.into() }) }
    }

    /// Adds a key, or replaces the one at its frame. The count of numbers may change if that is the
    /// only key.
    ///
    /// # Errors
    /// The count of numbers in the other keys, if it differs.
    pub(crate) fn set(&mut self, subject: TrackSubject, frame: f64, numbers: &[f64]) -> Result<(), usize> {
        // -0 becomes 0: keys are in the total order of numbers, where they differ.
        let frame = frame + 0.0;
        let is_only = self.keys.len() == 1 && self.keys[0].frame == frame;
        if self.subject != subject && !is_only {
            return Err(self.subject.number_count());
        }
        self.subject = subject;
        let key = Key { frame, numbers: numbers.into() };
        match self.keys.binary_search_by(|key| key.frame.total_cmp(&frame)) {
            Ok(at) => self.keys[at] = key,
            Err(at) => self.keys.insert(at, key),
        }
        Ok(())
    }

    /// Removes the key at a frame, or all keys. Returns their count.
    pub(crate) fn remove(&mut self, frame: Option<f64>) -> usize {
        let before = self.keys.len();
        self.keys.retain(|key| frame.is_some_and(|frame| frame != key.frame));
        before - self.keys.len()
    }

    pub(crate) fn rename(&mut self, name: &str, new: &str) {
        self.subject.rename(name, new);
    }

    /// Gives the child that the track animates another alias.
    pub(crate) fn rename_child(&mut self, new: &str) {
        self.subject.cursor = Some(new.into());
    }

    /// The subject of the track.
    pub fn subject(&self) -> &TrackSubject {
        &self.subject
    }

    /// The keys, at least one, in rising order of frames.
    pub fn keys(&self) -> impl ExactSizeIterator<Item = &Key> {
        self.keys.iter()
    }

    /// The numbers at a frame.
    ///
    /// Before the first key and after the last one the numbers are those of that key. Between two
    /// keys each number follows a monotone cubic (Fritsch and Carlson 1980, with the slopes of
    /// Fritsch and Butland 1984): it stays in the range of the two keys, and the curve is smooth
    /// where three keys rise or fall. The slope is 0 at the first and the last key.
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

    /// The index of the first key after a frame.
    fn first_after(&self, frame: f64) -> usize {
        match self.keys.binary_search_by(|key| key.frame.total_cmp(&frame)) {
            Ok(at) => at + 1,
            Err(at) => at,
        }
    }
}

/// A point of a curve: (frame, value).
type Point = (f64, f64);

/// The cubic Hermite value at a frame between `from` and `to`; `before` and `after` are their
/// neighbours.
fn interpolate(before: Option<Point>, from: Point, to: Point, after: Option<Point>, frame: f64) -> f64 {
    // Halved, so that no difference overflows.
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
    // Linear, if the frames are too close for a finite slope.
    let value = if value.is_finite() { value } else { from.1 * s + to.1 * t };
    value.clamp(from.1.min(to.1), from.1.max(to.1))
}

/// The slope at the middle one of three points: the weighted harmonic mean of the two secants, or 0
/// at an extremum or where a secant is flat.
fn monotone_slope(a: Point, b: Point, c: Point) -> f64 {
    let (h0, h1) = (b.0 - a.0, c.0 - b.0);
    let (d0, d1) = ((b.1 - a.1) / h0, (c.1 - b.1) / h1);
    if d0 == 0.0 || d1 == 0.0 || (d0 > 0.0) != (d1 > 0.0) {
        return 0.0;
    }
    // Normalised, so that the weights are finite for any frames.
    let w0 = (2.0 * (h1 / 3.0) + h0 / 3.0) / (h0 + h1);
    ((w0 / d0) + (1.0 - w0) / d1).recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(keys: &[Point]) -> Track {
        let words = vec![TrackWord::Number];
        let subject = TrackSubject { command: "c".into(), words, selected: None, cursor: None };
        let (first, others) = keys.split_first().unwrap();
        let mut track = Track::new(subject.clone(), first.0, &[first.1]);
        for (frame, value) in others {
            track.set(subject.clone(), *frame, &[*value]).unwrap();
        }
        track
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
    fn both_zeros_are_one_frame() {
        for frames in [[0.0, -0.0], [-0.0, 0.0]] {
            let mut track = track(&[(frames[0], 1.0)]);
            track.set(track.subject().clone(), frames[1], &[2.0]).unwrap();
            assert_eq!(track.keys().len(), 1);
            assert!([0.0, -0.0].iter().all(|frame| track.numbers_at(*frame) == [2.0]));
        }
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
}
