//! Devices under test, and how each kind is connected to a segment.

use super::environment::{DpLine, TrialEnvironment};
use super::live::{LiveDevice, SharedLiveDevice, VirtualStart};
use super::segment::{DeviceOnStand, ModelOnStand, NoStand, PeerWithoutStand, Segment, VirtualSegment};
use controllers::profibus_dp::MasterSettings;
use deviations::{BuildError, Line, Setup, Subject, subject};
use station::{Duration, Outbox, Stand, Station, Time};
use std::fmt;
use std::net::Ipv4Addr;
use std::str::FromStr;
use virtual_wire::hostile::{HOSTILE_DEVICES, HostileDevice, SpoiltDevice};
use virtual_wire::null::{Babbler, BusBabbler, BusReflector, DiesAfter, Reflector, Silent};
use wire::ethernet::Mac;
use wire::profibus::fdl::BitTimes;
use wire::profinet::dcp::block::IpParameter;

/// The first controller of a virtual segment; all addresses there are locally administered MACs and private IP addresses.
pub const CONTROLLER: (Mac, Ipv4Addr) = (Mac([2, 0, 0, 0, 0, 1]), Ipv4Addr::new(192, 168, 0, 1));
/// The second controller of a virtual segment.
pub const SECOND: (Mac, Ipv4Addr) = (Mac([2, 0, 0, 0, 0, 2]), Ipv4Addr::new(192, 168, 0, 2));
/// The device under test; a manual may define how its MAC address begins.
pub const DEVICE: (Mac, Ipv4Addr) = (Mac([2, 0, 0, 0, 1, 0]), Ipv4Addr::new(192, 168, 0, 10));
/// An unused IP address of the virtual segment.
const FREE: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 200);
/// The subnet mask of the virtual segment.
pub const MASK: Ipv4Addr = Ipv4Addr::new(255, 255, 255, 0);
/// The time between two frames of a babbler.
const BABBLES_EACH: Duration = Duration::from_micros(500);
/// The delay of a reflector on a bus: the shortest that a slave may have (min TSDR).
const REFLECTS_AFTER: BitTimes = BitTimes(11);
/// The station name of the device on virtual benches.
pub const STATION_NAME: &str = "encoder-under-test";

/// A peer that is not a conforming device; a run against one must never be green.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NullPeer {
    /// No station.
    Absent,
    /// A station that never sends.
    Silent,
    /// A station that sends every frame back.
    Reflector,
    /// A station that sends random bytes.
    Babbler,
    /// A conforming device with another identity than claimed.
    WrongIdentity,
    /// A conforming device that falls silent after this many frames.
    DiesAfter(usize),
    /// A conforming device whose frames are spoilt in one way.
    Hostile(&'static HostileDevice),
}

impl NullPeer {
    /// The words of `--dut null:WORD`.
    pub fn words() -> impl Iterator<Item = &'static str> + Clone {
        let own = ["absent", "silent", "reflector", "babbler", "wrong-identity", "dies-after-N"];
        own.into_iter().chain(HOSTILE_DEVICES.iter().map(|device| device.name))
    }
}

impl FromStr for NullPeer {
    type Err = String;

    fn from_str(word: &str) -> Result<NullPeer, String> {
        Ok(match word {
            "absent" => NullPeer::Absent,
            "silent" => NullPeer::Silent,
            "reflector" => NullPeer::Reflector,
            "babbler" => NullPeer::Babbler,
            "wrong-identity" => NullPeer::WrongIdentity,
            word => match word.strip_prefix("dies-after-").map(str::parse) {
                Some(Ok(frames)) => NullPeer::DiesAfter(frames),
                _ => match HOSTILE_DEVICES.iter().find(|device| device.name == word) {
                    Some(device) => NullPeer::Hostile(device),
                    None => {
                        let known: Vec<&str> = NullPeer::words().collect();
                        return Err(format!("unknown null:{word}; known are {}", known.join(", ")));
                    }
                },
            },
        })
    }
}

impl fmt::Display for NullPeer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NullPeer::Absent => f.write_str("absent"),
            NullPeer::Silent => f.write_str("silent"),
            NullPeer::Reflector => f.write_str("reflector"),
            NullPeer::Babbler => f.write_str("babbler"),
            NullPeer::WrongIdentity => f.write_str("wrong-identity"),
            NullPeer::DiesAfter(frames) => write!(f, "dies-after-{frames}"),
            NullPeer::Hostile(device) => f.write_str(device.name),
        }
    }
}

