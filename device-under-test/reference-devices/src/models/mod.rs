//! The models: one encoder per manual, and for each bus a generic device that follows no manual.
//!
//! A model is one file or folder here and one entry in `manuals.rs`. It must not depend on other models.
//! Parts shared by the models of one vendor are in a separate folder.

pub mod datalogic_amt58;
pub mod generic_dp_encoder;
pub mod generic_io;
pub mod generic_profidrive_encoder;
pub mod generic_slave;
pub mod kuebler_sendix58xx;
pub mod lika_xac77;
pub mod sick;
pub mod sick_a3m60;
pub mod sick_afx60;
