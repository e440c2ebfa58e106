//! YAML as a tree with lines. Its size and nesting are bounded, copies by aliases included.

use std::collections::HashMap;

use saphyr_parser::{Event, Parser, Span};

use super::error::ReadError;

/// The most nodes of a tree; an alias counts as all that it copies.
const MOST_NODES: usize = 4_000_000;
/// The deepest nesting.
const MOST_LEVELS: usize = 64;
/// The most keys of a map.
const MOST_KEYS: usize = 1000;

/// A node of the tree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    /// Its line, counted from 1.
    pub(crate) line: u64,
    pub(crate) content: Content,
}

/// The content of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Content {
    Scalar(String),
    List(Vec<Node>),
    /// Keys with their values, in the order of the file.
    Map(Vec<(String, Node)>),
}

impl Node {
    /// An error at this node.
    pub(crate) fn error(&self, message: impl Into<String>) -> ReadError {
        ReadError::line(self.line, message)
    }

    /// The value of a key, if this is a map that has it.
    pub(crate) fn get(&self, key: &str) -> Option<&Self> {
        let Content::Map(entries) = &self.content else { return None };
        entries.iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    /// The value of a key, or an error that names it.
    pub(crate) fn needed(&self, key: &str) -> Result<&Self, ReadError> {
        self.get(key).ok_or_else(|| self.error(format!("expected the key '{key}'")))
    }

    /// The entries of a map.
    pub(crate) fn entries(&self) -> Result<&[(String, Self)], ReadError> {
        match &self.content {
            Content::Map(entries) => Ok(entries),
            _ => Err(self.error("expected keys with values")),
        }
    }

    /// The items of a list; an empty value is an empty list.
    pub(crate) fn items(&self) -> Result<&[Self], ReadError> {
        match &self.content {
            Content::List(items) => Ok(items),
            Content::Scalar(text) if matches!(text.as_str(), "" | "~" | "null") => Ok(&[]),
            _ => Err(self.error("expected a list")),
        }
    }

    /// The text of a scalar.
    pub(crate) fn text(&self) -> Result<&str, ReadError> {
        match &self.content {
            Content::Scalar(text) => Ok(text),
            _ => Err(self.error("expected one value")),
        }
    }

    /// A finite number.
    pub(crate) fn number(&self) -> Result<f64, ReadError> {
        let text = self.text()?;
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            self.error(format!("expected a number, found '{shown}'"))
        })
    }

    /// A list of N finite numbers.
    pub(crate) fn numbers<const N: usize>(&self) -> Result<[f64; N], ReadError> {
        let items = self.items()?;
        if items.len() != N {
            return Err(self.error(format!("expected {N} numbers, found {}", items.len())));
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(items) {
            *number = item.number()?;
        }
        Ok(numbers)
    }
}

/// The tree of the first document of a text.
///
/// # Errors
/// The text is no YAML, has a key twice, an alias without its anchor, or exceeds the bounds.
pub(crate) fn parse(text: &str) -> Result<Node, ReadError> {
    let mut builder = Builder::default();
    let mut parser = Parser::new_from_str(text);
    while let Some(event) = parser.next_event() {
        let (event, span) = event.map_err(|error| {
            ReadError::line(
                error.marker().line() as u64,
                format!("the YAML cannot be read: {}", error.info()),
            )
        })?;
        if matches!(event, Event::DocumentEnd) {
            break;
        }
        builder.add(event, span)?;
    }
    builder.root.ok_or_else(|| ReadError::File("the YAML file is empty".to_owned()))
}

/// A list or map that is not complete.
struct Open {
    node: Node,
    anchor: usize,
    /// The key that waits for its value.
    key: Option<String>,
    /// The nodes in it, itself included.
    size: usize,
}

#[derive(Default)]
struct Builder {
    open: Vec<Open>,
    anchors: HashMap<usize, (Node, usize)>,
    root: Option<Node>,
    nodes: usize,
}

impl Builder {
    fn add(&mut self, event: Event<'_>, span: Span) -> Result<(), ReadError> {
        let line = span.start.line() as u64;
        let node = |content| Node { line, content };
        match event {
            Event::Scalar(text, _, anchor, _) => {
                self.close(node(Content::Scalar(text.into_owned())), anchor, 1)
            }
            Event::SequenceStart(anchor, _) => self.begin(node(Content::List(Vec::new())), anchor),
            Event::MappingStart(anchor, _) => self.begin(node(Content::Map(Vec::new())), anchor),
            Event::SequenceEnd | Event::MappingEnd => match self.open.pop() {
                Some(Open { node, anchor, size, .. }) => self.close(node, anchor, size),
                None => Ok(()),
            },
            Event::Alias(anchor) => {
                let Some((mut copy, size)) = self.anchors.get(&anchor).cloned() else {
                    return Err(ReadError::line(line, "the alias stands within its own anchor"));
                };
                copy.line = line;
                self.count(size, line)?;
                self.close(copy, 0, size)
            }
            Event::Nothing
            | Event::StreamStart
            | Event::StreamEnd
            | Event::DocumentStart(_)
            | Event::DocumentEnd => Ok(()),
        }
    }

