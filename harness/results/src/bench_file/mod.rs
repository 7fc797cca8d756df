//! The bench file: which live device to test, its link, its stand, and the permitted changes.
//!
//! The file is YAML and is checked as strictly as a suite: a misspelt key is an error with its line and a suggestion.
//! `harness/encspec/examples/bench.yaml` explains every key, `encspec bench init` writes a file for a device on a segment,
//! `encspec schema` writes the schema for an editor. Only two lines are required:
//!
//! ```yaml
//! device: lika-xac77-profinet/xac7718
//! link: nic:eth1
//! ```
//!
//! | keys | meaning |
//! | --- | --- |
//! | `device`, `description`, `link`, `station_name`, `mac`, `ip`, `mask`, `ip_permanence`, `controller` | the device, and the addresses of the controller |
//! | `line` | PROFIBUS: baud rate, parity and slot time of the line, control of its driver, the addresses on the bus |
//! | `cycle`, `watchdog`, `persona`, `boot_time`, `timing`, `tolerance`, `position_noise`, `direct_cable` | times and tolerances of this bench, and whether the cable has no switch |
//! | `telegrams`, `lacks`, `firmware`, `gsdml`, `gsd`, `ledger` | claims about the device and its known failures; wrong claims are findings |
//! | `stand` | how the shaft is turned, the power is cut and LEDs are read: `control` (a socket), `hooks` (programs), `ask` (an operator) |
//! | `pages` | paths and labels of web pages that the manual does not print |
//! | `consent` | permitted lasting changes; nothing else is changed |
//!
//! A case that needs an ability or a consent that is missing is not applicable, with a reason. If a hook and the control channel
//! serve the same name, the hook is used.

pub mod command;
pub mod keys;
mod line;
mod read;
mod stand;

use crate::outcome::DescriptionKind;
use expression::Value;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::time::Duration;
use wire::ethernet::Mac;

use suite::device::{Bus, DeviceDescription, Origin};
use suite::model::Manual;
use suite_yaml::LoadErrors;

pub use line::{Driver, LineSpec};
pub use read::is_station_name;

/// The manual for PROFINET devices without a manual; the bench file has `device: none` and a description.
pub const ANY_DEVICE: &str = "profinet-io";

/// The manual for PROFIBUS devices without a manual; the bench file has `device: none` and a GSD or a description.
pub const ANY_SLAVE: &str = "dp-slave";

/// Reads a bench file and checks it against the manual that it names; returns all errors at once.
///
/// For `device: none` the manual is [`ANY_DEVICE`] or [`ANY_SLAVE`], loaded with the description that [`read_alone`] returns.
pub fn read(path: &Path, manuals: &[Manual]) -> Result<BenchFile, LoadErrors> {
    read::file(path, Some(manuals))
}

/// Reads a bench file without manuals, for its times and its description, before the manuals are loaded.
///
/// Returns errors as [`read`] does, but names of variants, telegrams, records and faults are not checked.
pub fn read_alone(path: &Path) -> Result<BenchFile, LoadErrors> {
    read::file(path, None)
}

/// The manual and variant that a live device is tested against.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceClaim {
    /// Name of the manual, which is its folder under `suites`.
    pub manual: String,
    pub variant: String,
}

/// The link to a live device.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum LinkSpec {
    /// A network interface.
    Nic(String),
    /// A socket that carries Ethernet frames, written as in `--dut socket:`.
    Socket(String),
    /// The path of a serial line with PROFIBUS.
    Serial(String),
    /// The command of a program that is the application of a device, on either bus.
    App(String),
}

