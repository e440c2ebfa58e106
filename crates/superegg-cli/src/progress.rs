//! The progress of renders and of long searches.

use std::fmt::Write;

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// A bar of pixels on standard error, with `detail` before the times; hidden where that is no
/// terminal.
pub(crate) fn progress_bar(pixels: u64, quiet: bool, detail: &str) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let template = format!("{{bar:40}} {{percent:>3}} %  {detail}, {{elapsed}} elapsed, {{eta}} left");
    let style = ProgressStyle::with_template(&template);
    ProgressBar::with_draw_target(Some(pixels), target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).with_key("rate", rate))
}

/// A line on standard error for work whose extent is not known; hidden where that is no terminal.
pub(crate) fn spinner(quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let style =
        ProgressStyle::with_template("{spinner} {msg}, {elapsed} elapsed; ctrl-c keeps what is there");
    ProgressBar::with_draw_target(None, target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
}

/// Writes the rate with three significant digits: "12,300 pixels/s".
fn rate(state: &ProgressState, out: &mut dyn Write) {
    let rate = state.per_sec();
    let step = 10f64.powf((rate.max(1.0).log10().floor() - 2.0).max(0.0));
    let rounded = ((rate / step).round() * step) as u64;
    // A terminal that cannot be written to shows no bar.
    let _ = write!(out, "{} pixels/s", HumanCount(rounded));
}
