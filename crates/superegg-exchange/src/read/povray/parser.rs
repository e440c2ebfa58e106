//! The walk through the tokens of a scene: blocks, directives and what is skipped.

use std::collections::HashMap;
use std::rc::Rc;

use superegg_geom::TransformStep;

use super::lexer::{Token, TokenKind};
use super::model::{Node, PovScene, Surface};
use super::value::Value;
use crate::read::error::ReadError;

/// The deepest nesting of blocks, expressions and declared objects.
pub(crate) const MOST_LEVELS: usize = 100;
/// The most tokens that are walked over, those of loops each time.
const MOST_STEPS: u64 = 20_000_000;
/// The most objects of a scene.
const MOST_NODES: usize = 2_000_000;
/// The most warnings that are kept.
const MOST_WARNINGS: usize = 50;
/// Files that declare what this reader knows or what has no effect on it.
const KNOWN_INCLUDES: [&str; 6] =
    ["colors.inc", "consts.inc", "math.inc", "transforms.inc", "shapes.inc", "functions.inc"];

/// Why a statement is skipped.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Trouble {
    pub(crate) line: u64,
    pub(crate) message: String,
    /// Whether the whole scene is given up.
    pub(crate) is_fatal: bool,
}

pub(crate) type Parsed<T> = Result<T, Trouble>;

/// The part of a surface that a block describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Pigment,
    Finish,
    Interior,
    Texture,
    Material,
}

/// The value of an identifier.
#[derive(Clone, Debug)]
pub(crate) enum Declared {
    Value(Value),
    Object(Rc<Node>),
    Surface(Part, Surface),
    Steps(Vec<TransformStep>),
    /// Something that is not read.
    Other,
}

/// An open `#if`, `#while` or `#for`.
#[derive(Clone, Debug)]
enum Frame {
    If,
    While { directive: usize },
    For { name: String, current: f64, last: f64, step: f64, body: usize },
}

/// The state of the walk.
pub(crate) struct Parser {
    tokens: Vec<Token>,
    pub(crate) position: usize,
    steps: u64,
    pub(crate) levels: usize,
    nodes: usize,
    frames: Vec<Frame>,
    pub(crate) declared: HashMap<String, Declared>,
    pub(crate) scene: PovScene,
    /// The factor of `ambient_light`.
    pub(crate) ambient_light: f64,
    /// Whether a value depends on the size of the picture.
    pub(crate) uses_picture_size: bool,
    warnings: Vec<String>,
    left_out: usize,
}

impl Parser {
    pub(crate) fn new(tokens: Vec<Token>) -> Self {
        Self {
            tokens,
            position: 0,
            steps: 0,
            levels: 0,
            nodes: 0,
            frames: Vec::new(),
            declared: HashMap::new(),
            scene: PovScene::default(),
            ambient_light: 1.0,
            uses_picture_size: false,
            warnings: Vec::new(),
            left_out: 0,
        }
    }

    /// Reads all statements.
    ///
    /// # Errors
    /// The scene has too many objects or its loops take too long.
    pub(crate) fn run(&mut self) -> Result<(), ReadError> {
        while self.position < self.tokens.len() {
            let start = self.position;
            self.levels = 0;
            if let Err(trouble) = self.statement() {
                if trouble.is_fatal {
                    return Err(ReadError::line(trouble.line, trouble.message));
                }
                self.warn(trouble.line, &trouble.message);
                self.pass_statement(start);
            }
        }
        Ok(())
    }

    /// The warnings, with their number if some are left out.
    pub(crate) fn take_warnings(&mut self) -> Vec<String> {
        let mut warnings = std::mem::take(&mut self.warnings);
        if self.left_out > 0 {
            warnings.push(format!("{} more warnings", self.left_out));
        }
        warnings
    }

    pub(crate) fn warn(&mut self, line: u64, message: &str) {
        let warning = format!("line {line}: {message}");
        // A loop repeats its warnings.
        if self.warnings.contains(&warning) {
            return;
        }
        if self.warnings.len() < MOST_WARNINGS {
            self.warnings.push(warning);
        } else {
            self.left_out += 1;
        }
    }

