//! Tests of deviations on devices that have them.

mod datalogic_amt58;
mod subjects;