/// The kind of device under test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DutKind {
    /// The built-in reference device with these deviations.
    Model {
        /// Names of bugs and permitted variations.
        deviations: Vec<String>,
    },
    /// A reference device that is not that of the manual, with these deviations.
    External {
        /// Its manual and how it is built.
        model: &'static Subject,
        /// Its variant, if the manual calls it otherwise.
        variant: Option<String>,
        /// Names of bugs and permitted variations.
        deviations: Vec<String>,
    },
    /// A peer that must never pass.
    Null(NullPeer),
    /// A device outside of this process, on its bench.
    Live(SharedLiveDevice),
}

/// A device under test and the identity that it claims.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DutSpec {
    /// Name of the manual.
    pub manual: String,
    /// Name of the variant.
    pub variant: String,
    pub kind: DutKind,
}

/// The form of `--dut`.
impl fmt::Display for DutSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            DutKind::External { model, variant: Some(variant), .. } => {
                write!(f, "model:{}/{variant}", model.manual.name)
            }
            DutKind::Model { .. } | DutKind::External { .. } => write!(f, "model:{}/{}", self.manual, self.variant),
            DutKind::Null(null) => write!(f, "null:{null}"),
            DutKind::Live(device) => match &device.0.bench().path {
                Some(path) => write!(f, "{}", path.display()),
                None => write!(f, "{}", device.0.bench().link),
            },
        }
    }
}

impl DutSpec {
    /// The word for the kind in reports.
    pub fn kind_word(&self) -> &'static str {
        match &self.kind {
            DutKind::Model { .. } | DutKind::External { .. } => "model",
            DutKind::Null(_) => "null",
            DutKind::Live(device) => device.0.bench().link.kind(),
        }
    }

    /// `--dut`, and what else says on a command line which device it is.
    pub fn option(&self) -> String {
        let named = self.to_string();
        let named = if named.contains(char::is_whitespace) { format!("'{named}'") } else { named };
        // A command does not say what the program claims to be.
        let is_bare = self.live().is_some_and(|live| live.is_virtual() && live.bench().path.is_none());
        let claim = if is_bare { format!(" --device {}/{}", self.manual, self.variant) } else { String::new() };
        format!("--dut {named}{claim}")
    }

    /// The reference device of the same variant without deviations.
    #[must_use]
    pub fn without_deviations(&self) -> DutSpec {
        DutSpec { kind: DutKind::Model { deviations: Vec::new() }, ..self.clone() }
    }

    /// The live device, if it is one.
    pub fn live(&self) -> Option<&dyn LiveDevice> {
        match &self.kind {
            DutKind::Live(device) => Some(&*device.0),
            DutKind::Model { .. } | DutKind::External { .. } | DutKind::Null(_) => None,
        }
    }

    /// The manual and the build function of the reference device.
    pub(super) fn model(&self) -> Result<&'static Subject, BuildError> {
        match &self.kind {
            DutKind::External { model, .. } => Ok(model),
            DutKind::Model { .. } | DutKind::Null(_) | DutKind::Live(_) => subject(&self.manual),
        }
    }

    /// The variant of the reference device.
    fn model_variant(&self) -> &str {
        match &self.kind {
            DutKind::External { variant: Some(variant), .. } => variant,
            _ => &self.variant,
        }
    }

    /// The addresses of the device and of the harness's stations.
    pub fn environment(&self) -> TrialEnvironment {
        if let DutKind::Live(device) = &self.kind {
            return device.0.environment().clone();
        }
        TrialEnvironment {
            is_other_model: matches!(self.kind, DutKind::External { .. }),
            name: STATION_NAME.to_owned(),
            mac: None,
            ip: IpParameter { address: DEVICE.1, mask: MASK, gateway: Ipv4Addr::UNSPECIFIED },
            controllers: [CONTROLLER, SECOND],
            free_ip: FREE,
            line: DpLine::default(),
            seed: 0,
            noise: self.model().map_or(0, |of| of.position_noise(self.deviations().iter().map(String::as_str))),
            slack: Duration::ZERO,
            bench: None,
            persona: None,
            deviates: !self.bugs().is_empty(),
        }
    }

    /// Connects a new device to a new segment for the trial `id`; its shaft position depends on the trial. A live device is used as it
    /// is. `line` has the addresses and the baud rate on PROFIBUS, `is_slave` says whether the manual is one of PROFIBUS.
    pub fn segment<'a>(&'a self, id: &str, line: DpLine, is_slave: bool) -> Result<Box<dyn Segment + 'a>, String> {
        let shaft = shaft(id);
        let subject = self.model();
        let mac = subject.as_ref().map_or(DEVICE.0.0, |subject| subject.manual.mac(DEVICE.0.0));
        let is_built_in = matches!(self.kind, DutKind::Model { .. });
        let on = SegmentBuilder { is_slave, is_built_in, line };
        let built = move |deviations: &[String], is_named: bool| {
            let bugs: Vec<&str> = deviations.iter().map(String::as_str).collect();
            let build = if is_named { Subject::build } else { Subject::build_in_factory_state };
            let setup =
                Setup { mac, bugs: &bugs, line: Line { address: line.station, baud: line.baud }, ..setup(shaft) };
            subject
                .clone()
                .and_then(|subject| build(subject, self.model_variant(), &setup))
                .map_err(|error| error.to_string())
        };
        let model = |bugs: &'a [String]| -> Result<ModelOnStand<'a>, String> {
            let delivered = built.clone();
            Ok(ModelOnStand::new(built(bugs, true)?, Box::new(move || delivered(bugs, false))))
        };
        Ok(match &self.kind {
            DutKind::Live(device) => device.0.segment(VirtualStart { shaft, line }),
            DutKind::Model { deviations } | DutKind::External { deviations, .. } => on.put(model(deviations)?),
            DutKind::Null(NullPeer::Absent | NullPeer::Silent) => on.put(PeerWithoutStand(Silent, NoStand)),
            DutKind::Null(NullPeer::Reflector) if is_slave => {
                let delay = Duration::from_nanos(line.baud.nanoseconds(REFLECTS_AFTER));
                on.put(PeerWithoutStand(BusReflector::new(delay), NoStand))
            }
            DutKind::Null(NullPeer::Reflector) => on.put(PeerWithoutStand(Reflector, NoStand)),
            DutKind::Null(NullPeer::Babbler) if is_slave => {
                let babbler = BusBabbler::new(shaft, BABBLES_EACH, line.station, line.masters[0]);
                on.put(PeerWithoutStand(babbler, NoStand))
            }
            DutKind::Null(NullPeer::Babbler) => {
                let babbler = Babbler::new(shaft, BABBLES_EACH, DEVICE.0.0, CONTROLLER.0.0);
                on.put(PeerWithoutStand(babbler, NoStand))
            }
            DutKind::Null(NullPeer::WrongIdentity) => {
                let device = built(&[], true)?;
                let rewrite = if is_slave { other_ident } else { other_identity };
                on.put(PeerWithoutStand(RewritingDevice::new(device, rewrite), NoStand))
            }
            DutKind::Null(NullPeer::DiesAfter(frames)) => {
                on.put(ChangedModel { station: DiesAfter::new(model(&[])?, *frames), model: DiesAfter::station_mut })
            }
            DutKind::Null(NullPeer::Hostile(how)) if how.is_of_profibus != is_slave => {
                let bus = if how.is_of_profibus { "PROFIBUS" } else { "PROFINET" };
                return Err(format!("null:{} is a device on {bus}", how.name));
            }
            DutKind::Null(NullPeer::Hostile(how)) => {
                on.put(ChangedModel { station: SpoiltDevice::new(model(&[])?, how), model: SpoiltDevice::station_mut })
            }
        })
    }
}

