//! Habits of language that a tool can see: none of them is in documents, help texts, messages and comments.
//!
//! Documents are the Markdown files without their code. Help texts and messages are the string literals of the crates and the documentation of
//! the program's arguments. Comments are those of Rust. `CONTRIBUTING.md` says how to write instead.

use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// Phrases, in lower case between words, and what to write instead.
const PHRASES: &[(&str, &str)] = &[
    ("is told", "name the computation: 'is computed', 'is reported'"),
    ("are told", "name the computation: 'are computed', 'are reported'"),
    ("tells of", "write 'reports', 'shows' or 'describes'"),
    ("speaks of", "write 'mentions' or 'describes'"),
    ("unless said", "write 'default:'"),
    ("if not said", "write 'default:'"),
    ("say otherwise", "write 'override'"),
    ("says otherwise", "write 'overrides'"),
    ("so manyth", "is no English"),
    ("that is none", "name the thing: 'an invalid line'"),
];

/// First words of a sentence that make a reader wait for its subject.
const BEGINNINGS: &[(&str, &str)] = &[
    ("What ", "begin with the subject: 'The rest', 'A longer text', 'Changes'"),
    ("Of ", "begin with the subject: 'The first hundred of many errors', 'A third of the time is'"),
    ("Those that ", "begin with the subject"),
];

/// The faults of a text, one for each.
fn faults(text: &str) -> Vec<String> {
    let flat: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let lower = format!(
        " {} ",
        flat.to_lowercase().replace(|letter: char| !letter.is_alphanumeric() && letter != ' ', " ")
    );
    let phrases = PHRASES
        .iter()
        .filter(|(phrase, _)| lower.contains(&format!(" {phrase} ")))
        .map(|(phrase, instead)| format!("'{phrase}': {instead}"));
    let sentences = sentences(&flat);
    let beginnings = sentences.iter().flat_map(|sentence| {
        BEGINNINGS
            .iter()
            .filter(|(begin, _)| {
                sentence.starts_with(begin) && !sentence.starts_with("Of course") && !sentence.ends_with('?')
            })
            .map(move |(_, instead)| format!("'{sentence}': {instead}"))
    });
    let clauses = sentences
        .iter()
        .filter(|sentence| has_what_clause(sentence))
        .map(|sentence| format!("'{sentence}': a clause with 'what is' as a subject; name the thing"));
    phrases.chain(beginnings).chain(clauses).collect()
}

/// The sentences of a text without line breaks; bold letters and list marks are left out.
fn sentences(text: &str) -> Vec<String> {
    let mut sentences = Vec::new();
    let mut rest = text;
    loop {
        let end = [". ", "? ", "! ", ": "].iter().filter_map(|end| rest.find(end)).min();
        let sentence = end.map_or(rest, |at| &rest[..=at]);
        sentences.push(sentence.trim_start_matches(['-', '*', '|', '#', '>', ' ']).trim().to_owned());
        match end {
            Some(at) => rest = &rest[at + 2..],
            None => return sentences,
        }
    }
}

/// Whether a statement has a subject as in "what is exported is closed".
fn has_what_clause(sentence: &str) -> bool {
    let words: Vec<String> = sentence.split(' ').map(str::to_lowercase).collect();
    !sentence.ends_with('?')
        && words.windows(2).enumerate().any(|(at, two)| {
            two == ["what", "is"]
                && words[at + 2..]
                    .iter()
                    .take(5)
                    .take_while(|word| !word.ends_with([',', ';', ':', '.']))
                    .any(|word| word == "is")
        })
}

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Every file below a folder whose name ends so, without build folders and hidden ones.
fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir()
            && !path.is_symlink()
            && !name.starts_with('.')
            && !["target", "shared", "node_modules"].contains(&name.as_str())
        {
            files(&path, ending, found);
        } else if name.ends_with(ending) {
            found.push(path);
        }
    }
}

/// The paragraphs of a Markdown file with the number of their first line: without blocks of code, what stands between back quotes, the targets of links,
/// and rows of tables as one text each.
fn paragraphs(text: &str) -> Vec<(usize, String)> {
    let mut paragraphs: Vec<(usize, String)> = Vec::new();
    let mut is_code = false;
    let mut is_open = false;
    for (at, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
            is_open = false;
            continue;
        }
        let trimmed = line.trim();
        let is_indented = line.starts_with("    ") && !is_open;
        if is_code || is_indented || trimmed.is_empty() {
            is_open = false;
            continue;
        }
        let line: String = trimmed
            .split('`')
            .enumerate()
            .map(|(part, text)| if part % 2 == 0 { text } else { "code" })
            .collect();
        let begins = ["- ", "* ", "# ", "## ", "### "].iter().any(|mark| line.starts_with(mark));
        if line.starts_with('|') {
            paragraphs.extend(line.split('|').map(|cell| (at + 1, cell.trim().to_owned())));
            is_open = false;
        } else if is_open && !begins {
            let last = &mut paragraphs.last_mut().unwrap().1;
            *last = format!("{last} {line}");
        } else {
            paragraphs.push((at + 1, line));
            is_open = true;
        }
    }
    paragraphs
}

/// The string literals of a file, tests excepted, and the documentation of arguments where that is their help.
#[derive(Default)]
struct Texts {
    has_help: bool,
    found: Vec<String>,
}

