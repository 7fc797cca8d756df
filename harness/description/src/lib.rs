//! The vendor's descriptions of a device, GSDML on PROFINET and GSD on PROFIBUS, and their disagreements with the manual.
//!
//! This crate must not know how the device is driven.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

pub mod gsd;
pub mod gsdml;
pub mod record_match;
pub mod start_parameters;
mod value_texts;
pub mod variant;
mod variant_reading;
