//! Tokens of POV-Ray's language.

use crate::read::error::ReadError;

/// A token with its line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Token {
    pub(crate) line: u64,
    pub(crate) kind: TokenKind,
    /// The position of the closing brace, if this is an opening one.
    pub(crate) close: usize,
}

/// The content of a token.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TokenKind {
    Number(f64),
    /// A keyword or identifier.
    Word(String),
    Text(String),
    /// A directive without its '#': "declare".
    Directive(String),
    Symbol(char),
}

/// The most tokens of a file.
const MOST_TOKENS: usize = 50_000_000;

/// Splits a scene into tokens, and pairs its braces. Comments are left out; block comments nest.
///
/// # Errors
/// A comment or text has no end, a brace has no partner, or there are too many tokens.
pub(crate) fn tokens(text: &str) -> Result<Vec<Token>, ReadError> {
    let mut lexer = Lexer { rest: text, line: 1 };
    let mut tokens: Vec<Token> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    while let Some((line, kind)) = lexer.next()? {
        if tokens.len() == MOST_TOKENS {
            return Err(ReadError::line(line, format!("the scene has more than {MOST_TOKENS} words")));
        }
        match kind {
            TokenKind::Symbol('{') => open.push(tokens.len()),
            TokenKind::Symbol('}') => {
                let Some(first) = open.pop() else {
                    return Err(ReadError::line(line, "this '}' closes nothing"));
                };
                tokens[first].close = tokens.len();
            }
            _ => {}
        }
        tokens.push(Token { line, kind, close: 0 });
    }
    match open.last() {
        Some(&first) => Err(ReadError::line(tokens[first].line, "this '{' is not closed")),
        None => Ok(tokens),
    }
}

struct Lexer<'a> {
    rest: &'a str,
    line: u64,
}

impl<'a> Lexer<'a> {
    /// Takes this many bytes.
    fn take(&mut self, bytes: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(bytes);
        self.line += taken.bytes().filter(|byte| *byte == b'\n').count() as u64;
        self.rest = rest;
        taken
    }

    /// Takes characters as long as they fulfil a condition.
    fn take_while(&mut self, is_wanted: impl Fn(char) -> bool) -> &'a str {
        self.take(self.rest.find(|c| !is_wanted(c)).unwrap_or(self.rest.len()))
    }

    fn next(&mut self) -> Result<Option<(u64, TokenKind)>, ReadError> {
        self.pass_blanks()?;
        let Some(first) = self.rest.chars().next() else { return Ok(None) };
        let line = self.line;
        let second = self.rest.chars().nth(1);
        let is_number =
            first.is_ascii_digit() || (first == '.' && second.is_some_and(|c| c.is_ascii_digit()));
        let kind = if is_number {
            self.number()
        } else if is_word(first) {
            TokenKind::Word(self.take_while(is_word).to_owned())
        } else if first == '"' {
            self.text()?
        } else if first == '#' {
            self.take(1);
            self.take_while(|c| c == ' ' || c == '\t');
            TokenKind::Directive(self.take_while(is_word).to_owned())
        } else {
            self.take(first.len_utf8());
            TokenKind::Symbol(first)
        };
        Ok(Some((line, kind)))
    }

    fn pass_blanks(&mut self) -> Result<(), ReadError> {
        loop {
            self.take_while(char::is_whitespace);
            if self.rest.starts_with("//") {
                self.take_while(|c| c != '\n');
            } else if self.rest.starts_with("/*") {
                self.block_comment()?;
            } else {
                return Ok(());
            }
        }
    }

    fn block_comment(&mut self) -> Result<(), ReadError> {
        let line = self.line;
        let mut depth = 0_usize;
        loop {
            self.take_while(|c| c != '/' && c != '*');
            if self.rest.starts_with("/*") {
                self.take(2);
                depth += 1;
            } else if self.rest.starts_with("*/") {
                self.take(2);
                depth -= 1;
                if depth == 0 {
                    return Ok(());
                }
            } else if self.rest.is_empty() {
                return Err(ReadError::line(line, "this comment has no end"));
            } else {
                self.take(1);
            }
        }
    }

    fn number(&mut self) -> TokenKind {
        let bytes = self.rest.as_bytes();
        let digits = |mut at: usize| {
            while bytes.get(at).is_some_and(u8::is_ascii_digit) {
                at += 1;
            }
            at
        };
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') {
            end = digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let after = digits(end + 1 + sign);
            if after > end + 1 + sign {
                end = after;
            }
        }
        // Digits with a point and an exponent are a number.
        TokenKind::Number(self.take(end).parse().unwrap_or(f64::NAN))
    }

    fn text(&mut self) -> Result<TokenKind, ReadError> {
        let line = self.line;
        self.take(1);
        let mut is_escaped = false;
        let end = self.rest.find(|c| {
            let is_end = c == '"' && !is_escaped;
            is_escaped = c == '\\' && !is_escaped;
            is_end
        });
        let Some(end) = end else { return Err(ReadError::line(line, "this text has no end")) };
        let text = self.take(end).to_owned();
        self.take(1);
        Ok(TokenKind::Text(text))
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_nest_and_braces_pair() {
        let text = "// {\n/* a /* } */ b */ sphere { 1.5e2, .5 \"a\\\"}\" }\n#declare A=-2;";
        let tokens = tokens(text).unwrap();
        let kinds: Vec<TokenKind> = tokens.iter().map(|token| token.kind.clone()).collect();
        let word = |text: &str| TokenKind::Word(text.to_owned());
        let expected = [
            word("sphere"),
            TokenKind::Symbol('{'),
            TokenKind::Number(150.0),
            TokenKind::Symbol(','),
            TokenKind::Number(0.5),
            TokenKind::Text("a\\\"}".to_owned()),
            TokenKind::Symbol('}'),
            TokenKind::Directive("declare".to_owned()),
            word("A"),
            TokenKind::Symbol('='),
            TokenKind::Symbol('-'),
            TokenKind::Number(2.0),
            TokenKind::Symbol(';'),
        ];
        assert_eq!(kinds, expected);
        assert_eq!((tokens[1].close, tokens[1].line, tokens[7].line), (6, 2, 3));
    }

    #[test]
    fn what_has_no_end_is_an_error() {
        let message = |text: &str| tokens(text).unwrap_err().to_string();
        assert_eq!(message("\n/* /* */"), "line 2: this comment has no end");
        assert_eq!(message("\n\"a"), "line 2: this text has no end");
        assert_eq!(message("a {\n{}"), "line 1: this '{' is not closed");
        assert_eq!(message("a }"), "line 1: this '}' closes nothing");
    }
}
