//! Numbers, vectors and colours.

use crate::srgb::linear_of_srgb;
use superegg_geom::glam::DVec3;

use super::lexer::TokenKind;
use super::parser::{Declared, Parsed, Parser};
use super::value::{Value, named_color};

/// The size of the picture that scenes may ask for.
const PICTURE_SIZE: [f64; 2] = [1280.0, 960.0];

impl Parser {
    /// A value of a condition: comparisons joined by `&` and `|`.
    pub(crate) fn condition(&mut self) -> Parsed<Value> {
        let mut value = self.comparison()?;
        loop {
            let is_and = self.is_symbol('&');
            if !is_and && !self.is_symbol('|') {
                return Ok(value);
            }
            self.advance()?;
            let other = self.comparison()?;
            let truth = |value: Value| value.number() != 0.0;
            let joined = if is_and { truth(value) && truth(other) } else { truth(value) || truth(other) };
            value = Value::Number(f64::from(u8::from(joined)));
        }
    }

    fn comparison(&mut self) -> Parsed<Value> {
        let left = self.expression()?;
        let Some(&TokenKind::Symbol(first @ ('<' | '>' | '=' | '!'))) = self.kind() else { return Ok(left) };
        self.advance()?;
        let or_equal = self.accept('=')?;
        let (a, b) = (left.number(), self.expression()?.number());
        let is_true = match (first, or_equal) {
            ('<', false) => a < b,
            ('<', true) => a <= b,
            ('>', false) => a > b,
            ('>', true) => a >= b,
            ('!', _) => a != b,
            _ => a == b,
        };
        Ok(Value::Number(f64::from(u8::from(is_true))))
    }

