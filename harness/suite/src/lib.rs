//! The suite language: what a device must do, read from YAML and checked to the last letter.
//!
//! [`load`] gives manuals whose names are resolved and whose conditions are compiled ([`model`]). Everything that can be
//! wrong is found here, with file, line and column; the engine meets no mistake of a suite.

mod access;
mod answer;
mod base;
mod case;
mod checks;
pub mod compiled;
pub mod device;
pub mod device_yaml;
pub mod dialect;
mod encoding;
mod entry;
pub mod error;
mod frame;
pub mod keys;
mod lists;
mod load;
mod location;
mod masks;
mod matcher;
pub mod model;
mod names;
pub mod needs;
mod outline;
pub mod persona;
mod profibus;
mod rule;
pub mod scan;
mod schema;
mod shared;
mod source;
pub mod start;
mod step;
mod table;
mod taken;
pub mod words;
pub mod yaml;

pub use error::{LoadError, LoadErrors};
pub use load::{Checker, load, load_some};
pub use location::Location;
pub use masks::MaskList;
pub use schema::schema;
pub use source::{ANY_DEVICE, BenchTimes, Sources};
pub use yaml::read_plain;
