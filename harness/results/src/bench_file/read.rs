//! Reads a bench file: identity, addresses, times, claims, consents.

use super::keys::{PERMANENCES, bench, bench_consent, bench_controller, bench_page};
use super::line::line;
use super::stand::stand;
use super::{ANY_DEVICE, ANY_SLAVE, BenchFile, BenchPage, BenchTiming, Consents, DeviceClaim, LinkSpec, StandSpec};
use crate::outcome::DescriptionKind;
use expression::Value;
use std::fs;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use suite::Location;
use suite::device::{DeviceDescription, OurSpan};
use suite::model::Manual;
use suite_yaml::LoadErrors;
use suite_yaml::device_yaml::{OurKind, duration, fields, flag, named, our_value, path, patience, plain, whole};
use suite_yaml::error::{LoadError, Mistake, Mistakes, Read};
use suite_yaml::keys::{Key, Keyed};
use suite_yaml::persona::persona_name;
use suite_yaml::start::{checked_cycle, checked_watchdog};
use suite_yaml::yaml::{self, Node};
use wire::ethernet::Mac;
use wire::profinet::dcp::station_name::{NameProblem, check};

/// The default subnet mask.
const MASK: Ipv4Addr = Ipv4Addr::new(255, 255, 255, 0);
/// The default cycle, which a watchdog is compared with.
const CYCLE: Duration = Duration::from_millis(2);
/// The largest value of `boot_time`.
const LONGEST_BOOT: Duration = Duration::from_secs(600);

/// Reads the file; without manuals the names of the device are not checked.
pub(super) fn file(path: &Path, manuals: Option<&[Manual]>) -> Result<BenchFile, LoadErrors> {
    let shown = Arc::new(path.to_owned());
    let failed = |message: String| {
        let at = Location { file: Arc::clone(&shown), line: 0, column: 0 };
        LoadErrors(vec![LoadError { at, width: 0, line: String::new(), message, help: None }])
    };
    let octets = fs::read(path).map_err(|error| failed(error.to_string()))?;
    let text = String::from_utf8(octets).map_err(|_| failed("the file is not UTF-8 text".to_owned()))?;
    let mistakes = Mistakes::default();
    let read = mistakes.keep(yaml::parse(0, &text)).and_then(|node| bench(&node, path, manuals, &mistakes));
    match read {
        Some(bench) if mistakes.count() == 0 => Ok(bench),
        _ => Err(LoadErrors(mistakes.take().into_iter().map(|mistake| located(mistake, &shown, &text)).collect())),
    }
}

fn located(mistake: Mistake, file: &Arc<PathBuf>, text: &str) -> LoadError {
    let spot = mistake.spot;
    let line = (spot.line as usize).checked_sub(1).and_then(|line| text.lines().nth(line)).unwrap_or_default();
    LoadError {
        at: Location { file: Arc::clone(file), line: spot.line, column: spot.column },
        width: spot.width.max(1) as usize,
        line: line.to_owned(),
        message: mistake.message,
        help: mistake.help,
    }
}

