//! The program: everything is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    torquescope::cli::run(std::env::args_os())
}
