//! Tests that need no real time: suites, verdicts, replay, reports, and the command line.
//!
//! Tests of one binary run in parallel, so no test may change process-wide state: working directory, environment, signals. A test
//! that needs its own directory or environment starts the binary (`common::program`) in a `testing::Folder`.

#[path = "../common/mod.rs"]
mod common;

mod against;
mod attributed_failures;
mod attribution;
mod bench_file;
mod bugs;
mod built_in;
mod built_in_suites;
mod cli;
mod code_rules;
mod coverage;
mod crate_structure;
mod damaged_captures;
mod device_description;
mod device_yaml_keys;
mod dissect_profibus;
mod dp_encoder;
mod filters;
mod gsd;
mod gsdml;
mod hostile_devices;
mod interop_captures;
mod listings;
mod live_stand;
mod load_errors;
mod loader;
mod many_stations;
mod misspelt_words;
mod modular_stations;
mod needs;
mod new_manual;
mod no_false_pass;
mod null_devices;
mod on_two_threads;
mod personas;
mod plain_devices;
mod profibus_class_2;
mod profibus_models;
mod random_sequences;
mod record;
mod recordings;
mod replay;
mod replay_blame;
mod replay_bugs;
mod replay_conforming;
mod replay_fragments;
mod replay_imperfect;
mod replay_protocol;
mod replay_protocol_bus;
mod replay_triage;
mod replay_varied;
mod reports;
mod rules_on_captures;
mod sample_run;
mod schema_mistakes;
mod semantics;
mod shared_device;
mod shrink;
mod signal_forms;
mod small_manual;
mod start_parameters;
mod suite_init;
mod suite_language_page;
mod times;
mod tracker;
mod tracker_profibus;
mod variant_claim;
mod variations;
mod vendor_descriptions;
mod verdicts;
mod wording;
