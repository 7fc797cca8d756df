//! Conformance and interoperability tests for absolute encoders on PROFINET and PROFIBUS DP.
//!
//! This crate is the command line. The other crates of the harness, from the bytes of a frame to a verdict and its report:
//!
//! | crate | what it does | what it does not depend on |
//! | --- | --- | --- |
//! | [`suite`] | a manual as trials and rules with resolved names | YAML, frames, running devices |
//! | [`suite_yaml`] | the suite language: YAML to manuals, each error with file, line and column | frames, running devices |
//! | [`suites`] | the built-in suites, as files | their contents |
//! | [`results`] | verdicts, results, the ledger of known failures, bench files | engines, reports |
//! | [`judge`] | frames to observations; conditions, windows and rules over observations | where the frames come from |
//! | [`description`] | a vendor's GSDML or GSD, and where it disagrees with the manual | how the device is driven |
//! | [`engine`] | runs trials against a device under test | real wires, reports |
//! | [`live`] | devices on real wires: preflight, stand, journal, served reference devices | how results are judged |
//! | [`replay`] | captures: connections, events, broken rules, protocol checks | how trials are run |
//! | [`watch`](mod@watch) | judges frames as they arrive, keeps the last ones on disk, counts | sockets and interfaces |
//! | [`compare`] | compares a capture with another device, and finds the shortest case that shows a difference | the command line |
//! | [`report`] | results as text and as HTML pages | suites, engines, files |
//! | [`cli`] | the command line | how results are judged |

pub mod attribution;
pub mod cli;

pub use description::{gsd, gsdml};
pub use judge::observe;
pub use live::lock;
pub use report::page;
pub use results::{bench_file, ledger, outcome as result, verdict};
pub use virtual_wire::record;
pub use {
    compare, description, engine, expression, judge, live, replay, report, results, suite, suite_yaml, suites, watch,
};
