//! The argument `--color`. It is found before all arguments are parsed, because their errors have
//! colours, too.

use std::ffi::{OsStr, OsString};

use clap::ValueEnum;

use crate::system::terminal::has_cursor;

/// When messages have colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ColorArg {
    /// At a terminal that shows them
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// The name of the argument.
const NAME: &str = "--color";

impl ColorArg {
    /// The value among these arguments; the default one if it is missing or wrong.
    pub(crate) fn among(args: &[OsString]) -> Self {
        let found = args.iter().zip(args.iter().skip(1).map(Some).chain([None])).find_map(|(word, next)| {
            let word = word.to_str()?;
            if word == NAME { next?.to_str() } else { word.strip_prefix(NAME)?.strip_prefix('=') }
        });
        found.and_then(|word| Self::from_str(word, true).ok()).unwrap_or_default()
    }

    /// The arguments except this one.
    pub(crate) fn without(args: &[OsString]) -> impl Iterator<Item = &OsString> {
        let mut is_value = false;
        args.iter().filter(move |word| {
            let is_name = *word == OsStr::new(NAME);
            let is_both = word.to_str().is_some_and(|word| word.starts_with("--color="));
            !std::mem::replace(&mut is_value, is_name) && !is_name && !is_both
        })
    }

    /// Makes this the choice for all output of the process.
    pub(crate) fn choose(self) {
        match self {
            // By the environment: NO_COLOR, CLICOLOR, CLICOLOR_FORCE and TERM. A plain terminal stays plain where
            // CI is set, too, which stands for colours in the library.
            Self::Auto if !has_cursor() && !is_forced() => anstream::ColorChoice::Never,
            Self::Auto => anstream::ColorChoice::Auto,
            Self::Always => anstream::ColorChoice::Always,
            Self::Never => anstream::ColorChoice::Never,
        }
        .write_global();
    }
}

/// Whether the environment wants colours, whatever the output is.
fn is_forced() -> bool {
    std::env::var_os("CLICOLOR_FORCE").is_some_and(|value| value != "0")
}

impl From<ColorArg> for clap::ColorChoice {
    fn from(arg: ColorArg) -> Self {
        match arg {
            ColorArg::Auto => Self::Auto,
            ColorArg::Always => Self::Always,
            ColorArg::Never => Self::Never,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_found_anywhere() {
        for (words, color, first) in [
            ("superegg", ColorArg::Auto, None),
            ("superegg --color never rendr s", ColorArg::Never, Some("rendr")),
            ("superegg --color=always rendr s", ColorArg::Always, Some("rendr")),
            ("superegg render s --color never", ColorArg::Never, Some("render")),
            ("superegg render s --color", ColorArg::Auto, Some("render")),
            ("superegg render s --color pink", ColorArg::Auto, Some("render")),
        ] {
            let args: Vec<OsString> = words.split(' ').map(OsString::from).collect();
            assert_eq!(ColorArg::among(&args), color, "{words}");
            assert_eq!(ColorArg::without(&args).nth(1).and_then(|word| word.to_str()), first, "{words}");
        }
    }
}