/// Connects a device to a new virtual wire, or to a new bus if it is a slave.
pub fn virtual_segment<'a>(device: impl DeviceOnStand + 'a, line: DpLine, is_slave: bool) -> Box<dyn Segment + 'a> {
    SegmentBuilder { is_slave, is_built_in: false, line }.put(device)
}

/// The segment to which a device is connected.
#[derive(Clone, Copy)]
struct SegmentBuilder {
    is_slave: bool,
    is_built_in: bool,
    line: DpLine,
}

impl SegmentBuilder {
    fn put<'a>(self, device: impl DeviceOnStand + 'a) -> Box<dyn Segment + 'a> {
        let DpLine { baud, .. } = self.line;
        if self.is_slave {
            let usual = MasterSettings::new(0, baud);
            // The GSD files of the built-in devices have the defaults of the standard for MaxTsdr; that of another device is unknown.
            let max_tsdr = self.is_built_in.then_some(usual.max_tsdr);
            Box::new(VirtualSegment::bus(device, baud, usual.slot_time, max_tsdr))
        } else {
            Box::new(VirtualSegment::new(device))
        }
    }
}

fn setup(shaft: u64) -> Setup<'static> {
    Setup { mac: DEVICE.0.0, shaft, station_name: STATION_NAME, ..Setup::default() }
}

/// A raw shaft position that depends on the id of the trial and is never 0 (FNV-1a hash, so it is the same on every host).
fn shaft(id: &str) -> u64 {
    let hash = id
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325u64, |hash, octet| (hash ^ u64::from(octet)).wrapping_mul(0x100_0000_01b3));
    hash % 0x3_0000 + 0x1001
}

/// A reference device inside a station that changes or loses its frames; its stand keeps working.
struct ChangedModel<'a, S> {
    station: S,
    model: fn(&mut S) -> &mut ModelOnStand<'a>,
}