    fn count(&mut self, size: usize, line: u64) -> Result<(), ReadError> {
        self.nodes = self.nodes.saturating_add(size);
        if self.nodes > MOST_NODES {
            let message = format!("the file has more than {MOST_NODES} values, copies by aliases included");
            return Err(ReadError::line(line, message));
        }
        Ok(())
    }

    fn begin(&mut self, node: Node, anchor: usize) -> Result<(), ReadError> {
        if self.open.len() == MOST_LEVELS {
            return Err(node.error(format!("the values are nested deeper than {MOST_LEVELS} levels")));
        }
        self.open.push(Open { node, anchor, key: None, size: 1 });
        Ok(())
    }

    /// Adds a complete node to what is open.
    fn close(&mut self, node: Node, anchor: usize, size: usize) -> Result<(), ReadError> {
        self.count(1, node.line)?;
        if anchor > 0 {
            self.count(size, node.line)?;
            self.anchors.insert(anchor, (node.clone(), size));
        }
        let Some(open) = self.open.last_mut() else {
            self.root = Some(node);
            return Ok(());
        };
        open.size = open.size.saturating_add(size);
        match &mut open.node.content {
            Content::List(items) => items.push(node),
            Content::Map(entries) => match open.key.take() {
                None => {
                    let key = node.text()?.to_owned();
                    if entries.len() == MOST_KEYS {
                        return Err(node.error(format!("more than {MOST_KEYS} keys stand here")));
                    }
                    if entries.iter().any(|(other, _)| *other == key) {
                        let shown: String = key.chars().take(40).collect();
                        return Err(node.error(format!("the key '{shown}' stands here twice")));
                    }
                    open.key = Some(key);
                }
                Some(key) => entries.push((key, node)),
            },
            Content::Scalar(_) => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn values_have_their_lines() {
        let tree =
            parse("a: 1\nb: { c: [1, 2.5, -3e2], d: 'x y' }\nlist:\n- &n 7\n- *n\n- deep: yes\n").unwrap();
        assert_eq!(tree.needed("a").unwrap().number().unwrap(), 1.0);
        let b = tree.needed("b").unwrap();
        assert_eq!(b.needed("c").unwrap().numbers::<3>().unwrap(), [1.0, 2.5, -300.0]);
        assert_eq!(b.needed("d").unwrap().text().unwrap(), "x y");
        let list = tree.needed("list").unwrap().items().unwrap();
        assert_eq!((list[1].number().unwrap(), list[1].line), (7.0, 5));
        assert_eq!(list[2].needed("deep").unwrap().line, 6);
        assert_eq!(list[2].needed("no").unwrap_err().to_string(), "line 6: expected the key 'no'");
        assert!(parse("a:\n").unwrap().needed("a").unwrap().items().unwrap().is_empty());
    }

    #[test]
    fn hostile_files_are_errors() {
        assert!(message("a: [1, 2\nb: 3").starts_with("line "));
        assert_eq!(message("a: 1\na: 2\n"), "line 2: the key 'a' stands here twice");
        assert!(message("a: &x [*x]").contains("own anchor"));
        assert!(message("a: *unknown").starts_with("line 1"));
        assert!(message("").contains("empty"));
        assert!(message(&"[".repeat(200)).contains("deeper than 64"));
        assert!(message(&"[".repeat(100_000)).starts_with("line 1"));
        assert!(message(&format!("{}{}", "- ".repeat(1000), "1")).contains("deeper than 64"));
        let mut bomb = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n".to_owned();
        for level in 1..40 {
            let aliases = vec![format!("*a{}", level - 1); 10].join(",");
            bomb += &format!("a{level}: &a{level} [{aliases}]\n");
        }
        assert!(message(&bomb).contains("copies by aliases"));
        let tree = parse("a: .inf").unwrap();
        let error = tree.needed("a").unwrap().number().unwrap_err();
        assert_eq!(error.to_string(), "line 1: expected a number, found '.inf'");
    }

    proptest! {
        #[test]
        fn any_text_is_a_tree_or_an_error(text in "[a-c:&*{}\\[\\], \n\"'|>!%-]{0,80}") {
            let _ = parse(&text);
        }
    }
}