    /// The line of the next token, or of the last one.
    pub(crate) fn line(&self) -> u64 {
        self.tokens.get(self.position).or(self.tokens.last()).map_or(1, |token| token.line)
    }

    pub(crate) fn trouble<T>(&self, message: impl Into<String>) -> Parsed<T> {
        Err(Trouble { line: self.line(), message: message.into(), is_fatal: false })
    }

    pub(crate) fn kind(&self) -> Option<&TokenKind> {
        self.tokens.get(self.position).map(|token| &token.kind)
    }

    /// The next token, if it is a word.
    pub(crate) fn word(&self) -> Option<&str> {
        match self.kind() {
            Some(TokenKind::Word(word)) => Some(word),
            _ => None,
        }
    }

    pub(crate) fn is_symbol(&self, symbol: char) -> bool {
        self.kind() == Some(&TokenKind::Symbol(symbol))
    }

    /// Passes the next token.
    pub(crate) fn advance(&mut self) -> Parsed<()> {
        self.steps += 1;
        if self.steps > MOST_STEPS {
            let message = "the loops of the scene take too long".to_owned();
            return Err(Trouble { line: self.line(), message, is_fatal: true });
        }
        self.position += 1;
        Ok(())
    }

    /// Passes a symbol if it is next.
    pub(crate) fn accept(&mut self, symbol: char) -> Parsed<bool> {
        let is_next = self.is_symbol(symbol);
        if is_next {
            self.advance()?;
        }
        Ok(is_next)
    }

    pub(crate) fn expect(&mut self, symbol: char) -> Parsed<()> {
        if self.accept(symbol)? { Ok(()) } else { self.trouble(format!("expected '{symbol}'")) }
    }

    /// Passes a word if it is next.
    pub(crate) fn accept_word(&mut self, word: &str) -> Parsed<bool> {
        let is_next = self.word() == Some(word);
        if is_next {
            self.advance()?;
        }
        Ok(is_next)
    }

    /// Runs a part of the walk one level deeper.
    pub(crate) fn nested<T>(&mut self, part: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.levels == MOST_LEVELS {
            return self.trouble(format!("nested deeper than {MOST_LEVELS} levels"));
        }
        self.levels += 1;
        let result = part(self);
        self.levels -= 1;
        result
    }

    /// Reads a block: passes each item to `item`, and carries out directives between them.
    pub(crate) fn block(&mut self, item: &mut dyn FnMut(&mut Self) -> Parsed<()>) -> Parsed<()> {
        let open = self.position;
        self.expect('{')?;
        let close = self.tokens[open].close;
        self.nested(|parser| {
            while parser.position < close {
                if matches!(parser.kind(), Some(TokenKind::Directive(_))) {
                    parser.directive()?;
                } else {
                    item(parser)?;
                }
            }
            Ok(())
        })?;
        self.position = close;
        self.advance()
    }

    /// Passes a block whole.
    pub(crate) fn pass_block(&mut self) -> Parsed<()> {
        if self.is_symbol('{') {
            self.position = self.tokens[self.position].close;
            self.advance()?;
        }
        Ok(())
    }

    /// Passes a word that is not known with what belongs to it, and warns.
    pub(crate) fn pass_unknown(&mut self) -> Parsed<()> {
        let line = self.line();
        let Some(word) = self.word().map(str::to_owned) else { return self.advance() };
        let shown: String = word.chars().take(40).collect();
        self.warn(line, &format!("'{shown}' is not understood and left out"));
        self.advance()?;
        loop {
            match self.kind() {
                Some(TokenKind::Symbol('{')) => return self.pass_block(),
                None | Some(TokenKind::Word(_) | TokenKind::Directive(_) | TokenKind::Symbol('}')) => {
                    return Ok(());
                }
                Some(TokenKind::Number(_) | TokenKind::Text(_) | TokenKind::Symbol(_)) => self.advance()?,
            }
        }
    }

