//! Conformance and interoperability tests for absolute encoders on PROFINET and PROFIBUS DP.
//!
//! The rooms of the runner, from the text of a suite to a verdict:
//!
//! | module | what it is | what it must not know |
//! | --- | --- | --- |
//! | [`suite`] | the language and its loader: YAML to compiled trials and rules | frames, devices at work |
//! | [`observe`] | frames to observations: connections, cyclic data, alarms | suites, verdicts |
//! | [`judge`] | conditions, windows and rules over observations | who sends the frames |
//! | [`engine`] | runs trials against a device under test | the kind of wire, the reports |
//! | [`record`] | octets with times, from a line or a hex log, to captures of PROFIBUS | lines, what the frames mean |
//! | [`replay`] | captures: connections, events, rules that were broken | how trials are run |
//! | [`page`] | pages for a browser: timelines, packets octet by octet | captures, runs, verdicts |
//! | [`verdict`], [`result`] | what a run found, as plain data | how it is shown |
//! | [`report`] | results as text, and what they come to | suites, engines, files |
//! | [`ledger`], [`lock`] | known failures; one process for each device | how it is shown |
//! | [`bench_file`] | the bench file: what a device under test claims to be and what may be done to it | links, frames |
//! | [`gsdml`], [`gsd`] | a vendor's description, and where it differs from the manual | how the device is driven |
//! | [`live`] | benches with real wires: preflight, stand, journal, the served reference device | suites, how anything is judged |
//! | [`cli`] | the command line | how anything is judged |

pub mod bench_file;
pub mod cli;
pub mod engine;
pub mod gsd;
pub mod gsdml;
pub mod judge;
pub mod ledger;
pub mod live;
pub mod lock;
pub mod observe;
pub mod page;
pub mod record;
pub mod replay;
pub mod report;
pub mod result;
pub mod suite;
pub mod verdict;
