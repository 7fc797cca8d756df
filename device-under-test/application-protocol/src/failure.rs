//! What can go wrong with a program, in words for its author.

use crate::VERSION;
use plain_text::printable;
use std::time::Duration;

/// The longest part of a line that is shown, in characters.
const SHOWN: usize = 160;

/// Why a program cannot be tested, or no longer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProgramFailure {
    /// The command is not one.
    #[error("`app:{command}` is not a command: {why}")]
    Command {
        /// The text after `app:`.
        command: String,
        /// What is wrong with it.
        why: String,
    },
    /// It could not be started.
    #[error(
        "the program {program} cannot be started ({why}); check the command after `app:`, which is looked up in {folder}"
    )]
    Start {
        /// The program.
        program: String,
        /// Why.
        why: String,
        /// Where it was started.
        folder: String,
    },
    /// It has ended.
    #[error("the program ended ({status}) instead of answering {asked}{stderr}")]
    Ended {
        /// What it was asked.
        asked: String,
        /// Its exit status.
        status: String,
        /// The last lines of its standard error, with an introduction, or nothing.
        stderr: String,
    },
    /// It does not answer.
    #[error(
        "the program was silent for {} s of real time when it was asked {asked}; answer each line with one line, and flush standard \
         output after it{stderr}",
        .patience.as_secs_f64()
    )]
    Silent {
        /// What it was asked.
        asked: String,
        /// How long was waited.
        patience: Duration,
        /// As in [`ProgramFailure::Ended`].
        stderr: String,
    },
    /// It printed something else than an answer.
    #[error(
        "the program answered {asked} with a line that is not an answer ({why}): `{line}`; print nothing else to standard output"
    )]
    Nonsense {
        /// What it was asked.
        asked: String,
        /// What is wrong.
        why: String,
        /// The line, escaped and cut.
        line: String,
    },
    /// It printed a line that was not asked for.
    #[error("the program printed a line that was not asked for: `{line}`; print to standard error instead")]
    Unasked {
        /// The line, escaped and cut.
        line: String,
    },
    /// It answered another message.
    #[error(
        "the program answered `{answered}` when it was asked {asked}; answer the messages in their order, each once"
    )]
    Other {
        /// What it was asked.
        asked: String,
        /// The word of its answer.
        answered: String,
    },
    /// It has another version of the messages.
    #[error("the program speaks version {theirs} of the messages, and this encspec speaks version {VERSION}")]
    Version {
        /// Its version.
        theirs: u32,
    },
    /// Its answer lacks something, or does not fit.
    #[error("the answer of the program to {asked} cannot be used: {why}")]
    Content {
        /// What it was asked.
        asked: String,
        /// What is wrong.
        why: String,
    },
    /// It reports an error of its own.
    #[error("the program reported an error when it was asked {asked}: {text}{stderr}")]
    Reported {
        /// What it was asked.
        asked: String,
        /// Its words.
        text: String,
        /// As in [`ProgramFailure::Ended`].
        stderr: String,
    },
    /// It says something else of the device than at its first start.
    #[error(
        "the program describes another device than at its first start; the description may not change during a run"
    )]
    Changed,
}

/// A line of a program, safe for a terminal and short.
pub(crate) fn shown(line: &str) -> String {
    let text = printable(line);
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
