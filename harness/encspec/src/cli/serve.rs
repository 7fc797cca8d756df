//! `encspec serve`: serves reference devices on a network interface, a socket or a serial line.

use super::dut::suggest;
use super::port::PortArgs;
use super::{CommandError, CommandResult, print_message, show};
use clap::Args;
use deviations::{DeviceManual, Line, ManualBus, Setup, Subject, persona_bugs};
use engine::dut::{DEVICE, STATION_NAME};
use link::lines::LineListener;
use link::{LinkError, Serial, SerialBus, SerialSettings, Wire, interrupt, privileges, realtime};
use live::fdl::FdlFrames;
use live::serve::{DeclaredStandNames, DeviceMaker, DeviceServer, InitialDeviceState, ServedDevice, ServedMedium};
use report::ExitStatus;
use station::Time;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Duration;
use suite_yaml::load;
use wire::ethernet::Mac;
use wire::profibus::fdl::BaudRate;

/// The default shaft position of a served device, in hardware steps.
const SHAFT: u64 = 0x1001;

/// The highest bit rate at which a real serial line answers within the slot time.
const FASTEST_SLAVE: u32 = 19_200;

/// Arguments of `encspec serve`.
#[derive(Debug, Args)]
pub(super) struct ServeArgs {
    /// Reference device, model:MANUAL[/VARIANT]; without a variant the first one of the manual
    #[arg(value_name = "MODEL")]
    model: String,
    #[command(flatten)]
    link: ServeLinkArgs,
    /// PROFIBUS: bit rate in bit/s
    #[arg(long, value_name = "BITS", default_value_t = 1_500_000, value_parser = clap::value_parser!(u32).range(1..), requires = "line")]
    baud: u32,
    /// PROFIBUS: station address; with --count that of the first device
    #[arg(long, value_name = "ADDRESS", default_value_t = 3, value_parser = clap::value_parser!(u8).range(0..=126), requires = "line")]
    address: u8,
    /// PROFIBUS: allow rates at which this host cannot answer within the standard slot time; the master must use a longer one
    #[arg(long, requires = "line")]
    patient_master: bool,
    /// Stored station name; an empty name is the factory state
    #[arg(long, value_name = "NAME", default_value = STATION_NAME)]
    name: String,
    /// Stored IP address, with the prefix length unless it is 24 [default: none, the factory state]
    #[arg(long, value_name = "ADDRESS[/LENGTH]", value_parser = address)]
    ip: Option<(Ipv4Addr, Ipv4Addr)>,
    /// MAC address [default: one with the OUI of the manual]
    #[arg(long, value_name = "MAC")]
    mac: Option<Mac>,
    /// Shaft position in hardware steps
    #[arg(long, value_name = "STEPS", default_value_t = SHAFT)]
    shaft: u64,
    /// Enable a bug; may be repeated; `encspec bugs` lists them
    #[arg(long = "bug", value_name = "NAME")]
    bugs: Vec<String>,
    /// Enable a variation that the manual permits, or with random:SEED a random combination of them; may be repeated;
    /// `encspec variations` lists them
    #[arg(long = "vary", value_name = "NAME")]
    variations: Vec<String>,
    /// Unix socket that controls power, shaft and faults, one command a line (`help` lists them); with --count one socket for each
    /// device, PATH.1, PATH.2 and so on
    #[arg(long, value_name = "PATH")]
    control: Option<PathBuf>,
    /// Number of devices; MAC and IP addresses count up from the first, the names end in -1, -2 and so on
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    count: u16,
    /// Stop after this many seconds [default: stop on Ctrl-C]
    #[arg(long, value_name = "SECONDS")]
    duration: Option<u64>,
    /// Do not request real-time scheduling and locked memory
    #[arg(long)]
    no_realtime: bool,
    /// What is done anyway; accepted for scripts
    #[arg(long, hide = true, conflicts_with = "no_realtime")]
    realtime: bool,
}

/// Where the devices are served.
#[derive(Clone, Debug, Args)]
#[group(required = true, multiple = false)]
struct ServeLinkArgs {
    /// Network interface
    #[arg(long, value_name = "IF")]
    nic: Option<String>,
    /// Socket with Ethernet frames as in QEMU's `-netdev stream`: HOST:PORT, /PATH, listen:HOST:PORT or listen:/PATH
    #[arg(long, value_name = "ADDRESS")]
    socket: Option<String>,
    /// Serial line of a PROFIBUS, or a pseudoterminal
    #[arg(long, value_name = "TTY", group = "line")]
    serial: Option<PathBuf>,
    /// Create a pseudoterminal that acts as the serial line of a PROFIBUS, and LINK as a symbolic link to it
    #[arg(long, value_name = "LINK", group = "line")]
    pty: Option<PathBuf>,
}

