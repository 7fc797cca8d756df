//! What a master can be asked to do, and who it is.

use super::connection::Connection;
use crate::words::words;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;
use core::time::Duration;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::fdl::{BaudRate, BitTimes};
use wire::profibus::global_control::GlobalControl;

/// Who a master is, and the parameters of its bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Its address, 0 to 125.
    pub address: u8,
    /// The baud rate of the bus.
    pub baud: BaudRate,
    /// TSL: how long an answer is waited for, up to its first character.
    pub slot_time: BitTimes,
    /// The longest that a slave of this bus takes to answer (max TSDR); so long a request without answer is left alone.
    pub max_tsdr: BitTimes,
    /// TID1: the silence before a request; not below TSYN.
    pub idle: BitTimes,
    /// How long a master that is alone keeps the token when it has nothing to send; below six slot times.
    pub token_pause: BitTimes,
    /// TTR: how long the token may take to come round.
    pub rotation: BitTimes,
    /// How often a request that nobody answers is sent again.
    pub retries: u8,
    /// G: after how many rounds of the token the next address is asked for a master; 0: nobody is ever asked.
    pub gap_factor: u8,
    /// HSA: the highest address that is asked.
    pub highest: u8,
    /// How long an answer of DP-V1 may take.
    pub acyclic: Duration,
    /// How long the master may be without the token while it has something to do.
    pub patience: Duration,
}

impl Settings {
    /// The usual parameters of a bus at `baud` (the defaults of GSD revision 3 for slot time and max TSDR).
    pub fn new(address: u8, baud: BaudRate) -> Settings {
        let (slot, tsdr) = match baud.0 {
            ..=187_500 => (100, 60),
            187_501..=500_000 => (200, 100),
            500_001..=1_500_000 => (300, 150),
            1_500_001..=3_000_000 => (400, 250),
            3_000_001..=6_000_000 => (600, 450),
            _ => (1_000, 800),
        };
        Settings {
            address,
            baud,
            slot_time: BitTimes(slot),
            max_tsdr: BitTimes(tsdr),
            idle: BitTimes(37),
            token_pause: BitTimes(5 * slot),
            rotation: BitTimes(50_000),
            retries: 1,
            gap_factor: 10,
            highest: 126,
            acyclic: Duration::from_secs(5),
            patience: Duration::from_secs(2),
        }
    }
}