    /// Sums of products.
    pub(crate) fn expression(&mut self) -> Parsed<Value> {
        let mut value = self.product()?;
        loop {
            if self.accept('+')? {
                value = value.with(self.product()?, |a, b| a + b);
            } else if self.accept('-')? {
                value = value.with(self.product()?, |a, b| a - b);
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> Parsed<Value> {
        let mut value = self.factor()?;
        loop {
            if self.accept('*')? {
                value = value.with(self.factor()?, |a, b| a * b);
            } else if self.accept('/')? {
                value = value.with(self.factor()?, |a, b| a / b);
            } else {
                return Ok(value);
            }
        }
    }

    fn factor(&mut self) -> Parsed<Value> {
        let mut value = self.nested(|parser| {
            if parser.accept('-')? {
                return Ok(Value::Number(0.0).with(parser.factor()?, |a, b| a - b));
            }
            if parser.accept('+')? {
                return parser.factor();
            }
            if parser.accept('!')? {
                let is_false = parser.factor()?.number() == 0.0;
                return Ok(Value::Number(f64::from(u8::from(is_false))));
            }
            parser.primary()
        })?;
        while self.is_symbol('.') {
            self.advance()?;
            let component = self.word().and_then(|name| value.component(name));
            let Some(component) = component else { return self.trouble("expected a component such as x") };
            self.advance()?;
            value = Value::Number(component);
        }
        Ok(value)
    }

    fn primary(&mut self) -> Parsed<Value> {
        match self.kind().cloned() {
            Some(TokenKind::Number(number)) => {
                self.advance()?;
                Ok(Value::Number(number))
            }
            Some(TokenKind::Symbol('(')) => {
                self.advance()?;
                let value = self.condition()?;
                self.expect(')')?;
                Ok(value)
            }
            Some(TokenKind::Symbol('<')) => self.vector(),
            Some(TokenKind::Word(word)) => {
                let Some(value) = self.word_value(&word)? else {
                    let shown: String = word.chars().take(40).collect();
                    return self.trouble(format!("'{shown}' has no value that is understood"));
                };
                Ok(value)
            }
            _ => self.trouble("expected a value"),
        }
    }

    fn vector(&mut self) -> Parsed<Value> {
        let found = self.elements()?;
        if !(2..=5).contains(&found.len()) {
            return self.trouble(format!("expected a vector of 2 to 5 numbers, found {}", found.len()));
        }
        let mut numbers = [0.0; 5];
        numbers[..found.len()].copy_from_slice(&found);
        Ok(Value::Vector { numbers, length: found.len() })
    }

    /// The numbers between '<' and '>'.
    pub(crate) fn elements(&mut self) -> Parsed<Vec<f64>> {
        self.expect('<')?;
        let mut numbers = Vec::new();
        while !self.accept('>')? {
            numbers.push(self.expression()?.number());
            self.accept(',')?;
        }
        Ok(numbers)
    }

    /// The value of a word, which is passed; `None`, and the word stays, if it has none.
    fn word_value(&mut self, word: &str) -> Parsed<Option<Value>> {
        let constant = match word {
            "x" | "u" => Some(Value::vector(DVec3::X)),
            "y" | "v" => Some(Value::vector(DVec3::Y)),
            "z" => Some(Value::vector(DVec3::Z)),
            "pi" => Some(Value::Number(std::f64::consts::PI)),
            "on" | "yes" | "true" => Some(Value::Number(1.0)),
            "off" | "no" | "false" | "clock" | "frame_number" => Some(Value::Number(0.0)),
            "version" => Some(Value::Number(3.7)),
            "image_width" | "image_height" => {
                self.uses_picture_size = true;
                Some(Value::Number(PICTURE_SIZE[usize::from(word == "image_height")]))
            }
            _ => None,
        };
        if let Some(value) = constant {
            self.advance()?;
            return Ok(Some(value));
        }
        match self.declared.get(word) {
            Some(Declared::Value(value)) => {
                let value = *value;
                self.advance()?;
                return Ok(Some(value));
            }
            Some(_) => return Ok(None),
            None => {}
        }
        if is_color_word(word) {
            return self.color().map(Some);
        }
        if let Some(value) = named_color(word) {
            self.advance()?;
            return Ok(Some(value));
        }
        self.function(word)
    }

    /// A call of a function; `None`, and the word stays, if it is not known.
    fn function(&mut self, word: &str) -> Parsed<Option<Value>> {
        let arguments = match word {
            "sin" | "cos" | "tan" | "asin" | "acos" | "atan" | "sqrt" | "exp" | "ln" | "log" | "abs"
            | "int" | "floor" | "ceil" | "radians" | "degrees" | "vlength" | "vnormalize" => 1..=1,
            "atan2" | "pow" | "mod" | "vdot" | "vcross" => 2..=2,
            "min" | "max" => 1..=64,
            _ => return Ok(None),
        };
        self.advance()?;
        self.expect('(')?;
        let mut values = Vec::new();
        while !self.accept(')')? {
            values.push(self.expression()?);
            self.accept(',')?;
            if values.len() > *arguments.end() {
                break;
            }
        }
        if !arguments.contains(&values.len()) {
            return self.trouble(format!("'{word}' has another number of arguments"));
        }
        let (first, last) = (values[0], values[values.len() - 1]);
        let (a, b) = (first.number(), last.number());
        let number = match word {
            "sin" => a.sin(),
            "cos" => a.cos(),
            "tan" => a.tan(),
            "asin" => a.asin(),
            "acos" => a.acos(),
            "atan" => a.atan(),
            "atan2" => a.atan2(b),
            "sqrt" => a.sqrt(),
            "exp" => a.exp(),
            "ln" => a.ln(),
            "log" => a.log10(),
            "abs" => a.abs(),
            "int" => a.trunc(),
            "floor" => a.floor(),
            "ceil" => a.ceil(),
            "radians" => a.to_radians(),
            "degrees" => a.to_degrees(),
            "pow" => a.powf(b),
            "mod" => a % b,
            "min" => values.iter().map(|value| value.number()).fold(f64::INFINITY, f64::min),
            "max" => values.iter().map(|value| value.number()).fold(f64::NEG_INFINITY, f64::max),
            "vlength" => first.three().length(),
            "vdot" => first.three().dot(last.three()),
            "vcross" => return Ok(Some(Value::vector(first.three().cross(last.three())))),
            _ => return Ok(Some(Value::vector(first.three().normalize_or_zero()))),
        };
        Ok(Some(Value::Number(number)))
    }

    /// A colour: red, green, blue, filter and transmit, in linear values.
    pub(crate) fn color(&mut self) -> Parsed<Value> {
        let mut color = [0.0; 5];
        let mut is_given = false;
        while let Some(word) = self.word().map(str::to_owned) {
            let channel = match word.as_str() {
                "red" => Some(0),
                "green" => Some(1),
                "blue" => Some(2),
                "filter" => Some(3),
                "transmit" => Some(4),
                _ => None,
            };
            if let Some(channel) = channel {
                self.advance()?;
                color[channel] = self.expression()?.number();
            } else if matches!(word.as_str(), "color" | "colour") && !is_given {
                self.advance()?;
                continue;
            } else if !is_given && is_color_word(&word) {
                self.advance()?;
                let (is_srgb, kind) =
                    word.strip_prefix('s').map_or((false, word.as_str()), |kind| (true, kind));
                color = arranged(self.expression()?, kind);
                if is_srgb {
                    color[..3].iter_mut().for_each(|channel| *channel = linear_of_srgb(*channel));
                }
            } else if is_given {
                break;
            } else {
                color = self.expression()?.five();
            }
            is_given = true;
        }
        if !is_given {
            color = self.expression()?.five();
        }
        Ok(Value::Vector { numbers: color, length: 5 })
    }
}

/// Whether a word begins a colour.
pub(crate) fn is_color_word(word: &str) -> bool {
    matches!(
        word,
        "color"
            | "colour"
            | "rgb"
            | "rgbf"
            | "rgbt"
            | "rgbft"
            | "srgb"
            | "srgbf"
            | "srgbt"
            | "srgbft"
            | "red"
            | "green"
            | "blue"
    )
}

/// The channels of the value after 'rgb', 'rgbf', 'rgbt' or 'rgbft'.
fn arranged(value: Value, kind: &str) -> [f64; 5] {
    let [red, green, blue, fourth, fifth] = value.five();
    let (filter, transmit) = match kind {
        "rgbf" => (fourth, 0.0),
        "rgbt" => (0.0, fourth),
        "rgbft" => (fourth, fifth),
        // A fourth and fifth number after 'rgb' count; a single number is grey without them.
        _ => match value {
            Value::Number(_) => (0.0, 0.0),
            Value::Vector { .. } => (fourth, fifth),
        },
    };
    [red, green, blue, filter, transmit]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::povray::lexer::tokens;

    fn value(text: &str) -> Value {
        let mut parser = Parser::new(tokens(text).unwrap());
        let value = parser.condition().unwrap_or_else(|trouble| panic!("{trouble:?}"));
        assert!(parser.kind().is_none(), "{text}");
        value
    }

    #[test]
    fn expressions_have_their_order() {
        for (text, expected) in [
            ("1 + 2 * 3 - 4 / 2", 5.0),
            ("-2 * -(3 + 1)", 8.0),
            ("<1, 2, 3>.y + (x * 4).x", 6.0),
            ("sin(pi / 2) + max(1, 7, 3) + int(-2.5)", 6.0),
            ("(1 < 2) & (3 >= 3) & !(1 = 2)", 1.0),
            ("vlength(vcross(x, y) * 3)", 3.0),
            ("image_width / image_height", 4.0 / 3.0),
        ] {
            assert_eq!(value(text).number(), expected, "{text}");
        }
        assert_eq!(value("<1, 2> + 1").five()[..2], [2.0, 3.0]);
        assert_eq!(value("2 * y - z").three(), DVec3::new(0.0, 2.0, -1.0));
    }

    #[test]
    fn colours_have_many_forms() {
        for (text, expected) in [
            ("rgb <1, 0.5, 0>", [1.0, 0.5, 0.0, 0.0, 0.0]),
            ("color rgb 0.25", [0.25, 0.25, 0.25, 0.0, 0.0]),
            ("rgbf <1, 2, 3, 0.5>", [1.0, 2.0, 3.0, 0.5, 0.0]),
            ("rgbt <1, 2, 3, 0.5>", [1.0, 2.0, 3.0, 0.0, 0.5]),
            ("color Red filter 0.25", [1.0, 0.0, 0.0, 0.25, 0.0]),
            ("color red 0.5 blue 1", [0.5, 0.0, 1.0, 0.0, 0.0]),
            ("White * 0.5", [0.5, 0.5, 0.5, 0.0, 0.0]),
            ("srgb <1, 0, 0.04045>", [1.0, 0.0, 0.04045 / 12.92, 0.0, 0.0]),
        ] {
            assert_eq!(value(text).five(), expected, "{text}");
        }
    }

    #[test]
    fn what_has_no_value_is_an_error() {
        for text in ["rand(S)", "<1>", "<1, 2", "1 +", "sin(1, 2)", "x.w", "", "pow(1)"] {
            let mut parser = Parser::new(tokens(text).unwrap());
            assert!(parser.condition().is_err(), "{text}");
        }
        for text in ["(", "-", "<", "rgb ", "sin("] {
            let mut parser = Parser::new(tokens(&text.repeat(100_000)).unwrap());
            assert!(parser.condition().unwrap_err().message.contains("levels"), "{text}");
        }
    }
}