impl ServeArgs {
    /// Opens the medium. It must fit the bus of `manual`.
    fn medium(&self, manual: &DeviceManual) -> Result<(ServedMedium, String), CommandError> {
        let unusable = |error: LinkError| CommandError::bench(error.to_string());
        let ServeLinkArgs { nic, socket, serial, pty } = &self.link;
        let settings = SerialSettings::new(self.baud);
        let on_bus = |serial: Serial| {
            let place = serial.describe();
            (ServedMedium::from(SerialBus::new(serial, Box::<FdlFrames>::default())), place)
        };
        match (serial, pty, manual.bus) {
            (None, None, ManualBus::Profibus(_)) => Err(CommandError::usage(format!(
                "{} is a PROFIBUS device; serve it with --serial or --pty",
                manual.name
            ))),
            (Some(_), _, ManualBus::Profinet(_)) | (_, Some(_), ManualBus::Profinet(_)) => Err(CommandError::usage(
                format!("{} is a PROFINET device; serve it with --nic or --socket", manual.name),
            )),
            (None, None, ManualBus::Profinet(_)) => {
                let port = PortArgs { nic: nic.clone(), socket: socket.clone() }.wait()?;
                let place = port.describe();
                Ok((Wire::new(port).into(), place))
            }
            (_, Some(link), ManualBus::Profibus(_)) => {
                Ok(on_bus(Serial::controlling(link, &settings).map_err(unusable)?))
            }
            (Some(path), None, ManualBus::Profibus(_)) => {
                let serial = Serial::open(path, &settings).map_err(unusable)?;
                if !serial.is_pty() && self.baud > FASTEST_SLAVE && !self.patient_master {
                    return Err(CommandError::bench(format!(
                        "{} cannot answer within the standard slot time at {} bit/s; use --baud {FASTEST_SLAVE} or less, or raise the \
                         slot time of the master and add --patient-master",
                        serial.describe(),
                        self.baud
                    )));
                }
                Ok(on_bus(serial))
            }
        }
    }
}

fn address(text: &str) -> Result<(Ipv4Addr, Ipv4Addr), String> {
    let (address, length) = text.split_once('/').unwrap_or((text, "24"));
    let address = address.parse().map_err(|_| format!("`{address}` is not an IPv4 address"))?;
    let length: Option<u32> = length.parse().ok().filter(|length| (1..=32).contains(length));
    let length = length.ok_or("a prefix length is a number from 1 to 32")?;
    Ok((address, Ipv4Addr::from(u32::MAX << (32 - length))))
}

/// The reference device that `model:MANUAL[/VARIANT]` names.
fn model(text: &str) -> Result<(&'static Subject, &'static str), String> {
    let Some(what) = text.strip_prefix("model:") else {
        return Err(format!("`{text}` is not a reference device; write model:MANUAL[/VARIANT]"));
    };
    let (manual, variant) = what.split_once('/').map_or((what, None), |(manual, variant)| (manual, Some(variant)));
    let known = deviations::subjects();
    let found = known.iter().find(|known| known.manual.name == manual);
    let found = found.ok_or_else(|| suggest("device", manual, known.iter().map(|known| known.manual.name)))?;
    let variants = found.manual.variants.iter().copied();
    let chosen = variants.clone().find(|known| variant.is_none_or(|variant| variant == *known));
    let unknown = || suggest(&format!("variant of {manual}"), variant.unwrap_or_default(), variants);
    Ok((found, chosen.ok_or_else(unknown)?))
}

/// One of the served devices.
#[derive(Clone, Debug)]
struct ServedReferenceDevice {
    subject: &'static Subject,
    variant: &'static str,
    name: String,
    mac: Mac,
    ip: Ipv4Addr,
    mask: Ipv4Addr,
    shaft: u64,
    line: Line,
    bugs: Rc<[String]>,
}

impl ServedReferenceDevice {
    /// The device with this index, from 0.
    fn of(args: &ServeArgs, number: u16) -> Result<ServedReferenceDevice, String> {
        let (subject, variant) = model(&args.model)?;
        let manual = subject.manual;
        let known = || subject.bugs().chain(persona_bugs()).map(|known| known.name);
        if let Some(unknown) = args.bugs.iter().find(|bug| known().all(|known| known != **bug)) {
            return Err(suggest(&format!("bug of {}", manual.name), unknown, known()));
        }
        let permitted = || subject.permitted().map(|known| known.name);
        if let Some(unknown) = args.variations.iter().find(|name| subject.variations_of(name).is_none()) {
            return Err(suggest(&format!("variation of {}", manual.name), unknown, permitted()));
        }
        let name = match args.count {
            _ if args.name.is_empty() => String::new(),
            1 => args.name.clone(),
            _ => format!("{}-{}", args.name, number + 1),
        };
        let [a, b, octets @ ..] = args.mac.map_or_else(|| manual.mac(DEVICE.0.0), |mac| mac.0);
        let [c, d, e, f] = u32::from_be_bytes(octets).wrapping_add(number.into()).to_be_bytes();
        let (ip, mask) = args.ip.unwrap_or((Ipv4Addr::UNSPECIFIED, Ipv4Addr::UNSPECIFIED));
        let ip = if ip.is_unspecified() { ip } else { Ipv4Addr::from(u32::from(ip).wrapping_add(number.into())) };
        let bugs = [args.bugs.as_slice(), &args.variations].concat().into();
        let line = match manual.bus {
            ManualBus::Profinet(_) => Line::default(),
            ManualBus::Profibus(_) => {
                let address = u8::try_from(u16::from(args.address) + number).ok().filter(|address| *address <= 126);
                let address =
                    address.ok_or("PROFIBUS addresses end at 126; choose a lower --address for the first device")?;
                Line { address, baud: BaudRate(args.baud) }
            }
        };
        let mac = Mac([a, b, c, d, e, f]);
        Ok(ServedReferenceDevice { subject, variant, name, mac, ip, mask, shaft: args.shaft, line, bugs })
    }

