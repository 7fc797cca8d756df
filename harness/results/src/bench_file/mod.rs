//! The bench file: what a live device claims to be, where it is, what holds it, and what may be done to it.
//!
//! It is YAML, read as strictly as a suite: what is misspelt is found, with its line and what was probably meant.
//! `examples/bench.yaml` beside this crate has every key with its reason, `encspec bench init` writes a file from what is
//! found on a segment, `encspec schema` has the keys for an editor. Only two lines have to be there:
//!
//! ```yaml
//! device: lika-xac77-profinet/xac7718
//! link: nic:eth1
//! ```
//!
//! | section | what it decides |
//! | --- | --- |
//! | `device`, `description`, `link`, `station_name`, `mac`, `ip`, `mask`, `controller` | which device is meant, and our own addresses |
//! | `line` | PROFIBUS: rate, parity and slot time of the line, who switches its driver, the addresses on the bus |
//! | `cycle`, `watchdog`, `persona`, `boot_time`, `position_noise`, `direct_cable` | times and tolerances of this bench, and whether its cable has no switch |
//! | `telegrams`, `lacks`, `firmware`, `gsdml`, `gsd`, `ledger` | what it is said to have and to fail; wrong claims are findings |
//! | `stand` | who turns the shaft, cuts the power, looks at LEDs: `control` (a socket), `hooks` (programs), `ask` (a person) |
//! | `pages` | where its web pages are and how their values are labelled, where the manual does not print that |
//! | `consent` | what may be done that lasts; what is not here is not done |
//!
//! A case that needs what the stand cannot do, or what nobody has consented to, is not applicable, and the reason says so.
//! A hook goes before the control channel where both serve a name. This room must not know links or frames.

pub mod command;
mod line;
mod read;
mod stand;

use crate::outcome::DescriptionKind;
use std::fmt;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::time::Duration;
use wire::ethernet::Mac;

use suite::device::{Bus, Device, Origin};
use suite::model::Manual;
use suite_yaml::LoadErrors;

pub use line::{Driver, LineSpec};
pub use read::is_station_name;

/// The manual of devices that have none of their own: a bench says `device: none` and describes them.
pub const ANY_DEVICE: &str = "profinet-io";

/// Reads a bench file and compares it with the manual that it names; everything that is wrong comes back at once.
///
/// For `device: none` the manual is [`ANY_DEVICE`], loaded with the description that [`read_alone`] names.
pub fn read(path: &Path, manuals: &[Manual]) -> Result<BenchFile, LoadErrors> {
    read::file(path, Some(manuals))
}

/// Reads a bench file without looking at manuals: its times and its description, before the manuals are loaded.
///
/// Fails as [`read`] does, but names of variants, telegrams, records and faults are taken as they are.
pub fn read_alone(path: &Path) -> Result<BenchFile, LoadErrors> {
    read::file(path, None)
}

/// What a live device claims to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Claim {
    /// The manual: the name of its folder under `suites`.
    pub manual: String,
    /// The variant.
    pub variant: String,
}

/// Where a live device is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum LinkSpec {
    /// At a network interface of this name.
    Nic(String),
    /// At the other end of a socket that carries Ethernet frames, written as `--dut socket:` has it.
    Socket(String),
    /// At the serial line with this path, which is a PROFIBUS.
    Serial(String),
}

impl LinkSpec {
    /// The kinds of links there are.
    pub const KINDS: [&'static str; 3] = ["nic", "socket", "serial"];

    /// The link of a kind of [`LinkSpec::KINDS`] at an address; none for another kind, or where there is no address.
    pub fn of(kind: &str, address: &str) -> Option<LinkSpec> {
        let make = match kind {
            "nic" => LinkSpec::Nic,
            "socket" => LinkSpec::Socket,
            "serial" => LinkSpec::Serial,
            _ => return None,
        };
        (!address.is_empty()).then(|| make(address.to_owned()))
    }

    /// The bus of devices at it.
    pub fn bus(&self) -> Bus {
        match self {
            LinkSpec::Nic(_) | LinkSpec::Socket(_) => Bus::Profinet,
            LinkSpec::Serial(_) => Bus::Profibus,
        }
    }

    /// What kind of link it is: one of [`LinkSpec::KINDS`].
    pub fn kind(&self) -> &'static str {
        match self {
            LinkSpec::Nic(_) => "nic",
            LinkSpec::Socket(_) => "socket",
            LinkSpec::Serial(_) => "serial",
        }
    }
}

/// As `--dut` has it.
impl fmt::Display for LinkSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LinkSpec::Nic(name) => write!(f, "nic:{name}"),
            LinkSpec::Socket(address) => write!(f, "socket:{address}"),
            LinkSpec::Serial(path) => write!(f, "serial:{path}"),
        }
    }
}