fn bench(node: &Node, path: &Path, manuals: Option<&[Manual]>, mistakes: &Mistakes) -> Option<BenchFile> {
    let keyed = mistakes.keep(Keyed::new(node, &bench::KEYS))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let link = mistakes.keep(keyed.must(&bench::link).and_then(link));
    // A program is on the bus of its description.
    let with_gsd = || keyed.key(&bench::gsd).is_some();
    let on_profibus = link.as_ref().is_some_and(|link| link.bus().map_or_else(with_gsd, |bus| bus.is_profibus()));
    let any = if on_profibus { ANY_SLAVE } else { ANY_DEVICE };
    let claimed = mistakes.keep(keyed.must(&bench::device).and_then(|node| claim(node, manuals, any)));
    let device = claimed.as_ref().and_then(|(_, manual)| manual.map(|manual| &*manual.device));
    let is_any =
        keyed.get(&bench::device).and_then(Node::scalar).is_some_and(|text| text.split('/').next() == Some("none"));
    if let (Some(link), Some(device)) = (&link, device)
        && link.bus().is_some_and(|bus| bus != device.bus.kind())
    {
        let right = suite_yaml::dialect::links(device.bus.kind());
        let wrong = format!("{} cannot be connected to the link {link}", device.name);
        mistakes.note(keyed.node.key(bench::link.name).wrong(wrong).help(format!("use {right}")));
    }
    let reader = BenchReader { keyed, mistakes, folder };

    let description = reader.path(&bench::description);
    let is_described = keyed.key(if on_profibus { &bench::gsd } else { &bench::gsdml }).is_some();
    match (keyed.key(&bench::description), is_any) {
        (Some(key), false) => mistakes.note(
            key.wrong("`description` is for a device without a manual").help("write `device: none`, or remove the key"),
        ),
        (None, true) if !is_described => {
            let help = if on_profibus {
                "name its GSD under `gsd`, or a file that describes the device with the keys of device.yaml"
            } else {
                "name the GSDML of a PROFIdrive encoder under `gsdml`, or a file that describes the device with the keys of device.yaml"
            };
            let node = keyed.node.key(bench::device.name);
            mistakes.note(node.wrong("a device without a manual needs a `description`").help(help));
        }
        _ => {}
    }
    let (ip, mask, controller_ip, controller_mac) = reader.addresses();
    let (cycle, watchdog, boot_time) = reader.times();
    let timing = reader.value(&bench::timing, |node| timing(node, device, mistakes)).unwrap_or_default();
    let tolerances = reader.value(&bench::tolerance, |node| tolerances(node, device, mistakes)).unwrap_or_default();
    let line = keyed.get(&bench::line).and_then(|node| mistakes.keep(line(node)));
    let stand = keyed.get(&bench::stand).and_then(|node| mistakes.keep(stand(node, folder, device, mistakes)));
    Some(BenchFile {
        path: Some(path.to_owned()),
        claim: claimed.map(|(claim, _)| claim)?,
        description,
        link: link?,
        line: line.unwrap_or_default(),
        station_name: reader.value(&bench::station_name, station_name),
        mac: reader.value(&bench::mac, mac),
        ip,
        mask,
        ip_permanence: mistakes.keep(keyed.word(&bench::ip_permanence, &PERMANENCES)).flatten(),
        controller_ip,
        controller_mac,
        cycle,
        watchdog,
        persona: reader.value(&bench::persona, persona_name),
        boot_time,
        timing,
        tolerances,
        descriptions: DescriptionKind::ALL
            .into_iter()
            .filter_map(|kind| Some((kind, reader.path(bench::KEYS.key(kind.key())?)?)))
            .collect(),
        start_parameters: reader
            .value(&bench::start_parameters, |node| start_parameters(node, device))
            .unwrap_or_default(),
        gsd_module: reader.value(&bench::gsd_module, |node| node.text("the name of a module").map(str::to_owned)),
        telegrams: reader.value(&bench::telegrams, |node| telegrams(node, device)),
        lacks: reader.value(&bench::lacks, |node| lacks(node, device)).unwrap_or_default(),
        firmware: reader.value(&bench::firmware, firmware),
        ledger: reader.path(&bench::ledger),
        direct_cable: reader.flag(&bench::direct_cable),
        position_noise: reader.value(&bench::position_noise, |node| whole(node, "a noise")).unwrap_or(0),
        pages: reader.value(&bench::pages, |node| pages(node, device)).unwrap_or_default(),
        stand: stand.unwrap_or_else(StandSpec::default),
        consent: reader.value(&bench::consent, consent).unwrap_or_default(),
    })
}

/// Reads the values of the top level.
struct BenchReader<'n> {
    keyed: Keyed<'n>,
    mistakes: &'n Mistakes,
    folder: &'n Path,
}

