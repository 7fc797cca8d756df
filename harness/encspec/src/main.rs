//! The binary `encspec`; everything it does is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    encspec::cli::main()
}
