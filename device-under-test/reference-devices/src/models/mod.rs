//! The encoders, one manual each: what its user reads is what stands here. And a device after no manual at all.
//!
//! A model is one file or folder here and one entry in `manuals.rs`. It must not know the others;
//! what those of one maker share stands in a folder of its own.

pub mod datalogic_amt58;
pub mod kuebler_sendix58xx;
pub mod lika_xac77;
pub mod plain;
pub mod sick;
pub mod sick_a3m60;
pub mod sick_afx60;
