//! Dictionaries in JSON files, wherever in the file they lie.

use serde_json::{Map, Value};

use crate::read::error::ReadError;

/// Parses a file. Nesting is bounded by the parser.
///
/// # Errors
/// The text is no JSON; the error names the line.
pub(crate) fn parse(bytes: &[u8]) -> Result<Value, ReadError> {
    serde_json::from_slice(bytes)
        .map_err(|error| ReadError::line(error.line() as u64, format!("the JSON cannot be read: {error}")))
}

/// A dictionary and where it lies in its file: `.fit` or `[3]`.
#[derive(Debug)]
pub(crate) struct Found<'a> {
    pub(crate) path: String,
    pub(crate) map: &'a Map<String, Value>,
}

/// The outermost dictionaries that have all these keys, in the order of the file.
pub(crate) fn with_keys<'a>(value: &'a Value, keys: &[&str]) -> Vec<Found<'a>> {
    let mut found = Vec::new();
    collect(value, keys, &mut String::new(), &mut found);
    found
}

fn collect<'a>(value: &'a Value, keys: &[&str], path: &mut String, found: &mut Vec<Found<'a>>) {
    let length = path.len();
    match value {
        Value::Object(map) if keys.iter().all(|key| map.contains_key(*key)) => {
            found.push(Found { path: path.clone(), map });
        }
        Value::Object(map) => {
            for (key, value) in map {
                path.push('.');
                path.extend(key.chars().take(40));
                collect(value, keys, path, found);
                path.truncate(length);
            }
        }
        // Long lists of numbers hold no dictionary.
        Value::Array(values) if values.first().is_some_and(|first| first.is_object() || first.is_array()) => {
            for (index, value) in values.iter().enumerate() {
                path.push_str(&format!("[{index}]"));
                collect(value, keys, path, found);
                path.truncate(length);
            }
        }
        _ => {}
    }
}

/// The number of a key, or an error that names it.
pub(crate) fn number(found: &Found<'_>, key: &str) -> Result<f64, ReadError> {
    found
        .map
        .get(key)
        .and_then(Value::as_f64)
        .ok_or_else(|| ReadError::part(format!("{}.{key}", found.path), "expected a number"))
}

/// All numbers below a key, in order; empty if there is no such key.
pub(crate) fn numbers(found: &Found<'_>, key: &str) -> Result<Vec<f64>, ReadError> {
    let mut numbers = Vec::new();
    let mut waiting: Vec<&Value> = found.map.get(key).into_iter().collect();
    while let Some(value) = waiting.pop() {
        match value {
            Value::Array(values) => waiting.extend(values.iter().rev()),
            other => numbers.push(
                other
                    .as_f64()
                    .ok_or_else(|| ReadError::part(format!("{}.{key}", found.path), "expected numbers"))?,
            ),
        }
    }
    Ok(numbers)
}

/// Whether a text begins a JSON file that has this key within its first bytes.
pub(crate) fn has_key(head: &[u8], key: &str) -> bool {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let starts = head.trim_ascii_start().first().is_some_and(|first| matches!(first, b'{' | b'['));
    let quoted = format!("\"{key}\"");
    starts && head.windows(quoted.len()).any(|window| window == quoted.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dictionaries_are_found_where_they_lie() {
        let value = parse(br#"{"a": [1, 2], "fit": {"x": 1, "y": [[2, 3], 4]}, "list": [{"x": 5, "y": 6}]}"#)
            .unwrap();
        let found = with_keys(&value, &["x", "y"]);
        let paths: Vec<&str> = found.iter().map(|found| found.path.as_str()).collect();
        assert_eq!(paths, [".fit", ".list[0]"]);
        assert_eq!(numbers(&found[0], "y").unwrap(), [2.0, 3.0, 4.0]);
        assert_eq!(number(&found[1], "x").unwrap(), 5.0);
        assert_eq!(number(&found[0], "y").unwrap_err().to_string(), "'.fit.y': expected a number");
        assert!(numbers(&found[0], "z").unwrap().is_empty());
    }

    #[test]
    fn errors_name_the_line_and_nesting_is_bounded() {
        assert!(parse(b"{\n\"a\": NaN}").unwrap_err().to_string().starts_with("line 2: "));
        assert!(parse("[".repeat(100_000).as_bytes()).is_err());
        assert!(has_key(b" \n{\"eps1\": 1", "eps1"));
        assert!(!has_key(b"eps1 \"eps1\"", "eps1"));
    }
}
