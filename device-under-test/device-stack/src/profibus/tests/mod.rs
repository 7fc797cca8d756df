//! Tests of the slave with a toy application and a scripted master.

mod bench;
mod finding;
mod records;
mod start_up;
mod toy;
