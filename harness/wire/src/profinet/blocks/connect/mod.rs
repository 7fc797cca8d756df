//! Connect: the list of blocks that requests or confirms an AR.

mod alarm_cr;
mod ar;
mod block;
mod expected;
mod iocr;

pub use alarm_cr::{AlarmCrBlockReq, AlarmCrBlockRes, AlarmCrProperties};
pub use ar::{ArBlockReq, ArBlockRes, ArProperties, ArRpcBlock, ArServerBlockRes, ArType, PrmServerBlockReq};
pub use block::{Connect, ConnectBlock, ConnectContent};
pub use expected::{
    DataDescription, ExpectedModule, ExpectedSubmodule, ExpectedSubmoduleBlockReq, SubmoduleProperties, SubmoduleType,
};
pub use iocr::{FrameObject, IocrApi, IocrBlockReq, IocrBlockRes, IocrProperties, IocrType, RtClass};
