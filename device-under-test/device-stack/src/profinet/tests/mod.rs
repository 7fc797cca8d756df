//! Tests of the stack with a toy application and a scripted controller.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod alarms;
mod bench;
mod blocks;
mod calls;
mod captures;
mod connection;
mod damage;
mod discovery;
#[cfg(feature = "deviations")]
mod hooks;
mod neighbours;
mod personas;
mod phases;
mod plugs;
mod records;
mod refusals;
mod requirements;
mod skip;
mod stand;
mod toy;
