//! The bugs, on devices that have them.

mod datalogic_amt58;
mod lika_xac77;
mod slave;
mod subjects;
