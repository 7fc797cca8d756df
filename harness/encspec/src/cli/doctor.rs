//! `encspec doctor`: checks whether this host can test a live device, and names the command that fixes what it cannot.
//!
//! It changes nothing on the host. On an interface it sends one Identify, as `encspec discover` does.

use super::port::PortArgs;
use super::{CommandResult, ListingFormat, show};
use clap::Args;
use link::{interfaces, privileges, realtime};
use live::discover::Survey;
use plain_text::{count, printable};
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Duration;

const EXAMPLE: &str = "\
Example:
  encspec doctor --nic eth1

Exit status: 0 a device can be tested, 3 something has to be fixed first.";

/// Arguments of `encspec doctor`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub(super) struct DoctorArgs {
    /// Network interface with the device [default: all, without asking who is on the wire]
    #[arg(long, value_name = "IF")]
    nic: Option<String>,
    /// Seconds to wait for stations at the interface
    #[arg(long, value_name = "SECONDS", default_value_t = 2, value_parser = clap::value_parser!(u64).range(1..=120))]
    wait: u64,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: ListingFormat,
}

/// How good something is for testing a live device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Health {
    Good,
    /// Tests are possible, with limits.
    Warning,
    /// Tests are not possible, or would say nothing.
    Bad,
}

/// One thing that was checked.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct HostCheck {
    what: String,
    health: Health,
    text: String,
    /// The command that fixes it, or what to do.
    #[serde(skip_serializing_if = "Option::is_none")]
    fix: Option<String>,
}

impl HostCheck {
    fn new(what: &str, health: Health, text: impl Into<String>) -> HostCheck {
        HostCheck { what: what.to_owned(), health, text: text.into(), fix: None }
    }

    fn good(what: &str, text: impl Into<String>) -> HostCheck {
        HostCheck::new(what, Health::Good, text)
    }

    fn warning(what: &str, text: impl Into<String>) -> HostCheck {
        HostCheck::new(what, Health::Warning, text)
    }

    fn bad(what: &str, text: impl Into<String>) -> HostCheck {
        HostCheck::new(what, Health::Bad, text)
    }

    fn fix(self, fix: impl Into<String>) -> HostCheck {
        HostCheck { fix: Some(fix.into()), ..self }
    }
}

pub(super) fn doctor(args: &DoctorArgs) -> CommandResult {
    let root = Path::new("/");
    let mut checks = vec![raw_access()];
    checks.extend(real_time(root));
    match &args.nic {
        Some(name) => {
            checks.extend(interface(root, name));
            // Without access or without the interface there is nothing to ask.
            if checks.iter().all(|check| check.health != Health::Bad) {
                checks.push(on_the_wire(name, Duration::from_secs(args.wait)));
            }
        }
        None => {
            let names = interfaces().into_iter().filter(|known| !known.loopback).map(|known| known.name);
            names.for_each(|name| checks.extend(interface(root, &name).into_iter().map(optional)));
        }
    }
    checks.extend(adapters(root));
    let is_bad = checks.iter().any(|check| check.health == Health::Bad);
    show(&match args.format {
        ListingFormat::Json => super::list::pretty(&checks),
        ListingFormat::Text => text(&checks),
    });
    Ok(if is_bad { ExitStatus::Bench } else { ExitStatus::Green })
}

/// An interface that the command line does not name need not be usable.
fn optional(check: HostCheck) -> HostCheck {
    let health = if check.health == Health::Bad { Health::Warning } else { check.health };
    HostCheck { health, ..check }
}

fn raw_access() -> HostCheck {
    let what = "raw Ethernet";
    if privileges::has_raw_sockets() {
        return HostCheck::good(what, "this process may open raw sockets (CAP_NET_RAW)");
    }
    let program = std::env::current_exe().map_or_else(|_| "encspec".to_owned(), |path| path.display().to_string());
    HostCheck::bad(what, "CAP_NET_RAW is missing: no interface can be opened").fix(privileges::how_to_grant(&program))
}

