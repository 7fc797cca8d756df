//! What a controller can be asked to do.

use super::broken::Broken;
use super::connection::{Connection, Record, Target};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use core::time::Duration;
use wire::ethernet::Mac;
use wire::profinet::dcp::{Block, Element, Value};
use wire::profinet::rpc::ObjectUuid;
use wire::profinet::status::AbortReason;

/// Who a controller is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Its MAC address.
    pub mac: Mac,
    /// Its IPv4 address.
    pub ip: Ipv4Addr,
    /// The mask of its subnet.
    pub mask: Ipv4Addr,
    /// Its gateway, or its own address.
    pub gateway: Ipv4Addr,
    /// Its name of station.
    pub station_name: Vec<u8>,
    /// Its vendor number.
    pub vendor_id: u16,
    /// Its device number.
    pub device_id: u16,
    /// What its UUIDs and transaction numbers are derived from: the same seed gives the same run.
    pub seed: u64,
}

/// A station whose addresses are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Partner {
    /// Its MAC address.
    pub mac: Mac,
    /// Its IPv4 address.
    pub ip: Ipv4Addr,
}

/// Which stations are asked to tell who they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum IdentifyBy {
    /// All.
    All,
    /// Those of this name of station.
    Name(Vec<u8>),
    /// Those at this place: `port.station` of the neighbour.
    Alias(Vec<u8>),
    /// Those for which each of these values holds.
    Values(Vec<Value>),
}

/// One thing that a controller is asked to do; it takes one at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Collects the answers to a DCP Identify for `wait`. Gives [`Outcome::Stations`](super::Outcome::Stations).
    Identify {
        /// Who is asked.
        by: IdentifyBy,
        /// How long answers are collected; the question is asked once.
        wait: Duration,
    },
    /// DCP Get. Gives [`Outcome::Dcp`](super::Outcome::Dcp).
    DcpGet {
        /// Who is asked.
        to: Mac,
        /// What is asked for.
        elements: Vec<Element>,
    },
    /// DCP Set. Gives [`Outcome::Dcp`](super::Outcome::Dcp).
    DcpSet {
        /// Whose values are set.
        to: Mac,
        /// Values with their qualifiers, see [`Block::set`]; start and stop of a transaction can stand among them.
        blocks: Vec<Block>,
    },
    /// DCP Set that lets the device flash its light once. Gives [`Outcome::Dcp`](super::Outcome::Dcp).
    DcpSignal {
        /// Who flashes.
        to: Mac,
    },
    /// DCP Set that resets. Gives [`Outcome::Dcp`](super::Outcome::Dcp).
    DcpReset {
        /// Who is reset.
        to: Mac,
        /// The form of the reset.
        reset: Reset,
    },
    /// The whole start-up of an AR. Gives [`Outcome::StartUp`](super::Outcome::StartUp).
    Connect(Box<Connection>),
    /// Ends the AR by Release. Gives [`Outcome::Ended`](super::Outcome::Ended).
    Release,
    /// Ends the AR by an ERR-RTA. Gives [`Outcome::Ended`](super::Outcome::Ended).
    Abort {
        /// The reason that is told.
        code: AbortReason,
    },
    /// Writes a record in the AR. Gives [`Outcome::Record`](super::Outcome::Record).
    Write {
        /// Where it goes.
        target: Target,
        /// What it says.
        data: Vec<u8>,
    },
    /// Writes several records in one call. Gives [`Outcome::Records`](super::Outcome::Records).
    WriteMultiple(Vec<Record>),
    /// Reads a record in the AR. Gives [`Outcome::Record`](super::Outcome::Record).
    Read {
        /// Where it is.
        target: Target,
        /// Most octets that are taken.
        length: u32,
    },
    /// Reads a record without an AR. Gives [`Outcome::Record`](super::Outcome::Record).
    ReadImplicit {
        /// Who is asked.
        partner: Partner,
        /// The object that is called.
        object: ObjectUuid,
        /// Where the record is.
        target: Target,
        /// Most octets that are taken.
        length: u32,
    },
    /// A request of the PROFIdrive base mode: written, then the answer is read as often as it is not ready.
    /// Gives [`Outcome::Parameter`](super::Outcome::Parameter).
    Parameter {
        /// The record, 0xB02E at the parameter access submodule.
        at: Target,
        /// The octets of the request, right or wrong.
        request: Vec<u8>,
    },
    /// Asks the endpoint mapper for all that is registered. Gives [`Outcome::Endpoints`](super::Outcome::Endpoints).
    EndpointLookup {
        /// Who is asked.
        partner: Partner,
    },
    /// Asks a web server, over a connection of its own. Gives [`Outcome::Page`](super::Outcome::Page).
    Page {
        /// The server.
        partner: Partner,
        /// What is asked.
        request: wire::http::Request,
    },
    /// Announces ourselves as neighbour by LLDP, once. Gives [`Outcome::Sent`](super::Outcome::Sent).
    Lldp {
        /// The name of our chassis; that of the station where it is empty.
        chassis: Vec<u8>,
        /// The name of our port, such as `port-001`.
        port: Vec<u8>,
    },
    /// Asks by ARP who has an address, and collects the answers. Gives [`Outcome::Owners`](super::Outcome::Owners).
    Arp {
        /// The address.
        target: Ipv4Addr,
        /// Whether the question names no sender, as before an address is given (RFC 5227).
        probe: bool,
        /// How long answers are collected; the question is asked once.
        wait: Duration,
    },
    /// Sends a frame as it is. Gives [`Outcome::Sent`](super::Outcome::Sent).
    Raw(Vec<u8>),
    /// Sends a frame that is damaged on purpose. Gives [`Outcome::Broken`](super::Outcome::Broken).
    Broken {
        /// How it is damaged.
        broken: Broken,
        /// To whom, where no AR stands.
        partner: Option<Partner>,
    },
}

/// How DCP resets a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reset {
    /// Suboption 5, which does not say what is reset.
    Factory,
    /// Suboption 6 with this qualifier as it is sent.
    ToFactory {
        /// The qualifier; bits 1 to 15 hold the mode, see [`wire::profinet::dcp::ResetMode::qualifier`].
        qualifier: u16,
    },
}

/// The controller has not yet done what it was last asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy;

impl core::fmt::Display for Busy {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the controller is busy with another request")
    }
}
