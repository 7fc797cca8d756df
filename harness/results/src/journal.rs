//! Entries of the journal of a live run: the initial state of the device, lasting changes, every verdict.
//!
//! The crate `live` reads and writes the file and restores the device.

use crate::bench_file::BenchFile;
use serde::{Deserialize, Serialize};
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// The initial state of the device, before the run changes anything.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InitialDevice {
    /// The version of encspec.
    pub version: String,
    /// Start of the run in seconds since 1970 (UTC).
    pub began: u64,
    /// The link to the device, in the form of `--dut`.
    pub link: String,
    /// The bench file, if there is one.
    pub bench: Option<PathBuf>,
    /// The manual that the device is tested against.
    pub manual: String,
    /// The variant that the device is tested as.
    pub variant: String,
    /// MAC address in hexadecimal with colons; empty on PROFIBUS.
    pub mac: String,
    /// Station address (PROFIBUS).
    #[serde(default)]
    pub station: Option<u8>,
    pub vendor_id: u16,
    /// Device ID; on PROFIBUS the ident number.
    pub device_id: u16,
    /// Station name as raw bytes, since it may not be valid text.
    pub name: Vec<u8>,
    /// IP address.
    pub ip: Ipv4Addr,
    /// Subnet mask.
    pub mask: Ipv4Addr,
    pub gateway: Ipv4Addr,
}

impl InitialDevice {
    /// What is known before the device was found: the bench and its claim, now.
    pub fn of(bench: &BenchFile) -> InitialDevice {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        InitialDevice {
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

/// The initial value of a parameter of the base mode parameter access.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InitialParameter {
    /// Parameter number (PNU).
    pub number: u16,
    /// Subindex of an array element; 0 for other parameters.
    #[serde(default)]
    pub subindex: u16,
    /// PROFIdrive format code.
    pub format: u8,
    /// The value, most significant byte first.
    pub octets: Vec<u8>,
}

/// A line of a journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// The first line.
    Found(InitialDevice),
    /// Initial values of parameters.
    Parameters(Vec<InitialParameter>),
    /// A trial is about to make lasting changes.
    Changes {
        trial: String,
        /// The consents that it uses.
        what: Vec<String>,
    },
    /// The verdict of a trial.
    Verdict { trial: String, verdict: String },
    /// All changes were restored.
    Restored,
}
