//! A manual as trials and rules: names that are resolved, conditions that are compiled, everything with its place in the YAML.
//!
//! Whoever runs, judges or reports a suite reads it here ([`model`], [`device`]). How it is written in YAML is told by
//! `suite-yaml` alone; what the program carries was read from YAML when it was built, and is kept as octets ([`compiled`]).

pub mod compiled;
pub mod device;
mod encoding;
mod location;
pub mod model;
pub mod needs;
pub mod persona;
pub mod scan;
pub mod words;

pub use location::Location;
