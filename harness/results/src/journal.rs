//! What the journal of a live run holds: how the device was found, what was changed, every verdict.
//!
//! The file of it is written and read elsewhere. This module must not know how anything is put back.

use crate::bench_file::BenchFile;
use serde::{Deserialize, Serialize};
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// How the device was found, before anything was changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Found {
    /// The version of encspec.
    pub version: String,
    /// Seconds since 1970 (UTC) when the run began.
    pub began: u64,
    /// Where the device is, as `--dut` has it.
    pub link: String,
    /// The bench file, where there is one.
    pub bench: Option<PathBuf>,
    /// What it claims to be.
    pub manual: String,
    /// The variant that it claims to be.
    pub variant: String,
    /// Its MAC address, in hexadecimal with colons; empty on PROFIBUS.
    pub mac: String,
    /// Its station address on PROFIBUS.
    #[serde(default)]
    pub station: Option<u8>,
    /// Its vendor number.
    pub vendor_id: u16,
    /// Its device number; on PROFIBUS the ident number.
    pub device_id: u16,
    /// Its station name; octets, since it may be anything.
    pub name: Vec<u8>,
    /// Its address.
    pub ip: Ipv4Addr,
    /// The mask of its subnet.
    pub mask: Ipv4Addr,
    /// Its gateway.
    pub gateway: Ipv4Addr,
}

impl Found {
    /// What is known before the device was found: the bench and its claim, now.
    pub fn of(bench: &BenchFile) -> Found {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Found {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            began: since.as_secs(),
            link: bench.link.to_string(),
            bench: bench.path.clone(),
            manual: bench.claim.manual.clone(),
            variant: bench.claim.variant.clone(),
            mac: String::new(),
            station: None,
            vendor_id: 0,
            device_id: 0,
            name: Vec::new(),
            ip: Ipv4Addr::UNSPECIFIED,
            mask: Ipv4Addr::UNSPECIFIED,
            gateway: Ipv4Addr::UNSPECIFIED,
        }
    }
}

/// A parameter of the base mode parameter access as it was found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its number.
    pub number: u16,
    /// The element of an array; 0 where it is none.
    #[serde(default)]
    pub subindex: u16,
    /// Its format, as PROFIdrive numbers it.
    pub format: u8,
    /// Its value, most significant octet first.
    pub octets: Vec<u8>,
}

/// A line of a journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// The first line.
    Found(Found),
    /// Parameters as they were found.
    Parameters(Vec<Parameter>),
    /// A trial is about to change something that lasts: its id, and what.
    Changes {
        /// The trial.
        trial: String,
        /// The consents that it makes use of.
        what: Vec<String>,
    },
    /// What a trial came to.
    Verdict {
        /// The trial.
        trial: String,
        /// The verdict.
        verdict: String,
    },
    /// Everything was put back.
    Restored,
}
