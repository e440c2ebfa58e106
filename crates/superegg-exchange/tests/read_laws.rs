//! The laws of the fuzz target of readers, on its corpus and on mutations of it: a short run that needs
//! no fuzzer.

#[path = "../../../fuzz/read_laws.rs"]
mod read_laws;

use std::path::Path;

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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/read");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| std::fs::read(file).unwrap()).collect()
}

#[test]
fn the_corpus_and_its_mutations_keep_the_laws() {
    let words: [&[u8]; 10] = [
        b"nan",
        b"-1",
        b"0",
        b"1e308",
        b"18446744073709551615",
        b"-0",
        b"\n",
        b" ",
        b"ITEM: TIMESTEP\n",
        b"\xff",
    ];
    let corpus = corpus();
    assert!(!corpus.is_empty());
    corpus.iter().for_each(|bytes| read_laws::check(bytes));
    let mut random = Random(1971);
    for _ in 0..6000 {
        let mut bytes = random.pick(&corpus).clone();
        for _ in 0..=random.below(6) {
            let at = random.below(bytes.len() + 1);
            match random.below(6) {
                0 if at < bytes.len() => bytes[at] = random.below(256) as u8,
                1 if at < bytes.len() => drop(bytes.remove(at)),
                2 if random.below(4) == 0 => bytes.truncate(at),
                3 => {
                    let other = random.pick(&corpus);
                    let from = random.below(other.len());
                    let to = (from + random.below(60)).min(other.len());
                    let part = other[from..to].to_vec();
                    bytes.splice(at..at, part);
                }
                _ => {
                    let end = (at + random.below(4)).min(bytes.len());
                    bytes.splice(at..end, random.pick(&words).iter().copied());
                }
            }
        }
        read_laws::check(&bytes);
    }
}
