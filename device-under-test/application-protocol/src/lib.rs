//! Encoder applications that are programs of their own, without a network stack.
//!
//! A program reads one JSON object per line from its standard input and answers each with one line on its standard output.
//! [`RemoteIoApplication`] and [`RemoteSlaveApplication`] implement the application traits of the stacks by such a program, so that
//! it is tested like any other device. Time is part of each message, so a run is as fast as the program and always the same.
//! `docs/application-protocol.md` describes every message; [`ApplicationRequest`] and [`ApplicationAnswer`] are the messages.
//!
//! This crate must not know suites, nor how anything is judged.

mod answer;
mod dialogue;
mod failure;
mod hello;
mod hex;
mod io_application;
mod process;
mod program;
mod request;
mod slave_application;
mod stand;

pub use answer::{AnsweredDiagnosis, AnsweredInputs, ApplicationAnswer, SeverityWord};
pub use failure::ProgramFailure;
pub use hello::{ApplicationDescription, DescribedDpSlave, DescribedIoDevice, DescribedSubmodule};
pub use hex::HexText;
pub use io_application::RemoteIoApplication;
pub use process::ProgramCommand;
pub use program::{ApplicationProgram, PATIENCE, SharedProgram, in_program};
pub use request::{
    ApplicationBus, ApplicationRequest, EndWord, RequestedOutputs, ScopeWord, StandValue, SubmodulePlace,
};
pub use slave_application::RemoteSlaveApplication;

/// The version of the messages.
pub const VERSION: u32 = 1;
