//! The binary `encspec`. All of its code is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    encspec::cli::main()
}