    /// Goes behind a statement that could not be read.
    fn pass_statement(&mut self, start: usize) {
        let mut at = start + 1;
        while let Some(token) = self.tokens.get(at) {
            match token.kind {
                TokenKind::Symbol('{') => {
                    at = token.close + 1;
                    break;
                }
                TokenKind::Directive(_) => break,
                TokenKind::Symbol(';') => {
                    at += 1;
                    break;
                }
                _ => at += 1,
            }
        }
        self.position = at;
    }

    fn statement(&mut self) -> Parsed<()> {
        match self.kind() {
            Some(TokenKind::Directive(_)) => self.directive(),
            Some(TokenKind::Word(word)) => {
                let word = word.clone();
                if self.scene_item(&word)? { Ok(()) } else { self.pass_unknown() }
            }
            _ => self.advance(),
        }
    }

    /// A new object, counted.
    pub(crate) fn node(&mut self, node: Node) -> Parsed<Rc<Node>> {
        self.nodes += 1;
        if self.nodes > MOST_NODES {
            let message = format!("the scene has more than {MOST_NODES} objects");
            return Err(Trouble { line: self.line(), message, is_fatal: true });
        }
        if node.levels > MOST_LEVELS {
            return self.trouble(format!("objects are nested deeper than {MOST_LEVELS} levels"));
        }
        Ok(Rc::new(node))
    }

    /// Carries out a directive.
    fn directive(&mut self) -> Parsed<()> {
        let at = self.position;
        let line = self.line();
        let Some(TokenKind::Directive(name)) = self.kind() else { return self.advance() };
        let name = name.clone();
        self.advance()?;
        match name.as_str() {
            "declare" | "local" => self.declare(),
            "undef" => {
                if let Some(word) = self.word().map(str::to_owned) {
                    self.declared.remove(&word);
                }
                self.advance()
            }
            "include" => self.include(line),
            "version" => {
                self.expression()?;
                self.accept(';').map(drop)
            }
            "default" => {
                self.warn(line, "'#default' is not read");
                self.pass_block()
            }
            "if" | "ifdef" | "ifndef" => match self.condition_of(&name) {
                Ok(is_true) => self.branch(is_true),
                Err(trouble) => {
                    self.pass_branch(false)?;
                    Err(trouble)
                }
            },
            "else" | "elseif" => {
                self.frames.pop();
                self.pass_branch(false).map(drop)
            }
            "while" => match self.condition_of("if") {
                Ok(true) => {
                    self.frames.push(Frame::While { directive: at });
                    Ok(())
                }
                Ok(false) => self.pass_branch(false).map(drop),
                Err(trouble) => {
                    self.pass_branch(false)?;
                    Err(trouble)
                }
            },
            "for" => self.begin_for(),
            "end" => self.end(),
            "macro" | "switch" => {
                self.warn(line, &format!("'#{name}' is not carried out"));
                self.pass_branch(false).map(drop)
            }
            "debug" | "warning" | "error" | "render" | "statistics" => {
                while matches!(self.kind(), Some(TokenKind::Text(_))) {
                    self.advance()?;
                }
                Ok(())
            }
            other => {
                let shown: String = other.chars().take(40).collect();
                self.warn(line, &format!("'#{shown}' is not read"));
                Ok(())
            }
        }
    }

    fn include(&mut self, line: u64) -> Parsed<()> {
        if let Some(TokenKind::Text(file)) = self.kind() {
            if !KNOWN_INCLUDES.contains(&file.as_str()) {
                let shown: String = file.chars().take(80).collect();
                self.warn(line, &format!("the file \"{shown}\" is not included"));
            }
            self.advance()?;
        }
        Ok(())
    }