impl LinkSpec {
    /// The kinds of links.
    pub const KINDS: [&'static str; 4] = ["nic", "socket", "serial", "app"];

    /// The link of a kind of [`LinkSpec::KINDS`] with an address; `None` for another kind or an empty address.
    pub fn of(kind: &str, address: &str) -> Option<LinkSpec> {
        let make = match kind {
            "nic" => LinkSpec::Nic,
            "socket" => LinkSpec::Socket,
            "serial" => LinkSpec::Serial,
            "app" => LinkSpec::App,
            _ => return None,
        };
        (!address.is_empty()).then(|| make(address.to_owned()))
    }

    /// The bus of the link; `None` if it carries either.
    pub fn bus(&self) -> Option<Bus> {
        match self {
            LinkSpec::Nic(_) | LinkSpec::Socket(_) => Some(Bus::Profinet),
            LinkSpec::Serial(_) => Some(Bus::Profibus),
            LinkSpec::App(_) => None,
        }
    }

    /// The kind: one of [`LinkSpec::KINDS`].
    pub fn kind(&self) -> &'static str {
        match self {
            LinkSpec::Nic(_) => "nic",
            LinkSpec::Socket(_) => "socket",
            LinkSpec::Serial(_) => "serial",
            LinkSpec::App(_) => "app",
        }
    }
}

/// Formats the link as in `--dut`.
impl fmt::Display for LinkSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LinkSpec::Nic(name) => write!(f, "nic:{name}"),
            LinkSpec::Socket(address) => write!(f, "socket:{address}"),
            LinkSpec::Serial(path) => write!(f, "serial:{path}"),
            LinkSpec::App(command) => write!(f, "app:{command}"),
        }
    }
}

/// A bench file.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchFile {
    /// The file, for messages; `None` for a bench from command-line options.
    pub path: Option<PathBuf>,
    /// The manual and variant that the device is tested against.
    pub claim: DeviceClaim,
    /// For a device without a manual: the file that describes it with the keys of `device.yaml`.
    pub description: Option<PathBuf>,
    pub link: LinkSpec,
    /// Settings of a PROFIBUS line.
    pub line: LineSpec,
    /// Station name of the device on this bench; `None`: the only station that matches the claim.
    pub station_name: Option<String>,
    /// Required MAC address of the device.
    pub mac: Option<Mac>,
    /// IP address that the controller assigns to the device; `None`: its current address.
    pub ip: Option<Ipv4Addr>,
    /// Subnet mask of the segment.
    pub mask: Ipv4Addr,
    /// Whether the device has stored the IP address that it has before the run; `None`: not known.
    pub ip_permanence: Option<DcpPermanence>,
    /// IP address of the controller; `None`: a free address of the device's subnet.
    pub controller_ip: Option<Ipv4Addr>,
    /// MAC address of the controller; `None`: derived from that of the interface.
    pub controller_mac: Option<Mac>,
    /// Default cycle of cases.
    pub cycle: Option<Duration>,
    /// Default watchdog of cases.
    pub watchdog: Option<Duration>,
    /// Name of the persona of the controller.
    pub persona: Option<String>,
    /// Maximum time from power-up to the first answer, if it differs from the manual.
    pub boot_time: Option<Duration>,
    /// Times of ours that are others on this bench.
    pub timing: BenchTiming,
    /// Tolerances of ours that are others on this bench.
    pub tolerances: Vec<(String, Value)>,
    /// Device descriptions of the vendor.
    pub descriptions: Vec<(DescriptionKind, PathBuf)>,
    /// Start parameters by their names in `device.yaml`, each with its name in the GSDML or GSD, on which a person decided.
    pub start_parameters: Vec<(String, String)>,
    /// The name of the module in the GSD that a slave without a manual has.
    pub gsd_module: Option<String>,
    /// The modules (telegrams) that the device supports, by their names in `device.yaml`; `None`: all.
    pub telegrams: Option<Vec<String>>,
    /// Records and parameters that the device does not have, by their names in `device.yaml`.
    pub lacks: Vec<String>,
    /// Firmware version of the device, as reported in I&M0.
    pub firmware: Option<String>,
    /// The ledger of known failures.
    pub ledger: Option<PathBuf>,
    /// Whether the cable ends at the device, without a switch that would stop LLDP.
    pub direct_cable: bool,
    /// By how many steps a position may differ from the expected one because the shaft is never completely still.
    pub position_noise: u32,
    /// Web pages whose layout the manual does not print, by their names in `device.yaml`.
    pub pages: Vec<(String, BenchPage)>,
    /// The stand.
    pub stand: StandSpec,
    /// Permitted lasting changes.
    pub consent: Consents,
}

