//! Conformance and interoperability tests for absolute encoders on PROFINET and PROFIBUS DP.
//!
//! The command line, over the crates of the harness, from the bytes of a frame to a verdict and its report:
//!
//! | crate | what it is | what it must not know |
//! | --- | --- | --- |
//! | [`suite`] | a manual as trials and rules with resolved names | YAML, frames, devices at work |
//! | [`suite_yaml`] | the language: YAML to manuals, with every mistake where it stands | frames, devices at work |
//! | [`suites`] | the shipped suites | what stands in them |
//! | [`results`] | verdicts, results, the ledger of known failures, what a bench file says | engines, reports |
//! | [`judge`] | frames to observations; conditions, windows and rules over observations | who sends the frames |
//! | [`description`] | a vendor's GSDML or GSD, and where it differs from the manual | how the device is driven |
//! | [`engine`] | runs trials against a device under test | real wires, reports |
//! | [`live`] | devices on real wires: preflight, stand, journal, the served reference device | how anything is judged |
//! | [`replay`] | captures: connections, events, rules that were broken | how trials are run |
//! | [`compare`] | a capture against another device, and the shortest case that shows the difference | the command line |
//! | [`report`] | results as text and as pages | suites, engines, files |
//! | [`cli`] | the command line | how anything is judged |

pub mod cli;

pub use description::{gsd, gsdml};
pub use judge::observe;
pub use live::lock;
pub use report::page;
pub use results::{bench_file, ledger, outcome as result, verdict};
pub use virtual_wire::record;
pub use {compare, description, engine, expression, judge, live, replay, report, results, suite, suite_yaml, suites};
