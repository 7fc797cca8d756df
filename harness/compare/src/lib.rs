//! Captures against a device: the controller side is driven again, and the answers are compared with the recorded ones.
//!
//! A capture is listened to ([`listen`]) until it is a conversation in the names of the manual ([`heard`]); what the controller did
//! becomes a script ([`mod@script`], in its timing [`timed`]) that the engine runs ([`drive`]), with the shaft where it was ([`infer`])
//! and as it turned ([`motion`], [`turn`]); the two conversations are compared ([`mod@compare`], [`masks`]) but for what nobody can
//! know ([`follows`]). [`mod@shrink`] finds the shortest script that still differs, and [`write_case`] writes it as a case.

pub mod ask;
mod checks;
pub mod compare;
pub mod drive;
pub mod follows;
pub mod heard;
pub mod hold;
pub mod infer;
pub mod listen;
pub mod masks;
pub mod motion;
pub mod report;
pub mod script;
pub mod shrink;
pub mod slice;
pub mod timed;
pub mod turn;
pub mod write_case;
