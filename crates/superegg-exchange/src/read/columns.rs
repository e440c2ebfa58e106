//! Further columns of a file, chosen by name.

use super::error::ReadError;
use super::options::ReadOptions;

/// The further columns that the options ask for, out of those that a file has.
///
/// # Errors
/// A name is none of the columns.
pub(crate) fn extra_columns(
    available: Vec<(String, Vec<f64>)>,
    options: &ReadOptions,
) -> Result<Vec<(String, Vec<f64>)>, ReadError> {
    for wanted in &options.extra {
        if !available.iter().any(|(name, _)| name == wanted) {
            let names: Vec<&str> = available.iter().map(|(name, _)| name.as_str()).collect();
            let has = match names.is_empty() {
                true => "the file has no further columns".to_owned(),
                false => format!("the file has: {}", names.join(", ")),
            };
            return Err(ReadError::part(wanted.as_str(), format!("there is no such column; {has}")));
        }
    }
    let is_kept = |name: &String| options.all_extra || options.extra.contains(name);
    Ok(available.into_iter().filter(|(name, _)| is_kept(name)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_columns_are_errors() {
        let available = || vec![("a".to_owned(), vec![1.0]), ("b".to_owned(), vec![2.0])];
        let asked = |extra: &[&str]| ReadOptions {
            extra: extra.iter().map(|name| (*name).to_owned()).collect(),
            ..ReadOptions::default()
        };
        assert_eq!(extra_columns(available(), &asked(&["b"])).unwrap(), [available().remove(1)]);
        let message = extra_columns(available(), &asked(&["c"])).unwrap_err().to_string();
        assert_eq!(message, "'c': there is no such column; the file has: a, b");
        let all = ReadOptions { all_extra: true, ..ReadOptions::default() };
        assert_eq!(extra_columns(available(), &all).unwrap(), available());
    }
}
