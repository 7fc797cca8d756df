//! Deviations, on devices that have them.

mod datalogic_amt58;
mod slave;
mod subjects;