impl BenchReader<'_> {
    fn value<T>(&self, key: &Key, read: impl FnOnce(&Node) -> Read<T>) -> Option<T> {
        self.mistakes.keep(self.keyed.get(key).map(read).transpose()).flatten()
    }

    fn flag(&self, key: &Key) -> bool {
        self.mistakes.keep(flag(self.keyed, key)).unwrap_or_default()
    }

    /// The path of a file, relative to the bench file or absolute.
    fn path(&self, key: &Key) -> Option<PathBuf> {
        self.value(key, |node| {
            let path = self.folder.join(node.text(key.name)?);
            match fs::File::open(&path).and_then(|file| file.metadata()) {
                Ok(metadata) if metadata.is_file() => Ok(path),
                Ok(_) => Err(node.wrong(format!("{} is not a file", path.display()))),
                Err(error) => Err(node
                    .wrong(format!("{}: {error}", path.display()))
                    .help("paths are relative to the folder of the bench file")),
            }
        })
    }

    fn addresses(&self) -> (Option<Ipv4Addr>, Ipv4Addr, Option<Ipv4Addr>, Option<Mac>) {
        let ip = self.value(&bench::ip, host);
        let mask = self.value(&bench::mask, mask).unwrap_or(MASK);
        let controller =
            self.keyed.get(&bench::controller).map(|node| Keyed::new(node, &bench_controller::KEYS)).transpose();
        let controller = self.mistakes.keep(controller).flatten();
        let of = |key: &Key| controller.as_ref().and_then(|keyed| keyed.get(key));
        let controller_ip = self.mistakes.keep(of(&bench_controller::ip).map(host).transpose()).flatten();
        let controller_mac = self.mistakes.keep(of(&bench_controller::mac).map(mac).transpose()).flatten();
        let note = |node: Option<&Node>, wrong: &str| {
            node.into_iter().for_each(|node| self.mistakes.note(node.wrong(wrong)));
        };
        if let (Some(ours), Some(ip)) = (controller_ip, ip) {
            if ours == ip {
                note(of(&bench_controller::ip), "controller and device cannot have the same address");
            } else if ours & mask != ip & mask {
                note(of(&bench_controller::ip), "controller and device are not in the same subnet");
            }
        }
        let address = controller_ip.or(ip);
        if address.is_some_and(|ip| ip & mask == ip || ip | !mask == ip) {
            let node = if controller_ip.is_some() { of(&bench_controller::ip) } else { self.keyed.get(&bench::ip) };
            note(node, "this is the network or broadcast address of its subnet, which no station can have");
        }
        (ip, mask, controller_ip, controller_mac)
    }

    fn times(&self) -> (Option<Duration>, Option<Duration>, Option<Duration>) {
        let cycle = self.value(&bench::cycle, |node| checked_cycle(duration(node, "a cycle")?, node));
        let watchdog = self.value(&bench::watchdog, |node| {
            checked_watchdog(duration(node, "a watchdog")?, cycle.unwrap_or(CYCLE), node)
        });
        let boot_time = self.value(&bench::boot_time, |node| match duration(node, "a boot time")? {
            time if time.is_zero() || time > LONGEST_BOOT => {
                Err(node.wrong("a boot time must be more than 0 and at most 10min"))
            }
            time => Ok(time),
        });
        (cycle, watchdog, boot_time)
    }
}

/// Times of ours that are others on the bench; the names are those of the manual.
fn timing(node: &Node, device: Option<&DeviceDescription>, mistakes: &Mistakes) -> Read<BenchTiming> {
    let mut timing = BenchTiming::default();
    for (name, value) in named(node, "timing")? {
        if name == "patience" {
            timing.patience = mistakes.keep(patience(value));
            continue;
        }
        let known = device.map(|device| device.timing.ours.as_slice());
        timing.ours.extend(mistakes.keep(our_span(node, (name, value), OurKind::Time, known)));
    }
    Ok(timing)
}

fn tolerances(node: &Node, device: Option<&DeviceDescription>, mistakes: &Mistakes) -> Read<Vec<(String, Value)>> {
    let known = device.map(|device| device.timing.tolerances.as_slice());
    let read = |entry| mistakes.keep(our_span(node, entry, OurKind::Tolerance, known));
    Ok(named(node, "tolerance")?.into_iter().filter_map(read).collect())
}

fn our_span(
    node: &Node,
    (name, value): (&str, &Node),
    kind: OurKind,
    known: Option<&[OurSpan]>,
) -> Read<(String, Value)> {
    match known {
        Some(known) if known.iter().all(|known| known.name != name) => {
            let names = known.iter().map(|known| known.name.as_str());
            Err(Mistake::unknown(node.key(name).spot, &format!("{} of ours", kind.word()), name, names))
        }
        _ => Ok((name.to_owned(), our_value(value, kind)?)),
    }
}

/// The claim, and the manual if manuals are loaded.
///
/// `any` is the manual for a device without one.
fn claim<'m>(node: &Node, manuals: Option<&'m [Manual]>, any: &str) -> Read<(DeviceClaim, Option<&'m Manual>)> {
    let text = node.text("device")?;
    let (name, variant) = text.split_once('/').map_or((text, None), |(name, variant)| (name, Some(variant)));
    let folder = if name == "none" { any } else { name };
    let Some(manuals) = manuals else {
        let claim = DeviceClaim { manual: folder.to_owned(), variant: variant.unwrap_or_default().to_owned() };
        return Ok((claim, None));
    };
    let Some(manual) = manuals.iter().find(|manual| manual.device.name == folder) else {
        let known: Vec<&str> = manuals.iter().map(|manual| manual.device.name.as_str()).chain(["none"]).collect();
        return Err(Mistake::unknown(node.spot, "manual", name, known));
    };
    let variants = &manual.device.variants;
    let variant = match (variant, variants.as_slice()) {
        (None, [only]) => only,
        (None, _) => {
            let all: Vec<usize> = (0..variants.len()).collect();
            return Err(node
                .wrong(format!("`{name}` has several variants, and this line does not say which it is"))
                .help(manual.device.variant_question(&all)));
        }
        (Some(variant), _) => match variants.iter().find(|known| *known == variant) {
            Some(known) => known,
            None => {
                let known = variants.iter().map(String::as_str);
                return Err(Mistake::unknown(node.spot, &format!("variant of {name}"), variant, known));
            }
        },
    };
    Ok((DeviceClaim { manual: folder.to_owned(), variant: variant.clone() }, Some(manual)))
}

