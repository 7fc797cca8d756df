//! `encspec bench`: creates bench files from discovered devices; [`restore`] restores a device after an interrupted run.

mod init;
mod mapping;
mod restore;
mod soak;
mod text;

use super::CommandResult;
use clap::{Args, Subcommand};
use init::InitArgs;
use std::time::Duration;

/// How long to wait for a device that another process uses.
const LOCK_WAIT: Duration = Duration::from_secs(60);

/// Arguments of `encspec bench`.
#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    what: BenchCommand,
}

#[derive(Debug, Subcommand)]
enum BenchCommand {
    /// Write a bench file for a device found on a segment or a PROFIBUS
    #[command(after_help = "Example: encspec bench init --nic eth1 --output bench.yaml")]
    Init(InitArgs),
    /// Restore a device from the journal of an interrupted run: name, address, I&M1 to I&M4 and parameters
    #[command(after_help = "Example: encspec bench restore")]
    Restore(restore::RestoreArgs),
    /// Keep connections to many devices for a long time, and show how steady they are
    #[command(after_help = "Example: encspec bench soak bench.yaml --count 4 --duration 3600")]
    Soak(soak::SoakArgs),
}

pub(super) fn run(args: &BenchArgs) -> CommandResult {
    match &args.what {
        BenchCommand::Init(args) => init::init(args),
        BenchCommand::Restore(args) => restore::run(args),
        BenchCommand::Soak(args) => soak::run(args),
    }
}

#[cfg(test)]
mod tests;
