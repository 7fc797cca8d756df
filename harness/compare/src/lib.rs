//! Compares captures with a device: drives the controller side again and compares the answers with the recorded ones.
//!
//! [`extract`] extracts from a capture the conversation in the names of the manual ([`conversation`]). The actions of the controller become a
//! script ([`mod@script`], with its timing [`timed_script`]) that the engine runs ([`drive`]), with the shaft at its position ([`shaft_position`]) and
//! with its movement ([`motion`], [`shaft_motion`], `shaft_fit`). The two conversations are compared ([`mod@compare`], [`masks`]), except for values that
//! cannot be known ([`shaft_dependence`]); for what is left an unseen cause is searched for (`unseen`). [`mod@shrink`] finds the shortest script that still differs ([`minimal`]), and [`write_case`] writes it as a case.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

pub mod action;
pub mod capture;
mod checks;
pub mod compare;
pub mod conversation;
pub mod drive;
pub mod extract;
pub mod masks;
pub mod minimal;
pub mod motion;
pub mod report;
pub mod script;
pub mod shaft_dependence;
mod shaft_fit;
pub mod shaft_motion;
pub mod shaft_position;
pub mod shrink;
pub mod slice;
pub mod timed_script;
mod unseen;
pub mod write_case;
