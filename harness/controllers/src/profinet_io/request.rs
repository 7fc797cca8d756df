//! The requests to a controller, and its settings.

use super::broken::DamagedIoFrame;
use super::connection::{ArConfig, RecordAddress, StartUpRecord};
use super::load::NetLoad;
use super::ping::PingRequest;
use super::raw::{RawCall, RawDcpRequest};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use core::time::Duration;
use wire::ethernet::Mac;
use wire::profinet::dcp::{DcpBlock, DcpValue, Element};
use wire::profinet::rpc::ObjectUuid;
use wire::profinet::status::AbortReason;

/// Addresses and identity of a controller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControllerSettings {
    /// MAC address.
    pub mac: Mac,
    /// IPv4 address.
    pub ip: Ipv4Addr,
    /// Subnet mask.
    pub mask: Ipv4Addr,
    /// Gateway, or its own address.
    pub gateway: Ipv4Addr,
    /// Name of station.
    pub station_name: Vec<u8>,
    /// Vendor ID.
    pub vendor_id: u16,
    /// Device ID.
    pub device_id: u16,
    /// Seed of its UUIDs and transaction numbers: the same seed gives the same run.
    pub seed: u64,
}

/// A station with its addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Partner {
    /// MAC address.
    pub mac: Mac,
    /// IPv4 address.
    pub ip: Ipv4Addr,
}

/// The stations that an Identify request addresses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum IdentifyBy {
    /// All stations.
    All,
    /// Stations with this name of station.
    Name(Vec<u8>),
    /// Stations with this alias: `port.station` of the neighbour.
    Alias(Vec<u8>),
    /// Stations that have all of these values.
    Values(Vec<DcpValue>),
    /// Stations that have what these filters say, given as bytes, right or not.
    Filters {
        /// Everything after DCPDataLength.
        octets: Vec<u8>,
        /// ResponseDelayFactor.
        delay: u16,
    },
}