impl<S: Station> DeviceOnStand for ChangedModel<'_, S> {
    fn station(&mut self) -> &mut dyn Station {
        &mut self.station
    }

    fn stand(&mut self) -> &mut dyn Stand {
        (self.model)(&mut self.station)
    }
}

/// A conforming device whose frames are all rewritten.
struct RewritingDevice<S> {
    device: S,
    sent: Outbox,
    rewrite: fn(&[u8], &mut Outbox),
}

impl<S: Station> RewritingDevice<S> {
    fn new(device: S, rewrite: fn(&[u8], &mut Outbox)) -> RewritingDevice<S> {
        RewritingDevice { device, sent: Outbox::new(), rewrite }
    }

    fn pass(&mut self, out: &mut Outbox) {
        self.sent.frames().for_each(|frame| (self.rewrite)(frame, out));
        self.sent.clear();
    }
}

impl<S: Station> Station for RewritingDevice<S> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.device.receive(now, frame, &mut self.sent);
        self.pass(out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.device.wake(now, &mut self.sent);
        self.pass(out);
    }

    fn deadline(&self) -> Option<Time> {
        self.device.deadline()
    }
}

/// Replaces vendor and device id in a DCP frame.
fn other_identity(frame: &[u8], out: &mut Outbox) {
    use wire::ethernet::{EtherType, FrameHeader};
    use wire::profinet::dcp::{Dcp, DcpBody, DcpValue};
    let dcp = FrameHeader::parse(frame)
        .ok()
        .filter(|(header, _)| header.ether_type == EtherType::PROFINET)
        .and_then(|(header, payload)| Some((header, Dcp::parse(payload).ok()?)));
    let Some((header, mut dcp)) = dcp else { return out.push(frame) };
    if let DcpBody::Blocks(blocks) = &mut dcp.body {
        for block in blocks {
            if let DcpValue::DeviceId { vendor_id, device_id } = &mut block.value {
                (*vendor_id, *device_id) = (!*vendor_id, !*device_id);
            }
        }
    }
    out.push_with(|out| dcp.write_frame(header.destination, header.source, out));
}

/// Replaces the ident number in a diagnosis.
fn other_ident(octets: &[u8], out: &mut Outbox) {
    use wire::profibus::fdl::{DataFrame, FdlFrame};
    use wire::profibus::sap::{SapService, SlaveSap};
    match FdlFrame::parse(octets) {
        Ok(FdlFrame::Data(frame)) if SapService::of(&frame) == SapService::Slave(SlaveSap::SLAVE_DIAG) => {
            let mut data = frame.data.to_vec();
            data.iter_mut().skip(4).take(2).for_each(|octet| *octet = !*octet);
            out.push_with(|out| DataFrame { data: &data, ..frame }.write(out));
        }
        _ => out.push(octets),
    }
}

impl DutSpec {
    /// The names of its deviations: bugs and permitted variations.
    pub fn deviations(&self) -> &[String] {
        match &self.kind {
            DutKind::Model { deviations } | DutKind::External { deviations, .. } => deviations,
            DutKind::Null(_) | DutKind::Live(_) => &[],
        }
    }

    /// The names of its bugs.
    pub fn bugs(&self) -> Vec<String> {
        self.deviations().iter().filter(|name| !self.is_permitted(name)).cloned().collect()
    }

    /// The names of its permitted variations.
    pub fn variations(&self) -> Vec<String> {
        self.deviations().iter().filter(|name| self.is_permitted(name)).cloned().collect()
    }

    /// The name and the sentence of each variation that the manual permits a reference device; empty for another device.
    pub fn permitted_variations(&self) -> Vec<(&'static str, &'static str)> {
        match &self.kind {
            DutKind::Model { .. } => self.model().map_or_else(
                |_| Vec::new(),
                |model| model.permitted().map(|known| (known.name, known.sentence)).collect(),
            ),
            DutKind::External { .. } | DutKind::Null(_) | DutKind::Live(_) => Vec::new(),
        }
    }

    /// The same reference device with one more deviation.
    #[must_use]
    pub fn with_deviation(&self, name: &str) -> DutSpec {
        let mut dut = self.clone();
        if let DutKind::Model { deviations } = &mut dut.kind {
            deviations.push(name.to_owned());
        }
        dut
    }

    fn is_permitted(&self, name: &str) -> bool {
        self.model().is_ok_and(|model| model.variations_of(name).is_some())
    }

    /// The bugs that no manual lists, each as `name: sentence`.
    pub fn bug_notes(&self) -> Vec<String> {
        deviations::persona_bugs()
            .filter(|bug| self.deviations().iter().any(|name| name == bug.name))
            .map(|bug| format!("{}: {}", bug.name, bug.sentence))
            .collect()
    }
}
