//! The XAC77 as an application, driven like by a stack: one call per frame, two milliseconds apart.

mod bench;
mod faults;
mod handshakes;
mod memory;
mod restarts;
mod start_up;
mod web;

use self::bench::*;
use alloc::vec::Vec;
use device_stack::profinet::{ArKey, IoApplication, RecordAccess, RecordRefusal, StationData};
use station::StandAction;
use wire::http;