    /// A function that builds the device. It is built once here, so that errors are reported now.
    fn device_builder(&self) -> Result<DeviceMaker, String> {
        let station = self.clone();
        let make = move |made| {
            let build =
                if made == InitialDeviceState::Named { Subject::build } else { Subject::build_in_factory_state };
            let bugs: Vec<&str> = station.bugs.iter().map(String::as_str).collect();
            let setup = Setup {
                mac: station.mac.0,
                bugs: &bugs,
                shaft: station.shaft,
                station_name: &station.name,
                ip: station.ip.octets(),
                mask: station.mask.octets(),
                gateway: [0; 4],
                line: station.line,
            };
            build(station.subject, station.variant, &setup).map_err(|error| error.to_string())
        };
        make(InitialDeviceState::Named)?;
        // The same setup was built successfully above.
        Ok(Box::new(move |made| make(made).unwrap_or_else(|why| unreachable!("{why}"))))
    }

    fn announcement(&self) -> String {
        if let ManualBus::Profibus(_) = self.subject.manual.bus {
            return format!("station {} model:{}/{}\n", self.line.address, self.subject.manual.name, self.variant);
        }
        let or = |text: String| if text.is_empty() { "-".to_owned() } else { text };
        let ip = if self.ip.is_unspecified() { String::new() } else { self.ip.to_string() };
        let name = plain_text::printable(&self.name);
        format!("station {} {} {} model:{}/{}\n", or(name), self.mac, or(ip), self.subject.manual.name, self.variant)
    }
}

/// The names of the stand that the suite of the manual defines, for the control channel.
fn names(manual: &str) -> Result<DeclaredStandNames, CommandError> {
    let manuals = load(&suites::sources(), Some(manual))?;
    let Some(stand) = manuals.first().map(|manual| &manual.device.stand) else {
        return Ok(DeclaredStandNames::default());
    };
    let firsts = |of: &[(String, String)]| of.iter().map(|(name, _)| name.clone()).collect();
    Ok(DeclaredStandNames {
        faults: firsts(&stand.faults),
        buttons: firsts(&stand.buttons),
        switches: stand.switches.iter().map(|switch| (switch.name.clone(), switch.home)).collect(),
        leds: stand.leds.iter().map(|(name, _)| name.clone()).collect(),
        counters: firsts(&stand.counters),
    })
}

/// The control socket of the device with this index, from 0.
fn bind_control_socket(args: &ServeArgs, number: u16) -> Result<Option<LineListener>, CommandError> {
    let Some(path) = &args.control else { return Ok(None) };
    let mut path = path.as_os_str().to_owned();
    if args.count > 1 {
        path.push(format!(".{}", number + 1));
    }
    LineListener::bind(Path::new(&path)).map(Some).map_err(|error| CommandError::bench(error.to_string()))
}

pub(super) fn run(args: &ServeArgs) -> CommandResult {
    let stations: Vec<ServedReferenceDevice> = (0..args.count)
        .map(|number| ServedReferenceDevice::of(args, number))
        .collect::<Result<_, _>>()
        .map_err(CommandError::usage)?;
    let names = match (&args.control, stations.first()) {
        (Some(_), Some(first)) => names(first.subject.manual.name)?,
        _ => DeclaredStandNames::default(),
    };
    let unusable = |error: LinkError| CommandError::bench(error.to_string());
    interrupt::watch();
    let first = stations.first().ok_or_else(|| CommandError::usage("there is no device to serve".to_owned()))?;
    let (medium, place) = args.medium(first.subject.manual)?;
    if !args.no_realtime {
        // One note is enough: both requests are refused for the same reason.
        if let Some(refused) = realtime::raise().refused.first() {
            print_message(&format!(
                "answers may be late on a busy host: {refused}; --no-realtime disables the request"
            ));
        }
    }
    privileges::drop().map_err(unusable)?;
    let mut server = DeviceServer::new(medium);
    for (number, station) in (0..).zip(&stations) {
        let device = ServedDevice::new(station.device_builder().map_err(CommandError::usage)?, &names);
        server.add(station.mac.0, device, bind_control_socket(args, number)?);
    }
    show(&stations.iter().map(ServedReferenceDevice::announcement).collect::<String>());
    show(&format!("ready {} at {place}\n", stations.len()));
    let end = args.duration.map_or(Time::MAX, |seconds| server.now() + Duration::from_secs(seconds));
    server.run(end, &mut interrupt::requested, &mut |note| print_message(note)).map_err(unusable)?;
    Ok(ExitStatus::Green)
}
