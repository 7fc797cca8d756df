//! The JSON Schema of every YAML file: suites, bench files and ledgers.

use crate::bench_file::keys::{HOOKS, bench};
use crate::ledger::keys::ledger;
use serde_json::Value;

/// The JSON Schema (draft 2020-12) of all suite files, of bench files and of ledgers.
pub fn schema() -> Value {
    suite_yaml::schema(&[&bench::KEYS, &ledger::KEYS], HOOKS)
}