fn link(node: &Node) -> Read<LinkSpec> {
    let text = node.text("link")?;
    let Some((kind, address)) = text.split_once(':') else {
        return Err(node.wrong("a link must be `nic:INTERFACE`, `socket:ADDRESS`, `serial:TTY` or `app:COMMAND`"));
    };
    if !LinkSpec::KINDS.contains(&kind) {
        return Err(Mistake::unknown(node.spot, "kind of link", kind, LinkSpec::KINDS));
    }
    LinkSpec::of(kind, address).ok_or_else(|| node.wrong(format!("the address after `{kind}:` is missing")))
}

/// Whether a text is a station name: labels of 1 to 63 lowercase letters, digits and inner hyphens, separated by dots, at most
/// 240 bytes in all. A name that looks like an IP address or a port counts as well.
pub fn is_station_name(text: &str) -> bool {
    let found = check(text.as_bytes());
    matches!(found, Ok(()) | Err(NameProblem::LikeAnAddress | NameProblem::LikeAPort))
}

fn station_name(node: &Node) -> Read<String> {
    let text = node.text("a station name")?;
    if is_station_name(text) {
        Ok(text.to_owned())
    } else {
        Err(node
            .wrong(format!("`{}` is not a station name", text.escape_default()))
            .help("use lowercase letters, digits, inner hyphens, and dots between labels of at most 63 characters"))
    }
}

fn mac(node: &Node) -> Read<Mac> {
    let mac: Mac = node.text("a MAC address")?.parse().map_err(|error| node.wrong(format!("{error}")))?;
    if mac.0[0] & 1 == 0 && mac.0 != [0; 6] {
        Ok(mac)
    } else {
        Err(node.wrong("no station can have this MAC address: it is a group address or zero"))
    }
}

fn address(node: &Node) -> Read<Ipv4Addr> {
    let text = node.text("an address")?;
    text.parse().map_err(|_| node.wrong(format!("`{}` is not an IPv4 address", text.escape_default())))
}

fn host(node: &Node) -> Read<Ipv4Addr> {
    let ip = address(node)?;
    if ip.is_unspecified() || ip.is_loopback() || ip.is_multicast() || ip.is_broadcast() {
        Err(node.wrong(format!("no station can have the address {ip}")))
    } else {
        Ok(ip)
    }
}

fn mask(node: &Node) -> Read<Ipv4Addr> {
    let mask = address(node)?;
    let bits = u32::from(mask);
    if (1..=30).contains(&bits.leading_ones()) && bits.leading_ones() + bits.trailing_zeros() == 32 {
        Ok(mask)
    } else {
        Err(node
            .wrong("a subnet mask has one bits, then zero bits, and space for two stations")
            .help("for instance 255.255.255.0"))
    }
}

/// A list of distinct names; `check` returns the error of a name.
fn names(node: &Node, what: &str, check: impl Fn(&Node, &str) -> Read<()>) -> Read<Vec<String>> {
    let mut names: Vec<String> = Vec::new();
    for item in node.items(what)? {
        let name = item.text("a name")?;
        check(item, name)?;
        if names.iter().any(|known| known == name) {
            return Err(item.wrong(format!("`{name}` is listed twice in {what}")));
        }
        names.push(name.to_owned());
    }
    if names.is_empty() { Err(node.wrong(format!("{what} is empty")).help("remove the key")) } else { Ok(names) }
}

fn telegrams(node: &Node, device: Option<&DeviceDescription>) -> Read<Vec<String>> {
    names(node, "telegrams", |node, name| {
        let Some(device) = device else { return Ok(()) };
        let known = || device.modules.iter().map(|module| module.name.as_str());
        if known().any(|known| known == name) {
            Ok(())
        } else {
            Err(Mistake::unknown(node.spot, "module", name, known().collect::<Vec<_>>()))
        }
    })
}

