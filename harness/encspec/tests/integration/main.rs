//! Tests that need no real time: suites, verdicts, replay, reports, and the command line.
//!
//! Tests of one binary run in parallel, so no test may change process-wide state: working directory, environment, signals. A test
//! that needs its own directory or environment starts the binary (`common::program`) in a `testing::Folder`.

#[path = "../common/mod.rs"]
mod common;

mod against;
mod bench_file;
mod borders;
mod bugs;
mod changed_device;
mod cli;
mod description;
mod dissect_profibus;
mod gsd;
mod gsdml;
mod house;
mod kept_captures;
mod listings;
mod live_stand;
mod load_errors;
mod loads;
mod many_stations;
mod mutations;
mod needs;
mod no_false_pass;
mod nobody;
mod one_device;
mod one_letter;
mod personas;
mod plain_devices;
mod profibus_models;
mod record;
mod recorded;
mod replay;
mod replay_blame;
mod replay_bugs;
mod replay_fragments;
mod replay_healthy;
mod replay_odd;
mod replay_protocol;
mod replay_protocol_bus;
mod replay_triage;
mod replayed;
mod reports;
mod sample;
mod semantics;
mod shipped;
mod shipped_suites;
mod shrink;
mod sixth_manual;
mod small_manual;
mod suite_language_page;
mod tracker;
mod tracker_profibus;
mod variations;
mod verdicts;
