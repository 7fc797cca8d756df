//! `encspec control`: sends one command to the control channel of a served device.

use super::{CommandError, CommandResult, show};
use clap::Args;
use link::lines::LineClient;
use live::control::StandAnswer;
use report::ExitStatus;
use std::path::PathBuf;
use std::time::Duration;

/// How long to wait for an answer; the same as in a run.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);

/// Arguments of `encspec control`.
#[derive(Debug, Args)]
pub(super) struct ControlArgs {
    /// Unix socket that `encspec serve --control PATH` created
    #[arg(value_name = "PATH")]
    path: PathBuf,
    /// Command, for instance `shaft speed 60`; `help` lists all commands
    #[arg(value_name = "COMMAND", required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    command: Vec<String>,
}

pub(super) fn run(args: &ControlArgs) -> CommandResult {
    let broken = |error: link::LinkError| CommandError::bench(error.to_string());
    let mut client = LineClient::connect(&args.path).map_err(broken)?;
    let line = client.request(&args.command.join(" "), ANSWER_TIMEOUT).map_err(broken)?;
    let answer = StandAnswer::parse(&line).map_err(CommandError::bench)?;
    Ok(match answer {
        StandAnswer::Done(_) => {
            show(&format!("{line}\n"));
            ExitStatus::Green
        }
        // `help` and `abilities` are lists.
        StandAnswer::Word(words) => {
            show(&format!("{}\n", words.replace("; ", "\n")));
            ExitStatus::Green
        }
        StandAnswer::Cannot(_) | StandAnswer::Broken(_) => {
            show(&format!("{line}\n"));
            ExitStatus::Red
        }
    })
}
