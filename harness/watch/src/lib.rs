//! A permanent monitor and flight recorder: judges frames as they arrive, keeps the last ones on disk, and counts.
//!
//! [`LiveWatch`] takes frames with their times and returns what was found; [`DiskRing`] keeps the frames of the last minutes in
//! pcapng files, from which it saves an incident for each finding; [`WatchCounts`] is what a monitoring system collects. Memory does
//! not grow with the number of frames. This crate opens no socket and no interface; whoever calls it does.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod counts;
mod incident;
mod line;
mod pages;
mod prometheus;
mod ring;
mod screen;
mod watch;

pub use counts::{ConnectionCounts, DirectionCounts, WatchCounts};
pub use line::{WatchLine, json_line, text_line};
pub use prometheus::prometheus;
pub use replay::utc;
pub use ring::{DiskRing, RingSettings};
pub use screen::screen;
pub use watch::LiveWatch;
