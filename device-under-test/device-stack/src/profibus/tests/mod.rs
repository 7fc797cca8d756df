//! Tests of the slave with a toy application and a scripted master.

mod addressing;
mod bench;
mod records;
mod start_up;
mod toy;