fn lacks(node: &Node, device: Option<&DeviceDescription>) -> Read<Vec<String>> {
    names(node, "lacks", |node, name| {
        let Some(device) = device else { return Ok(()) };
        let parameters = device.parameters.iter().map(|parameter| format!("P{}", parameter.number));
        let known: Vec<String> = device.records.iter().map(|record| record.name.clone()).chain(parameters).collect();
        if known.iter().any(|known| known == name) {
            Ok(())
        } else {
            Err(Mistake::unknown(node.spot, "record or parameter", name, known.iter().map(String::as_str)))
        }
    })
}

/// Start parameters of the device, each with its name in a description.
fn start_parameters(node: &Node, device: Option<&DeviceDescription>) -> Read<Vec<(String, String)>> {
    let mut named_parameters = Vec::new();
    for (name, node) in named(node, "start_parameters")? {
        let records = device.into_iter().flat_map(|device| &device.records).filter(|record| record.start);
        let known: Vec<&str> = records.flat_map(|record| &record.fields).map(|field| field.name.as_str()).collect();
        if device.is_some() && !known.contains(&name) {
            return Err(Mistake::unknown(node.spot, "start parameter", name, known));
        }
        named_parameters.push((name.to_owned(), plain(node, "a name in the GSDML or GSD")?.to_owned()));
    }
    Ok(named_parameters)
}

/// The web pages; each name must be a page of the device.
fn pages(node: &Node, device: Option<&DeviceDescription>) -> Read<Vec<(String, BenchPage)>> {
    let mut pages = Vec::new();
    for (name, node) in named(node, "pages")? {
        let of = device.map(|device| device.pages.iter().find(|page| page.name == name));
        if let (Some(None), Some(device)) = (of, device) {
            let known = device.pages.iter().map(|page| page.name.as_str());
            return Err(Mistake::unknown(node.spot, "web page", name, known));
        }
        let keyed = Keyed::new(node, &bench_page::KEYS)?;
        let own = BenchPage {
            path: keyed.get(&bench_page::path).map(path).transpose()?,
            fields: keyed.get(&bench_page::fields).map_or(Ok(Vec::new()), fields)?,
            shows: keyed.get(&bench_page::shows).map_or(Ok(Vec::new()), fields)?,
        };
        if let Some(Some(declared)) = of {
            let unknown =
                |what: &str, name: &str, known: Vec<&str>| Err(Mistake::unknown(node.spot, what, name, known));
            let fields: Vec<&str> = declared.fields.iter().map(|(name, _)| name.as_str()).collect();
            if let Some((name, _)) = own.fields.iter().find(|(name, _)| !fields.contains(&name.as_str())) {
                return unknown("field of the page", name, fields);
            }
            let shown: Vec<&str> = declared.shows.iter().map(|value| value.name.as_str()).collect();
            if let Some((name, _)) = own.shows.iter().find(|(name, _)| !shown.contains(&name.as_str())) {
                return unknown("value of the page", name, shown);
            }
        }
        pages.push((name.to_owned(), own));
    }
    Ok(pages)
}

fn firmware(node: &Node) -> Read<String> {
    let text = node.text("a firmware")?;
    let parts: Vec<&str> = text.split('.').collect();
    let number = |part: &&str| !part.is_empty() && part.bytes().all(|octet| octet.is_ascii_digit());
    if parts.len() == 3 && parts.iter().all(number) {
        Ok(text.to_owned())
    } else {
        Err(node
            .wrong(format!("`{}` is not a firmware version", text.escape_default()))
            .help("write three numbers, for instance 1.1.0"))
    }
}

fn consent(node: &Node) -> Read<Consents> {
    let keyed = Keyed::new(node, &bench_consent::KEYS)?;
    Ok(Consents {
        factory_reset: flag(keyed, &bench_consent::factory_reset)?,
        set_name: flag(keyed, &bench_consent::set_name)?,
        set_ip: flag(keyed, &bench_consent::set_ip)?,
        set_address: flag(keyed, &bench_consent::set_address)?,
        im_records: flag(keyed, &bench_consent::im_records)?,
        lock_address: flag(keyed, &bench_consent::lock_address)?,
        nvm_write: keyed.get(&bench_consent::nvm_write).map_or(Ok(0), |node| whole(node, "a number of writes"))?,
        position_reference: flag(keyed, &bench_consent::position_reference)?,
        firmware: flag(keyed, &bench_consent::firmware)?,
        overstress: flag(keyed, &bench_consent::overstress)?,
        alone: flag(keyed, &bench_consent::alone)?,
    })
}