/// Scheduling, memory and the clock of the processor.
fn real_time(root: &Path) -> Vec<HostCheck> {
    let settings = realtime::raise();
    let granted = settings.granted.into_iter().map(|text| HostCheck::good("real time", text));
    let refused = settings.refused.into_iter().map(|text| {
        let program = std::env::current_exe().map_or_else(|_| "encspec".to_owned(), |path| path.display().to_string());
        HostCheck::warning("real time", text).fix(privileges::how_to_grant(&program))
    });
    granted.chain(refused).chain(governor(root)).collect()
}

fn governor(root: &Path) -> Option<HostCheck> {
    let governor = read(&root.join("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"))?;
    let what = "processor";
    Some(match governor.as_str() {
        "performance" => HostCheck::good(what, "it does not slow down (governor performance)"),
        other => HostCheck::warning(what, format!("it slows down when idle (governor {other}), which delays frames"))
            .fix("sudo cpupower frequency-set --governor performance"),
    })
}

/// The state of an interface, by what the kernel says below `root`.
fn interface(root: &Path, name: &str) -> Vec<HostCheck> {
    let what = format!("interface {}", printable(name));
    let folder = root.join("sys/class/net").join(name);
    if name.contains('/') || !folder.is_dir() {
        let known = fs::read_dir(root.join("sys/class/net")).into_iter().flatten().flatten();
        let mut known: Vec<String> = known.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        known.retain(|name| name != "lo");
        known.sort();
        let text = format!("there is none of this name; there are: {}", known.join(", "));
        return vec![HostCheck::bad(&what, text)];
    }
    let mut checks = Vec::new();
    let flags =
        read(&folder.join("flags")).and_then(|text| u32::from_str_radix(text.trim_start_matches("0x"), 16).ok());
    let is_up = flags.is_some_and(|flags| flags & 1 == 1);
    checks.push(match (is_up, read(&folder.join("carrier")).as_deref()) {
        (false, _) => HostCheck::bad(&what, "it is down").fix(format!("sudo ip link set {name} up")),
        (true, Some("1")) => HostCheck::good(&what, "it is up, and a cable with a station is plugged in"),
        (true, _) => HostCheck::bad(&what, "it is up, and no station is at the other end of its cable")
            .fix("plug in the cable, and switch the device on"),
    });
    if folder.join("brport").exists() || folder.join("master").exists() {
        checks.push(
            HostCheck::bad(&what, "it is a port of a bridge or a bond, which passes frames to other stations")
                .fix(format!("sudo ip link set {name} nomaster")),
        );
    }
    checks.push(vlan(root, name, &what));
    if read(&folder.join("type")).is_some_and(|of| of != "1") {
        checks.push(HostCheck::bad(&what, "it carries no Ethernet frames"));
    }
    if root.join("run/NetworkManager").is_dir() {
        checks.push(
            HostCheck::warning(&what, "NetworkManager may send DHCP and router solicitations on it")
                .fix(format!("sudo nmcli device set {name} managed no")),
        );
    }
    checks
}

/// Whether tags of priority arrive.
fn vlan(root: &Path, name: &str, what: &str) -> HostCheck {
    let folder = root.join("proc/net/vlan");
    if folder.join(name).exists() {
        let below = fs::read_to_string(folder.join(name)).unwrap_or_default();
        let below = below.lines().find_map(|line| line.strip_prefix("Device:")).unwrap_or("").trim().to_owned();
        return HostCheck::bad(what, format!("it is a VLAN of {below}, where frames lose their tags"))
            .fix(format!("use --nic {below}"));
    }
    HostCheck::good(what, "tags that the adapter removes are read from what the kernel says of each frame")
}

/// Who is at the interface.
fn on_the_wire(name: &str, wait: Duration) -> HostCheck {
    let port = PortArgs { nic: Some(name.to_owned()), socket: None };
    match port.survey(wait) {
        Err(error) => HostCheck::bad("wire", error.message),
        Ok((survey, _)) => stations(name, &survey),
    }
}