/// A bench: everything that is known about a live device and what holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchFile {
    /// The file, for messages; none for a bench that the command line describes.
    pub path: Option<PathBuf>,
    /// What the device claims to be.
    pub claim: Claim,
    /// For a device without a manual of its own: the file that describes it in the words of `device.yaml`.
    pub description: Option<PathBuf>,
    /// Where it is.
    pub link: LinkSpec,
    /// What is known about a PROFIBUS.
    pub line: LineSpec,
    /// The station name that the device has on this bench; none: the only station that fits the claim is meant.
    pub station_name: Option<String>,
    /// Its MAC address, where it has to be this one.
    pub mac: Option<Mac>,
    /// The address that our controller gives it; none: the one that it has.
    pub ip: Option<Ipv4Addr>,
    /// The mask of the segment.
    pub mask: Ipv4Addr,
    /// Our controller's address; none: one of the device's subnet that nobody has.
    pub controller_ip: Option<Ipv4Addr>,
    /// Our controller's MAC address; none: one derived from the interface's.
    pub controller_mac: Option<Mac>,
    /// The cycle of cases that say none.
    pub cycle: Option<Duration>,
    /// The watchdog of cases that say none.
    pub watchdog: Option<Duration>,
    /// In the manner of which controller the device is addressed: the name of a persona.
    pub persona: Option<String>,
    /// From power to an answer, at most, where it differs from the manual.
    pub boot_time: Option<Duration>,
    /// The vendor's descriptions.
    pub descriptions: Vec<(DescriptionKind, PathBuf)>,
    /// The modules (telegrams) that the device is said to support, by their names in `device.yaml`; none: all.
    pub telegrams: Option<Vec<String>>,
    /// Records and parameters that the device is said to lack, by their names in `device.yaml`.
    pub lacks: Vec<String>,
    /// The firmware that the device is said to have, as I&M0 tells it.
    pub firmware: Option<String>,
    /// The ledger of known failures.
    pub ledger: Option<PathBuf>,
    /// Whether our cable ends at the device, without a switch between, at which LLDP would stop.
    pub direct_cable: bool,
    /// By how many steps a place may differ from what is expected, because the shaft is never quite still.
    pub position_noise: u32,
    /// Its web pages whose looks the manual does not print, by their names in `device.yaml`.
    pub pages: Vec<(String, BenchPage)>,
    /// What holds the device.
    pub stand: StandSpec,
    /// What may be done to it.
    pub consent: Consents,
}

impl BenchFile {
    /// The vendor's description of this kind, a file.
    pub fn description_of(&self, kind: DescriptionKind) -> Option<&Path> {
        self.descriptions.iter().find(|(known, _)| *known == kind).map(|(_, path)| path.as_path())
    }

    /// Gives the web pages of `device` the looks that the bench says they have.
    pub fn describe_pages(&self, device: &mut Device) {
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
            page.shows.iter_mut().for_each(|value| take(&own.shows, &value.name, &mut value.behind));
        }
    }

    /// A bench without a file: nothing holds the device, and nothing that lasts may be done to it.
    pub fn bare(link: LinkSpec, claim: Claim) -> BenchFile {
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
            controller_ip: None,
            controller_mac: None,
            cycle: None,
            watchdog: None,
            persona: None,
            boot_time: None,
            descriptions: Vec::new(),
            telegrams: None,
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

/// A web page as it is on a live device, as far as it is another one than `device.yaml` says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BenchPage {
    /// Where it is.
    pub path: Option<String>,
    /// The fields of its form: our name and the one in the page.
    pub fields: Vec<(String, String)>,
    /// Its values and the texts in front of them.
    pub shows: Vec<(String, String)>,
}

/// What holds a live device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StandSpec {
    /// A Unix socket that understands the control lines of the crate `live`.
    pub control: Option<PathBuf>,
    /// Commands: the stand name as `set` has it (`power`, `fault.x`, `button.x`, `led.x`, `shaft.speed`, `turn`, `renew`,
    /// `clock`) and the command line, in which `{value}` stands for what is to be set.
    pub hooks: Vec<(String, String)>,
    /// Names that an operator serves when asked at the terminal.
    pub ask: Vec<String>,
    /// What can be done with the shaft.
    pub shaft: ShaftAbility,
    /// The folder of the bench file: the programs of hooks are looked for from here on, and run here.
    pub folder: PathBuf,
    /// The names that the other end of `control` says it serves; none: it was not asked, and all of them are counted on.
    pub offers: Option<Vec<String>>,
}

impl StandSpec {
    /// Whether a hook, the operator or the control channel serves this name.
    pub fn serves(&self, name: &str) -> bool {
        let controlled = || self.offers.as_ref().is_none_or(|list| list.iter().any(|offer| offer == name));
        self.hooks.iter().any(|(hook, _)| hook == name)
            || self.ask.iter().any(|ask| ask == name)
            || (self.control.is_some() && controlled())
    }

    /// To how many steps the shaft can be brought to a place; none: it cannot.
    pub fn position(&self) -> Option<f64> {
        self.shaft.position.or((self.control.is_some() && self.shaft == ShaftAbility::default()).then_some(0.0))
    }

    /// To how many revolutions per minute the shaft can be turned at a speed; none: it cannot.
    pub fn speed(&self) -> Option<f64> {
        self.shaft.speed.or((self.control.is_some() && self.shaft == ShaftAbility::default()).then_some(0.0))
    }
}

/// What a stand can do with the shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaftAbility {
    /// Somebody turns it by hand: it moves, but not to a place or at a speed that is known.
    pub hand: bool,
    /// It can be brought to a place, to so many steps.
    pub position: Option<f64>,
    /// It can be turned at a speed, to so many revolutions per minute.
    pub speed: Option<f64>,
}

/// What may be done to a live device that lasts beyond the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Consents {
    /// It may be reset to factory settings.
    pub factory_reset: bool,
    /// Its station name may be changed.
    pub set_name: bool,
    /// Its IP address may be changed for good.
    pub set_ip: bool,
    /// Its station address may be changed over the bus (PROFIBUS).
    pub set_address: bool,
    /// Its memory may be written so many times in a run.
    pub nvm_write: u32,
    /// Its position may be preset: the reference of the machine that it stands in is lost.
    pub position_reference: bool,
    /// It may be told to wait for another firmware, which stops its web server.
    pub firmware: bool,
    /// Nothing else is on the segment that could be disturbed.
    pub alone: bool,
}
