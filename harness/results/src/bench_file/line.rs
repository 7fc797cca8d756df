//! The section `line` of a bench file: settings of a PROFIBUS line.

use super::keys::{DRIVERS, PARITIES, bench_line};
use station::Parity;
use suite_yaml::device_yaml::{flag, whole};
use suite_yaml::error::Read;
use suite_yaml::keys::{Key, Keyed};
use suite_yaml::yaml::Node;
use wire::profibus::fdl::{BROADCAST, BaudRate, BitTimes};

/// Maximum slot time in bit times; more than a minute at the lowest rate.
const LONGEST_SLOT: u64 = 1_000_000;
/// Highest station address of a master.
const HIGHEST_MASTER: u8 = 125;

/// Settings of a PROFIBUS line; `None`: the default.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineSpec {
    /// Transmission rate.
    pub baud: Option<BaudRate>,
    pub parity: Parity,
    /// How long an answer is waited for (TSL).
    pub slot_time: Option<BitTimes>,
    /// Maximum station delay of a responder (max TSDR).
    pub max_tsdr: Option<BitTimes>,
    /// What switches the driver of the RS-485 adapter; `None`: not specified.
    pub driver: Option<Driver>,
    /// Whether the adapter echoes sent bytes.
    pub echo: bool,
    /// Station address of the device.
    pub address: Option<u8>,
    /// Station addresses of the two masters of the harness.
    pub masters: Option<[u8; 2]>,
}

/// What switches the driver of an RS-485 adapter on and off; this must be done by hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// The adapter.
    Adapter,
    /// The serial port, controlled by the kernel.
    Port,
}

/// Reads the section `line`.
pub(super) fn line(node: &Node) -> Read<LineSpec> {
    let keyed = Keyed::new(node, &bench_line::KEYS)?;
    let get = |key: &Key| keyed.get(key);
    let bits = |node: &Node| match whole::<u64>(node, "a number of bit times")? {
        bits @ 1..=LONGEST_SLOT => Ok(BitTimes(bits)),
        _ => Err(node.wrong(format!("a time on the bus must be 1 to {LONGEST_SLOT} bit times"))),
    };
    let address = get(&bench_line::address).map(|node| station(node, BROADCAST - 1)).transpose()?;
    let masters = get(&bench_line::masters).map(masters).transpose()?;
    if let (Some(node), Some(address), Some(masters)) = (get(&bench_line::address), address, masters)
        && masters.contains(&address)
    {
        return Err(node.wrong("the device cannot have the address of one of the masters of the harness"));
    }
    Ok(LineSpec {
        baud: get(&bench_line::baud).map(baud).transpose()?,
        parity: keyed.word(&bench_line::parity, &PARITIES)?.unwrap_or(Parity::Even),
        slot_time: get(&bench_line::slot_time).map(bits).transpose()?,
        max_tsdr: get(&bench_line::max_tsdr).map(bits).transpose()?,
        driver: keyed.word(&bench_line::driver, &DRIVERS)?,
        echo: flag(keyed, &bench_line::echo)?,
        address,
        masters,
    })
}

fn baud(node: &Node) -> Read<BaudRate> {
    let rate = BaudRate(whole(node, "a rate")?);
    if BaudRate::STANDARD.contains(&rate) {
        return Ok(rate);
    }
    let all: Vec<String> = BaudRate::STANDARD.iter().map(|rate| rate.0.to_string()).collect();
    Err(node.wrong(format!("PROFIBUS has no rate of {} bit/s", rate.0)).help(format!("use one of {}", all.join(", "))))
}

fn station(node: &Node, highest: u8) -> Read<u8> {
    let address: u8 = whole(node, "a station address")?;
    if address <= highest {
        Ok(address)
    } else {
        Err(node.wrong(format!("the station address must be 0 to {highest}")))
    }
}

fn masters(node: &Node) -> Read<[u8; 2]> {
    match node.items("masters")? {
        [first, second] => match (station(first, HIGHEST_MASTER)?, station(second, HIGHEST_MASTER)?) {
            (one, other) if one == other => Err(second.wrong("two masters cannot have the same address")),
            (one, other) => Ok([one, other]),
        },
        _ => Err(node.wrong("`masters` needs two addresses").help("for instance [1, 2]")),
    }
}
