//! Captures against a device: the controller side is driven again, and the answers are compared with the recorded ones.
//!
//! A capture is listened to ([`listen`]) until it is a conversation in the names of the manual ([`heard`]); what the controller did
//! becomes a script ([`mod@script`]) that the engine runs ([`drive`]), and the two conversations are compared ([`mod@compare`],
//! [`masks`]). [`mod@shrink`] finds the shortest script that still differs, and [`write_case`] writes it as a case.

pub mod ask;
mod checks;
pub mod compare;
pub mod drive;
pub mod heard;
pub mod hold;
pub mod infer;
pub mod listen;
pub mod masks;
pub mod report;
pub mod script;
pub mod shrink;
pub mod slice;
pub mod write_case;
