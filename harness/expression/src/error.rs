//! Errors of expressions: message, span and help.

use std::fmt;
use std::ops::Range;

/// An error in the text of an expression or a literal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExprError {
    /// Byte range of the error in the text, on character boundaries; may be empty.
    pub span: Range<usize>,
    /// The error in one sentence without a full stop.
    pub message: String,
    /// How to fix it.
    pub help: Option<String>,
}

impl ExprError {
    pub(super) fn new(span: Range<usize>, message: impl Into<String>) -> ExprError {
        ExprError { span, message: message.into(), help: None }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> ExprError {
        self.help = Some(help.into());
        self
    }

    pub(super) fn did_you_mean(self, nearest: Option<String>) -> ExprError {
        match nearest {
            Some(word) => self.help(format!("did you mean `{word}`?")),
            None => self,
        }
    }
}

impl fmt::Display for ExprError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.help {
            Some(help) => write!(f, "{}: {help}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for ExprError {}