impl BenchFile {
    /// The file with the vendor's description of this kind.
    pub fn description_of(&self, kind: DescriptionKind) -> Option<&Path> {
        self.descriptions.iter().find(|(known, _)| *known == kind).map(|(_, path)| path.as_path())
    }

    /// Overwrites paths and labels of the web pages of `device` with those of the bench file.
    pub fn describe_pages(&self, device: &mut DeviceDescription) {
        let take = |list: &[(String, String)], name: &str, into: &mut String| {
            if let Some((_, own)) = list.iter().find(|(known, _)| known == name) {
                into.clone_from(own);
            }
        };
        for page in &mut device.pages {
            let Some((_, own)) = self.pages.iter().find(|(known, _)| *known == page.name) else { continue };
            page.origin = Origin::Description;
            page.path = own.path.clone().unwrap_or_else(|| page.path.clone());
            page.fields.iter_mut().for_each(|(name, field)| take(&own.fields, name, field));
            page.shows.iter_mut().for_each(|value| take(&own.shows, &value.name, &mut value.label));
        }
    }

    /// A bench without a file: no stand and no consents.
    pub fn bare(link: LinkSpec, claim: DeviceClaim) -> BenchFile {
        BenchFile {
            path: None,
            claim,
            description: None,
            link,
            line: LineSpec::default(),
            station_name: None,
            mac: None,
            ip: None,
            mask: Ipv4Addr::new(255, 255, 255, 0),
            ip_permanence: None,
            controller_ip: None,
            controller_mac: None,
            cycle: None,
            watchdog: None,
            persona: None,
            boot_time: None,
            timing: BenchTiming::default(),
            tolerances: Vec::new(),
            descriptions: Vec::new(),
            telegrams: None,
            start_parameters: Vec::new(),
            gsd_module: None,
            lacks: Vec::new(),
            firmware: None,
            ledger: None,
            direct_cable: false,
            position_noise: 0,
            pages: Vec::new(),
            stand: StandSpec::default(),
            consent: Consents::default(),
        }
    }
}

/// Whether a device keeps its IP address or station name when it loses power.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DcpPermanence {
    /// It is stored.
    Permanent,
    /// It is lost with the power.
    Temporary,
    /// Not known; it is put back as a permanent one.
    #[default]
    Unknown,
}

/// Formats the word of the journal.
impl fmt::Display for DcpPermanence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            DcpPermanence::Permanent => "permanent",
            DcpPermanence::Temporary => "temporary",
            DcpPermanence::Unknown => "permanence unknown, assumed permanent",
        })
    }
}

/// Times of ours that a bench changes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BenchTiming {
    /// By the names of `timing` in `device.yaml`.
    pub ours: Vec<(String, Value)>,
    /// The factor up to which slowness is only noted.
    pub patience: Option<u32>,
}

/// Differences of a web page of a live device from `device.yaml`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BenchPage {
    /// Path of the page.
    pub path: Option<String>,
    /// Fields of its form: name in the suite, name in the page.
    pub fields: Vec<(String, String)>,
    /// Its values: name in the suite, text before the value.
    pub shows: Vec<(String, String)>,
}

/// The stand of a live device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StandSpec {
    /// A Unix socket that accepts the control commands of the crate `live`.
    pub control: Option<PathBuf>,
    /// Hooks: the stand name as in `set` (`power`, `fault.x`, `button.x`, `led.x`, `shaft.speed`, `turn`, `renew`, `clock`) and
    /// the command line, in which `{value}` is the value to set.
    pub hooks: Vec<(String, String)>,
    /// Names that the operator serves at the terminal.
    pub ask: Vec<String>,
    /// What the stand can do with the shaft.
    pub shaft: ShaftAbility,
    /// The folder of the bench file, in which hooks are run and relative program paths are resolved.
    pub folder: PathBuf,
    /// The names that the peer at `control` reports; `None`: not queried, all names are assumed to be served.
    pub offers: Option<Vec<String>>,
}

