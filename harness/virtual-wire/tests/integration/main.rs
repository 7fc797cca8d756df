//! Captures of strangers, and a stranger that reads ours.

mod strangers;
