//! The suite language: what a device must do, read from YAML and checked to the last letter.
//!
//! [`load`] gives manuals whose names are resolved and whose conditions are compiled ([`suite::model`]). Everything that can be
//! wrong is found here, with file, line and column; the engine meets no mistake of a suite. Bench files and ledgers are read
//! with the same tools ([`yaml`], [`keys`]).

#[macro_use]
pub mod keys;

mod access;
mod also;
mod answer;
mod base;
mod case;
mod checks;
pub mod device_yaml;
pub mod dialect;
mod entry;
pub mod error;
mod folder;
mod frame;
mod lists;
mod load;
mod masks;
mod matcher;
mod named_bits;
mod names;
mod needed_version;
mod octet_names;
mod outline;
pub mod persona;
mod profibus;
mod request_keys;
mod rule;
mod schema;
mod shared;
mod source;
pub mod start;
mod step;
mod table;
mod taken;
mod topic_keys;
mod verbs;
pub mod yaml;

pub use error::{LoadError, LoadErrors};
pub use load::{Checker, load, load_some};
pub use masks::MaskList;
pub use schema::schema;
pub use source::{ANY_DEVICE, ANY_DP_ENCODER, ANY_ENCODER, ANY_SLAVE, AddedSuites, BenchTimes, Sources};
pub use yaml::read_file;