impl StandSpec {
    /// Whether a hook, the operator or the control channel serves the name.
    pub fn serves(&self, name: &str) -> bool {
        let controlled = || self.offers.as_ref().is_none_or(|list| list.iter().any(|offer| offer == name));
        self.hooks.iter().any(|(hook, _)| hook == name)
            || self.ask.iter().any(|ask| ask == name)
            || (self.control.is_some() && controlled())
    }

    /// Accuracy in steps with which the shaft can be positioned; `None`: it cannot be positioned.
    pub fn position(&self) -> Option<f64> {
        self.shaft.position.or((self.control.is_some() && self.shaft.is_unsaid()).then_some(0.0))
    }

    /// What it can do, in words: the names that it serves, and how it moves the shaft.
    pub fn abilities(&self) -> Vec<String> {
        let offers = self.offers.clone().unwrap_or_else(|| vec!["whatever the control channel serves".to_owned()]);
        let controlled = self.control.iter().flat_map(|_| offers.clone());
        let hooks = self.hooks.iter().map(|(name, _)| name.clone());
        let asked = self.ask.iter().map(|name| format!("{name} (the operator)"));
        let shaft = self.shaft.hand.then(|| "shaft by hand".to_owned());
        let uncoupled = self.shaft.uncoupled.then(|| "shaft uncoupled".to_owned());
        let mut all: Vec<String> = controlled.chain(hooks).chain(asked).chain(shaft).chain(uncoupled).collect();
        all.extend(self.position().map(|steps| format!("shaft to a position (±{steps} steps)")));
        all.extend(self.speed().map(|speed| format!("shaft at a speed (±{speed} revolutions per minute)")));
        all
    }

    /// Accuracy in revolutions per minute with which the shaft can be turned; `None`: it cannot be turned at a speed.
    pub fn speed(&self) -> Option<f64> {
        self.shaft.speed.or((self.control.is_some() && self.shaft.is_unsaid()).then_some(0.0))
    }
}

/// What a stand can do with the shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaftAbility {
    /// The operator turns it by hand, with unknown position and speed.
    pub hand: bool,
    /// It can be positioned, with this accuracy in steps.
    pub position: Option<f64>,
    /// It can be turned at a speed, with this accuracy in revolutions per minute.
    pub speed: Option<f64>,
    /// It is coupled to nothing, and nothing is driven by the position.
    pub uncoupled: bool,
}

impl ShaftAbility {
    /// Whether nothing says how it is moved.
    pub fn is_unsaid(&self) -> bool {
        !self.hand && self.position.is_none() && self.speed.is_none()
    }
}

/// Permitted changes to a live device that last beyond the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Consents {
    /// Reset to factory settings.
    pub factory_reset: bool,
    /// Change the station name.
    pub set_name: bool,
    /// Change the stored IP address.
    pub set_ip: bool,
    /// Change the station address over the bus (PROFIBUS).
    pub set_address: bool,
    /// Overwrite I&M1 to I&M4.
    pub im_records: bool,
    /// Lock the station address against further changes until the device is reset (PROFIBUS).
    pub lock_address: bool,
    /// Maximum number of writes to non-volatile memory in a run.
    pub nvm_write: u32,
    /// Preset the position; the reference of the machine that the encoder is mounted in is lost.
    pub position_reference: bool,
    /// Put it into the mode that waits for a firmware update, which stops its web server.
    pub firmware: bool,
    /// Set supply and temperature beyond what the manual permits, which can damage the device.
    pub overstress: bool,
    /// No other station is on the segment that tests could disturb.
    pub alone: bool,
}

impl Consents {
    /// What is permitted, as the bench file names it.
    pub fn words(&self) -> Vec<String> {
        let flags = [
            ("factory_reset", self.factory_reset),
            ("set_name", self.set_name),
            ("set_ip", self.set_ip),
            ("set_address", self.set_address),
            ("im_records", self.im_records),
            ("lock_address", self.lock_address),
            ("position_reference", self.position_reference),
            ("firmware", self.firmware),
            ("overstress", self.overstress),
            ("alone", self.alone),
        ];
        let given = flags.into_iter().filter(|(_, is)| *is).map(|(name, _)| name.to_owned());
        given.chain((self.nvm_write > 0).then(|| format!("nvm_write: {}", self.nvm_write))).collect()
    }
}