impl Visit<'_> for Texts {
    fn visit_item_mod(&mut self, module: &syn::ItemMod) {
        let is_test = module.attrs.iter().any(|attribute| {
            attribute.path().is_ident("cfg")
                && attribute.parse_args::<syn::Ident>().is_ok_and(|condition| condition == "test")
        });
        if !is_test {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_attribute(&mut self, attribute: &syn::Attribute) {
        if self.has_help
            && attribute.path().is_ident("doc")
            && let syn::Meta::NameValue(pair) = &attribute.meta
            && let syn::Expr::Lit(literal) = &pair.value
            && let syn::Lit::Str(text) = &literal.lit
        {
            self.found.push(text.value());
        }
    }

    fn visit_lit_str(&mut self, literal: &syn::LitStr) {
        self.found.push(literal.value());
    }

    fn visit_macro(&mut self, call: &syn::Macro) {
        for token in call.tokens.clone() {
            self.add_token(token);
        }
    }
}

impl Texts {
    /// The literals among the tokens of a macro.
    fn add_token(&mut self, token: proc_macro2::TokenTree) {
        match token {
            proc_macro2::TokenTree::Group(group) => {
                for token in group.stream() {
                    self.add_token(token);
                }
            }
            proc_macro2::TokenTree::Literal(literal) => {
                if let syn::Lit::Str(text) = syn::Lit::new(literal) {
                    self.found.push(text.value());
                }
            }
            _ => {}
        }
    }
}

/// The paragraphs of the comments of a Rust file, with the number of their first line.
fn comments(text: &str) -> Vec<(usize, String)> {
    // The comment marks become those of quotes, of one kind after the other, so that code in doc comments is left out as in
    // Markdown.
    let marks = ["///", "//!", "//"];
    let mut found = Vec::new();
    for mark in marks {
        let lines = text.lines().map(|line| {
            let line = line.trim_start();
            let is_of_kind = marks.iter().find(|mark| line.starts_with(**mark)) == Some(&mark);
            let rest = if is_of_kind { &line[mark.len()..] } else { "" };
            rest.strip_prefix(' ').unwrap_or(rest)
        });
        found.extend(paragraphs(&lines.collect::<Vec<_>>().join("\n")));
    }
    found
}

#[test]
fn no_comment_has_a_banned_habit() {
    let mut sources = Vec::new();
    files(&project().join("crates"), ".rs", &mut sources);
    // The habits themselves stand in this file.
    sources.retain(|path| !path.ends_with("tests/words.rs"));
    let mut found = Vec::new();
    let mut count = 0;
    for path in sources {
        let comments = comments(&fs::read_to_string(&path).unwrap());
        count += comments.len();
        for (line, text) in comments {
            found
                .extend(faults(&text).into_iter().map(|fault| format!("{}:{line}: {fault}", path.display())));
        }
    }
    assert!(count > 8000, "only {count} paragraphs were found");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_paragraphs_of_comments_are_found() {
    let text = "//! Of a file.\n\nfn f() {\n    // One\n    // two.\n    let x = 1; // no\n    /// ```\n    /// What\n    /// ```\n}\n";
    let expected = [(1, "Of a file."), (4, "One two.")].map(|(line, text)| (line, text.to_owned()));
    assert_eq!(comments(text), expected);
}

#[test]
fn every_finding_has_a_row() {
    let folder = project().join("findings");
    let table = fs::read_to_string(folder.join("README.md")).unwrap();
    let mut scripts = Vec::new();
    files(&folder, ".sh", &mut scripts);
    assert!(scripts.len() > 5);
    for script in scripts {
        let name = script.file_name().unwrap().to_string_lossy().into_owned();
        assert!(table.contains(&format!("[{name}]({name})")), "findings/README.md has no row for {name}");
        let text = fs::read_to_string(&script).unwrap();
        assert!(text.contains("For us:"), "{name} has no line that begins with 'For us:'");
    }
}

#[test]
fn no_document_has_a_banned_habit() {
    let mut documents = Vec::new();
    files(&project(), ".md", &mut documents);
    assert!(documents.len() > 20);
    let mut found = Vec::new();
    for path in documents {
        for (line, text) in paragraphs(&fs::read_to_string(&path).unwrap()) {
            found
                .extend(faults(&text).into_iter().map(|fault| format!("{}:{line}: {fault}", path.display())));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_help_text_or_message_has_a_banned_habit() {
    let mut sources = Vec::new();
    for entry in fs::read_dir(project().join("crates")).unwrap() {
        files(&entry.unwrap().path().join("src"), ".rs", &mut sources);
    }
    assert!(sources.len() > 100);
    let mut found = Vec::new();
    let mut count = 0;
    for path in sources {
        let has_help =
            path.components().any(|part| part.as_os_str() == "args" || part.as_os_str() == "args.rs");
        let mut texts = Texts { has_help, ..Texts::default() };
        texts.visit_file(&syn::parse_file(&fs::read_to_string(&path).unwrap()).unwrap());
        count += texts.found.len();
        for text in texts.found {
            found.extend(faults(&text).into_iter().map(|fault| format!("{}: {fault}", path.display())));
        }
    }
    assert!(count > 1000, "only {count} texts were found");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_habits_are_seen_and_plain_sentences_pass() {
    for bad in [
        "What is left is scalar work.",
        "It is fast. Of many errors the first hundred are described.",
        "The ground is told by the lanes",
        "It takes 4 unless said.",
        "All what is exported is closed.",
    ] {
        assert!(!faults(bad).is_empty(), "{bad}");
    }
    for good in [
        "What is a ray?",
        "Of course it is.",
        "An error says what is wrong, where, and what to do next.",
        "Files cannot be told apart by their endings.",
        "It says what is missing; the picture is written.",
    ] {
        assert_eq!(faults(good), Vec::<String>::new(), "{good}");
    }
}
