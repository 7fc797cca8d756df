//! The stack against scripted frames: a toy encoder behind it, a hand-driven controller before it.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod alarms;
mod bench;
mod blocks;
mod calls;
mod captures;
mod connection;
mod damage;
mod duties;
mod finding;
#[cfg(feature = "deviations")]
mod hooks;
mod neighbours;
mod personas;
mod phases;
mod records;
mod refusals;
mod skip;
mod stand;
mod toy;
