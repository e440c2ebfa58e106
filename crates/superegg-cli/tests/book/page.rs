//! A page of the book: its blocks of code, headings, links and pictures.

use std::path::{Path, PathBuf};

/// A page as it is in its file.
pub(crate) struct Page {
    pub(crate) path: PathBuf,
    pub(crate) lines: Vec<String>,
}

/// A block of code between fences.
pub(crate) struct Block {
    /// The first word behind the fence: how the block is run.
    pub(crate) kind: String,
    /// The second word: the file that the block is written to.
    pub(crate) file: Option<String>,
    /// Indices of its lines in the page, without the fences.
    pub(crate) lines: std::ops::Range<usize>,
}

impl Page {
    pub(crate) fn read(path: &Path) -> Self {
        let text =
            std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self { path: path.to_owned(), lines: text.lines().map(str::to_owned).collect() }
    }

    /// The place of a line for messages, as editors understand it.
    pub(crate) fn at(&self, line: usize) -> String {
        let project = crate::project("").canonicalize().unwrap();
        let path = self.path.canonicalize().unwrap();
        format!("{}:{}", path.strip_prefix(project).unwrap_or(&path).display(), line + 1)
    }

    /// Blocks between fences, in order.
    pub(crate) fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        let mut open: Option<(String, usize)> = None;
        for (at, line) in self.lines.iter().enumerate() {
            let Some(info) = line.strip_prefix("```") else { continue };
            match open.take() {
                None => open = Some((info.trim().to_owned(), at + 1)),
                Some((info, first)) => {
                    let mut words = info.split_whitespace().map(str::to_owned);
                    let (kind, file) = (words.next().unwrap_or_default(), words.next());
                    blocks.push(Block { kind, file, lines: first..at });
                }
            }
        }
        assert!(open.is_none(), "{}: a fence is not closed", self.at(self.lines.len()));
        blocks
    }

    /// Lines outside of blocks, with their indices.
    pub(crate) fn prose(&self) -> impl Iterator<Item = (usize, &str)> {
        let mut is_code = false;
        self.lines.iter().enumerate().filter_map(move |(at, line)| {
            if line.starts_with("```") {
                is_code = !is_code;
                return None;
            }
            (!is_code).then_some((at, line.as_str()))
        })
    }

    /// Lines that Markdown takes for code because they are indented: nothing runs them.
    pub(crate) fn indented_code(&self) -> Vec<usize> {
        let mut is_after_blank = true;
        let mut found = Vec::new();
        for (at, line) in self.prose() {
            if is_after_blank && line.starts_with("    ") && !line.trim().is_empty() {
                found.push(at);
            }
            is_after_blank = line.trim().is_empty();
        }
        found
    }

    /// The anchors of the headings, as GitHub and mdBook make them.
    pub(crate) fn anchors(&self) -> Vec<String> {
        let mut anchors: Vec<String> = Vec::new();
        for (_, line) in self.prose().filter(|(_, line)| line.starts_with('#')) {
            let slug = slug(line.trim_start_matches('#').trim());
            let same = anchors.iter().filter(|anchor| **anchor == slug).count();
            anchors.push(if same == 0 { slug } else { format!("{slug}-{same}") });
        }
        anchors
    }

    /// The targets of links and pictures, with the index of their line.
    pub(crate) fn links(&self) -> Vec<(usize, String)> {
        let mut links = Vec::new();
        for (at, line) in self.prose() {
            let line = without_code(line);
            for part in line.split("](").skip(1) {
                if let Some((target, _)) = part.split_once(')') {
                    links.push((at, target.to_owned()));
                }
            }
        }
        links
    }

    /// Words between back quotes outside of blocks, with the index of their line.
    pub(crate) fn code_words(&self) -> Vec<(usize, &str)> {
        let spans =
            self.prose().flat_map(|(at, line)| line.split('`').skip(1).step_by(2).map(move |s| (at, s)));
        spans.flat_map(|(at, span)| span.split_whitespace().map(move |word| (at, word))).collect()
    }
}

/// A line without what stands between back quotes.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect()
}

fn slug(heading: &str) -> String {
    heading
        .to_lowercase()
        .chars()
        .filter_map(|letter| match letter {
            ' ' => Some('-'),
            '-' | '_' => Some(letter),
            letter if letter.is_alphanumeric() => Some(letter),
            _ => None,
        })
        .collect()
}
