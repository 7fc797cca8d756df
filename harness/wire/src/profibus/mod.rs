//! PROFIBUS DP: FDL frames, the services of DP-V0 behind their access points, the acyclic services of DP-V1.
//!
//! This room must not know masters, slaves and their states, nor what the user octets of a device mean. The standard is
//! cited as IEC 61158-4-3 (data link) and IEC 61158-6-3 (DP), with the names of its fields.

pub mod address;
pub mod cfg;
pub mod diag;
pub mod dpv1;
pub mod fdl;
pub mod global_control;
pub mod prm;
pub mod sap;
