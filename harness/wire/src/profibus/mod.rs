//! PROFIBUS DP: FDL frames, the services of DP-V0 with their access points, the acyclic services of DP-V1.
//!
//! This module must not know masters, slaves and their states, nor the meaning of a device's user parameters. The standard is
//! cited as IEC 61158-4-3 (data link) and IEC 61158-6-3 (DP), with its field names.

pub mod address;
pub mod call;
pub mod cfg;
pub mod diag;
pub mod dpv1;
pub mod fdl;
pub mod global_control;
pub mod prm;
pub mod sap;
pub mod statistics;