/// One thing that a master is asked to do; it takes one at a time.
///
/// `to` is the address of a slave. What has octets sends them as they are, right or wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// The whole start-up of a slave. Gives [`Outcome::StartUp`](super::Outcome::StartUp).
    Connect(Box<Connection>),
    /// Ends the exchange and gives the slave free by a Set_Prm with Unlock. Gives [`Outcome::Ended`](super::Outcome::Ended).
    Release,
    /// Ends the exchange without a word; taken at any time. Gives [`Outcome::Ended`](super::Outcome::Ended).
    Abort,
    /// Slave_Diag. Gives [`Outcome::Answer`](super::Outcome::Answer).
    Diagnosis {
        /// Who is asked.
        to: u8,
    },
    /// Get_Cfg. Gives [`Outcome::Answer`](super::Outcome::Answer).
    Configuration {
        /// Who is asked.
        to: u8,
    },
    /// RD_Inp. Gives [`Outcome::Answer`](super::Outcome::Answer).
    ReadInputs {
        /// Who is asked.
        to: u8,
    },
    /// RD_Outp. Gives [`Outcome::Answer`](super::Outcome::Answer).
    ReadOutputs {
        /// Who is asked.
        to: u8,
    },
    /// Set_Slave_Address. Gives [`Outcome::Answer`](super::Outcome::Answer).
    SetSlaveAddress {
        /// Who is asked, 126 as a rule.
        to: u8,
        /// The new address and what goes with it.
        set: SetSlaveAddress,
    },
    /// Global_Control; Clear and Operate become the mode of the master. Gives [`Outcome::Sent`](super::Outcome::Sent).
    GlobalControl {
        /// Who is meant: 127 for all.
        to: u8,
        /// The command.
        control: GlobalControl,
    },
    /// FDL status. Gives [`Outcome::Answer`](super::Outcome::Answer).
    FdlStatus {
        /// Who is asked.
        to: u8,
    },
    /// Set_Prm on its own. Gives [`Outcome::Answer`](super::Outcome::Answer).
    SetPrm {
        /// Who is asked.
        to: u8,
        /// The octets from the station status on.
        octets: Vec<u8>,
    },
    /// Chk_Cfg on its own. Gives [`Outcome::Answer`](super::Outcome::Answer).
    CheckConfiguration {
        /// Who is asked.
        to: u8,
        /// The identifiers.
        octets: Vec<u8>,
    },
    /// One Data_Exchange beside those of the cycle. Gives [`Outcome::Answer`](super::Outcome::Answer).
    DataExchange {
        /// Who is asked.
        to: u8,
        /// The outputs.
        octets: Vec<u8>,
    },
    /// DS_Read over MS1. Gives [`Outcome::Record`](super::Outcome::Record).
    Read {
        /// Who is asked.
        to: u8,
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
        /// Most octets that are taken, up to 240.
        length: u8,
    },
    /// DS_Write over MS1. Gives [`Outcome::Record`](super::Outcome::Record).
    Write {
        /// Who is asked.
        to: u8,
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
        /// What it says, up to 240 octets.
        data: Vec<u8>,
    },
    /// A request of the PROFIdrive base mode: written to data set 47, then its answer is read as often as it is not ready.
    /// Gives [`Outcome::Parameter`](super::Outcome::Parameter).
    Parameter {
        /// Who is asked.
        to: u8,
        /// The slot.
        slot: u8,
        /// The octets of the request, right or wrong.
        request: Vec<u8>,
    },
    /// Any request of the data link, answered or not. Gives [`Outcome::Answer`](super::Outcome::Answer).
    Service {
        /// Who is asked.
        to: u8,
        /// The access point at the slave; none means the default one.
        dsap: Option<u8>,
        /// The access point at the master; none means the default one.
        ssap: Option<u8>,
        /// The data.
        octets: Vec<u8>,
    },
    /// Sends octets as they are. Gives [`Outcome::Sent`](super::Outcome::Sent).
    Raw(Vec<u8>),
    /// Sends a frame that is damaged on purpose, and ignores what comes of it. Gives [`Outcome::Broken`](super::Outcome::Broken).
    Broken {
        /// To whom.
        to: u8,
        /// How it is damaged.
        broken: Broken,
    },
}

/// The master has not yet done what it was last asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy;

impl fmt::Display for Busy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the master is busy with another request")
    }
}

words! {
    /// A frame that is damaged on purpose.
    pub enum Broken {
        Checksum "checksum" "A Slave_Diag request whose checksum is wrong.",
        EndDelimiter "end_delimiter" "A Slave_Diag request whose end delimiter is wrong.",
        LengthRepeated "length_repeated" "A Slave_Diag request whose two lengths differ.",
        LengthBeyond "length_beyond" "A Slave_Diag request that announces more octets than it has.",
        StartDelimiter "start_delimiter" "A Slave_Diag request with a start delimiter that does not exist.",
        Truncated "truncated" "A Slave_Diag request that ends in its middle.",
        UnknownFunction "unknown_function" "A request with a function code that is reserved.",
        UnknownAccessPoint "unknown_access_point" "A request to an access point that no slave has.",
        SetPrmShort "set_prm_short" "A Set_Prm of three octets.",
        Noise "noise" "Octets that are no frame.",
    }
}

impl Broken {
    /// The damaged frame that has this word.
    pub fn by_word(word: &str) -> Option<Broken> {
        Broken::TABLE.iter().find(|entry| entry.1 == word).map(|entry| entry.0)
    }
}

/// Every damaged frame that the master can make: its word and its sentence.
pub fn broken_frames() -> impl Iterator<Item = (&'static str, &'static str)> {
    Broken::TABLE.iter().map(|&(_, word, sentence)| (word, sentence))
}
