//! The program `superegg`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(superegg_cli::run(std::env::args_os()))
}