    fn declare(&mut self) -> Parsed<()> {
        let Some(name) = self.word().map(str::to_owned) else { return self.trouble("expected a name") };
        self.advance()?;
        self.expect('=')?;
        match self.declared_value(&name) {
            Ok(value) => {
                self.declared.insert(name, value);
                self.accept(';').map(drop)
            }
            Err(trouble) => {
                // A declaration that is not understood still takes the name.
                self.declared.insert(name, Declared::Other);
                Err(trouble)
            }
        }
    }

    fn condition_of(&mut self, directive: &str) -> Parsed<bool> {
        self.expect('(')?;
        let is_true = match directive {
            "ifdef" | "ifndef" => {
                let is_declared = self.word().is_some_and(|word| self.declared.contains_key(word));
                self.advance()?;
                is_declared == (directive == "ifdef")
            }
            _ => self.condition()?.number() != 0.0,
        };
        self.expect(')')?;
        Ok(is_true)
    }

    /// Enters or passes the branch of an `#if`.
    fn branch(&mut self, is_true: bool) -> Parsed<()> {
        if is_true {
            self.frames.push(Frame::If);
            return Ok(());
        }
        // The branch after it, unless the `#if` ends without one.
        while self.pass_branch(true)? {
            let Some(TokenKind::Directive(name)) = self.kind() else { break };
            let is_else = name == "else";
            self.advance()?;
            if is_else || self.condition_of("if")? {
                self.frames.push(Frame::If);
                break;
            }
        }
        Ok(())
    }

    /// Goes behind the `#end` of the innermost open directive; with `stops_at_else` to its `#else` or
    /// `#elseif`, and returns whether it stands there.
    fn pass_branch(&mut self, stops_at_else: bool) -> Parsed<bool> {
        let mut depth = 0_usize;
        while let Some(kind) = self.kind() {
            if let TokenKind::Directive(name) = kind {
                match name.as_str() {
                    "if" | "ifdef" | "ifndef" | "while" | "for" | "switch" | "macro" => depth += 1,
                    "else" | "elseif" if depth == 0 && stops_at_else => return Ok(true),
                    "end" if depth == 0 => {
                        self.advance()?;
                        return Ok(false);
                    }
                    "end" => depth -= 1,
                    _ => {}
                }
            }
            self.advance()?;
        }
        Ok(false)
    }

    fn begin_for(&mut self) -> Parsed<()> {
        self.expect('(')?;
        let Some(name) = self.word().map(str::to_owned) else { return self.trouble("expected a name") };
        self.advance()?;
        let mut numbers = Vec::new();
        while self.accept(',')? {
            numbers.push(self.expression()?.number());
        }
        self.expect(')')?;
        let (current, last, step) = match numbers[..] {
            [current, last] => (current, last, 1.0),
            [current, last, step] if step != 0.0 => (current, last, step),
            _ => return self.trouble("expected '#for (name, first, last, step)'"),
        };
        let body = self.position;
        self.frames.push(Frame::For { name, current: current - step, last, step, body });
        self.end()
    }

    /// Carries out `#end`: leaves an `#if`, or begins the next turn of a loop.
    fn end(&mut self) -> Parsed<()> {
        match self.frames.pop() {
            None | Some(Frame::If) => Ok(()),
            Some(Frame::While { directive }) => {
                self.position = directive;
                Ok(())
            }
            Some(Frame::For { name, current, last, step, body }) => {
                let next = current + step;
                self.position = body;
                self.advance_turn()?;
                // Rounding may not take the last turn away.
                let slack = 1e-10 * step.abs();
                if (step > 0.0 && next <= last + slack) || (step < 0.0 && next >= last - slack) {
                    self.declared.insert(name.clone(), Declared::Value(Value::Number(next)));
                    self.frames.push(Frame::For { name, current: next, last, step, body });
                    Ok(())
                } else {
                    self.pass_branch(false).map(drop)
                }
            }
        }
    }

    /// Counts a turn of a loop, which may have no tokens.
    fn advance_turn(&mut self) -> Parsed<()> {
        self.advance()?;
        self.position -= 1;
        Ok(())
    }
}
