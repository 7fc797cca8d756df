//! Entries of the journal of a live run: the initial state of the device, lasting changes, every verdict.
//!
//! The crate `live` reads and writes the file and restores the device.

use crate::bench_file::{BenchFile, DcpPermanence};
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
    /// Whether the device stored its IP address; DCP cannot read it.
    #[serde(default)]
    pub ip_permanence: DcpPermanence,
    /// Whether the device stored its station name; only a power cycle shows it.
    #[serde(default)]
    pub name_permanence: DcpPermanence,
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
            ip_permanence: bench.ip_permanence.unwrap_or_default(),
            name_permanence: DcpPermanence::Unknown,
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

/// The initial content of one of the records I&M1 to I&M4, which are stored in the device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InitialImRecord {
    /// API of the submodule.
    pub api: u32,
    pub slot: u16,
    pub subslot: u16,
    /// Record index, 0xAFF1 to 0xAFF4.
    pub index: u16,
    /// The record as it was read, with its block header.
    pub octets: Vec<u8>,
}

/// What a lasting change is called in a journal.
pub mod change {
    /// Parameters that are written.
    pub const PARAMETERS: &str = "parameters";
    /// The prefix for writes to non-volatile memory; the number of writes may follow.
    pub const MEMORY: &str = "nvm_write";
    /// I&M1 to I&M4.
    pub const IM_RECORDS: &str = "im_records";
    /// The station name.
    pub const NAME: &str = "set_name";
    /// The stored IP address.
    pub const IP: &str = "set_ip";
    /// An IP address until power-off, which erases a stored one.
    pub const TEMPORARY_IP: &str = "temporary_ip";
    /// A power cycle before the first change, which shows what the device has stored.
    pub const POWER_CYCLE: &str = "power_cycle";
    /// A reset to factory settings.
    pub const FACTORY_RESET: &str = "factory_reset";
    /// The position reference.
    pub const POSITION_REFERENCE: &str = "position_reference";
    /// The mode that waits for another firmware.
    pub const FIRMWARE: &str = "firmware";
    /// Another device, in factory state, in place of the one that was found.
    pub const NEW_DEVICE: &str = "renew";
}

/// A line of a journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// The first line.
    Found(InitialDevice),
    /// Initial values of parameters.
    Parameters(Vec<InitialParameter>),
    /// Initial contents of I&M1 to I&M4.
    ImRecords(Vec<InitialImRecord>),
    /// A trial is about to make lasting changes, or to use the stand.
    Changes {
        trial: String,
        /// The consents that it uses, and the words of [`change`].
        what: Vec<String>,
        /// The names that it sets at the stand; they are set back before its verdict.
        #[serde(default)]
        stand: Vec<String>,
    },
    /// The verdict of a trial.
    Verdict { trial: String, verdict: String },
    /// What a power cycle before the first change showed.
    Permanence {
        /// Of the station name.
        name: DcpPermanence,
        /// Of the IP address.
        ip: DcpPermanence,
    },
    /// What was assumed when the device was restored, or stays different until power-off.
    Remark { text: String },
    /// All changes were restored.
    Restored,
    /// The journal was closed on purpose; nothing more is restored from it.
    Closed { reason: String },
}