fn stations(name: &str, survey: &Survey) -> HostCheck {
    let what = "wire";
    let named = |is_meant: &dyn Fn(&Vec<&'static str>) -> bool| -> Vec<String> {
        let those = survey.stations.iter().filter(|of| is_meant(&of.roles));
        those.map(|of| format!("{} ({})", of.printable_name(), of.mac)).collect()
    };
    let is_controller =
        |roles: &Vec<&'static str>| roles.iter().any(|role| ["controller", "supervisor"].contains(role));
    let controllers = named(&is_controller);
    let devices = named(&|roles| !is_controller(roles));
    if !controllers.is_empty() {
        return HostCheck::bad(what, format!("another controller is on the wire: {}", controllers.join(", ")))
            .fix("connect the device to this host alone");
    }
    if let Some(remark) = survey.remarks.first() {
        return HostCheck::bad(what, remark.clone()).fix("leave one device on the wire");
    }
    match devices.as_slice() {
        [] => HostCheck::bad(what, "no station answers").fix(format!("encspec discover --nic {name} --wait 30")),
        [one] => HostCheck::good(what, format!("one device: {one}")),
        several => {
            HostCheck::warning(what, format!("{}: {}", count(several.len(), "device", "devices"), several.join(", ")))
                .fix("leave one device on the wire, or say `station_name` and `alone` in the bench file")
        }
    }
}

/// The serial adapters for PROFIBUS.
fn adapters(root: &Path) -> Vec<HostCheck> {
    let entries = fs::read_dir(root.join("sys/class/tty")).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.retain(|name| name.starts_with("ttyUSB") || name.starts_with("ttyACM") || name.starts_with("ttySC"));
    names.sort();
    let mut checks = Vec::new();
    for name in names {
        let what = format!("adapter /dev/{name}");
        let device = root.join("dev").join(&name);
        let opened = fs::metadata(&device);
        checks.push(match opened {
            Err(error) => HostCheck::warning(&what, error.to_string()),
            Ok(_) => HostCheck::good(&what, "it is there; docs/profibus-adapters.md says what each kind can do"),
        });
        let timer = read(&root.join("sys/class/tty").join(&name).join("device/latency_timer"));
        if let Some(timer) = timer.filter(|timer| timer != "1") {
            checks.push(
                HostCheck::warning(&what, format!("it keeps received bytes for {timer} ms (latency timer)"))
                    .fix(format!("echo 1 | sudo tee /sys/class/tty/{name}/device/latency_timer")),
            );
        }
    }
    checks
}

fn read(path: &Path) -> Option<String> {
    Some(fs::read_to_string(path).ok()?.trim().to_owned())
}

