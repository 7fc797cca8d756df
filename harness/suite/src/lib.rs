//! A manual as compiled trials and rules: names are resolved, conditions are compiled, every part has its position in the YAML.
//!
//! The engine, the judge and the reports use [`model`] and [`device`]. Only `suite-yaml` reads YAML. The built-in suites are
//! compiled at build time and stored as bytes ([`compiled`]).

#![allow(missing_docs, reason = "internal crate: self-explanatory items need no comment")]

pub mod compiled;
pub mod device;
mod encoding;
mod location;
pub mod model;
pub mod needs;
pub mod persona;
pub mod reach;
pub mod scan;
pub mod words;

pub use location::Location;