/// A request to a controller; it accepts one at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ControllerRequest {
    /// Collects the answers to a DCP Identify for `wait`. Returns [`ControllerOutcome::Stations`](super::ControllerOutcome::Stations).
    Identify {
        /// Which stations answer.
        by: IdentifyBy,
        /// How long answers are collected; the request is sent once.
        wait: Duration,
    },
    /// DCP Get. Returns [`ControllerOutcome::Dcp`](super::ControllerOutcome::Dcp).
    DcpGet {
        /// Address of the station.
        to: Mac,
        /// The requested elements.
        elements: Vec<Element>,
    },
    /// DCP Set. Returns [`ControllerOutcome::Dcp`](super::ControllerOutcome::Dcp).
    DcpSet {
        /// Address of the station.
        to: Mac,
        /// Values with their qualifiers, see [`DcpBlock::set`]; start and stop of a transaction may be among them.
        blocks: Vec<DcpBlock>,
    },
    /// DCP Get or Set with the bytes of the caller, right or not. Returns
    /// [`ControllerOutcome::DcpAnswer`](super::ControllerOutcome::DcpAnswer), or
    /// [`ControllerOutcome::Dcp`](super::ControllerOutcome::Dcp) if there is no answer.
    RawDcp {
        /// Address of the station.
        to: Mac,
        /// The request.
        request: RawDcpRequest,
    },
    /// An RPC PDU with the fields of the caller, right or not. Returns [`ControllerOutcome::Called`](super::ControllerOutcome::Called).
    RawCall {
        /// The station.
        partner: Partner,
        /// The PDU.
        call: RawCall,
    },
    /// An SNMP request. Returns [`ControllerOutcome::Snmp`](super::ControllerOutcome::Snmp).
    Snmp {
        /// The device.
        partner: Partner,
        /// The payload of the datagram, right or not.
        octets: Vec<u8>,
        /// Whether a message gets a request ID of the controller.
        gets_id: bool,
    },
    /// Sends a net load. Returns [`ControllerOutcome::Sent`](super::ControllerOutcome::Sent) at its end.
    Load(NetLoad),
    /// An ICMP echo request. Returns [`ControllerOutcome::Ping`](super::ControllerOutcome::Ping).
    Ping {
        /// The device.
        partner: Partner,
        /// The request.
        ping: PingRequest,
    },
    /// DCP Set that makes the device flash its LED once (Signal). Returns [`ControllerOutcome::Dcp`](super::ControllerOutcome::Dcp).
    DcpSignal {
        /// Address of the station.
        to: Mac,
    },
    /// DCP Set that resets. Returns [`ControllerOutcome::Dcp`](super::ControllerOutcome::Dcp).
    DcpReset {
        /// Address of the station.
        to: Mac,
        /// The form of the reset.
        reset: DcpResetForm,
    },
    /// The whole start-up of an AR. Returns [`ControllerOutcome::StartUp`](super::ControllerOutcome::StartUp).
    Connect(Box<ArConfig>),
    /// Ends the AR by Release. Returns [`ControllerOutcome::Ended`](super::ControllerOutcome::Ended).
    Release,
    /// Ends the AR by an ERR-RTA. Returns [`ControllerOutcome::Ended`](super::ControllerOutcome::Ended).
    Abort {
        /// The reason in the ERR-RTA.
        code: AbortReason,
    },
    /// Writes a record in the AR. Returns [`ControllerOutcome::Record`](super::ControllerOutcome::Record).
    Write {
        /// Address of the record.
        target: RecordAddress,
        /// The data.
        data: Vec<u8>,
    },
    /// Writes several records in one call. Returns [`ControllerOutcome::Records`](super::ControllerOutcome::Records).
    WriteMultiple(Vec<StartUpRecord>),
    /// Reads a record in the AR. Returns [`ControllerOutcome::Record`](super::ControllerOutcome::Record).
    Read {
        /// Address of the record.
        target: RecordAddress,
        /// Maximum length in bytes.
        length: u32,
    },
    /// Reads a record without an AR. Returns [`ControllerOutcome::Record`](super::ControllerOutcome::Record).
    ReadImplicit {
        /// The device.
        partner: Partner,
        /// The object that is called.
        object: ObjectUuid,
        /// Address of the record.
        target: RecordAddress,
        /// Maximum length in bytes.
        length: u32,
    },
    /// A PROFIdrive base mode request: written to the record, then the response is read until it is ready. Returns
    /// [`ControllerOutcome::Parameter`](super::ControllerOutcome::Parameter).
    Parameter {
        /// The record, 0xB02E at the parameter access submodule.
        at: RecordAddress,
        /// The bytes of the request, valid or not.
        request: Vec<u8>,
    },
    /// Requests all entries of the endpoint mapper. Returns [`ControllerOutcome::Endpoints`](super::ControllerOutcome::Endpoints).
    EndpointLookup {
        /// The station.
        partner: Partner,
    },
    /// Requests a page from a web server over its own TCP connection. Returns [`ControllerOutcome::Page`](super::ControllerOutcome::Page).
    Page {
        /// The server.
        partner: Partner,
        /// The HTTP request.
        request: wire::http::HttpRequest,
    },
    /// Announces the controller as neighbour by LLDP, once. Returns [`ControllerOutcome::Sent`](super::ControllerOutcome::Sent).
    Lldp {
        /// Chassis ID; if empty, the name of station.
        chassis: Vec<u8>,
        /// Port ID, such as `port-001`.
        port: Vec<u8>,
    },
    /// Sends an ARP request for an address and collects the answers. Returns [`ControllerOutcome::Owners`](super::ControllerOutcome::Owners).
    Arp {
        /// The address.
        target: Ipv4Addr,
        /// Whether this is an ARP probe, without a sender address, as before an address is assigned (RFC 5227).
        probe: bool,
        /// How long answers are collected; the request is sent once.
        wait: Duration,
    },
    /// Sends a frame as it is. Returns [`ControllerOutcome::Sent`](super::ControllerOutcome::Sent).
    Raw(Vec<u8>),
    /// Sends a frame damaged on purpose. Returns [`ControllerOutcome::DamagedIoFrame`](super::ControllerOutcome::Broken).
    Broken {
        /// The kind of damage.
        broken: DamagedIoFrame,
        /// The destination if there is no AR.
        partner: Option<Partner>,
    },
}

/// The form of a DCP reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DcpResetForm {
    /// Suboption 5 (factory reset), which does not say what is reset.
    Factory,
    /// Suboption 6 (reset to factory) with this qualifier, sent as it is.
    ToFactory {
        /// The qualifier; bits 1 to 15 hold the mode, see [`wire::profinet::dcp::ResetMode::qualifier`].
        qualifier: u16,
    },
}

/// The controller has not finished the previous request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControllerBusy;

impl core::fmt::Display for ControllerBusy {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the controller is busy with another request")
    }
}