fn text(checks: &[HostCheck]) -> String {
    let mut out = String::new();
    for check in checks {
        let word = match check.health {
            Health::Good => "good",
            Health::Warning => "warning",
            Health::Bad => "bad",
        };
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{word:<8} {}: {}", check.what, printable(&check.text));
        if let Some(fix) = &check.fix {
            let _ = writeln!(out, "         fix: {}", printable(fix));
        }
    }
    let of = |health| checks.iter().filter(|check| check.health == health).count();
    let last = match (of(Health::Bad), of(Health::Warning)) {
        (0, 0) => "A device can be tested.".to_owned(),
        (0, warnings) => format!("A device can be tested; {}.", count(warnings, "warning", "warnings")),
        (bad, _) => format!("{} to fix before a device can be tested.", count(bad, "thing", "things")),
    };
    let _ = writeln!(out, "{last}");
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use live::discover::DiscoveredStation;
    use rstest::rstest;
    use testing::Folder;
    use wire::ethernet::Mac;

    /// A root with an interface `eth1` that has these files.
    fn root(name: &str, files: &[(&str, &str)]) -> Folder {
        let folder = Folder::new(&format!("doctor-{name}"));
        for (path, content) in [("sys/class/net/eth1/type", "1\n")].iter().chain(files) {
            let file = folder.join(path);
            fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
            fs::write(file, content).expect("a file");
        }
        folder
    }

    fn worst(checks: &[HostCheck]) -> &HostCheck {
        let rank =
            |check: &&HostCheck| [Health::Bad, Health::Warning, Health::Good].iter().position(|of| *of == check.health);
        checks.iter().min_by_key(rank).expect("a check")
    }

    const UP: (&str, &str) = ("sys/class/net/eth1/flags", "0x1003\n");
    const CARRIER: (&str, &str) = ("sys/class/net/eth1/carrier", "1\n");

    #[rstest]
    #[case::good(&[UP, CARRIER], Health::Good, "it is up, and a cable", "")]
    #[case::down(&[("sys/class/net/eth1/flags", "0x1002\n")], Health::Bad, "it is down", "sudo ip link set eth1 up")]
    #[case::no_cable(&[UP, ("sys/class/net/eth1/carrier", "0\n")], Health::Bad, "no station is at the other end", "plug in")]
    #[case::bridge(&[UP, CARRIER, ("sys/class/net/eth1/brport/x", "")], Health::Bad, "a bridge or a bond", "sudo ip link set eth1 nomaster")]
    #[case::vlan(&[UP, CARRIER, ("proc/net/vlan/eth1", "eth1  VID: 5\nDevice: eth0\n")], Health::Bad, "a VLAN of eth0", "use --nic eth0")]
    #[case::managed(&[UP, CARRIER, ("run/NetworkManager/x", "")], Health::Warning, "DHCP", "sudo nmcli device set eth1 managed no")]
    fn an_interface(#[case] files: &[(&str, &str)], #[case] health: Health, #[case] says: &str, #[case] fix: &str) {
        let folder = root(&says.replace([' ', ','], "-"), files);
        let checks = interface(folder.path(), "eth1");
        let worst = worst(&checks);
        assert_eq!(worst.health, health, "{checks:?}");
        assert!(worst.text.contains(says) && worst.fix.as_deref().unwrap_or_default().starts_with(fix), "{worst:?}");
    }

    #[test]
    fn an_unknown_interface_lists_the_others() {
        let folder = root("unknown", &[]);
        let checks = interface(folder.path(), "eth7");
        assert_eq!(checks.len(), 1);
        assert_eq!(
            (checks[0].health, checks[0].text.as_str()),
            (Health::Bad, "there is none of this name; there are: eth1")
        );
        assert_eq!(interface(folder.path(), "../net/eth1")[0].health, Health::Bad);
    }

    #[test]
    fn an_adapter_with_a_latency_timer() {
        let folder = root("adapter", &[("sys/class/tty/ttyUSB0/device/latency_timer", "16\n"), ("dev/ttyUSB0", "")]);
        let checks = adapters(folder.path());
        assert_eq!(checks.iter().map(|check| check.health).collect::<Vec<_>>(), [Health::Good, Health::Warning]);
        assert_eq!(checks[1].fix.as_deref(), Some("echo 1 | sudo tee /sys/class/tty/ttyUSB0/device/latency_timer"));
    }

    fn station(last: u8, roles: &[&'static str]) -> DiscoveredStation {
        let mac = Mac([2, 0, 0, 0, 0, last]);
        DiscoveredStation {
            mac,
            name: b"a".to_vec(),
            ip: None,
            ids: None,
            station_type: String::new(),
            roles: roles.to_vec(),
        }
    }

    #[rstest]
    #[case::one(vec![station(1, &["device"])], Health::Good, "one device: a")]
    #[case::none(vec![], Health::Bad, "no station answers")]
    #[case::two(vec![station(1, &["device"]), station(2, &["device"])], Health::Warning, "2 devices")]
    #[case::controller(vec![station(1, &["device"]), station(2, &["controller"])], Health::Bad, "another controller")]
    fn stations_on_the_wire(#[case] found: Vec<DiscoveredStation>, #[case] health: Health, #[case] says: &str) {
        let check = stations("eth1", &Survey { stations: found, remarks: Vec::new() });
        assert_eq!(check.health, health, "{check:?}");
        assert!(check.text.contains(says), "{check:?}");
        assert_eq!(check.fix.is_some(), health != Health::Good);
    }
}
