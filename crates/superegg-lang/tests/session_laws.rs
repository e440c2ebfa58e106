//! The laws of the fuzz target, on its corpus and on mutations of it: a short run that needs no
//! fuzzer.

#[path = "../../../fuzz/session_laws.rs"]
mod session_laws;

use std::path::Path;

use superegg_lang::{ArgKind, COMMANDS};

/// A small generator of numbers (xorshift, Marsaglia 2003).
struct Random(u64);

impl Random {
    fn below(&mut self, most: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % most as u64) as usize
    }

    fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

fn corpus() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/session");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| std::fs::read(file).unwrap()).collect()
}

/// A line of a command with words that fit, and now and then some that do not.
fn line(random: &mut Random) -> String {
    let spec = random.pick(COMMANDS);
    let spellings: Vec<_> = spec.all_spellings().collect();
    let mut words = vec![(*random.pick(&spellings)).to_owned()];
    for arg in spec.all_args() {
        let word = match arg.kind {
            _ if random.below(40) == 0 => {
                *random.pick(&["-0", "1e308", "1e-308", "nan", "\"", "#", "ü", "--history"])
            }
            ArgKind::Number(_) => *random.pick(&["0", "1", "2", ".5", "-1", "1e-9", "25"]),
            ArgKind::Choice(choices) => *random.pick(choices),
            ArgKind::Size => "8x6",
            ArgKind::Line => *random.pick(&[
                "rotate 0 0 1 90",
                "color 1 0 0",
                "light a 1 2 3",
                "camera 1 2 3 0 0 0",
                "floor 1 a",
                "set exposure 2",
                "xall 1e300 0 0",
            ]),
            _ => *random.pick(&["a", "b", "c", "o", "p", "size", "on"]),
        };
        words.push(word.to_owned());
    }
    if random.below(8) == 0 {
        words.pop();
    }
    words.join(" ")
}

#[test]
fn the_corpus_and_its_mutations_keep_the_laws() {
    let corpus = corpus();
    assert!(!corpus.is_empty());
    corpus.iter().for_each(|bytes| session_laws::check(bytes));
    let mut random = Random(1971);
    for _ in 0..3000 {
        let mut bytes = random.pick(&corpus).clone();
        for _ in 0..random.below(30) {
            let at = random.below(bytes.len() + 1);
            match random.below(4) {
                0 if at < bytes.len() => bytes[at] = random.below(256) as u8,
                1 if at < bytes.len() => drop(bytes.remove(at)),
                _ => {
                    let end = bytes[at..]
                        .iter()
                        .position(|&byte| byte == b'\n')
                        .map_or(bytes.len(), |end| at + end);
                    let new = format!("\n{}", line(&mut random));
                    bytes.splice(end..end, new.into_bytes());
                }
            }
        }
        session_laws::check(&bytes);
    }
}
