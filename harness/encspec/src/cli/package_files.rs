//! `encspec man` and `encspec completions`: files that packages install, made of the command line itself.

use super::{Cli, CommandError, CommandResult, show};
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use report::ExitStatus;
use std::fs;
use std::path::PathBuf;

/// Arguments of `encspec man`.
#[derive(Debug, Args)]
pub(super) struct ManArgs {
    /// The folder for the pages, one for each command; it is created
    folder: PathBuf,
}

/// Arguments of `encspec completions`.
#[derive(Debug, Args)]
pub(super) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

pub(super) fn man(args: &ManArgs) -> CommandResult {
    let written =
        fs::create_dir_all(&args.folder).and_then(|()| clap_mangen::generate_to(Cli::command(), &args.folder));
    written.map_err(|error| CommandError::usage(format!("{}: {error}", args.folder.display())))?;
    Ok(ExitStatus::Green)
}

pub(super) fn completions(args: &CompletionsArgs) -> CommandResult {
    let mut text = Vec::new();
    generate(args.shell, &mut Cli::command(), "encspec", &mut text);
    show(&String::from_utf8_lossy(&text));
    Ok(ExitStatus::Green)
}
